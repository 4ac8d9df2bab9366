# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Tables of text that are packed are read as they are unpacked, or refused in a sentence."""

import bz2
import gzip
import lzma
import random
import zipfile

import pytest

from sosml_friction.bags.tables import packed_file
from sosml_friction.bags.tables.data_file import DataFile
from sosml_friction.exceptions import DataError

TEXT = b't,q\n0,1\n1,2.5\n'


def archive(path, **members):
    with zipfile.ZipFile(path, 'w', zipfile.ZIP_DEFLATED) as stream:
        for name, content in members.items():
            stream.writestr(name.replace('_', '.'), content)


@pytest.mark.parametrize(
    ('name', 'content'),
    [
        ('x.csv.gz', gzip.compress(TEXT)),
        ('x.gz', gzip.compress(TEXT)),
        ('x.csv.bz2', bz2.compress(TEXT)),
        ('x.txt.xz', lzma.compress(TEXT.replace(b',', b'\t'))),
        ('x.csv.lzma', lzma.compress(TEXT, lzma.FORMAT_ALONE)),
        ('x.json.gz', gzip.compress(b'{"t": [0, 1], "q": [1, 2.5]}')),
        # The name is wrong, the bytes are not.
        ('x.csv', gzip.compress(TEXT)),
        ('x.csv.gz', TEXT),
    ],
    # The bytes have the time of packing in them.
    ids=lambda each: each if isinstance(each, str) else '',
)
def test_a_packed_table_is_read_as_what_is_in_it(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    data = DataFile(tmp_path / name)
    assert {name: data[name].tolist() for name in data} == {'t': [0, 1], 'q': [1.0, 2.5]}


@pytest.mark.parametrize('name', ['log/x_csv', 'x_jsonl', 'out'])
def test_the_one_table_of_an_archive_is_read(tmp_path, name):
    lines = b'{"t": 0, "q": 1.0}\n{"t": 1, "q": 2.5}\n'
    path = tmp_path / 'x.zip'
    archive(path, **{name: lines if 'json' in name else TEXT, '__MACOSX/._x': b'\0'})
    assert list(DataFile(path)['q']) == [1.0, 2.5]


def test_what_is_said_of_a_table_is_beside_it_and_no_other_table(tmp_path):
    archive(tmp_path / 'x.zip', README_txt='How it was recorded', x_csv=TEXT)
    assert list(DataFile(tmp_path / 'x.zip')) == ['t', 'q']


@pytest.mark.parametrize(
    ('members', 'sentence'),
    [
        ({'a_csv': TEXT, 'b_csv': TEXT}, r'several tables \(a\.csv, b\.csv\): unpack it'),
        ({'a_mcap': b'1'}, 'is an archive of no table of text: unpack it'),
        ({}, 'is an archive of no table of text: unpack it'),
    ],
)
def test_an_archive_without_its_one_table_is_refused(tmp_path, members, sentence):
    archive(tmp_path / 'x.zip', **members)
    with pytest.raises(DataError, match=sentence):
        DataFile(tmp_path / 'x.zip')


def test_an_archive_with_a_password_is_refused(tmp_path):
    path = tmp_path / 'x.zip'
    archive(path, x_csv=TEXT)
    content = bytearray(path.read_bytes())
    # Bit 0 of the flags, of the member and in the directory behind it.
    content[6] |= 1
    content[content.index(b'PK\x01\x02') + 8] |= 1
    path.write_bytes(content)
    with pytest.raises(DataError, match='locked with a password: unpack it'):
        DataFile(path)


@pytest.mark.parametrize('pack', [gzip.compress, bz2.compress, lzma.compress])
def test_a_packed_table_that_is_cut_off_is_refused(tmp_path, pack):
    whole = pack(random.Random(0).randbytes(2000).hex().encode())
    (tmp_path / 'x.csv.gz').write_bytes(whole[: len(whole) // 2])
    with pytest.raises(DataError, match='ends before what is packed in it does'):
        DataFile(tmp_path / 'x.csv.gz')


def test_a_damaged_packed_table_is_refused(tmp_path):
    whole = bytearray(gzip.compress(TEXT))
    whole[-6] ^= 1
    (tmp_path / 'x.csv.gz').write_bytes(whole)
    with pytest.raises(DataError, match=r'x\.csv\.gz cannot be unpacked: CRC'):
        DataFile(tmp_path / 'x.csv.gz')
    (tmp_path / 'x.zip').write_bytes(b'PK\x03\x04' + bytes(40))
    with pytest.raises(DataError, match=r'x\.zip cannot be unpacked: File is not a zip'):
        DataFile(tmp_path / 'x.zip')


@pytest.mark.parametrize('name', ['x.csv.gz', 'x.zip'])
def test_no_more_is_unpacked_than_a_recording_may_be(tmp_path, monkeypatch, name):
    monkeypatch.setattr(packed_file, '_UNPACKED', 2**16)
    zeros = b'0,0\n' * 2**18
    if name == 'x.zip':
        archive(tmp_path / name, x_csv=zeros)
    else:
        (tmp_path / name).write_bytes(gzip.compress(zeros))
    with pytest.raises(DataError, match='and unpacks to more than 65536: unpack it, and keep'):
        DataFile(tmp_path / name)


def test_other_tables_are_not_read_packed(tmp_path):
    (tmp_path / 'x.npz.gz').write_bytes(gzip.compress(b'x'))
    with pytest.raises(DataError, match=r'x\.npz\.gz is packed, as tables of text may be: unpack'):
        DataFile(tmp_path / 'x.npz.gz')
