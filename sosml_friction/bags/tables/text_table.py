# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Read a table of numbers written as text, with or without names of its columns."""

import codecs
import csv
import re
from collections import Counter
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from sosml_friction.bags.tables.cell_text import is_missing, is_number
from sosml_friction.bags.tables.header_words import are_units, read_header
from sosml_friction.exceptions import DataError

#: Cells with the line each was read from, by name of the column.
Columns = dict[str, list[tuple[int, str]]]
_DECIMAL_COMMA = re.compile(r'[+-]?\d*,\d+([eE][+-]?\d+)?')
#: Numbers with marks between thousands, by the mark of their decimals: 1,234.5 and 1.234,5.
_THOUSANDS = {'.': r'[+-]?\d{1,3}(,\d{3})+(\.\d*)?', ',': r'[+-]?\d{1,3}(\.\d{3})+(,\d*)?'}
_COMMENT = re.compile(r'\s*(?:[#%!]|//)')
_BETWEEN = re.compile(r"(?<=\d)[\u00a0\u2009\u202f'](?=\d{3}(?!\d))")
_WITH_UNIT = re.compile(r'([+-]?[\d.]+(?:[eE][+-]?\d+)?)\s*([^\d\s.].*)')
#: A name before its number, as a serial monitor shows it.
_LABEL = re.compile(r'([^\W\d][^:=]*?)\s*[:=]\s*([+-]?[\d.].*)')
#: What a serial monitor puts between the time of a line and the line.
_ARROW = re.compile(r'^(\s*\d+:\d+:[\d.,]+)\s*->')
#: Kana or kanji side by side. A letter with an accent takes the next one for a kanji in code page
#: 932; two of them, four letters of which each first one has an accent, no European word has.
_JAPANESE = re.compile('[\u3041-\u30ff\u4e00-\u9fff]{2}')
_IN_BRACKETS = re.compile(r'^[\[(](.*)[\])]$')
#: Lines that a header may have: a group of columns, names, units, a description.
_HEADER = 4
#: Rows that the form of a table is taken from: enough for a preamble, and read at once.
_LOOK = 200


class Row(NamedTuple):
    """Hold the cells of a row, and which line it is, counted from 1."""

    line: int
    cells: list[str]


def read_text_table(path: Path, raw: bytes) -> Columns:
    """
    Return the cells of each column of a text, ``raw``, that stands in a file.

    The text is UTF-8, UTF-16 with its mark, or of Windows: code page 932 where that makes kana or
    kanji of it, else 1252. Columns are parted by
    comma, semicolon, tab, bar, or any white space; where it is not the comma, a decimal comma is
    read as a point. What parts them may stand behind the last number of a row too. The header is
    what stands above the numbers, with ``#`` or ``%`` before it or without: names, units in a line
    of their own, which are put into the names as ``name [unit]``, a description. A column without
    a name is called by its number, counted from 0. Lines above the header that do not have its
    number of cells are passed over.

    :raises DataError: if it is no text, or lines differ in their number of cells.
    """
    # Minus signs of typesetting, and blanks between thousands.
    text = _BETWEEN.sub('', _text(path, raw).replace('\u2212', '-'))
    rows, first = _rows(path, text)
    return _columns(path, rows, first, not text.endswith(('\n', '\r')))


def read_rows(path: Path, rows: list[Row]) -> Columns:
    """
    Return the cells of each column of a table that was not written as text.

    :raises DataError: if rows differ in their number of cells, or columns in no name.
    """
    text = '\n'.join(cell for row in rows for cell in row.cells if ',' in cell)
    rows = _with_points(rows, ';', text) if text else rows
    return _columns(path, rows, _first_of_numbers(rows), False)


def _columns(path: Path, rows: list[Row], first: int, may_be_cut: bool) -> Columns:
    """Return the columns by the names above the first row of numbers."""
    if first == 0 and len(rows) > 1 and _are_numbers(rows[0].cells, rows[1].cells):
        # What pandas writes above columns without names is no sample.
        rows = rows[1:]
    whole = [cells for _, cells in rows[:first]]
    above = whole[-_HEADER:]
    # A line that is no row of the table is a preamble: the header has the cells of the numbers.
    width = len(rows[first].cells) if first < len(rows) else len(above[-1])
    if all(not row.cells[-1] for row in rows[first:]):
        above = [[*cells, ''] if len(cells) == width - 1 else cells for cells in above]
    if not any(len(cells) == width for cells in above):
        above = [_without_remarks(cells, width) for cells in above[-1:]]
    named = [cells for cells in above if len(cells) == width]
    if above and not named and width == 2 * len(above[-1]) and _are_whole(rows[first:]):
        raise DataError(
            f'{path} has {len(above[-1])} names of columns and {width} whole numbers in a row: a '
            'comma seems to be both the decimal mark and between the columns; export it with '
            'decimal points, or with semicolons'
        )
    above = named
    names = _labelled([cells for cells in whole if len(cells) == width]) or _names(above, width)
    table = _without_words(rows[first:])
    if len(table) > 1 and _says_the_end(table[-1].cells) and not _says_the_end(table[-2].cells):
        table.pop()
    if table and len(table[-1].cells) < width and may_be_cut:
        # A logger that was cut off.
        table.pop()
    for line, cells in table:
        if len(cells) != width:
            raise DataError(
                f'{path} line {line} has {len(cells)} cells where the '
                f'{"header" if above else "first row"} has {width}: correct that line, or give '
                'the tables of the file in files of their own'
            )
    columns: Columns = {}
    for i, name in enumerate(names):
        column = [(line, cells[i]) for line, cells in table]
        # A column that is there twice is one, such as the time beside each signal.
        if columns.setdefault(name, column) != column:
            raise DataError(
                f'{path} has two columns {name!r} with other numbers: each needs its own name'
            )
    return dict(_without_unit(name, column) for name, column in columns.items())


def _are_whole(rows: list[Row]) -> bool:
    """Tell whether there is no decimal mark in any cell."""
    return all(cell.lstrip('+-').isdecimal() for _, cells in rows[:_LOOK] for cell in cells)


def _without_remarks(cells: list[str], width: int) -> list[str]:
    """Return the names of the columns without those of remarks behind them, which no row has."""
    behind = cells[width:]
    # What has the name of a quantity is a column that the rows lack, perhaps not the last.
    return cells if any(read_header(cell).quantity for cell in behind) else cells[:width]


def _rows(path: Path, text: str) -> tuple[list[Row], int]:
    """Return the rows of a text without its comments, and the index of the first of the table."""
    lines = [(k, line) for k, line in enumerate(_lines(text), 1) if line.strip()]
    if not lines:
        raise DataError(f'{path} is empty: a CSV file needs rows of numbers, best below a header')
    delimiter = _delimiter([line for _, line in lines[:_LOOK]])
    lines = [(k, _ARROW.sub(rf'\1{delimiter or " "}', line)) for k, line in lines]
    try:
        rows = [Row(k, _cells(line, delimiter)) for k, line in lines]
    except csv.Error as error:
        raise DataError(f'{path} is no readable CSV file: {error}') from error
    names = _labels(rows)
    if names:
        rows = [Row(k, [_LABEL.sub(r'\2', cell) for cell in cells]) for k, cells in rows]
    if ',' in text and (delimiter != ',' or '"' in text):
        rows = _with_points(rows, delimiter, text)
    labels = _labels_beside(rows)
    if labels:
        rows = [Row(k, own[1::2] if own[::2] == labels else own) for k, own in rows]
        names = [label.rstrip(':=') for label in labels]
    if names:
        lines.insert(0, (0, ''))
        rows.insert(0, Row(0, names))
    first = _first_of_numbers(rows)
    width = len(rows[first].cells) if first < len(rows) else 0
    for k in range(first if not delimiter else 0):
        # Names of several words, with more than one blank between two of them.
        names = re.split(r'\s{2,}', lines[k][1].strip())
        if len(rows[k].cells) != width == len(names):
            rows[k] = Row(rows[k].line, names)
    rows = [row for k, row in enumerate(rows) if k < first or not _COMMENT.match(lines[k][1])]
    if not rows:
        raise DataError(f'{path} has comments only: a CSV file needs rows of numbers')
    return rows, first


def _labels(rows: list[Row]) -> list[str]:
    """Return the names that stand before the numbers of most rows, t:10,q:0.5, else nothing."""
    matches = [[_LABEL.fullmatch(cell) for cell in row.cells] for row in rows[:_LOOK]]
    forms = Counter(tuple(m[1] if m else '' for m in own) for own in matches)
    names, often = max(forms.items(), key=lambda form: form[1])
    return list(names) if all(names) and 2 * often > len(matches) else []


def _labels_beside(rows: list[Row]) -> list[str]:
    """Return what stands in a cell before each number of most rows, q 0.5 dq 0.1, or nothing."""
    forms = Counter(
        tuple(own[::2])
        for _, own in rows[:_LOOK]
        if own[1::2] and all(map(is_number, own[1::2])) and len(own) % 2 == 0
    )
    names, often = max(forms.items(), key=lambda form: form[1], default=((), 0))
    are_words = all(name[:1].isalpha() and not is_missing(name) for name in names)
    return list(names) if are_words and 2 * often > len(rows[:_LOOK]) else []


def _are_numbers(cells: list[str], below: list[str]) -> bool:
    """Tell whether a row has the numbers of the columns, and what is below it has decimals."""
    own = cells[1:] if cells[0] == '' else cells
    return (
        len(own) > 2
        and own == [str(k) for k in range(len(own))]
        and not all(cell.isdecimal() for cell in below)
    )


def _says_the_end(cells: list[str]) -> bool:
    """Tell whether a row has a word alone, and empty cells behind it: END,,,."""
    return cells[0].isalpha() and not is_missing(cells[0]) and not any(cells[1:])


def _without_words(rows: list[Row]) -> list[Row]:
    """Return the rows without those of words alone: a header that comes again, or a remark."""
    table = [row for row in rows if any(is_number(c) or is_missing(c) for c in row.cells)]
    return table if 2 * len(table) > len(rows) else list(rows)


def _text(path: Path, raw: bytes) -> str:
    is_wide = raw.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    if raw[1:4:2] == b'\0\0' and 0 not in raw[:4:2]:
        return raw.decode('utf-16-le', errors='replace')
    # What is no text has bytes of 0.
    known = (
        ('utf-16',)
        if is_wide
        else ('utf-8-sig',)
        if b'\0' in raw
        else ('utf-8-sig', 'cp932', 'cp1252')
    )
    for encoding in known:
        try:
            text = raw.decode(encoding)
        except UnicodeDecodeError:
            continue
        if encoding != 'cp932' or _JAPANESE.search(text):
            return text
    raise DataError(f'{path} is no readable CSV file: save it as text in UTF-8')


def _delimiter(lines: list[str]) -> str:
    """Return what parts the cells, '' for white space: what most lines have as many of."""
    best, most = '', 0
    for candidate in ';\t|,':
        counts = Counter(line.count(candidate) for line in lines)
        counts.pop(0, None)
        # With a decimal comma there are commas too, but the semicolon or tab comes first.
        same = max(counts.values(), default=0)
        if same > most:
            best, most = candidate, same
    # "0,5 1,25": commas inside of numbers that white space parts.
    if best == ',' and all(
        _DECIMAL_COMMA.fullmatch(cell) or ',' not in cell
        for line in lines[len(lines) // 2 :]
        for cell in line.split()
    ):
        parted = [len(line.split()) for line in lines[len(lines) // 2 :]]
        # Two whole numbers with a comma between them look alike: more cells than one decide.
        if min(parted) > 1:
            return ''
    return best


def _lines(text: str) -> list[str]:
    """Return the lines of a text; one of its first that ends within quotes goes on in the next."""
    lines = text.splitlines()
    for k in range(min(_LOOK, len(lines) - 1)):
        if lines[k].count('"') % 2:
            # The place of the line stays, so that the others keep their numbers.
            lines[k], lines[k + 1] = '', f'{lines[k]} {lines[k + 1]}'
    return lines


def _without_unit(name: str, cells: list[tuple[int, str]]) -> tuple[str, list[tuple[int, str]]]:
    """Return a column whose cells all have the same unit behind their numbers without it."""
    found = _WITH_UNIT.fullmatch(cells[0][1]) if cells else None
    if found is None or not are_units([found[2]]):
        return name, cells
    unit = found[2]
    if not all(cell.endswith(unit) or is_missing(cell) for _, cell in cells):
        return name, cells
    return f'{name} [{unit}]', [(line, cell.removesuffix(unit).strip()) for line, cell in cells]


def _cells(line: str, delimiter: str) -> list[str]:
    bare = re.sub(rf'^(?:{_COMMENT.pattern})+\s*', '', line)
    if not delimiter:
        return [_without_bracket(cell) for cell in bare.split()]
    (cells,) = csv.reader([bare], delimiter=delimiter, skipinitialspace=True)
    return [_without_bracket(cell.strip()) for cell in cells]


def _without_bracket(cell: str) -> str:
    """Return a number without the one bracket of a vector of several cells, as of (1 2 3)."""
    plain = cell.strip('()[]')
    is_of_one = cell[:1] in '([' and cell[-1:] in ')]'
    return plain if cell != plain and not is_of_one and is_number(plain) else cell


def _with_points(rows: list[Row], delimiter: str, text: str) -> list[Row]:
    """Return the rows with decimals behind a point, and without marks between thousands."""
    # A number with both marks says which is which; where commas part cells, it is in quotes.
    before, behind = ('"', '"') if delimiter == ',' else (r'(?<![\d.,])', r'(?![\d.,])')
    both = {'.': r'\d{1,3}(,\d{3})+\.\d+', ',': r'\d{1,3}(\.\d{3})+,\d+'}
    grouped = [m for m, form in both.items() if re.search(f'{before}[+-]?{form}{behind}', text)]
    if len(grouped) > 1:
        return rows
    has_commas = _has_commas(rows[:_LOOK], delimiter)
    decimal = grouped[0] if grouped else ',' if has_commas else '.'
    if not grouped and decimal == '.':
        return rows
    between = {'.': ',', ',': '.'}[decimal]
    group = re.compile(_THOUSANDS[decimal]) if grouped else None

    def plain(cell: str) -> str:
        if group is not None and group.fullmatch(cell):
            cell = cell.replace(between, '')
        return (
            cell.replace(',', '.') if decimal == ',' and _DECIMAL_COMMA.fullmatch(cell) else cell
        )

    return [Row(k, [plain(cell) for cell in row]) for k, row in rows]


def _has_commas(rows: list[Row], delimiter: str) -> bool:
    cells = [cell for _, row in rows for cell in row]
    points = sum('.' in cell and is_number(cell) for cell in cells)
    commas = [cell for cell in cells if _DECIMAL_COMMA.fullmatch(cell)]
    if delimiter == ',' and all(re.fullmatch(_THOUSANDS['.'], cell) for cell in commas):
        # "1,234" in quotes, where commas part cells, is one of thousands or open.
        return False
    return len(commas) > points


def _form(row: Row) -> tuple[int, int, int]:
    """Return how many cells a row has, how many numbers, and how many values are missing."""
    cells = row.cells
    return len(cells), sum(map(is_number, cells)), sum(map(is_missing, cells))


def _first_of_numbers(rows: list[Row]) -> int:
    """
    Return the index of the first row of the table itself.

    It is the first that has numbers, and as many cells and no more words among them than most rows
    have; a header has more words.
    """
    seen = Counter(map(_form, islice(rows, 1, _LOOK)))
    if not seen:
        return 0 if any(map(is_number, rows[0].cells)) else 1
    usual = max(seen, key=lambda form: (seen[form] * (form[1] > 0), form))
    for k, row in enumerate(rows):
        width, numbers, missing = _form(row)
        words = width - numbers - missing
        if width == usual[0] and numbers and words <= width - usual[1] - usual[2]:
            return k
    return 1


def _labelled(above: list[list[str]]) -> list[str]:
    """
    Return the names where each line above the numbers begins with what it has, else nothing.

    So a scope writes them: Name, Data-Type, SampleTime[ms], Unit. Its column of time, below those
    words, has no name but that of the line of its step.
    """
    # As "Channel name" too.
    labels = {cells[0].lower().split()[-1]: cells for cells in above if cells and cells[0].split()}
    if not {'name', 'unit'} <= set(labels):
        return []
    names, units = labels['name'], labels['unit']
    time = next((c[0] for c in above if read_header(c[0]).quantity == 'time'), names[0])
    # "° (Degree)" is said twice.
    bare = [_IN_BRACKETS.sub(r'\1', re.sub(r'\s+\(.*\)$', '', unit)) for unit in units]
    return [
        time if n == names[0] else n if is_missing(u) else f'{n} [{u}]'
        for n, u in zip(names, bare, strict=True)
    ]


def _names(above: list[list[str]], width: int) -> list[str]:
    """
    Return the names of the columns from the lines above the numbers.

    Of several lines one may have units; of the others that which says most of quantities has the
    names, so that names, units and a description may come in any order. Names that are there
    twice have those of their group before them, from the line above.
    """
    if not above:
        return [str(k) for k in range(width)]
    units = next((k for k in reversed(range(len(above))) if are_units(above[k])), None)
    rest = [k for k in range(len(above)) if k != units]
    if not rest:
        units, rest = None, [len(above) - 1]
    says = [sum(read_header(cell).quantity != '' for cell in above[k]) for k in rest]
    own = rest[says.index(max(says))] if any(says) else rest[-1]
    # Of two lines the one with gaps has the groups: "Position", two empty cells, "Velocity".
    filled = [sum(map(bool, cells)) for cells in above]
    own = next((k for k in rest if k > own and filled[k] > filled[own]), own)
    below = above[own + 1] if units is None and own + 1 < len(above) else ['0']
    if not any(is_number(cell) or read_header(cell).quantity for cell in below):
        # What nobody knows, in the place of the units: it is told where the unit is needed.
        units = own + 1
    names = above[own]
    if len(set(names)) < len(names) and own > 0:
        groups = list(above[own - 1])
        for k in range(1, width):
            groups[k] = groups[k] or groups[k - 1]
        names = [f'{group} {name}'.strip() for group, name in zip(groups, names, strict=True)]
    if units is not None:
        bare = [_IN_BRACKETS.sub(r'\1', cell) for cell in above[units]]
        names = [
            f'{n} [{u}]' if n and not is_missing(u) else n
            for n, u in zip(names, bare, strict=True)
        ]
    return [name or str(k) for k, name in enumerate(names)]
