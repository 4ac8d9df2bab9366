# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Sheets of Excel files are read by the rules of tables of text."""

import datetime

import pytest

from sosml_friction.bags.tables import packed_file
from sosml_friction.bags.tables.data_file import DataFile
from sosml_friction.exceptions import DataError

ROWS = [[0.0, 1.5], [0.25, 2.5], [0.5, -1e-7]]
HEADER = ['t', 'q']


def book(path, **sheets):
    openpyxl = pytest.importorskip('openpyxl')
    made = openpyxl.Workbook()
    made.remove(made.active)
    for name, rows in sheets.items():
        sheet = made.create_sheet(name)
        for row in rows:
            sheet.append(row)
    made.save(path)
    return path


def test_a_sheet_is_read_with_its_header(tmp_path):
    data = DataFile(book(tmp_path / 'x.xlsx', run=[HEADER, *ROWS]))
    assert {name: data[name].tolist() for name in data} == {
        't': [0.0, 0.25, 0.5],
        'q': [1.5, 2.5, -1e-7],
    }


def test_the_header_is_that_of_a_table_of_text_wherever_it_stands(tmp_path):
    info = [['operator', 'somebody'], ['mass', 2.0], ['length', 0.5], ['rate', 4], ['gear', 9]]
    above = [['Test 5'], [], [None, 'Time', 'Angle'], [None, 's', 'deg']]
    path = book(tmp_path / 'x.xlsx', Info=info, Data=[*above, *([None, *r] for r in ROWS)])
    data = DataFile(path)
    assert data['Angle [deg]'].tolist() == [1.5, 2.5, -1e-7]
    assert data.remarks == []


def test_dates_commas_and_missing_values_are_read(tmp_path):
    start = datetime.datetime(2025, 3, 30, 12)
    stamps = [start + datetime.timedelta(milliseconds=5 * k) for k in range(3)]
    rows = [[stamps[0], '1,5', 1], [stamps[1], None, '#DIV/0!'], [stamps[2], '2,25', 3]]
    data = DataFile(book(tmp_path / 'x.xlsx', run=[['t', 'q', 'f'], *rows]))
    assert data['t'][2] - data['t'][0] == pytest.approx(0.01, abs=1e-6)  # float64 of 2025 in s
    assert str(data['q'].tolist()) == '[1.5, nan, 2.25]'
    assert str(data['f'].tolist()) == '[1.0, nan, 3.0]'


def test_of_several_sheets_of_numbers_the_longest_is_read_and_it_is_told(tmp_path):
    path = book(tmp_path / 'x.xlsx', a=[HEADER, *ROWS[:2]], b=[HEADER, *ROWS], c=[HEADER, *ROWS])
    data = DataFile(path)
    assert len(data['q']) == 3
    assert data.remarks == [f'the sheet b of {path} was read, and not a, c']


@pytest.mark.parametrize('content', [b'', b't,q\n0,1\n', b'\xd0\xcf\x11\xe0' * 200, None])
def test_what_is_no_excel_file_is_refused(tmp_path, content):
    path = book(tmp_path / 'x.xlsx', run=[HEADER, *ROWS])
    path.write_bytes(path.read_bytes()[:-200] if content is None else content)
    with pytest.raises(DataError, match=r'no readable Excel file: .*; save it as .xlsx without'):
        DataFile(path)


def test_a_file_without_numbers_or_with_another_name_is_refused(tmp_path):
    with pytest.raises(DataError, match='holds no sheet with rows of numbers'):
        DataFile(book(tmp_path / 'x.xlsx', a=[['a', 'b']], b=[]))
    book(tmp_path / 'x.csv', run=[HEADER, *ROWS])
    with pytest.raises(DataError, match=r'x\.csv is a spreadsheet and no text: rename it \.xlsx'):
        DataFile(tmp_path / 'x.csv')


def test_a_sheet_that_unpacks_to_far_more_than_it_takes_is_refused(tmp_path, monkeypatch):
    path = book(tmp_path / 'x.xlsx', run=[HEADER, *([0.0, 0.0] for _ in range(20000))])
    monkeypatch.setattr(packed_file, '_UNPACKED', 2**16)
    monkeypatch.setattr(packed_file, '_TIMES', 2)
    with pytest.raises(DataError, match='says that it unpacks to'):
        DataFile(path)
