# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A table with a row for each joint is one with columns for each."""

import numpy as np
import pytest

from sosml_friction.bags.tables.data_file import DataFile
from sosml_friction.bags.tables.guess import guess_mapping

T = np.arange(400.0) * 0.005
Q = {'elbow': np.sin(3.0 * T), 'wrist': np.cos(2.0 * T)}


def write(path, name, joints, lag=0.0):
    lines = [f'time,{name},position']
    for k, t in enumerate(T.tolist()):
        for j, joint in enumerate(joints):
            lines.append(f'{t + j * lag!r},{joint},{list(Q.values())[j][k].item()!r}')
    path.write_text('\n'.join(lines))
    return DataFile(path)


@pytest.mark.parametrize(
    ('name', 'joints', 'called'),
    [
        ('joint_name', ('elbow', 'wrist'), ('elbow', 'wrist')),
        ('motor id', (1, 2), ('joint_1', 'joint_2')),
        ('ID', ('1.0', '2.0'), ('joint_1', 'joint_2')),
    ],
)
@pytest.mark.parametrize('lag', [0.0, 0.001])
def test_joints_that_take_turns_have_columns_each(tmp_path, name, joints, called, lag):
    data = write(tmp_path / 'x.csv', name, joints, lag)
    content = guess_mapping(data).content
    assert list(content['joints']) == list(called)
    for joint, q in zip(called, Q.values(), strict=True):
        found = data[content['joints'][joint]['position']['variable']]
        np.testing.assert_array_equal(found, q)
    np.testing.assert_array_equal(data[content['time']['variable']], T)


def test_a_turn_that_was_not_finished_is_left_out(tmp_path):
    write(tmp_path / 'x.csv', 'joint', ('elbow', 'wrist'))
    with (tmp_path / 'x.csv').open('a') as file:
        file.write('\n2.0,elbow,0.5\n')
    assert len(DataFile(tmp_path / 'x.csv')['wrist position']) == len(T)


@pytest.mark.parametrize('joints', [('elbow', 'elbow'), ('elbow', 'wrist')])
def test_without_turns_a_table_stays_as_it_is(tmp_path, joints):
    write(tmp_path / 'x.csv', 'joint', joints)
    with (tmp_path / 'x.csv').open('a') as file:
        file.write('\n2.0,wrist,0.5\n2.1,wrist,0.5\n')
    assert list(DataFile(tmp_path / 'x.csv')) == ['time', 'joint', 'position']
