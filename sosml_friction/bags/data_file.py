# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Read the named variables of a MAT, CSV, NPZ or NPY file."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sosml_friction.bags.joint_log import FloatArray
from sosml_friction.exceptions import ConfigurationError, DataError

SUFFIXES = ('.mat', '.csv', '.npz', '.npy')


class DataFile(Mapping[str, NDArray[Any]]):
    """
    Map the names of a file's variables to arrays of numbers, dimensions of length 1 removed.

    MAT up to version 7 (fields of structs as ``struct.field``), CSV with a header line (comma,
    semicolon or tab; an empty cell is NaN), NPZ, and NPY holding a table whose ``rows`` or
    ``columns`` are named here. Integers stay integers, so that stamps in ns keep every digit.

    :raises DataError: if the file is missing, of another kind, or damaged.
    :raises ConfigurationError: if the names given do not fit the table.
    """

    def __init__(
        self,
        path: str | Path,
        rows: Sequence[str] | None = None,
        columns: Sequence[str] | None = None,
    ) -> None:
        self.path = Path(path)
        suffix = self.path.suffix.lower()
        if not self.path.is_file():
            raise DataError(f'{self.path} does not exist: give the file to import')
        if suffix not in SUFFIXES:
            raise DataError(
                f'{self.path} is not of a kind that can be imported: give one of '
                f'{", ".join(SUFFIXES)}'
            )
        if (rows is not None or columns is not None) and suffix != '.npy':
            raise ConfigurationError(
                f'rows and columns name the parts of an .npy table, and {self.path} has names of '
                'its own: remove them from the mapping'
            )
        try:
            self._variables: dict[str, Any] = {
                '.mat': lambda: _read_mat(self.path),
                '.csv': lambda: _read_csv(self.path),
                '.npz': lambda: _read_npz(self.path),
                '.npy': lambda: _read_npy(self.path, rows, columns),
            }[suffix]()
        except OSError as error:
            raise DataError(f'{self.path} cannot be read: {error.strerror or error}') from error

    def __iter__(self) -> Iterator[str]:
        return iter(self._variables)

    def __len__(self) -> int:
        return len(self._variables)

    def __getitem__(self, name: str) -> NDArray[Any]:
        """
        Return a variable.

        :raises DataError: if the file does not have it (the sentence lists what it has) or it
            holds anything but real numbers.
        """
        if name not in self._variables:
            raise DataError(
                f'{self.path} has no variable {name!r}: it has {", ".join(self._variables)}'
            )
        value = self._variables[name]
        if isinstance(value, list):
            value = self._variables[name] = self._numbers(name, value)
        if value.dtype.kind not in 'iufb':
            raise DataError(
                f'the variable {name!r} of {self.path} holds {value.dtype}: real numbers '
                'are needed'
            )
        squeezed: NDArray[Any] = np.squeeze(value)
        return squeezed

    def _numbers(self, name: str, cells: list[tuple[int, str]]) -> NDArray[Any]:
        """Return a CSV column as int64 where every cell is a whole number, else as float64."""
        try:
            return np.array([int(cell) for _, cell in cells], dtype=np.int64)
        except (ValueError, OverflowError):
            pass
        numbers: FloatArray = np.empty(len(cells))
        for k, (line, cell) in enumerate(cells):
            try:
                numbers[k] = float(cell) if cell else np.nan
            except ValueError:
                raise DataError(
                    f'{self.path} line {line}, column {name!r}: {cell!r} is not a number (write '
                    'decimals with a point, leave a missing value empty)'
                ) from None
        return numbers


def _read_mat(path: Path) -> dict[str, Any]:
    from scipy.io import loadmat

    try:
        content = loadmat(path, simplify_cells=True)
    except NotImplementedError:
        raise DataError(
            f"{path} is of MATLAB version 7.3 (HDF5), which is not read: save it with '-v7'"
        ) from None
    except OSError:
        raise
    # A damaged file fails anywhere inside the parser.
    except Exception as error:
        raise DataError(f'{path} is no readable MAT file: {error}') from error
    variables: dict[str, Any] = {}

    def flatten(prefix: str, value: Any) -> None:
        if isinstance(value, dict):
            for name, part in value.items():
                flatten(f'{prefix}.{name}', part)
        else:
            variables[prefix] = np.asarray(value)

    for name, value in content.items():
        if not name.startswith('__'):
            flatten(name, value)
    return variables


def _read_csv(path: Path) -> dict[str, Any]:
    try:
        with path.open(encoding='utf-8-sig', newline='') as stream:
            head = stream.readline()
            stream.seek(0)
            delimiter = max(',;\t', key=head.count)
            reader = csv.reader(stream, delimiter=delimiter)
            rows = [(reader.line_num, row) for row in reader if any(cell.strip() for cell in row)]
    except (UnicodeDecodeError, csv.Error) as error:
        raise DataError(f'{path} is no readable CSV file: {error}') from error
    if not rows:
        raise DataError(f'{path} is empty: a CSV file needs a header line and rows of numbers')
    names = [cell.strip() for cell in rows[0][1]]
    if len(set(names)) != len(names):
        raise DataError(
            f'{path} has the header {", ".join(names)}: each column needs its own name'
        )
    for line, row in rows[1:]:
        if len(row) != len(names):
            raise DataError(
                f'{path} line {line} has {len(row)} cells where the header has {len(names)}: '
                'correct that line'
            )
    return {
        name: [(line, row[i].strip()) for line, row in rows[1:]] for i, name in enumerate(names)
    }


def _read_npz(path: Path) -> dict[str, Any]:
    variables: dict[str, Any] = {}
    try:
        with np.load(path, allow_pickle=False) as content:
            for name in content.files:
                variables[name] = content[name]
    except OSError:
        raise
    except Exception as error:
        raise DataError(f'{path} is no readable NPZ file of plain arrays: {error}') from error
    return variables


def _read_npy(
    path: Path, rows: Sequence[str] | None, columns: Sequence[str] | None
) -> dict[str, Any]:
    if (rows is None) == (columns is None):
        raise ConfigurationError(
            f'{path} has no names of its own: the mapping must name either its rows or its columns'
        )
    try:
        table = np.load(path, allow_pickle=False)
    except OSError:
        raise
    except Exception as error:
        raise DataError(f'{path} is no readable NPY file of a plain array: {error}') from error
    if table.ndim != 2:
        raise DataError(f'{path} holds an array of shape {table.shape}: a table is needed')
    table = table if rows is not None else table.T
    names = list(rows if rows is not None else columns or ())
    if len(names) != len(table) or len(set(names)) != len(names):
        what = 'rows' if rows is not None else 'columns'
        raise ConfigurationError(
            f'{path} has {len(table)} {what} and the mapping names {len(names)} '
            f'({", ".join(names)}): give each its own name'
        )
    return dict(zip(names, table, strict=True))
