# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The datasets of HDF5 files as h5py, MATLAB, pandas and recorders of robots write them."""

import numpy as np
import pytest

from sosml_friction.bags.tables import packed_file
from sosml_friction.bags.tables.data_file import DataFile
from sosml_friction.bags.tables.stated_columns import Columns, map_columns
from sosml_friction.exceptions import DataError

T = np.arange(6) * 0.5
Q = np.column_stack([np.sin(T), np.cos(T)])


def test_matlab_7_3_is_read(tmp_path):
    h5py = pytest.importorskip('h5py')
    path = tmp_path / 'x.mat'
    with h5py.File(path, 'w', userblock_size=512) as content:
        content['arm/q'] = Q.T
        content['t'] = T[None, :]
        cells = [
            content.create_dataset(f'#refs#/{k}', data=x[None]).ref for k, x in enumerate((T, -T))
        ]
        content.create_dataset('joints/q', data=np.array([cells], dtype=h5py.ref_dtype))
    head = b'MATLAB 7.3 MAT-file'.ljust(116) + bytes(8) + b'\x00\x02IM'
    with path.open('r+b') as stream:
        stream.write(head)
    data = DataFile(path)
    assert list(data.series()) == ['arm.q[0]', 'arm.q[1]', 'joints.q[0]', 'joints.q[1]', 't']
    np.testing.assert_array_equal(data['joints.q[1]'], -T)


def test_datasets_are_read_by_their_paths(tmp_path):
    h5py = pytest.importorskip('h5py')
    path = tmp_path / 'x.h5'
    with h5py.File(path, 'w') as content:
        content['t'] = T
        content.create_dataset('arm/q', data=Q, compression='gzip')
        content['robot'] = 'of some kind'
        content['camera/rgb'] = np.zeros((len(T), 4, 4, 3), dtype=np.uint8)
    data = DataFile(path)
    assert list(data) == ['arm.q', 'robot', 't']
    np.testing.assert_array_equal(data['arm.q[1]'], Q[:, 1])


def written(path, variables):
    h5py = pytest.importorskip('h5py')
    with h5py.File(path, 'w') as content:
        for name, values in variables.items():
            content[name] = values
    return path


def test_the_name_mat_of_an_hdf5_file_without_the_head_of_matlab_is_no_matter(tmp_path):
    path = written(tmp_path / 'x.mat', {'t': T, 'q': Q[:, 0]})
    np.testing.assert_array_equal(DataFile(path)['q'], Q[:, 0])


def test_which_side_of_a_table_has_the_samples_is_no_matter(tmp_path):
    for name, table in (('rows.h5', Q.T), ('columns.h5', Q)):
        data = DataFile(written(tmp_path / name, {'q': table}))
        np.testing.assert_array_equal(data['q[1]'], Q[:, 1])


def test_records_and_tables_of_pandas_have_the_names_of_their_columns(tmp_path):
    records = np.zeros(len(T), dtype=[('t', float), ('q', float, (2,))])
    records['t'], records['q'] = T, Q
    data = DataFile(written(tmp_path / 'x.h5', {'log/table': records}))
    assert list(data.series()) == ['log.table.t', 'log.table.q[0]', 'log.table.q[1]']
    frame = {'d/block0_items': [b't', b'q'], 'd/block0_values': np.column_stack([T, Q[:, 0]])}
    data = DataFile(written(tmp_path / 'y.h5', frame))
    np.testing.assert_array_equal(data['q'], Q[:, 0])


def test_a_unit_beside_a_dataset_is_the_unit_behind_its_name(tmp_path):
    path = written(tmp_path / 'x.h5', {'q': T, 'i': T})
    import h5py

    with h5py.File(path, 'r+') as content:
        content['q'].attrs['units'] = 'deg'
        content['i'].attrs['unit'] = np.bytes_('mA')
    assert list(DataFile(path)) == ['i [mA]', 'q [deg]']


@pytest.mark.parametrize('content', [b'', b't,q\n0,1\n', None])
def test_what_is_no_hdf5_or_is_cut_off_is_refused(tmp_path, content):
    path = written(tmp_path / 'x.h5', {'q': Q})
    path.write_bytes(path.read_bytes()[:-8] if content is None else content)
    with pytest.raises(DataError, match=r'x\.h5 is no readable HDF5 file') as caught:
        DataFile(path)
    assert '\n' not in str(caught.value)


def test_a_dataset_that_unpacks_to_far_more_than_it_takes_is_refused(tmp_path, monkeypatch):
    h5py = pytest.importorskip('h5py')
    monkeypatch.setattr(packed_file, '_UNPACKED', 2**20)
    with h5py.File(tmp_path / 'x.h5', 'w') as content:
        content.create_dataset(
            'q', shape=(2**40,), dtype=float, chunks=(2**10,), compression='gzip'
        )
    with pytest.raises(DataError, match='says that it unpacks to 8796093022208'):
        DataFile(tmp_path / 'x.h5')


def test_a_column_of_a_table_with_a_unit_is_found_without_it(tmp_path):
    h5py = pytest.importorskip('h5py')
    path = tmp_path / 'x.h5'
    with h5py.File(path, 'w') as content:
        content['log/t'], content['log/q'], content['log/tau'] = T, Q, 2.0 * Q
        content['log/q'].attrs['unit'], content['log/tau'].attrs['unit'] = 'rad', 'Nm'
    data = DataFile(path)
    assert data.find_series('log.q[1]') == 'log.q [rad][1]'
    assert data.find_series('log.q [rad][1]') == 'log.q [rad][1]'
    stated = Columns({'position': ['log.q[1]'], 'effort': ['log.tau[1]']}, time='log.t:s')
    (joint,) = map_columns(data, stated).content['joints'].values()
    assert joint['position'] == {'variable': 'log.q [rad][1]', 'unit': 'rad'}
    assert joint['effort']['unit'] == 'Nm'
