# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Tables with a row for each joint at each time, and a column that says which joint it is."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from sosml_friction.arrays import IndexArray
from sosml_friction.bags.tables.cell_text import is_number, number

#: Fewer turns than these may be chance in a table of few rows. Chosen, no measurement.
_TURNS = 10
#: So much of a table must be whole turns: of two kinds of rows in any order half is. Chosen, no
#: measurement.
_WHOLE = 2.0 / 3.0
#: What the column is called that has the joint of a row.
_NAMES = frozenset((
    'joint', 'jointname', 'jointid', 'jointindex', 'name', 'motor', 'motorname', 'motorid', 'axis',
    'axisid', 'actuator', 'actuatorid', 'servo', 'servoid', 'canid', 'nodeid', 'id', 'device',
    'deviceid',
))  # fmt: skip
#: Of these, what may be of anything else, such as runs.
_ANYTHING = frozenset(('name', 'id', 'device', 'deviceid'))


def widened(variables: Mapping[str, Any]) -> tuple[dict[str, Any] | None, list[str]]:
    """
    Return a long table with a row for each time and columns for each joint, None if it is none.

    It is one where the joints take turns in one and the same order, or where as many rows of each
    stand behind those of another and their column says that they are of joints. A turn that lacks
    a joint is left out, and told, as is what seems to be such a table and has no such order. A
    column that is the same for all joints of a turn, such as time, stays one; the others are
    called ``<joint> <column>``.

    :param variables: the columns; where they differ in length there is no such table.
    :return: the table, and remarks.
    """
    if len({len(column) for column in variables.values()}) != 1:
        return None, []
    told: list[str] = []
    for name, column in variables.items():
        word = re.sub('[^a-z]', '', name.lower())
        if word not in _NAMES:
            continue
        cells = [_plain(cell) for cell in column]
        # An index of 1.0 is 1.
        cells = [f'{number(cell):g}' if is_number(cell) else cell for cell in cells]
        joints = list(dict.fromkeys(cells))
        is_word = all(not is_number(joint) or number(joint).is_integer() for joint in joints)
        if not is_word or len(joints) < 2 or len(cells) < _TURNS * len(joints):
            continue
        rows = _turns(np.array([joints.index(cell) for cell in cells]), word not in _ANYTHING)
        if not len(rows):
            told.append(
                f'{name} may be the joint of each row ({", ".join(joints[:4])}), and they take no '
                'turns: if it is, give a table with a column for each'
            )
            continue
        lost = len(cells) - rows.size
        what = f'{lost} of {len(cells)} rows are of turns in which not every {name} is: left out'
        others = {n: x for n, x in variables.items() if n != name}
        return _wide(others, joints, rows), [what] if lost > len(joints) else []
    return None, told


def _plain(cell: Any) -> str:
    """Return a cell of text, which has its line with it, or a number as text."""
    return str(cell[1] if isinstance(cell, tuple) else cell)


def _turns(codes: IndexArray, may_be_sorted: bool) -> IndexArray:
    """Return the rows of each whole turn (turns, joints), of the joints in their order."""
    count = int(codes.max()) + 1
    size = len(codes) // count
    if may_be_sorted and np.array_equal(codes, np.repeat(np.arange(count), size)):
        return np.arange(count * size).reshape(count, size).T
    begins = np.append(True, np.diff(codes) <= 0)
    turn = np.cumsum(begins) - 1
    whole = np.bincount(turn) == count
    rows = np.flatnonzero(whole[turn]).reshape(-1, count)
    return rows if rows.size >= _WHOLE * len(codes) else rows[:0]


def _wide(variables: Mapping[str, Any], joints: Sequence[str], rows: IndexArray) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, column in variables.items():
        is_array = isinstance(column, np.ndarray)
        parts = [column[own] if is_array else [column[k] for k in own] for own in rows.T]
        plain = [list(map(_plain, part)) for part in parts]
        if all(part == plain[0] for part in plain):
            found[name] = parts[0]
        else:
            for joint, part in zip(joints, parts, strict=True):
                found[f'{joint} {name}'] = part
    return found
