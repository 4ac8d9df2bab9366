# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""``sosml trajectory``: what it asks of a robot, its files, and what is refused."""

import shutil

import numpy as np
import pytest
from slider_bags import EMPS, checked

from sosml_friction.model.model_folder import read_model
from sosml_friction.motion.trajectories import TRAJECTORIES
from sosml_friction.share import share_directory


@pytest.mark.parametrize('name', list(TRAJECTORIES))
def test_trajectory_draws_writes_and_tells_what_it_asks_of_the_exoskeleton(sosml, tmp_path, name):
    """The options are those of config/exoskeleton.yaml, which belongs to the model folder."""
    code, out, err = sosml('trajectory', name, '--json', '--plot=t.png', '--out=t.csv')
    assert (code, err) == (0, '')
    document = checked(out, 'trajectory')
    assert document['trajectory'] == name
    assert document['fits']
    assert document['beyond'] == []
    assert document['options']['centre'] == pytest.approx([-np.pi / 2, 1.2])
    assert (document['plot'], document['output']) == ('t.png', 't.csv')
    if name == 'speed_ladder':
        assert document['options']['plateau'] == 1.0
    assert (tmp_path / 't.png').read_bytes().startswith(b'\x89PNG')
    with (tmp_path / 't.csv').open() as file:
        header = file.readline().strip().split(',')
        rows = np.loadtxt(file, delimiter=',')
    assert header[:3] == ['time [s]', 'shoulder position [rad]', 'shoulder velocity [rad/s]']
    assert rows[-1, 0] == pytest.approx(document['duration_s'])
    elbow = document['joints']['elbow']
    assert elbow['position']['highest'] == pytest.approx(rows[:, 5].max())
    assert elbow['speed']['peak'] == pytest.approx(np.abs(rows[:, 6]).max())
    assert elbow['effort']['peak'] == pytest.approx(np.abs(rows[:, 8]).max())
    # 15 % of 5 Nm.
    assert elbow['effort']['friction_allowance'] == pytest.approx(0.75)
    robot = read_model(share_directory() / 'config' / 'exoskeleton').make_robot()
    k = len(rows) // 3
    q, v, a, tau = (rows[k, [1 + i, 5 + i]] for i in range(4))
    np.testing.assert_allclose(robot.inverse_dynamics(q, v, a), tau, atol=1e-6)
    # A second run replaces both.
    assert sosml('trajectory', name, '--plot=t.png', '--out=t.csv')[0] == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ['t.csv', 't.png']


def test_a_trajectory_beyond_the_limits_ends_with_1_and_a_sentence(sosml, tmp_path):
    """The picture shows where; samples that nobody should run are not written."""
    beyond = ('trajectory', 'speed_ladder', '--set=centre=0,1', '--plot=t.png', '--out=t.csv')
    code, out, err = sosml(*beyond, '--json')
    assert code == 1
    document = checked(out, 'trajectory')
    assert not document['fits']
    assert 'joint shoulder to a rigid-body effort of' in document['beyond'][0]
    assert document['output'] is None
    assert err.strip() == 'sosml: t.csv is not written: the trajectory is beyond a limit'
    assert [path.name for path in tmp_path.iterdir()] == ['t.png']
    code, out, _ = sosml(*beyond[:3])
    assert code == 1
    assert 'Beyond a limit: the trajectory takes joint shoulder to' in out
    assert '168 %' in out


def test_trajectory_of_a_prismatic_joint_begins_in_the_middle_of_its_range(sosml):
    options = ('--set', 'speeds=0.01,0.05', '--set', 'top_speed=0.1', '--set=scale=0.5')
    code, out, _ = sosml('trajectory', 'speed_ladder', '--model', EMPS, *options, '--json')
    assert code == 0
    slider = checked(out, 'trajectory')['joints']['slider']
    assert slider['unit'] == 'N'
    lowest, highest = slider['position']['lowest'], slider['position']['highest']
    assert 0.5 * (lowest + highest) == pytest.approx(0.125)
    assert slider['speed']['peak'] >= 0.5 * 0.05
    code, out, _ = sosml('trajectory', 'speed_ladder', '--model', EMPS, *options)
    assert 'm/s2' in out
    assert 'All within the limits.' in out


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (['zigzag'], "trajectory 'zigzag' is unknown: use speed_ladder, "),
        (['reversal', '--set', 'cycles'], 'write KEY=VALUE with amplitude, frequency'),
        (['reversal', '--set', 'speeds=1'], "'speeds=1' sets no option of reversal"),
        (['reversal', '--set', 'amplitude=much'], "amplitude is 'much': give a number"),
        (['multisine', '--set', 'seed=1.5'], "seed is '1.5': give a whole number"),
        (['multisine', '--set', 'centre=1'], 'centre has 1 values for the joints shoulder, elbow'),
        (['multisine', '--set', 'acceleration_limit=1,2,3'], '3 values for 2 joints'),
        (['rich', '--plot', 'rich.pdf'], 'does not end in .png'),
        (['rich', '--out', 'nowhere/rich.csv'], 'is no folder'),
        (['rich', '--model', 'nowhere'], 'nowhere'),
        (['rich', '--urdf', 'nowhere.urdf'], 'nowhere.urdf cannot be read'),
    ],
)
def test_a_trajectory_that_cannot_be_is_refused(refused, arguments, words):
    assert words in refused('trajectory', *arguments)


def test_trajectory_overwrites_no_foreign_file(refused, tmp_path):
    (tmp_path / 'thesis.png').write_text('mine')
    assert 'something else' in refused('trajectory', 'reversal', '--plot', 'thesis.png')
    (tmp_path / 'data.csv').write_text('a,b\n')
    assert 'something else' in refused('trajectory', 'reversal', '--out', 'data.csv')


def test_trajectory_takes_its_options_from_the_parameter_file_beside_the_model(
    sosml, refused, tmp_path
):
    """Nested or with a point, under the name of the trajectory; --set has the last word."""
    shutil.copytree(share_directory() / 'config' / 'exoskeleton', tmp_path / 'config' / 'mine')
    shutil.copytree(share_directory() / 'urdf', tmp_path / 'urdf')
    parameters = tmp_path / 'config' / 'mine.yaml'
    text = """/**/identifier_node:
  ros__parameters:
    centre: [-1.4, 1.0]
    acceleration_limit: [9.0]
    reversal: {amplitude: 0.2, cycles: 3.0}
    reversal.frequency: 0.4
"""
    parameters.write_text(text)
    command = ('trajectory', 'reversal', '--model', 'config/mine')
    document = checked(sosml(*command, '--set', 'cycles=2', '--json')[1], 'trajectory')
    options = document['options']
    assert (options['amplitude'], options['frequency'], options['cycles']) == (0.2, 0.4, 2.0)
    assert options['centre'] == [-1.4, 1.0]
    assert document['joints']['elbow']['acceleration']['limit'] == 9.0
    parameters.write_text(text.replace('0.4', 'fast'))
    assert 'reversal.frequency of identifier_node in ' in refused(*command)
    parameters.write_text('{')
    assert 'the parameter file beside the model, ' in refused(*command)
