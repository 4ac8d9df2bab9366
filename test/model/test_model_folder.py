# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The model folder: what is written is read, what is wrong is said."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.laws import FRICTION_LAWS, unit_of
from sosml_friction.model.model_folder import (
    FrictionParameters,
    JointModel,
    RobotModelFile,
    parse_model,
    read_model,
)
from sosml_friction.model.parameter import AT_BOUND, NOT_IDENTIFIABLE, Parameter
from sosml_friction.share import share_directory

finite = st.floats(allow_nan=False, allow_infinity=False)
names = st.text(st.characters(codec='utf-8', exclude_categories=['Cc', 'Cs']), min_size=1)


@st.composite
def parameters(draw, unit, values=finite):
    known = st.one_of(st.just(math.nan), st.floats(0.0, 1e6))
    interval = st.one_of(st.none(), st.tuples(finite, finite))
    flags = st.sampled_from([(), (AT_BOUND,), (NOT_IDENTIFIABLE, AT_BOUND)])
    return Parameter(draw(values), unit, draw(known), draw(interval), draw(flags))


@st.composite
def models(draw):
    joints = {}
    for name in draw(st.lists(names, min_size=1, max_size=4, unique=True)):
        effort = draw(st.sampled_from(['Nm', 'N']))
        armature = draw(parameters('kg m2' if effort == 'Nm' else 'kg', st.floats(0.0, 1e3)))
        friction = None
        if draw(st.booleans()):
            law = draw(st.sampled_from(sorted(FRICTION_LAWS)))
            values = {
                key: draw(
                    parameters(
                        unit_of(key, effort),
                        st.floats(1e-9, 1e9) if key == 'stribeck_velocity' else finite,
                    )
                )
                for key in FRICTION_LAWS[law].parameter_names
            }
            friction = FrictionParameters(law, draw(st.floats(0.0, 10.0)), values)
        joints[name] = JointModel(armature, friction)
    provenance = draw(
        st.dictionaries(names, st.one_of(finite, names, st.integers(-(2**63), 2**63)))
    )
    return RobotModelFile(draw(names), joints, '<robot name="r"/>', provenance)


@settings(max_examples=60)
@given(models())
def test_what_is_written_is_read_to_the_last_bit(tmp_path_factory, model):
    folder = tmp_path_factory.mktemp('model')
    model.write(folder)
    back = read_model(folder)
    # repr, because an unknown standard error is NaN and NaN differs from itself.
    assert repr(back) == repr(model)
    assert repr(read_model(folder / 'model.yaml')) == repr(model)
    assert back.joint_names == tuple(model.joints)


def test_every_model_that_is_shipped_can_be_read_and_makes_a_robot():
    folders = sorted(path.parent for path in share_directory().glob('config/*/model.yaml'))
    assert len(folders) >= 3
    for folder in folders:
        model = read_model(folder)
        assert model.make_robot().names == model.joint_names


def test_the_urdf_of_the_robot_that_is_there_comes_before_the_folders(emps_urdf):
    model = read_model(share_directory() / 'config/emps')
    heavier = emps_urdf.replace('95.1089', '100.0')
    assert model.make_robot(heavier).inertia(np.zeros(1))[0, 0] == pytest.approx(100.0)


def test_friction_laws_come_in_the_order_of_the_joints():
    laws = read_model(share_directory() / 'config/emulated_exoskeleton').friction_laws()
    assert [law.parameters['coulomb'] for law in laws] == [0.8, 0.4]


def test_a_joint_without_friction_is_named():
    with pytest.raises(ConfigurationError, match='joint shoulder of model exoskeleton has no fri'):
        read_model(share_directory() / 'config/exoskeleton').friction_laws()


def document():
    return yaml.safe_load((Path(__file__).parent / 'format_1.yaml').read_text())


def joint_of(data):
    return data['joints']['shoulder']


def friction_of(data):
    return joint_of(data)['friction']


def put(where, key, value):
    def change(data):
        where(data)[key] = value

    return change


def drop(where, key):
    return lambda data: where(data).pop(key)


def itself(data):
    return data


@pytest.mark.parametrize(
    ('change', 'words'),
    [
        (drop(itself, 'format'), 'its entry format must be sosml_friction/model/2'),
        (put(itself, 'format', 'sosml_friction/model/3'), 'is not a model'),
        (drop(itself, 'joints'), 'names no joints'),
        (put(itself, 'joints', ['shoulder']), 'names no joints'),
        (put(itself, 'provenance', [1]), 'provenance'),
        (drop(joint_of, 'armature'), 'file: shoulder has no armature: give the reflected'),
        (put(joint_of, 'armature', 0.0054), 'shoulder.armature is 0.0054: write it as'),
        (put(joint_of, 'armature', {'value': 'x', 'unit': 'kg m2'}), 'shoulder.armature is'),
        (put(joint_of, 'armature', {'value': None, 'unit': 'kg m2'}), 'shoulder.armature is nan'),
        (put(joint_of, 'armature', {'value': -1, 'unit': 'kg m2'}), 'shoulder.armature is -1'),
        (put(joint_of, 'armature', {'value': 54, 'unit': 'kg cm2'}), "is in 'kg cm2': give it in"),
        (put(joint_of, 'inertia', 1), 'unknown entry inertia'),
        (put(joint_of, 'friction', 'stribeck'), 'friction must have law'),
        (drop(friction_of, 'law'), 'friction must have law'),
        (drop(friction_of, 'smoothing_velocity'), 'smoothing_velocity'),
        (put(friction_of, 'smoothing_velocity', 'wide'), "smoothing_velocity is 'wide'"),
        (put(friction_of, 'smoothing_velocity', -1), 'smoothing_velocity'),
        (put(friction_of, 'law', 'lugre'), "shoulder.friction: friction law 'lugre' is unknown"),
        (put(friction_of, 'parameters', [1, 2]), 'friction.parameters is [1, 2]'),
        (drop(lambda d: friction_of(d)['parameters'], 'viscous'), "missing ['viscous']"),
        (
            put(lambda d: friction_of(d)['parameters'], 'coulomb', {'value': 800, 'unit': 'mNm'}),
            "friction.coulomb is in 'mNm': give it in Nm",
        ),
    ],
)
def test_a_model_that_is_wrong_says_where_in_one_sentence(change, words):
    data = document()
    change(data)
    with pytest.raises(ConfigurationError) as caught:
        parse_model(yaml.safe_dump(data), 'file')
    assert words in str(caught.value)
    assert str(caught.value).startswith('file')
    assert '\n' not in str(caught.value)


def test_a_folder_of_format_1_is_the_same_model():
    text = (Path(__file__).parent / 'format_1.yaml').read_text()
    shipped = read_model(share_directory() / 'config/emulated_exoskeleton')
    assert repr(replace(parse_model(text, 'old'), urdf=shipped.urdf)) == repr(shipped)


def terms_of(data):
    return data['terms']


@pytest.mark.parametrize(
    ('change', 'words'),
    [
        (put(terms_of, 0, {'term': 'coulomb'}), 'terms[0] must have term, joint and parameters'),
        (put(lambda d: terms_of(d)[0], 'term', 'lugre'), "unknown term 'lugre'"),
        (put(lambda d: terms_of(d)[0], 'joint', 'knee'), "acts in the joint 'knee'"),
        (put(lambda d: terms_of(d)[0], 'joint', '*'), 'a friction law is of a joint'),
        (
            put(lambda d: terms_of(d)[0]['parameters'], 'level', {'value': 1, 'unit': 'Nm'}),
            'shoulder.coulomb has coulomb, level: give it coulomb',
        ),
        (
            put(lambda d: terms_of(d)[0]['parameters'], 'coulomb', {'value': 1, 'unit': 'mNm'}),
            "shoulder.coulomb.coulomb is in 'mNm': give it in Nm",
        ),
        (put(joint_of, 'friction', {}), 'unknown entry friction'),
        (put(joint_of, 'smoothing_velocity', 'wide'), "smoothing_velocity is 'wide'"),
    ],
)
def test_a_list_of_terms_that_is_wrong_says_where_in_one_sentence(change, words):
    path = share_directory() / 'config/emulated_exoskeleton/model.yaml'
    data = yaml.safe_load(path.read_text())
    change(data)
    with pytest.raises(ConfigurationError) as caught:
        parse_model(yaml.safe_dump(data), 'file')
    assert words in str(caught.value)
    assert '\n' not in str(caught.value)


def test_units_must_be_those_of_the_urdfs_joint(emps_urdf):
    text = (share_directory() / 'config/emps/model.yaml').read_text()
    model = parse_model(text.replace('unit: kg}', 'unit: kg m2}'), 'file')
    with pytest.raises(ConfigurationError, match=r'armature of joint slider .* give it in kg$'):
        model.make_robot(emps_urdf)


def test_friction_in_newtons_on_a_revolute_joint_is_refused():
    folder = share_directory() / 'config/emulated_exoskeleton'
    text = re.sub(r'unit: Nm\}', 'unit: N}', (folder / 'model.yaml').read_text())
    model = parse_model(text, 'file')
    with pytest.raises(ConfigurationError, match=r'coulomb of joint shoulder .* give it in Nm$'):
        model.make_robot(read_model(folder).urdf)


def test_text_that_is_not_yaml_is_refused_in_one_sentence():
    with pytest.raises(ConfigurationError, match=r'^topic is not YAML') as caught:
        parse_model('a: [1,\nb', 'topic')
    assert '\n' not in str(caught.value)


def test_missing_files_are_named(tmp_path):
    with pytest.raises(ConfigurationError, match=r'give a folder that holds model\.yaml'):
        read_model(tmp_path / 'nowhere')
    with pytest.raises(ConfigurationError, match=r'give a folder that holds model\.yaml'):
        read_model(tmp_path)
    text = yaml.safe_dump({**document(), 'urdf': 'gone.urdf'})
    (tmp_path / 'model.yaml').write_text(text)
    with pytest.raises(ConfigurationError, match=r'gone\.urdf named in .* correct its entry urdf'):
        read_model(tmp_path)


def test_a_model_without_urdf_neither_makes_a_robot_nor_is_written(tmp_path):
    model = parse_model(yaml.safe_dump(document()), 'topic')
    with pytest.raises(ConfigurationError, match=r'has no URDF: put robot\.urdf'):
        model.make_robot()
    with pytest.raises(ConfigurationError, match='has no URDF to write'):
        model.write(tmp_path / 'new')
    assert not (tmp_path / 'new').exists()


def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / 'file').write_text('')
    model = read_model(share_directory() / 'config/exoskeleton')
    with pytest.raises(ConfigurationError, match='cannot be written'):
        model.write(tmp_path / 'file')


@pytest.mark.parametrize(
    'data',
    [
        None,
        3.0,
        {'unit': 'Nm'},
        {'value': 1.0},
        {'value': [], 'unit': 'Nm'},
        {'value': 1.0, 'unit': 'Nm', 'interval': [1.0]},
        {'value': 1.0, 'unit': 'Nm', 'flags': 'at_bound'},
    ],
)
def test_a_parameter_that_is_not_one_is_shown_with_how_to_write_it(data):
    with pytest.raises(ConfigurationError, match=r'^here is .*: write it as \{value'):
        Parameter.from_dict(data, 'here')


def test_an_unknown_number_is_none_in_the_file_and_nan_in_memory():
    parameter = Parameter(math.nan, 'Nm', interval=(0.0, math.inf), flags=(NOT_IDENTIFIABLE,))
    written = parameter.to_dict()
    assert written['value'] is None
    assert written['std_error'] is None
    assert written['interval'] == [0.0, None]
    back = Parameter.from_dict(written, 'here')
    assert math.isnan(back.value)
    assert back.interval is not None
    assert back.interval[0] == 0.0
