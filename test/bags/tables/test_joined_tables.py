# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Files with a joint each are one table where names and times say so, and refused otherwise."""

import numpy as np
import pytest

from sosml_friction.bags.tables.data_file import DataFile
from sosml_friction.bags.tables.joined_tables import join_tables
from sosml_friction.exceptions import ConfigurationError, DataError

T = np.arange(6) * 0.5
JOINTS = ('arm_joint_1', 'arm_joint_2')


@pytest.fixture
def files(tmp_path):
    def write(*names, times=T, header='time,"q, rad"'):
        paths = [tmp_path / name for name in names]
        for k, path in enumerate(paths):
            rows = ''.join(f'{t + 0.01 * k * (times is not T)},{k + t}\n' for t in times)
            path.write_text(f'{header}\n{rows}')
        return paths

    return write


@pytest.mark.parametrize(
    'names', [('arm_joint_2.csv', 'arm-joint-1.csv'), ('run7_J2.csv', 'run8_J1.csv')]
)
def test_the_columns_of_each_file_have_its_joint_before_their_names(tmp_path, files, names):
    stated = {'position': 'q:deg', 'effort': '1', 'time': 'time:s'}
    table, order, columns = join_tables(files(*names), JOINTS, tmp_path, stated)
    assert order == ['arm_joint_2', 'arm_joint_1']
    assert columns == {
        'position': 'arm_joint_2=arm_joint_2 q/ rad:deg,arm_joint_1=arm_joint_1 q/ rad:deg',
        'effort': 'arm_joint_2 q/ rad,arm_joint_1 q/ rad',
    }
    data = DataFile(table)
    assert list(data) == ['time', 'arm_joint_2 q/ rad', 'arm_joint_1 q/ rad']
    np.testing.assert_array_equal(data['time'], T)
    np.testing.assert_array_equal(data['arm_joint_1 q'], 1.0 + T)


@pytest.mark.parametrize('names', [('run_1.csv', 'run_2.csv'), ('j1_a.csv', 'j1_b.csv')])
def test_names_that_do_not_say_which_joint_each_is_are_refused(tmp_path, files, names):
    with pytest.raises(ConfigurationError, match='their names do not say which of arm_joint_1, '):
        join_tables(files(*names), JOINTS, tmp_path, {})


def test_other_times_are_refused(tmp_path, files):
    with pytest.raises(DataError, match=r'j1\.csv, j2\.csv have one .*, and other times: put'):
        join_tables(files('j1.csv', 'j2.csv', times=T + 1.0), JOINTS, tmp_path, {})


def test_without_a_time_each_file_needs_as_many_samples(tmp_path, files):
    paths = files('j1.csv', 'j2.csv', header='x,q')
    for path in paths:
        path.write_text('q,f\n1,0\n-1,1\n2,0\n')
    assert list(DataFile(join_tables(paths, JOINTS, tmp_path, {})[0])['sample']) == [0, 1, 2]
    paths[1].write_text('q,f\n1,0\n-1,1\n')
    with pytest.raises(DataError, match='and other times'):
        join_tables(paths, JOINTS, tmp_path, {})


def test_a_column_that_the_files_do_not_have_is_told(tmp_path, files):
    with pytest.raises(DataError, match=r"j1\.csv has no variable 'tau'"):
        join_tables(files('j1.csv', 'j2.csv'), JOINTS, tmp_path, {'effort': 'tau:Nm'})
