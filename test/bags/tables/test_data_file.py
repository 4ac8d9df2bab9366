# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The same series out of every kind of file, and how they are called."""

import json
import struct
import sys
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.io import savemat

from sosml_friction.bags.tables import packed_file
from sosml_friction.bags.tables.data_file import DataFile
from sosml_friction.bags.tables.hdf5_file import SIGNATURE
from sosml_friction.bags.tables.header_words import read_header
from sosml_friction.exceptions import DataError

T = np.arange(6) * 0.5
Q = np.column_stack([np.sin(T), np.cos(T)])


def write_json(path, form):
    records = [
        {'t': t, 'q': q.tolist(), 'motor': {'i': -t}} for t, q in zip(T.tolist(), Q, strict=True)
    ]
    if form == 'lists':
        whole = {'t': T.tolist(), 'q': Q.tolist(), 'motor': {'i': (-T).tolist()}}
        path.write_text(json.dumps(whole))
    elif form == 'records':
        path.write_text(json.dumps(records))
    else:
        path.write_text('\n'.join(map(json.dumps, records)) + '\n')


@pytest.mark.parametrize('form', ['lists', 'records', 'lines'])
@pytest.mark.parametrize('suffix', ['json', 'jsonl', 'ndjson'])
def test_every_form_of_json_holds_the_same_series(tmp_path, form, suffix):
    path = tmp_path / f'x.{suffix}'
    write_json(path, form)
    series = DataFile(path).series()
    assert list(series) == ['t', 'q[0]', 'q[1]', 'motor.i']
    np.testing.assert_array_equal(series['q[1]'], Q[:, 1])
    np.testing.assert_array_equal(series['motor.i'], -T)


def test_a_record_that_lacks_a_value_has_nan(tmp_path):
    path = tmp_path / 'x.jsonl'
    path.write_text('{"t": 0, "q": [1, 2]}\n{"t": 1}\n{"t": 2, "q": [3, 4], "c": null}\n')
    data = DataFile(path)
    np.testing.assert_array_equal(data['q'], [[1, 2], [np.nan, np.nan], [3, 4]])
    assert np.isnan(data['c']).all()


def test_a_null_in_a_list_of_numbers_is_nan(tmp_path):
    (tmp_path / 'x.json').write_text('{"t": [0, 1, 2], "arm": {"q": [0.5, null, 1.5]}}')
    series = DataFile(tmp_path / 'x.json').series()
    np.testing.assert_array_equal(series['arm.q'], [0.5, np.nan, 1.5])


def test_a_list_of_joints_in_each_record_is_a_table_of_each_quantity(tmp_path):
    joints = [[{'q': q, 'i': -q} for q in row] for row in Q.tolist()]
    records = [{'t': t, 'arm': row} for t, row in zip(T.tolist(), joints, strict=True)]
    (tmp_path / 'x.json').write_text(json.dumps(records))
    np.testing.assert_array_equal(DataFile(tmp_path / 'x.json')['arm.q'], Q)


@pytest.mark.parametrize('each', ['sample', 'joint'])
def test_an_array_of_structs_is_a_table_of_each_field(tmp_path, each):
    parts = Q if each == 'sample' else Q.T
    arm = np.zeros(len(parts), dtype=[('q', object)])
    arm['q'] = [*parts]
    savemat(tmp_path / 'x.mat', {'t': T, 'arm': arm})
    series = DataFile(tmp_path / 'x.mat').series()
    np.testing.assert_array_equal(series['arm.q[1]'], Q[:, 1])


def test_records_in_an_npz_file_have_their_fields(tmp_path):
    records = np.array([*zip(T, Q, strict=True)], dtype=[('t', float), ('q', float, 2)])
    np.savez(tmp_path / 'x.npz', log=records)
    assert list(DataFile(tmp_path / 'x.npz').series()) == ['log.t', 'log.q[0]', 'log.q[1]']


@given(st.text(max_size=100))
def test_any_text_is_json_or_a_sentence(tmp_path_factory, text):
    path = tmp_path_factory.mktemp('any') / 'x.json'
    path.write_text(text, encoding='utf-8')
    sentence = ''
    try:
        DataFile(path).series()
    except DataError as error:
        sentence = str(error)
    assert '\n' not in sentence


@pytest.mark.parametrize('turned', [False, True])
def test_a_table_without_names_has_numbers_along_its_shorter_side(tmp_path, turned):
    table = np.column_stack([T, Q])
    np.save(tmp_path / 'x.npy', table.T if turned else table)
    series = DataFile(tmp_path / 'x.npy').series()
    assert list(series) == ['0', '1', '2']
    np.testing.assert_array_equal(series['2'], Q[:, 1])


def test_records_of_numpy_have_their_fields(tmp_path):
    table = np.zeros(6, dtype=[('t', float), ('q', float)])
    table['t'] = T
    np.save(tmp_path / 'x.npy', table)
    np.testing.assert_array_equal(DataFile(tmp_path / 'x.npy')['t'], T)


def test_objects_of_python_are_not_loaded_and_hide_nothing(tmp_path):
    np.savez(tmp_path / 'x.npz', t=T, meta=np.array({'a': 1}, dtype=object), k=2.5)
    data = DataFile(tmp_path / 'x.npz')
    assert list(data.series()) == ['t']
    assert data.constants() == {'k': 2.5}
    with pytest.raises(DataError, match='holds object: real numbers are needed'):
        data['meta']


def test_names_are_found_without_unit_and_case_and_by_number(tmp_path):
    np.savez(tmp_path / 'x.npz', **{'Time [s]': T, 'q (rad)': Q[:, 0], 'both': Q})
    data = DataFile(tmp_path / 'x.npz')
    assert data.find('Time') == data.find('time') == data.find('0') == 'Time [s]'
    assert data.find('q') == 'q (rad)'
    np.testing.assert_array_equal(data['both[1]'], Q[:, 1])
    with pytest.raises(DataError, match=r'it has no column 2 \(counted from 0\)'):
        data['both[2]']
    with pytest.raises(DataError, match="has no variable 'x': it has Time"):
        data['x']


@pytest.mark.parametrize(
    ('name', 'head', 'needed', 'sentence'),
    [
        ('x.parquet', b'PAR1', 'pyarrow', 'needs pyarrow: pip install pyarrow'),
        ('x.xlsx', b'PK', 'openpyxl', 'which needs openpyxl: pip install openpyxl, or save'),
        ('x.h5', SIGNATURE, 'h5py', 'an HDF5 file, which needs h5py: pip install h5py'),
        ('x.mat', SIGNATURE, 'h5py', r"needs h5py: save it with '-v7', or pip install h5py"),
    ],
    ids=lambda each: each if isinstance(each, str) else '',
)
def test_what_a_kind_of_file_needs_is_told(tmp_path, monkeypatch, name, head, needed, sentence):
    (tmp_path / name).write_bytes(head)
    # An import then fails as if it were not there.
    monkeypatch.setitem(sys.modules, needed, None)
    with pytest.raises(DataError, match=sentence):
        DataFile(tmp_path / name)


def test_parquet_is_read(tmp_path):
    pa = pytest.importorskip('pyarrow')
    parquet = pytest.importorskip('pyarrow.parquet')
    path = tmp_path / 'x.parquet'
    parquet.write_table(pa.table({'t': T, 'q': list(Q)}), path)
    assert list(DataFile(path).series()) == ['t', 'q[0]', 'q[1]']


@pytest.mark.parametrize(
    ('cell', 'sentence'),
    [
        ('1_0', "line 3, column 'q': '1_0' is not a number"),
        ('inf', "line 3, column 'q': 'inf' is not a finite number .leave a missing value empty"),
        ('-1e999', "line 3, column 'q': '-1e999' is not a finite number"),
    ],
)
def test_a_cell_that_only_python_takes_for_a_number_is_refused(tmp_path, cell, sentence):
    path = tmp_path / 'x.csv'
    path.write_text(f't,q\n0,1\n1,{cell}\n2,3\n3,4\n')
    with pytest.raises(DataError, match=sentence):
        DataFile(path)['q']


def test_what_unpacks_to_far_more_than_it_takes_is_refused_before_it_does(tmp_path, monkeypatch):
    monkeypatch.setattr(packed_file, '_UNPACKED', 2**20)
    zeros = np.zeros(2**18)
    np.savez_compressed(tmp_path / 'x.npz', t=T, zeros=zeros)
    savemat(tmp_path / 'x.mat', {'t': T, 'zeros': zeros}, do_compression=True)
    for name in ('x.npz', 'x.mat'):
        with pytest.raises(DataError, match=r'x\.... takes \d+ bytes and says that it unpacks to'):
            DataFile(tmp_path / name)
    # What was measured does not pack so well, whatever its size.
    noise = np.random.default_rng(0).normal(size=2**18)
    np.savez_compressed(tmp_path / 'x.npz', noise=noise)
    savemat(tmp_path / 'x.mat', {'noise': noise}, do_compression=True)
    for name in ('x.npz', 'x.mat'):
        assert np.array_equal(DataFile(tmp_path / name)['noise'], noise)


def test_a_packed_mat_file_that_is_cut_off_is_refused_at_once(tmp_path):
    path = tmp_path / 'x.mat'
    savemat(path, {'q': np.random.default_rng(0).normal(size=2000)}, do_compression=True)
    whole = path.read_bytes()
    # Its one variable says that it is 4 GB long: the file ends before it does.
    path.write_bytes(whole[:132] + b'\xff\xff\xff\xff' + whole[136 : len(whole) // 2])
    with pytest.raises(DataError, match=r'x\.mat cannot be read: could not read'):
        DataFile(path)


def test_a_parquet_table_is_counted_by_the_widths_of_its_columns(tmp_path, monkeypatch):
    pa = pytest.importorskip('pyarrow')
    parquet = pytest.importorskip('pyarrow.parquet')
    monkeypatch.setattr(packed_file, '_UNPACKED', 2**20)
    path, rows = tmp_path / 'x.parquet', 2**13
    # 0.4 MB, where 8 bytes for each value were 3.3 MB.
    wide = {f'flag{k}': np.zeros(rows, dtype=bool) for k in range(48)}
    parquet.write_table(pa.table({'t': np.zeros(rows), **wide}), path)
    assert len(DataFile(path).series()) == 49
    for column in (np.zeros(2**18), [[0.0] * 2**6] * 2**12):
        parquet.write_table(pa.table({'x': column}), path)
        with pytest.raises(DataError, match=r'x\.parquet takes \d+ bytes and says that it unpac'):
            DataFile(path)


@pytest.mark.parametrize('packed', [False, True])
@pytest.mark.parametrize('kind', [0, 8, 46, 2**16 - 1])
def test_a_mat_file_with_data_of_no_type_is_refused(tmp_path, packed, kind):
    path = tmp_path / 'x.mat'
    savemat(path, {'arm': {'q': T}})
    content = path.read_bytes()
    assert list(DataFile(path)) == ['arm.q']
    # A double is of type 9. Where none is, the reader of scipy 1.17 ends the process.
    place = content.index(struct.pack('<II', 9, T.nbytes))
    content = content[:place] + struct.pack('<I', kind) + content[place + 4 :]
    if packed:
        inner = zlib.compress(content[128:])
        content = content[:128] + struct.pack('<II', 15, len(inner)) + inner
    path.write_bytes(content)
    with pytest.raises(DataError, match=rf'x\.mat is no readable MAT file: .* of type {kind}'):
        DataFile(path)


@pytest.mark.parametrize(
    'header', ['Zeit / s;Winkel / rad', 'Zeit/s;Winkel/rad', 'Zeit, s;Winkel, rad']
)
def test_a_unit_may_stand_behind_a_stroke_or_a_comma(tmp_path, header):
    (tmp_path / 'x.csv').write_text(f'{header}\n0,5;1,5\n0,75;2,5\n')
    assert DataFile(tmp_path / 'x.csv')['Winkel'].tolist() == [1.5, 2.5]


def structs(**fields):
    """Return an array of structs as MATLAB has it, (N,)."""
    made = np.zeros(len(next(iter(fields.values()))), dtype=[(name, 'O') for name in fields])
    for name, values in fields.items():
        for k, value in enumerate(values):
            made[name][k] = value
    return made


def test_signals_of_a_scope_have_their_names_and_units(tmp_path):
    scope = structs(values=[Q, -Q], dimensions=[2, 2], label=['q', 'tau'])
    recorder = structs(Name=['M/q', 'M/i'], Data=[T[None], -T[None]], Unit=['deg', 'A'])
    unnamed = structs(values=[Q, -Q], label=['', ''])
    content = {'scope': {'time': T, 'signals': scope}, 'rec': {'Y': recorder}, 'x': unnamed}
    savemat(tmp_path / 'x.mat', content)
    data = DataFile(tmp_path / 'x.mat')
    assert set(data) == {
        *('scope.time', 'scope.signals.q', 'scope.signals.tau'),
        *('rec.Y.M/q [deg]', 'rec.Y.M/i [A]', 'x.0', 'x.1'),
    }
    np.testing.assert_array_equal(data['scope.signals.tau[1]'], -Q[:, 1])
    np.testing.assert_array_equal(data['rec.Y.M/i [A]'], -T)


def test_records_of_samples_are_no_signals(tmp_path):
    records = structs(name=['a'] * 6, t=list(T), q=list(Q))
    savemat(tmp_path / 'x.mat', {'log': records})
    assert list(DataFile(tmp_path / 'x.mat').series()) == ['log.t', 'log.q[0]', 'log.q[1]']


@pytest.mark.parametrize('form', ['split', 'index'])
def test_a_table_of_pandas_in_json_has_its_names(tmp_path, form):
    rows = np.column_stack([T, Q[:, 0]]).tolist()
    split = {'columns': ['t', 'q'], 'index': list(range(len(T))), 'data': rows}
    index = {str(k): {'t': t, 'q': q} for k, (t, q) in enumerate(rows)}
    (tmp_path / 'x.json').write_text(json.dumps(split if form == 'split' else index))
    data = DataFile(tmp_path / 'x.json')
    assert list(data) == ['t', 'q']
    np.testing.assert_array_equal(data['q'], Q[:, 0])


def test_messages_that_were_printed_are_no_table(tmp_path):
    (tmp_path / 'x.txt').write_text('header:\n  stamp:\n    sec: 1\nposition:\n- 0.5\n---\n' * 3)
    with pytest.raises(DataError, match='ros2 topic echo prints: let it write a table, with --cs'):
        DataFile(tmp_path / 'x.txt')


@pytest.mark.parametrize('name', ['Istposition °', 'Istdrehzahl 1/min', 'Istmoment %', 'v rad/s'])
def test_a_unit_that_is_no_word_may_stand_behind_a_blank(tmp_path, name):
    (tmp_path / 'x.csv').write_text(f'Zeit ms;{name}\n' + '0;1.5\n2;2.5\n')
    data, bare = DataFile(tmp_path / 'x.csv'), name.split()[0]
    assert data.find(bare) == name
    unit = {'°': 'deg', '1/min': 'rpm', '%': 'percent', 'rad/s': 'rad/s'}[name.split()[1]]
    assert read_header(name).unit == unit
