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


def test_a_table_of_one_joint_stays_as_it_is(tmp_path):
    data = write(tmp_path / 'x.csv', 'joint', ('elbow', 'elbow'))
    assert (list(data), data.remarks) == (['time', 'joint', 'position'], [])


def write_rows(path, name, rows):
    lines = [f'{t!r},{joint},{list(Q.values())[j][k].item()!r}' for k, t, j, joint in rows]
    path.write_text('\n'.join([f'time,{name},position', *lines]))
    return DataFile(path)


def rows_of(joints):
    return [(k, t, j, x) for k, t in enumerate(T.tolist()) for j, x in enumerate(joints)]


def test_a_turn_that_lacks_a_joint_is_left_out_and_told(tmp_path):
    rows = [row for i, row in enumerate(rows_of((1, 2))) if i not in (100, 201, 302, 303, 505)]
    data = write_rows(tmp_path / 'x.csv', 'id', rows)
    kept = np.delete(np.arange(len(T)), [50, 100, 151, 252])
    for k, q in enumerate(Q.values(), 1):
        np.testing.assert_array_equal(data[f'{k} position'], q[kept])
    np.testing.assert_array_equal(data['time'], T[kept])
    assert data.remarks == [
        f'{tmp_path / "x.csv"}: 3 of 795 rows are of turns in which not every id is: left out'
    ]


def test_joints_that_stand_behind_one_another_have_columns_each(tmp_path):
    rows = sorted(rows_of(('elbow', 'wrist')), key=lambda row: row[2])
    data = write_rows(tmp_path / 'x.csv', 'joint', rows)
    for joint, q in Q.items():
        np.testing.assert_array_equal(data[f'{joint} position'], q)
    np.testing.assert_array_equal(data['time'], T)
    # What is called id may be a run.
    data = write_rows(tmp_path / 'y.csv', 'id', rows)
    assert list(data) == ['time', 'id', 'position']
    (told,) = data.remarks
    assert 'id may be the joint of each row (elbow, wrist), and they take no turns' in told


def test_rows_of_two_kinds_in_any_order_take_no_turns(tmp_path):
    rows = rows_of((1, 2))
    rng = np.random.default_rng(0)
    mixed = [(*row[:2], k, k + 1) for row, k in zip(rows, rng.integers(2, size=800), strict=True)]
    assert list(write_rows(tmp_path / 'x.csv', 'joint', mixed)) == ['time', 'joint', 'position']
