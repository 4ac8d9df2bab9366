# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A URDF whose numbers are none is refused in a sentence, by all that read one."""

import numpy as np
import pytest

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.robot import Robot
from sosml_friction.model.simple_models import skeleton_model
from sosml_friction.model.urdf_joints import read_joints

URDF = """<robot name="r"><link name="base"/>
<link name="arm"><inertial><origin xyz="0.2 0 0"/><mass value="2.5"/>
<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.03"/></inertial></link>
<link name="tip"/>
<joint name="j" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" velocity="2" effort="9"/></joint>
<joint name="f" type="fixed"><parent link="arm"/><child link="tip"/><axis xyz="0 0 0"/></joint>
</robot>"""


@pytest.mark.parametrize(
    ('old', 'new', 'sentence'),
    [
        ('value="2.5"', 'value="2,5"', "the mass of link arm is '2,5', no number"),
        ('value="2.5"', 'value="abc"', "the mass of link arm is 'abc'"),
        ('value="2.5"', 'value="nan"', "the mass of link arm is 'nan'"),
        ('value="2.5"', 'value="1e999"', "the mass of link arm is '1e999'"),
        ('value="2.5"', 'value="1_0"', "the mass of link arm is '1_0'"),
        ('value="2.5"', 'value="${m}"', r"the mass of link arm is '\$\{m\}', .*xacro still"),
        ('value="2.5"', '', 'the mass of link arm is missing'),
        ('<mass value="2.5"/>', '', 'the inertial of link arm has no mass'),
        ('value="2.5"', 'value="-2.5"', 'the mass of link arm is -2.5 kg'),
        ('value="2.5"', 'value="0"', 'the mass of link arm is 0 kg'),
        ('iyy="0.03"', 'iyy="-0.03"', 'link arm has a negative moment of inertia .*-0.03'),
        ('ixy="0"', 'ixy="0.1"', 'link arm has a negative moment of inertia'),
        ('iyy="0.03"', 'iyy="x"', "iyy of link arm is 'x'"),
        ('iyy="0.03"', '', 'iyy of link arm is missing'),
        ('0.2 0 0', '0.2 0', 'xyz in the origin of the inertial of link arm is .*three numbers'),
        ('0 1 0', '0 0 0', "the axis of joint j is '0 0 0', which is no direction"),
        ('0 1 0', '0 inf 0', "the axis of joint j is 'inf'"),
        ('0.2 0 0', '0.2, 0, 0', "xyz in the origin of the inertial of link arm is '0.2,'"),
        ('effort="9"', 'effort="nan"', "the effort limit of joint j is 'nan'"),
        ('lower="-1"', 'lower="nan"', "the lower limit of joint j is 'nan'"),
        ('child link="arm"', 'child link="leg"', "the child of joint j is 'leg', which is no"),
        ('parent link="base"', 'parent link="tip"', 'arm, tip hang on one another in a ring'),
        ('child link="tip"', 'child link="arm"', 'link arm is the child of two joints'),
        ('name="tip"', 'name="arm"', 'it has link arm twice'),
        ('<link name="base"/>', '<link name="base"/><link name="x"/>', 'links base, x hang on'),
        ('"revolute"', '"hinge"', "joint j is of type 'hinge'"),
    ],
)
def test_what_is_no_body_or_joint_is_refused_with_its_name_and_value(old, new, sentence, capfd):
    assert old in URDF
    urdf = URDF.replace(old, new, 1)
    for read in (read_joints, skeleton_model, lambda text: Robot(text, ['j'], [0.1])):
        with pytest.raises(ConfigurationError, match=sentence):
            read(urdf)
    # The parser of the library never sees it, and has nothing to say on stderr.
    assert capfd.readouterr() == ('', '')


def test_the_length_of_an_axis_and_an_empty_body_say_nothing():
    robot = Robot(URDF, ['j'], [0.1])
    q = np.array([0.3])
    longer = Robot(URDF.replace('0 1 0', '0 3 0'), ['j'], [0.1])
    assert longer.gravity(q) == pytest.approx(robot.gravity(q), rel=1e-14)
    nothing = (
        '<inertial><mass value="0"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>'
    )
    empty = URDF.replace('<link name="tip"/>', f'<link name="tip">{nothing}</inertial></link>')
    assert read_joints(empty) == read_joints(URDF)


def test_a_moment_of_inertia_that_was_rounded_is_let_through():
    rounded = URDF.replace('ixx="0.02"', 'ixx="0.000"').replace('ixy="0"', 'ixy="0.0005"')
    assert Robot(rounded, ['j'], [0.1]).n == 1


ZEROS = '<inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>'
ONES = '<inertia ixx="1" iyy="1" izz="1"/>'


@pytest.mark.parametrize(
    'inertial',
    [
        '',
        '<origin xyz="0, 0, 0"/>',
        '<mass value="0"/>',
        '<mass value="0"/><inertia/>',
        f'<mass value="0"/>{ONES}',
    ],
)
def test_a_frame_without_mass_has_no_body_whatever_else_it_states(inertial):
    frame = f'<link name="tip"><inertial>{inertial}</inertial></link>'
    urdf = URDF.replace('<link name="tip"/>', frame)
    assert read_joints(urdf) == read_joints(URDF)
    # What a joint moves is no frame.
    with pytest.raises(ConfigurationError, match=r'link tip (is 0 kg|has no|is missing)'):
        read_joints(urdf.replace('type="fixed"', 'type="planar"'))


@pytest.mark.parametrize(
    ('mass', 'sentence'),
    [('"2,5"', "'2,5'"), ('"abc"', "'abc'"), ('"nan"', "'nan'"), ('"-1"', '-1 kg'), ('', 'missi')],
)
def test_the_mass_of_a_frame_that_is_no_number_is_refused_too(mass, sentence):
    value = f'value={mass}' if mass else ''
    frame = f'<link name="tip"><inertial><mass {value}/>{ZEROS}</inertial></link>'
    with pytest.raises(ConfigurationError, match=f'the mass of link tip is {sentence}'):
        read_joints(URDF.replace('<link name="tip"/>', frame))


def test_a_frame_with_a_mass_and_no_inertia_is_a_point():
    point = '<link name="tip"><inertial><origin xyz="0.3 0 0"/><mass value="2"/>'
    bodies = [
        Robot(
            URDF.replace('<link name="tip"/>', f'{point}{inertia}</inertial></link>'), ['j'], [0.0]
        )
        for inertia in ('', ZEROS)
    ]
    q = np.array([0.3])
    assert bodies[0].gravity(q) == bodies[1].gravity(q)
    assert bodies[0].inertia(q)[0, 0] == pytest.approx(0.03 + 2.5 * 0.04 + 2 * 0.09)


@pytest.mark.parametrize(
    ('old', 'new'),
    [
        (' ixy="0" ixz="0"', ''),
        (' iyz="0"', ''),
        ('<origin xyz="0.2 0 0"/>', '<origin xyz="0.2 0 0" rpy=""/>'),
        ('<axis xyz="0 0 0"/>', '<origin xyz="" rpy=" "/>'),
    ],
)
def test_products_of_inertia_and_origins_that_are_left_out_are_0(old, new):
    assert old in URDF
    assert read_joints(URDF.replace(old, new, 1)) == read_joints(URDF)


def test_a_limit_that_is_infinite_is_none():
    for text in ('inf', '1e400'):
        limits = read_joints(URDF.replace('effort="9"', f'effort="{text}"')).joints['j'].limits
        assert limits.effort == np.inf
