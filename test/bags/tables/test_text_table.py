# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Tables as text: the same numbers whatever parts the cells and whatever stands above them."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from sosml_friction.bags.tables.data_file import DataFile
from sosml_friction.bags.tables.text_table import read_text_table
from sosml_friction.exceptions import DataError

LISTS = ['"[{}, {}]"', '"({}, {})"', '[{} {}]', '"array(\'d\', [{}, {}])"', 'array([{} {}])']
NAMES = ('t', 'q [rad]', 'motor current (A)', 'dq', 'Temp')


def values_of(path):
    data = DataFile(path)
    return list(data), np.column_stack([np.atleast_1d(data[name]) for name in data])


@given(
    table=arrays(
        float,
        st.tuples(st.integers(2, 12), st.integers(2, 5)),
        elements=st.floats(-1e6, 1e6, allow_nan=False).map(lambda x: round(x, 6)),
    ),
    delimiter=st.sampled_from([',', ';', '\t', '|', ' ', '   ']),
    comma=st.booleans(),
    header=st.sampled_from(['', 'plain', '#', '%']),
    preamble=st.booleans(),
)
def test_a_table_is_read_however_it_is_written(
    tmp_path_factory, table, delimiter, comma, header, preamble
):
    names = [name.split()[0] for name in NAMES[: table.shape[1]]]
    rows = [[f'{x:.6f}' for x in row] for row in table]
    if comma and delimiter != ',':
        rows = [[cell.replace('.', ',') for cell in row] for row in rows]
    lines = [delimiter.join(row) for row in rows]
    if header:
        mark = '' if header == 'plain' else f'{header} '
        lines.insert(0, mark + delimiter.join(names))
    if header and preamble:
        lines.insert(0, 'Recorded by somebody on a Tuesday with the blue robot')
    path = tmp_path_factory.mktemp('table') / 'x.csv'
    path.write_text('\n'.join(lines) + '\n')
    found, values = values_of(path)
    assert found == (names if header else [str(k) for k in range(table.shape[1])])
    np.testing.assert_array_equal(values, table)


def test_a_line_of_units_goes_into_the_names(tmp_path):
    (tmp_path / 'x.csv').write_text('time;q;\n[s];[deg];[A]\n0;1,5;2\n1;2,5;3\n')
    found, values = values_of(tmp_path / 'x.csv')
    assert found == ['time [s]', 'q [deg]', '2']
    assert values.tolist() == [[0, 1.5, 2], [1, 2.5, 3]]


@pytest.mark.parametrize(
    'lines',
    [
        ['t,q,tau', 's,deg,oz-in', 'clock,encoder of the arm,motor'],
        ['t,q,tau', 'clock,encoder of the arm,motor', '(s),(deg),(oz-in)'],
        ['clock,encoder of the arm,motor', 't,q,tau', 's,deg,oz-in'],
        ['s,deg,oz-in', 't,q,tau'],
        ['Robot 7,v1.2,cell', 't [s],q [deg],tau [oz-in]'],
    ],
)
def test_names_units_and_a_description_come_in_any_order(tmp_path, lines):
    (tmp_path / 'x.csv').write_text('\n'.join([*lines, '0,1,2', '1,2,3']))
    assert values_of(tmp_path / 'x.csv')[0] == ['t [s]', 'q [deg]', 'tau [oz-in]']


def test_a_line_of_units_that_nobody_knows_is_kept(tmp_path):
    (tmp_path / 'x.csv').write_text('t,q,tau\ns,grad,st ft\n0,1,2\n1,2,3\n')
    assert values_of(tmp_path / 'x.csv')[0] == ['t [s]', 'q [grad]', 'tau [st ft]']


def test_names_that_are_there_twice_have_their_group(tmp_path):
    lines = ['time,elbow,,wrist,', 's,deg,Nm,deg,Nm', ',q,tau,q,tau', '0,1,2,3,4', '1,2,3,4,5']
    (tmp_path / 'x.csv').write_text('\n'.join([lines[0], lines[2], lines[1], *lines[3:]]))
    assert values_of(tmp_path / 'x.csv')[0] == [
        'time [s]', 'elbow q [deg]', 'elbow tau [Nm]', 'wrist q [deg]', 'wrist tau [Nm]',
    ]  # fmt: skip


def test_a_preamble_filled_up_with_empty_cells_is_no_header(tmp_path):
    rows = ['Lab 3;;', 'Operator: XY;;', 't [s];q [deg];i [A]', '0;1,5;2', '1;2,5;3', '']
    (tmp_path / 'x.csv').write_text('\n'.join(rows))
    assert values_of(tmp_path / 'x.csv')[0] == ['t [s]', 'q [deg]', 'i [A]']


def test_columns_of_words_and_missing_values_do_not_hide_the_header(tmp_path):
    (tmp_path / 'x.csv').write_text('t,phase,q\n0,rest,1\n1,"go, on",\n2,go,NA\n3,go,2\n')
    data = DataFile(tmp_path / 'x.csv')
    assert list(data) == ['t', 'phase', 'q']
    np.testing.assert_array_equal(data['q'], [1, np.nan, np.nan, 2])
    assert list(data.series()) == ['t', 'q']


@pytest.mark.parametrize('names', ['時間[s],角度[deg]', '時間,モータ電流'])
def test_a_table_of_a_japanese_spreadsheet_is_read(tmp_path, names):
    path = tmp_path / 'jp.csv'
    raw = f'# 関節試験\n{names}\n0.0,1.5\n0.1,2.5\n'.encode('cp932')
    path.write_bytes(raw)
    assert list(read_text_table(path, raw)) == names.split(',')


@pytest.mark.parametrize(
    'names',
    [
        'Zählung;größte Weg-Länge',
        'Prüfstand;Drehgeschwindigkeit °/s',
        'Öffnungsäußerung;Rückübertragung',
        'température;créée à Besançon',
        'posição;ângulo é',
        'vääntö;jännite',
        'vinkel på ø-å æ;måling',
    ],
)
def test_a_table_of_a_european_spreadsheet_is_not_taken_for_japanese(tmp_path, names):
    path = tmp_path / 'eu.csv'
    raw = f'{names}\n0,0;1,5\n0,1;2,5\n'.encode('cp1252')
    path.write_bytes(raw)
    assert list(read_text_table(path, raw)) == names.split(';')


@pytest.mark.parametrize('encoding', ['utf-8', 'utf-8-sig', 'utf-16', 'utf-16-le', 'cp1252'])
def test_a_table_is_read_in_the_encodings_of_spreadsheets(tmp_path, encoding):
    (tmp_path / 'x.csv').write_text('t;Winkel [°]\n0;1,5\n1;2,5\n', encoding=encoding)
    found, values = values_of(tmp_path / 'x.csv')
    assert found == ['t', 'Winkel [°]']
    assert values.tolist() == [[0, 1.5], [1, 2.5]]


@pytest.mark.parametrize(
    ('text', 'delimiter'),
    [
        ('"0.5","12,345.5"|"1","1,234,567"|"1.5","-2"', ','),
        ('0,5;12.345,5|1;1.234.567|1,5;-2', ';'),
        ('0.5;12,345.5|1;1,234,567|1.5;-2', ';'),
        ('0,5\t12345,5|1\t1234567|1,5\t-2', '\t'),
        ('5.0D-01  1.23455D+04|1  1234567|1.5  -2', ' '),
    ],
)
def test_marks_between_thousands_and_either_decimal_mark_are_read(tmp_path, text, delimiter):
    (tmp_path / 'x.csv').write_text(f't{delimiter}q\n' + text.replace('|', '\n'))
    assert values_of(tmp_path / 'x.csv')[1].tolist() == [[0.5, 12345.5], [1, 1234567], [1.5, -2]]


@pytest.mark.parametrize('word', ['NA', '#N/A', '-', '#DIV/0!', '-nan(ind)', '1.#QNAN', '?', ''])
@pytest.mark.parametrize('row', [0, 3])
def test_a_missing_value_is_one_in_whatever_row(tmp_path, word, row):
    rows = [f'{k},{word if k == row else k}' for k in range(5)]
    (tmp_path / 'x.csv').write_text('t,q\n' + '\n'.join(rows))
    found, values = values_of(tmp_path / 'x.csv')
    assert found == ['t', 'q']
    assert values[:, 0].tolist() == [0, 1, 2, 3, 4]
    assert np.flatnonzero(np.isnan(values[:, 1])).tolist() == [row]


@pytest.mark.parametrize('words', ['t,q', 's,rad', 'End of the file'])
def test_a_header_that_comes_again_and_other_words_are_passed_over(tmp_path, words):
    (tmp_path / 'x.csv').write_text(f't,q\n0,1\n1,2\n{words}\n2,3\n')
    assert values_of(tmp_path / 'x.csv')[1].tolist() == [[0, 1], [1, 2], [2, 3]]


def test_units_behind_every_number_go_into_the_name(tmp_path):
    (tmp_path / 'x.csv').write_text('t,q,tau\n0 sec,1.5e0deg,1 x\n1 sec,NA,2 x\n2 sec,3deg,3 x\n')
    data = DataFile(tmp_path / 'x.csv')
    assert list(data) == ['t [sec]', 'q [deg]', 'tau']
    np.testing.assert_array_equal(data['q'], [1.5, np.nan, 3.0])
    assert list(data.series()) == ['t [sec]', 'q [deg]']


@pytest.mark.parametrize(
    'text',
    [
        '"t\n(s)","q\n(deg)"\n0,1\n1,2\n',
        '! t (s),q (deg)\n0,1\n1,2\n',
        'Date,2026\nX0,0\nt (s),q (deg)\n0,1\n1,2\n2,3\n',
        't (s)|q (deg)|t (s)\n-|-|-\n0|1|0\n1|2|1\n',
        't (s),q (deg)\n0,1\n1,2\n2',
        't (s)  q (deg)\n0  1\n1  2\n',
    ],
)
def test_headers_of_spreadsheets_and_instruments_are_read(tmp_path, text):
    (tmp_path / 'x.csv').write_text(text)
    found, values = values_of(tmp_path / 'x.csv')
    assert found == ['t (s)', 'q (deg)']
    assert values[:2].tolist() == [[0, 1], [1, 2]]


def test_one_name_for_two_columns_is_refused(tmp_path):
    (tmp_path / 'x.csv').write_text('t,q,q\n0,1,2\n1,2,3\n')
    with pytest.raises(
        DataError, match="has two columns 'q' with other numbers: each needs its own"
    ):
        read_text_table(tmp_path / 'x.csv', (tmp_path / 'x.csv').read_bytes())


def test_a_typeset_minus_and_blanks_between_thousands_are_read(tmp_path):
    (tmp_path / 'x.csv').write_text("t;q\n0;\u22121\u202f234,5\n1;2'000,5\n", encoding='utf-8')
    assert values_of(tmp_path / 'x.csv')[1].tolist() == [[0, -1234.5], [1, 2000.5]]


def test_brackets_around_numbers_that_blanks_part_are_passed_over(tmp_path):
    rows = [f'{k} [ok] ({0.5 * k} {2 * k}) [ok] ({3 * k})' for k in range(5)]
    (tmp_path / 'data.log').write_text('\n'.join(rows) + '\n')
    found = DataFile(tmp_path / 'data.log').series()
    assert [found[name].tolist()[4] for name in found] == [4, 2, 8, 12]
    rows = [f'{k},(0.5,{2 * k}),[{3 * k}' for k in range(5)]
    (tmp_path / 'x.csv').write_text('t,a,b,c\n' + '\n'.join(rows) + '\n')
    assert DataFile(tmp_path / 'x.csv')['c'].tolist() == [0, 3, 6, 9, 12]


@pytest.mark.parametrize('form', LISTS)
def test_lists_in_cells_are_the_columns_of_a_table(tmp_path, form):
    rows = [f'{k},{form.format(2 * k, 0.5 * k)}' for k in range(5)]
    (tmp_path / 'x.csv').write_text('t,q\n' + '\n'.join(rows))
    found = DataFile(tmp_path / 'x.csv').series()
    assert list(found) == ['t', 'q[0]', 'q[1]']
    assert found['q[1]'].tolist() == [0, 0.5, 1, 1.5, 2]


def test_what_is_no_text_is_refused(tmp_path):
    (tmp_path / 'x.csv').write_bytes(bytes(range(256)))
    with pytest.raises(DataError, match='save it as text'):
        read_text_table(tmp_path / 'x.csv', (tmp_path / 'x.csv').read_bytes())


@pytest.mark.parametrize('header', ['t,q', 't,q,'])
def test_a_comma_behind_each_row_leaves_the_header_in_place(tmp_path, header):
    (tmp_path / 'x.csv').write_text(f'{header}\n0,1,\n1,2,\n')
    data = DataFile(tmp_path / 'x.csv')
    assert list(data) == ['t', 'q', '2']
    np.testing.assert_array_equal(data['q'], [1, 2])


def test_remarks_between_the_rows_are_passed_over(tmp_path):
    (tmp_path / 'x.csv').write_text('# t,q\n0,1\n# the cable came off\n1,2\n')
    assert values_of(tmp_path / 'x.csv')[1].tolist() == [[0, 1], [1, 2]]


def test_whole_numbers_parted_by_commas_are_no_decimal_commas(tmp_path):
    (tmp_path / 'x.csv').write_text('1,2, 3\n4,5, 6\n')
    assert values_of(tmp_path / 'x.csv')[1].tolist() == [[1, 2, 3], [4, 5, 6]]


@example('%0')
@example('%')
@given(st.text(max_size=200))
def test_any_text_is_a_table_or_a_sentence(tmp_path_factory, text):
    path = tmp_path_factory.mktemp('any') / 'x.csv'
    path.write_text(text, encoding='utf-8')
    try:
        table = read_text_table(path, path.read_bytes())
    except DataError as error:
        sentence = str(error)
    else:
        sentence = ''
        assert len({len(column) for column in table.values()}) <= 1
    assert '\n' not in sentence


def test_lines_of_other_lengths_are_refused_by_number(tmp_path):
    (tmp_path / 'x.csv').write_text('0 1 2\n1 2 3\n2 3\n3 4 5\n')
    with pytest.raises(DataError, match='line 3 has 2 cells where the first row has 3'):
        read_text_table(tmp_path / 'x.csv', (tmp_path / 'x.csv').read_bytes())


def test_groups_with_gaps_stand_above_the_names(tmp_path):
    groups, names, units = 'Time,Position,,Torque,', ',J1,J2,J1,J2', 's,deg,deg,Nm,Nm'
    (tmp_path / 'x.csv').write_text('\n'.join([groups, names, units, '0,1,2,3,4', '1,2,3,4,5']))
    assert list(DataFile(tmp_path / 'x.csv')) == [
        'Time [s]',
        *('Position J1 [deg]', 'Position J2 [deg]', 'Torque J1 [Nm]', 'Torque J2 [Nm]'),
    ]


@pytest.mark.parametrize(('head', 'first'), [('0,1,2', ''), (',0,1,2', '0,'), ('0,1,2', '-')])
def test_the_numbers_of_columns_above_a_table_are_no_sample(tmp_path, head, first):
    rows = [f'{first}0,0.5,1.5', f'{first}1,1.5,2.5']
    (tmp_path / 'x.csv').write_text('\n'.join([head, *rows]))
    data = DataFile(tmp_path / 'x.csv')
    assert list(data) == [str(k) for k in range(rows[0].count(',') + 1)]
    assert list(data.values())[-1].tolist() == [1.5, 2.5]


def test_whole_numbers_below_the_same_are_samples(tmp_path):
    (tmp_path / 'x.csv').write_text('0,1,2\n1,2,3\n')
    assert DataFile(tmp_path / 'x.csv')['2'].tolist() == [2, 3]


def test_a_word_behind_the_last_row_is_no_sample(tmp_path):
    (tmp_path / 'x.csv').write_text('t,q\n0,1.5\n1,2.5\nEND,\n')
    assert DataFile(tmp_path / 'x.csv')['t'].tolist() == [0, 1]
    # A state that comes without numbers is one.
    (tmp_path / 'x.csv').write_text('state,q\nRUN,1.5\nSTOP,\nSTOP,\n')
    assert len(DataFile(tmp_path / 'x.csv')['q']) == 3


@pytest.mark.parametrize(('decimal', 'groups'), [('.', 1), (',', 1), ('.', 3)])
def test_a_header_whose_lines_say_what_they_have_is_read(tmp_path, decimal, groups):
    lines = {
        'Name': ['ActPos', 'ActVelo', 'ActTorque'],
        'SymbolComment': ['', '', ''],
        'Data-Type': ['REAL64'] * 3,
        'SampleTime[ms]': ['2'] * 3,
        'VariableSize': ['8'] * 3,
        'SymbolName': ['Axis.ActPos', 'Axis.ActVelo', 'Axis.ActTorque'],
        'Port': ['851'] * 3,
        'BitMask': ['0xffff'] * 3,
        'Unit': ['° (Degree)', '(None)', 'Nm'],
    }
    text = 'Name\tscope\nStart\t1329\tMonday\t15:56\n\n'
    rows = {key: [key] for key in lines} if groups == 1 else {key: [] for key in lines}
    for key, cells in lines.items():
        for cell in cells:
            rows[key] += [cell] if groups == 1 else [key, cell]
    text += ''.join('\t'.join(row) + '\n' for row in rows.values()) + '\n'
    for k in range(20):
        numbers = [f'{x:.1f}'.replace('.', decimal) for x in (1.5 * k, -k, 0.1 * k)]
        stamp = [str(2 * k)]
        row = stamp + numbers if groups == 1 else [x for own in numbers for x in (*stamp, own)]
        text += '\t'.join(row) + '\n'
    (tmp_path / 'x.csv').write_text(text + 'EOF\n')
    data = DataFile(tmp_path / 'x.csv')
    assert list(data) == ['SampleTime[ms]', 'ActPos [°]', 'ActVelo', 'ActTorque [Nm]']
    np.testing.assert_array_equal(data['SampleTime[ms]'], 2 * np.arange(20))
    np.testing.assert_allclose(data['ActPos'], 1.5 * np.arange(20))


@pytest.mark.parametrize(
    ('cells', 'expected'), [(('0,5', '-12,25'), [0.5, -12.25]), (('1,234', '2,500'), None)]
)
def test_decimal_commas_in_quotes_between_commas_are_read(tmp_path, cells, expected):
    text = 't,q\n' + ''.join(f'"{k}","{cell}"\n' for k, cell in enumerate(cells * 5))
    (tmp_path / 'x.csv').write_text(text)
    data = DataFile(tmp_path / 'x.csv')
    if expected is None:
        with pytest.raises(DataError, match='not a number'):
            data['q']
    else:
        np.testing.assert_array_equal(data['q'][:2], expected)


@pytest.mark.parametrize('form', ['t:{},q:{},tau [Nm]:{}', 't = {}; q = {}; tau [Nm] = {}'])
def test_names_before_each_number_are_those_of_the_columns(tmp_path, form):
    rows = [form.format(k, -0.5 * k, 0.1) for k in range(20)]
    (tmp_path / 'x.csv').write_text('\n'.join(['Booting...', 'ready', *rows, '']))
    names, values = values_of(tmp_path / 'x.csv')
    assert names == ['t', 'q', 'tau [Nm]']
    np.testing.assert_array_equal(values[:, 1], -0.5 * np.arange(20))


def test_two_tables_below_each_other_are_told(tmp_path):
    rows = [f'; {k}; 1' for k in range(20)]
    text = '\n'.join(['0.Variable; q', *rows, '1.Variable; dq', '1.Class; 14', *rows, ''])
    (tmp_path / 'x.csv').write_text(text)
    with pytest.raises(DataError, match='give the tables of the file in files of their own'):
        DataFile(tmp_path / 'x.csv')


@pytest.mark.parametrize(('sep', 'point'), [(' ', '.'), (' ', ','), (';', ','), (',', '.')])
def test_names_in_cells_before_the_numbers_are_those_of_the_columns(tmp_path, sep, point):
    rows = [sep.join(['j.pos', f'{-0.5 * k:+.3f}', 'cmd:', '+1.250']) for k in range(20)]
    text = 'Sampling period is 100000 nSec\n\n' + '\n'.join(rows).replace('.', point)
    (tmp_path / 'x.log').write_text(text.replace(f'j{point}pos', 'j.pos') + '\n')
    names, values = values_of(tmp_path / 'x.log')
    assert names == ['j.pos', 'cmd']
    np.testing.assert_array_equal(values[:, 0], -0.5 * np.arange(20))
    np.testing.assert_array_equal(values[:, 1], 1.25)


def test_lines_that_say_what_they_have_may_call_it_by_two_words(tmp_path):
    head = ['Timestamp,2024-01-02 03:04:05', 'Channel name,Force', 'Unit,V']
    rows = [f'{k},{0.1 * k:.1f}' for k in range(20)]
    pairs = [f'{line},{line}' for line in head] + [f'{row},{row}' for row in rows]
    pairs[1] = pairs[1].replace('Force,', 'Angle,', 1)
    (tmp_path / 'x.csv').write_text('\n'.join(pairs) + '\n')
    assert list(DataFile(tmp_path / 'x.csv')) == ['Timestamp', 'Angle [V]', 'Force [V]']


@pytest.mark.parametrize('sep', [',', '\t', ' '])
def test_an_arrow_of_a_serial_monitor_parts_the_time(tmp_path, sep):
    rows = [f'12:00:0{k}.005 -> {-0.5 * k}{sep}{k}' for k in range(10)]
    (tmp_path / 'x.txt').write_text('\n'.join(rows) + '\n')
    _, values = values_of(tmp_path / 'x.txt')
    np.testing.assert_allclose(values[:, 0] - values[0, 0], np.arange(10.0))
    np.testing.assert_array_equal(values[:, 1], -0.5 * np.arange(10))


@pytest.mark.parametrize(
    ('header', 'names'),
    [
        ('X_Value\tAngle (rad)\tTorque (Nm)\tComment', ['X_Value', 'Angle (rad)', 'Torque (Nm)']),
        # Which of the columns the rows lack is open.
        ('index\tt\tq\ttau', ['0', '1', '2']),
    ],
)
def test_a_remark_that_no_row_has_takes_no_names(tmp_path, header, names):
    rows = [f'{0.1 * k:.1f}\t{-0.5 * k}\t{k}' for k in range(20)]
    (tmp_path / 'x.lvm').with_suffix('.csv').write_text('\n'.join([header, *rows]) + '\n')
    assert list(DataFile(tmp_path / 'x.csv')) == names


def test_a_comma_that_is_decimal_mark_and_delimiter_at_once_is_told(tmp_path):
    path = tmp_path / 'x.csv'
    path.write_text('t,q\n' + ''.join(f'0,{k:03d},1,{k:04d}\n' for k in range(20)))
    with pytest.raises(
        DataError, match='2 names of columns and 4 whole numbers in a row: a comma'
    ):
        DataFile(path)
