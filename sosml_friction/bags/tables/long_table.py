# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Tables with a row for each joint at each time, and a column that says which joint it is."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

from sosml_friction.bags.tables.cell_text import is_number, number

#: Fewer turns than these may be chance in a table of few rows. Chosen, no measurement.
_TURNS = 10
#: What the column is called that has the joint of a row.
_NAMES = frozenset((
    'joint', 'jointname', 'jointid', 'jointindex', 'name', 'motor', 'motorname', 'motorid', 'axis',
    'axisid', 'actuator', 'actuatorid', 'servo', 'servoid', 'canid', 'nodeid', 'id', 'device',
    'deviceid',
))  # fmt: skip


def widened(variables: Mapping[str, Any]) -> dict[str, Any] | None:
    """
    Return a long table with a row for each time and columns for each joint, None if it is none.

    It is one where the joints take turns in one and the same order from the first row to the last;
    a turn that was not finished is left out. A column that is the same for all joints of a turn,
    such as time, stays one; the others are called ``<joint> <column>``.

    :param variables: the columns; where they differ in length there is no such table.
    """
    if len({len(column) for column in variables.values()}) != 1:
        return None
    for name, column in variables.items():
        if re.sub('[^a-z]', '', name.lower()) in _NAMES:
            joints = _turn([_plain(cell) for cell in column])
            # An index of 1.0 is 1.
            joints = [f'{number(joint):g}' if is_number(joint) else joint for joint in joints]
            if joints:
                return _wide({n: x for n, x in variables.items() if n != name}, joints)
    return None


def _plain(cell: Any) -> str:
    """Return a cell of text, which has its line with it, or a number as text."""
    return str(cell[1] if isinstance(cell, tuple) else cell)


def _turn(cells: Sequence[str]) -> list[str]:
    """Return the joints of a turn in their order, none where they take no turns."""
    if not cells or cells[0] not in cells[1:]:
        return []
    count = cells.index(cells[0], 1)
    joints = list(cells[:count])
    takes_turns = len(cells) >= _TURNS * count and all(
        cell == joints[k % count] for k, cell in enumerate(cells)
    )
    is_word = all(not is_number(joint) or number(joint).is_integer() for joint in joints)
    return joints if count > 1 and len(set(joints)) == count and takes_turns and is_word else []


def _wide(variables: Mapping[str, Any], joints: Sequence[str]) -> dict[str, Any]:
    count = len(joints)
    found: dict[str, Any] = {}
    for name, column in variables.items():
        whole = column[: len(column) // count * count]
        parts = [whole[k::count] for k in range(count)]
        plain = [list(map(_plain, part)) for part in parts]
        if all(part == plain[0] for part in plain):
            found[name] = parts[0]
        else:
            for joint, part in zip(joints, parts, strict=True):
                found[f'{joint} {name}'] = part
    return found
