# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""``sosml model``: folders that other commands take, and what they say is missing."""

import json

import pytest
from slider_bags import COULOMB, VISCOUS, checked, record, slider_log

from sosml_friction.model.model_folder import read_model


@pytest.mark.parametrize(
    ('arguments', 'folder', 'joint'),
    [
        (('pendulum', '--mass', '1', '--length', '0.25', '--armature=0'), 'pendulum', 'joint'),
        (('axis', '--mass', '95', '--joint', 'slider'), 'axis', 'slider'),
        (('free', '--inertia', '0.0566', '--out', 'motor'), 'motor', 'joint'),
    ],
)
def test_one_command_makes_a_model_that_the_others_take(sosml, arguments, folder, joint):
    code, out, err = sosml('model', *arguments, '--json')
    assert (code, err) == (0, '')
    document = checked(out, 'model')
    assert list(document['joints']) == [joint]
    assert read_model(folder).make_robot().names == (joint,)
    code, _, err = sosml('export', folder, '--to', 'csv')
    assert (code, err) == (0, '')
    # It may be made anew.
    assert sosml('model', *arguments)[0] == 0


def test_the_model_of_a_urdf_says_what_the_urdf_leaves_open(sosml, make_serial_arm, tmp_path):
    urdf = make_serial_arm(['revolute', 'continuous', 'prismatic', 'prismatic'])
    urdf = urdf.replace('effort="20"', '').replace(
        '<limit lower="-4"', '<mimic joint="j3" multiplier="-1"/><limit lower="-4"'
    )
    (tmp_path / 'arm.urdf').write_text(urdf)
    code, out, err = sosml('model', 'new', 'arm.urdf', '--json')
    assert (code, err) == (0, '')
    document = checked(out, 'model')
    assert list(document['joints']) == ['j1', 'j2', 'j3']
    assert document['followers'] == {'j4': 'j3'}
    assert document['held'] == {}
    j2 = document['joints']['j2']
    assert (j2['armature']['value'], j2['effort_limit'], j2['lower_limit']) == (None, None, None)
    assert j2['armature']['reason']
    assert set(j2['not_known']) == {'friction', 'effort limit'}
    assert read_model('chain_model').unknown_armature == ('j1', 'j2', 'j3')


def test_what_is_stated_is_in_the_model(sosml, make_serial_arm, tmp_path):
    (tmp_path / 'arm.urdf').write_text(make_serial_arm(['revolute'] * 3))
    stated = ('--armature', '0.1', '--armature', 'j1=0.2', '--locked', 'j3=0.5')
    code, out, err = sosml('model', 'new', 'arm.urdf', *stated, '--out', 'arm')
    assert (code, err) == (0, '')
    assert 'Not known' not in out
    robot = read_model('arm').make_robot()
    assert (robot.names, robot.armature, robot.held) == (('j1', 'j2'), (0.2, 0.1), {'j3': 0.5})
    code, out, _ = sosml('model', 'new', 'arm.urdf', '--joints', 'j2')
    assert code == 0
    assert 'Joints j1, j3 of the URDF are not in the model and held at 0' in out


@pytest.mark.parametrize(
    ('file', 'old', 'new'),
    [
        ('model.yaml', 'value: null', 'value: 0.1'),
        ('model.yaml', 'name: pendulum', '# mine\nname: pendulum'),
        ('robot.urdf', 'mass value="1.0"', 'mass value="1.1"'),
    ],
    ids=['value', 'comment', 'urdf'],
)
def test_a_model_that_a_person_changed_is_overwritten_by_force_alone(
    sosml, tmp_path, file, old, new
):
    make = ('model', 'pendulum', '--mass', '1', '--length', '0.25')
    assert sosml(*make)[0] == 0
    path = tmp_path / 'pendulum' / file
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    code, _, err = sosml(*make)
    assert code == 2
    assert f'{file} in pendulum changed since' in err
    assert new in path.read_text()
    assert sosml(*make, '--force')[0] == 0
    assert new not in path.read_text()


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (('axis', '--mass', '-1'), 'the mass is -1 kg'),
        (('axis',), "missing option '--mass'"),
        (('pendulum', '--mass', '1', '--length', '0.2', '--out', 'mine'), 'not overwritten'),
        (('free', '--inertia', '1', '--out', 'arm.urdf'), 'not overwritten'),
        (('new', 'absent.urdf'), 'cannot be read'),
        (('new', 'mine/notes.txt'), 'cannot be read'),
        (('new', 'arm.urdf', '--joints', 'j1,j9'), 'no joint j9 that moves'),
        (('new', 'arm.urdf', '--armature', 'j9=1'), 'stated for j9'),
        (('new', 'arm.urdf', '--armature', 'much'), '--armature much has no number'),
        (('new', 'arm.urdf', '--locked', 'j1=0'), 'all joints of model chain are locked'),
        (('new', 'arm.urdf', '--locked', 'j9=0'), 'joint j9 cannot be locked'),
    ],
)
def test_what_cannot_be_made_is_refused(refused, make_serial_arm, tmp_path, arguments, words):
    (tmp_path / 'mine').mkdir()
    (tmp_path / 'mine' / 'notes.txt').write_text('notes')
    (tmp_path / 'arm.urdf').write_text(make_serial_arm(['revolute']))
    assert words in refused('model', *arguments)


def test_a_bag_without_a_model_is_fitted_with_its_armature_stated(sosml, tmp_path):
    """As one option, and as a model made of the bag: the same numbers."""
    record(tmp_path / 'bag', slider_log(), model=False)
    code, out, err = sosml('fit', 'bag', '--armature', '0', '--json')
    assert (code, err) == (0, '')
    found = json.loads(out)['joints']['slider']['weak_form']['parameters']
    assert found['coulomb']['value'] == pytest.approx(COULOMB, rel=0.02)
    assert found['viscous']['value'] == pytest.approx(VISCOUS, rel=0.05)
    assert sosml('model', 'new', 'bag', '--armature', '0', '--out', 'axis')[0] == 0
    code, out, _ = sosml('fit', 'bag', '--model', 'axis', '--json', '--out', 'again')
    assert code == 0
    assert json.loads(out)['joints']['slider']['weak_form']['parameters'] == found
    code, _, err = sosml('fit', 'bag', '--armature', 'much')
    assert code == 2
    assert '--armature much has no number' in err
