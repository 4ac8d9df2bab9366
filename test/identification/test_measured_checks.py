# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the checks say of measured records: what is known of them, and nothing else."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.sampling import lost_samples
from sosml_friction.exceptions import DataError
from sosml_friction.identification.data_checks import check_data
from sosml_friction.identification.data_finding import NOTE
from sosml_friction.model.robot import Robot

#: data/README.md: drive gains [Nm/A] and inertias [kg m2].
GAINS = np.array([10.0000, 10.6956, 8.4566, 9.0029, 9.4800, 10.1232])
ROTORS = (0.0, 3.7434, 0.0, 0.0708, 0.2342, 0.4365)
SHAFT = """<robot name="shaft"><link name="base"/><link name="rotor"><inertial>
<origin xyz="0 0 0"/><mass value="0.1"/>
<inertia ixx="{0}" ixy="0" ixz="0" iyy="{0}" iyz="0" izz="{0}"/></inertial></link>
<joint name="motor" type="revolute"><parent link="base"/><child link="rotor"/>
<axis xyz="0 0 1"/><limit lower="-1e4" upper="1e4" effort="0" velocity="0"/></joint></robot>"""


def stamps(time):
    return np.rint((time - time[0]) * 1e9).astype(np.int64)


@pytest.fixture
def ur10e(data_directory):
    """Return a function that reads a record of the UR10e: log and robot."""

    def read(name, gains=GAINS):
        folder = data_directory / 'ur10e'
        if not (folder / name).is_file():
            pytest.skip(f'no {folder / name}')
        urdf = (folder / 'robot.urdf').read_text()
        joints = ElementTree.fromstring(urdf).findall('joint')
        names = tuple(x.get('name', '') for x in joints if x.get('type') == 'revolute')
        x = np.genfromtxt(folder / name, delimiter=',')
        log = JointLog(names, stamps(x[:, 0]), x[:, 1:7], x[:, 7:13], x[:, 13:19] * gains)
        return log, Robot(urdf, names, ROTORS)

    return read


def shaft(data_directory, name, inertia):
    file = data_directory / 'damiao' / name
    if not file.is_file():
        pytest.skip(f'no {file}')
    z = np.load(file)
    columns = (z[key][:, None] for key in ('position', 'velocity', 'torque_feedback'))
    return JointLog(('motor',), stamps(z['time']), *columns), Robot(
        SHAFT.format(inertia), ['motor'], [0.0]
    )


def test_a_robot_with_wrong_masses_is_accused_of_nothing_else(ur10e):
    log, robot = ur10e('30sec_12harm.csv')
    assert check_data(log, robot)[1].findings == ()
    assert lost_samples(log.time) == 0


def test_one_joint_of_six_is_used_and_the_others_named_as_resting(ur10e):
    log, robot = ur10e('joint_2.csv')
    used, checks = check_data(log, robot)
    assert set(checks.resting) == set(robot.names) - {'shoulder_lift_joint'}
    assert checks.refused == {}
    known = np.isfinite(used.tau).all(axis=0)
    assert [name for name, x in zip(used.names, known, strict=True) if x] == [
        'shoulder_lift_joint'
    ]


def test_currents_for_torques_are_told_from_gravity(ur10e):
    log, robot = ur10e('30sec_12harm.csv', np.ones(6))
    checks = check_data(log, robot)[1]
    for name in ('shoulder_lift_joint', 'elbow_joint'):
        assert 'it is not in Nm' in checks.refused[name]
    assert 'its effort is not in Nm' in checks.warnings['shoulder_pan_joint']


@pytest.mark.parametrize(
    ('name', 'inertia', 'factor', 'limited'),
    [
        ('motor_05_run_01.npz', 0.00107, 0.603, False),
        ('motor_05_run_02.npz', 0.00107, 0.603, False),
        ('motor_03_run_01.npz', 0.0566, 0.503, True),
        ('motor_03_run_02.npz', 0.0566, 0.502, True),
    ],
)
def test_wrap_velocity_and_speed_limit_of_a_servo(data_directory, name, inertia, factor, limited):
    log, robot = shaft(data_directory, name, inertia)
    used, checks = check_data(log, robot)
    assert used.wraps == {'motor': 25.0}
    assert checks.joints['motor'].velocity_factor == pytest.approx(factor, abs=0.002)
    wanted = {'wrap', 'velocity_unit'} | ({'speed_limit'} if limited else set())
    assert {f.check for f in checks.findings if f.level != NOTE} == wanted
    assert f'{factor:.2g}' in checks.sentences[1]


def test_cogging_of_a_motor_that_turns_once_is_no_turned_sign(data_directory):
    file = data_directory / 'odrive_cogging' / 'slow2_nocomp_1.npy'
    if not file.is_file():
        pytest.skip(f'no {file}')
    time, counts, current = np.load(file)
    q = counts[:, None] * 2.0 * np.pi / 8192
    log = JointLog(('motor',), stamps(time), q, np.full_like(q, np.nan), 0.0075 * current[:, None])
    with pytest.raises(DataError, match='one direction only'):
        check_data(log, Robot(SHAFT.format(2.5e-4), ['motor'], [0.0]))


@pytest.mark.parametrize(
    ('rotor', 'times', 'refused'), [(0.2, 1e3, True), (0.0, 1e3, False), (0.2, 9.0, False)]
)
def test_without_gravity_inertia_tells_another_unit_where_the_rotor_is_known(
    rotor, times, refused
):
    """
    A flywheel about a vertical axis, its current in mA taken for A: 1000 times as much.

    A load that the model lacks may be nine times what it has.
    """
    t = 1e-3 * np.arange(20_000)
    q, v, a = 0.8 * np.sin(2.0 * t), 1.6 * np.cos(2.0 * t), -3.2 * np.sin(2.0 * t)
    tau = times * ((0.06 + 0.2) * a + 0.3 * np.sign(v) + 0.2 * v)
    tau += 0.02 * times * np.random.default_rng(0).standard_normal(len(t))
    log = JointLog(
        ('motor',), np.rint(1e9 * t).astype(np.int64), *(x[:, None] for x in (q, v, tau))
    )
    robot = Robot(SHAFT.format(0.06), ['motor'], [rotor])
    if refused:
        with pytest.raises(DataError, match='times what the bodies of its URDF need: it is not'):
            check_data(log, robot)
    else:
        assert 'its effort is not in Nm' in check_data(log, robot)[1].warnings['motor']
