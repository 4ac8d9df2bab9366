# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Read the sheet of an Excel file that holds the recording."""

import datetime
import zipfile
from pathlib import Path
from typing import Any

from sosml_friction.bags.tables.cell_text import is_number
from sosml_friction.bags.tables.packed_file import check_size, readable
from sosml_friction.bags.tables.text_table import Columns, Row, read_rows
from sosml_friction.exceptions import DataError


def read_excel(path: Path) -> tuple[Columns, list[str]]:
    """
    Return the cells of each column of the sheet with the most rows of numbers, and remarks.

    Of equals it is the first. The header is found as in a table of text; formulas have the values
    that the program kept which saved them. The older kind ``.xls`` is not read.

    :raises DataError: if openpyxl is not there, or the file is damaged, locked, of the older kind
        ``.xls``, holds no numbers, or unpacks to too much.
    """
    try:
        import openpyxl
    except ImportError:
        raise DataError(
            f'{path} is an Excel file, which needs openpyxl: pip install openpyxl, or save the '
            'sheet as CSV'
        ) from None
    advice = '; save it as .xlsx without a password, or the sheet as CSV'
    with readable(path, 'Excel file', advice):
        with zipfile.ZipFile(path) as archive:
            check_size(path, sum(entry.file_size for entry in archive.infolist()))
        book = openpyxl.load_workbook(path, read_only=True, data_only=True)
        sheets = {sheet.title: _rows(sheet) for sheet in book.worksheets}
    counts = {title: _of_numbers(rows) for title, rows in sheets.items()}
    most = max(counts, key=lambda title: counts[title], default='')
    if not counts.get(most):
        raise DataError(f'{path} holds no sheet with rows of numbers: give a recording')
    others = [title for title in counts if title != most and 2 * counts[title] > counts[most]]
    told = f'the sheet {most} of {path} was read, and not {", ".join(others)}'
    return read_rows(path, sheets[most]), [told] if others else []


def _rows(sheet: Any) -> list[Row]:
    """Return the rows of a sheet that hold something, without the columns that hold nothing."""
    # What a program says of the size of its sheet may be wrong.
    sheet.reset_dimensions()
    rows = [[_text(cell) for cell in row] for row in sheet.iter_rows(values_only=True)]
    used = sorted({k for row in rows for k, cell in enumerate(row) if cell})
    found = []
    for line, row in enumerate(rows, 1):
        cells = [row[k] if k < len(row) else '' for k in used]
        filled = [cell for cell in cells if cell]
        if filled:
            is_title = len(filled) == 1 and not is_number(filled[0])
            found.append(Row(line, filled if is_title else cells))
    return found


def _of_numbers(rows: list[Row]) -> int:
    """Return how many rows have more than one number; a parameter beside its name is one."""
    # Numbers that were pasted as text may have a decimal comma.
    return sum(sum(is_number(x.replace(',', '.')) for x in row.cells) > 1 for row in rows)


def _text(cell: Any) -> str:
    """Return a cell as a table of text has it."""
    if cell is None:
        return ''
    if isinstance(cell, bool):
        return str(int(cell))
    if isinstance(cell, datetime.timedelta):
        return str(cell.total_seconds())
    if isinstance(cell, datetime.datetime | datetime.time):
        return cell.isoformat()
    return str(cell).strip()
