# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Put tables side by side that have a joint of one robot each."""

import re
from collections.abc import Sequence
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
    paths: Sequence[Path], joints: Sequence[str], folder: Path, time: str = ''
) -> tuple[Path, list[str]]:
    """
    Write one table of files with a joint each, and return it with the joint of each file.

    Its columns are called ``<joint> <column>``, and the time of all files is one.

    :param time: the column of time, '' for that which grows all the time.
    :raises ConfigurationError: if the names of the files do not say which joint each is.
    :raises DataError: if their samples are at other times.
    """
    order = [_joint_of(table_name(path), joints) for path in paths]
    listed = ', '.join(path.name for path in paths)
    if sorted(order) != sorted(joints):
        raise ConfigurationError(
            f'{listed} have one joint each, and their names do not say which of '
            f'{", ".join(joints)}: call each file as its joint, or put their columns into one '
            'table'
        )
    variables: dict[str, NDArray[Any]] = {}
    shared: NDArray[Any] | None = None
    for path, joint in zip(paths, order, strict=True):
        data = DataFile(path)
        series = data.series()
        own = find_time(series, (data.find(time) or time) if time else '').name
        stamps = series.pop(own, np.arange(max(map(len, series.values()), default=0)))
        if shared is None:
            shared = variables[own or 'sample'] = stamps
        if not np.array_equal(shared, stamps):
            raise DataError(
                f'{listed} have one joint of a robot each, and other times: put them into one '
                'table with a time for all, as of one sampling'
            )
        for name, values in series.items():
            # What states columns parts them with commas.
            variables[f'{joint} {name.replace(",", "/")}'] = values
    table = folder / f'{"+".join(map(table_name, paths))}.npz'
    np.savez(table, **variables)  # type: ignore[arg-type]
    return table, order


def _joint_of(name: str, joints: Sequence[str]) -> str:
    """Return the joint that a name has in it, else the one with its number, '' if none is."""
    words = f'_{re.sub("[^a-z0-9]+", "_", name.lower())}_'
    found = [j for j in joints if f'_{re.sub("[^a-z0-9]+", "_", j.lower())}_' in words]
    if not found:
        number = re.findall(_NUMBERED, name.lower())[-1:]
        found = [j for j in joints if number and re.findall(r'\d+', j)[-1:] == number]
    return found[0] if len(found) == 1 else ''
