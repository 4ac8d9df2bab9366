# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What one cell of a table written as text says: a number, nothing, or neither."""

import re

#: What loggers, MATLAB, C and spreadsheets write for a value that is missing, beside nan.
_MISSING = frozenset((
    '', 'na', 'n/a', '<na>', '#n/a', '#na', 'none', 'null', 'nil', 'missing', '-', '--', '---',
    '.', '?', '*', '#value!', '#div/0!', '#num!', '#ref!', 'nan(ind)', '-nan(ind)', '1.#qnan',
    '1.#ind', '-1.#ind',
))  # fmt: skip
#: As [0.1, 0.2], and as Python writes arrays: array('d', [0.1, 0.2]).
_LIST = re.compile(r"(?:(?:np\.)?array\((?:'\w', )?)?[\[(](.*?)[\])]\)?")
_FORTRAN = re.compile(r'([+-]?[\d.]+)[dD]([+-]?\d+)')


def is_missing(cell: str) -> bool:
    """Tell whether a cell stands for a value that is missing."""
    return cell.lower() in _MISSING


def number(cell: str) -> float:
    """Return the number in a cell, NaN where it is missing; a ValueError if it is neither."""
    # Python reads 1_0 as 10, nobody else does.
    if '_' in cell:
        raise ValueError
    try:
        return float(cell)
    except ValueError:
        return float('nan' if is_missing(cell) else _FORTRAN.sub(r'\1e\2', cell))


def numbers(cell: str) -> list[float]:
    """Return the numbers of a list in brackets such as [0.1, 0.2], else a ValueError."""
    inside = _LIST.fullmatch(cell)
    if inside is None:
        raise ValueError
    return [number(part) for part in re.split(r'[,;\s]+', inside[1].strip())]


def is_number(cell: str) -> bool:
    """Tell whether a cell holds a number, and not none."""
    try:
        number(cell)
    except ValueError:
        return False
    return not is_missing(cell)
