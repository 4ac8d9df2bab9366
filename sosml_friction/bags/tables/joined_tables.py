# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Put tables side by side that have a joint of one robot each."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sosml_friction.bags.tables.data_file import DataFile
from sosml_friction.bags.tables.file_kind import table_name
from sosml_friction.bags.tables.series_evidence import find_time
from sosml_friction.exceptions import ConfigurationError, DataError

#: A number that is one of a joint: that of a run is none.
_NUMBERED = r'(?<![a-z])(?:joint|axis|motor|servo|actuator|[jaqm])[ _-]?(\d+)'


def join_tables(
    paths: Sequence[Path], joints: Sequence[str], folder: Path, columns: Mapping[str, str]
) -> tuple[Path, list[str], dict[str, str]]:
    """
    Write one table of files with a joint each, of which one time is that of all.

    Return it, the joint of each file, and by quantity its columns, called ``<joint> <column>``.

    :param columns: by quantity, ``NAME`` or ``NAME:UNIT`` of a column of each file; without one of
        time it is what grows all the time.
    :raises ConfigurationError: if the names of the files do not say which joint each is.
    :raises DataError: if their samples are at other times, or the first has no such column.
    """
    order = [_joint_of(table_name(path), joints) for path in paths]
    listed = ', '.join(path.name for path in paths)
    if sorted(order) != sorted(joints):
        raise ConfigurationError(
            f'{listed} have one joint each, and their names do not say which of '
            f'{", ".join(joints)}: call each file as its joint, or put their columns into one '
            'table'
        )
    first = DataFile(paths[0])
    stated = {quantity: first.split_unit(entry) for quantity, entry in columns.items()}
    # What the file does not have is told before there is a table of all.
    found = {quantity: _column(first, *own) for quantity, own in stated.items()}
    time = stated.get('time', ('', ''))[0]
    variables: dict[str, NDArray[Any]] = {}
    shared: NDArray[Any] | None = None
    for path, joint in zip(paths, order, strict=True):
        data = DataFile(path)
        series = data.series()
        own = find_time(series, data.find(time) or time).name
        stamps = series.pop(own, np.arange(max(map(len, series.values()), default=0)))
        if shared is None:
            shared = variables[own or 'sample'] = stamps
        if not np.array_equal(shared, stamps):
            raise DataError(
                f'{listed} have one joint of a robot each, and other times: put them into one '
                'table with a time for all, as of one sampling'
            )
        for name, values in series.items():
            variables[f'{joint} {_without_commas(name)}'] = values
    table = folder / f'{"+".join(map(table_name, paths))}.npy'
    rows = np.empty(len(stamps), [(name, values.dtype) for name, values in variables.items()])
    for name, values in variables.items():
        rows[name] = values
    np.save(table, rows)
    whole = {
        quantity: ','.join(
            f'{joint}={joint} {column}' if quantity == 'position' else f'{joint} {column}'
            for joint in order
        )
        for quantity, column in found.items()
        if quantity != 'time'
    }
    return table, order, whole


def _column(data: DataFile, name: str, unit: str) -> str:
    """Return a column of a file, as it is called in the table of all, with its unit."""
    whole = data.find(name) or name
    data[whole]
    return _without_commas(f'{whole}:{unit}' if unit else whole)


def _without_commas(name: str) -> str:
    """Return a name that commas can part from others."""
    return name.replace(',', '/')


def _joint_of(name: str, joints: Sequence[str]) -> str:
    """Return the joint that a name has in it, else the one with its number, '' if none is."""
    words = f'_{re.sub("[^a-z0-9]+", "_", name.lower())}_'
    found = [j for j in joints if f'_{re.sub("[^a-z0-9]+", "_", j.lower())}_' in words]
    if not found:
        number = re.findall(_NUMBERED, name.lower())[-1:]
        found = [j for j in joints if number and re.findall(r'\d+', j)[-1:] == number]
    return found[0] if len(found) == 1 else ''
