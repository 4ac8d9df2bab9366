# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Read the named series of numbers in a file of any kind that a recording may come in."""

import json
import re
import struct
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sosml_friction.bags.stand_in import refuse_stand_in
from sosml_friction.bags.tables.cell_text import is_missing, is_number, number, numbers
from sosml_friction.bags.tables.date_text import read_dates
from sosml_friction.bags.tables.excel_file import read_excel
from sosml_friction.bags.tables.file_kind import JSON_SUFFIXES, PACKED, SUFFIXES, file_kind
from sosml_friction.bags.tables.hdf5_file import SIGNATURE, read_hdf5
from sosml_friction.bags.tables.header_words import without_unit
from sosml_friction.bags.tables.long_table import widened
from sosml_friction.bags.tables.overflow import without_overflow
from sosml_friction.bags.tables.packed_file import (
    check_size,
    most_unpacked,
    read_unpacked,
    readable,
)
from sosml_friction.bags.tables.text_table import read_text_table
from sosml_friction.exceptions import ConfigurationError, DataError

#: Types of what stands in a MAT file of version 5: an array, a packed one, and all of an array.
_ARRAY, _PACKED = 14, 15
_TYPES = frozenset((*range(1, 8), 9, 12, 13, _ARRAY, 16, 17, 18))
_PART = re.compile(r'(?P<name>.+)\[(?P<part>\d+)\]')
_NO_NUMBER = (
    'is not a number, nor a date such as 2025-03-30T12:00:00.005 (write decimals with a point, '
    'leave a missing value empty)'
)
#: Bytes of a value by the types that Parquet stores; those of any other are 8 at least.
_WIDTHS = {'BOOLEAN': 1, 'INT32': 4, 'FLOAT': 4}


class DataFile(Mapping[str, NDArray[Any]]):
    """
    Map the names of a file's variables to arrays of numbers, dimensions of length 1 removed.

    Text (columns, see :mod:`sosml_friction.bags.tables.text_table`), MAT (fields of structs as
    ``struct.field``), NPZ, NPY, Parquet and JSON: a list of records, an object of lists, or a
    record in each line. A field of an array of structs or records is a table. What has no names
    is called by number, counted from 0; ``rows`` or ``columns`` give names to a table that has
    none. Integers stay integers, so that stamps in ns keep every digit.

    A name is looked for as it is, then without the unit behind it, then without regard to case;
    ``name[k]`` is column k of a table, and a number the column of that number.

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
        #: Sentences on what was passed over.
        self.remarks: list[str] = []
        self._variables: dict[str, Any] = {}
        kind = file_kind(self.path)
        if not self.path.is_file():
            raise DataError(f'{self.path} does not exist: give the file to import')
        if kind not in (*SUFFIXES, *PACKED):
            raise DataError(
                f'{self.path} is not of a kind that can be imported: give one of '
                f'{", ".join(SUFFIXES)}; a table of text under another name is read as .csv'
            )
        if kind in _READERS and self.path.suffix.lower() != kind:
            raise DataError(f'{self.path} is packed, as tables of text may be: unpack it first')
        refuse_stand_in(self.path)
        try:
            if kind == '.xlsx':
                self._variables, self.remarks = read_excel(self.path)
            else:
                self._variables = _READERS.get(kind, _read_text)(self.path)
        except OSError as error:
            raise DataError(f'{self.path} cannot be read: {error.strerror or error}') from error
        self._name_parts(rows, columns)
        if {np.ndim(x) for x in self._variables.values() if not isinstance(x, list)} <= {1}:
            wide, told = widened(self._variables)
            self._variables = wide or self._variables
            self.remarks += [f'{self.path}: {sentence}' for sentence in told]

    def _name_parts(self, rows: Sequence[str] | None, columns: Sequence[str] | None) -> None:
        """Give the parts of a table without names those of the mapping."""
        given = rows if columns is None else columns
        if given is None:
            return
        if list(self._variables) != [str(k) for k in range(len(self._variables))]:
            raise ConfigurationError(
                f'rows and columns name the parts of a table without names, and {self.path} has '
                f'names of its own ({", ".join(self._variables)}): remove them from the mapping'
            )
        names = list(given)
        if len(names) != len(self._variables) or len(set(names)) != len(names):
            what = 'rows' if columns is None else 'columns'
            raise ConfigurationError(
                f'{self.path} has {len(self._variables)} {what} and the mapping names '
                f'{len(names)} ({", ".join(names)}): give each its own name'
            )
        self._variables = dict(zip(names, self._variables.values(), strict=True))

    def __iter__(self) -> Iterator[str]:
        return iter(self._variables)

    def __len__(self) -> int:
        return len(self._variables)

    def find(self, name: str) -> str | None:
        """Return the whole name of the variable that ``name`` means, None if there is none."""
        if name in self._variables:
            return name
        for form in (str, str.casefold):
            for bare in (str, without_unit):
                found = [known for known in self._variables if form(bare(known)) == form(name)]
                if len(found) == 1:
                    return found[0]
        if name.isdecimal() and int(name) < len(self._variables):
            return list(self._variables)[int(name)]
        return None

    def find_series(self, name: str) -> str:
        """Return the whole name of a variable, or of column k of one by ``name[k]``."""
        part = _PART.fullmatch(name)
        table = self.find(part['name']) if part and self.find(name) is None else None
        return f'{table}[{part["part"]}]' if part and table else self.find(name) or name

    def split_unit(self, entry: str) -> tuple[str, str]:
        """Return name and unit of ``NAME`` or ``NAME:UNIT``; a name may have a colon itself."""
        name, _, unit = entry.rpartition(':') if self.find(entry) is None else (entry, '', '')
        return (name, unit) if name else (unit, '')

    def __getitem__(self, name: str) -> NDArray[Any]:
        """
        Return a variable.

        :raises DataError: if the file does not have it (the sentence lists what it has) or it
            holds anything but real numbers.
        """
        known = self.find(name)
        if known is None:
            part = _PART.fullmatch(name)
            if part is not None and self.find(part['name']) is not None:
                return self._part(part['name'], int(part['part']))
            raise DataError(
                f'{self.path} has no variable {name!r}: it has {", ".join(self._variables)}'
            )
        value = self._variables[known]
        if isinstance(value, list):
            value = self._variables[known] = self._numbers(known, value)
        if value.dtype.kind not in 'iufb':
            raise DataError(
                f'the variable {name!r} of {self.path} holds {value.dtype}: real numbers '
                'are needed'
            )
        # Differences of unsigned numbers would never fall.
        signed = value.astype(np.int64) if value.dtype.kind in 'ub' else value
        squeezed: NDArray[Any] = np.squeeze(signed)
        return squeezed

    def _part(self, name: str, index: int) -> NDArray[Any]:
        """Return column ``index`` of a table whose longer side are the samples, (N,)."""
        table = self[name]
        parts = table.T if table.ndim == 2 and table.shape[0] >= table.shape[1] else table
        if table.ndim != 2 or index >= len(parts):
            raise DataError(
                f'the variable {name!r} of {self.path} has shape {table.shape}: it has no column '
                f'{index} (counted from 0)'
            )
        return np.asarray(parts[index])

    def arrays(self) -> Iterator[tuple[str, NDArray[Any]]]:
        """Yield the variables that hold real numbers."""
        for name in self:
            try:
                values = self[name]
            except DataError:
                continue
            yield name, values

    def series(self) -> dict[str, NDArray[Any]]:
        """
        Return the series of the recording by name: as long as most are, tables by ``name[k]``.

        Variables that hold no real numbers are not among them. Counters go on where they overflow.
        """
        found: dict[str, NDArray[Any]] = {}
        for name, values in self.arrays():
            if values.ndim == 1:
                found[name] = values
            elif values.ndim == 2:
                for k in range(min(values.shape)):
                    found[f'{name}[{k}]'] = self._part(name, k)
        lengths = [len(values) for values in found.values()]
        usual = max(lengths, key=lambda n: (lengths.count(n) * (n > 1), n), default=0)
        found = {name: values for name, values in found.items() if len(values) == usual}
        return {name: without_overflow(values) for name, values in found.items()}

    def texts(self) -> list[list[str]]:
        """Return the words of each column that has the same ones in every row."""
        found: list[list[str]] = []
        for value in self._variables.values():
            if isinstance(value, list):
                cells = {cell for _, cell in value}
                if len(cells) == 1:
                    found.append(re.findall(r'[^\s,;\[\]()\'"]+', cells.pop()))
            elif value.dtype.kind == 'U' and value.ndim and (value == value[:1]).all():
                found.append(np.ravel(value[:1]).tolist())
        return found

    def constants(self) -> dict[str, float]:
        """Return the variables that hold one finite number."""
        return {
            name: float(values.reshape(()))
            for name, values in self.arrays()
            if values.size == 1 and np.isfinite(values).all()
        }

    def _numbers(self, name: str, cells: list[tuple[int, str]]) -> NDArray[Any]:
        """Return a CSV column as int64 where every cell is a whole number, else as float64."""
        if not any('_' in cell for _, cell in cells):
            try:
                return np.array([int(cell) for _, cell in cells], dtype=np.int64)
            except (ValueError, OverflowError):
                pass
        texts = ['' if is_missing(cell) else cell for _, cell in cells]
        try:
            found = np.array([number(text) for text in texts])
        except ValueError:
            with suppress(ValueError):
                return np.array([numbers(text) for text in texts])
            try:
                found = read_dates(texts)
            except ValueError as error:
                k, why = error.args
                if not why:
                    # A word among numbers is what is wrong, and not the first number.
                    k = max(k, next(i for i, x in enumerate(texts) if x and not is_number(x)))
                    why = _NO_NUMBER
                raise self._wrong(name, cells[k], why) from None
        for k in np.flatnonzero(np.isinf(found))[:1]:
            raise self._wrong(
                name, cells[k], 'is not a finite number (leave a missing value empty)'
            )
        return found

    def _wrong(self, name: str, place: tuple[int, str], why: str) -> DataError:
        line, cell = place
        return DataError(f'{self.path} line {line}, column {name!r}: {cell!r} {why}')


def _flatten(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of nested mappings as arrays, by dotted names; null is NaN."""
    return {name: _array(value) for name, value in _plain(content).items()}


def _array(value: Any) -> NDArray[Any]:
    try:
        array = np.asarray(value)
        return array.astype(np.float64) if array.dtype == object else array
    except (TypeError, ValueError):  # lists of several lengths, or no numbers
        return np.asarray(value, dtype=object)


def _by_name(value: Any) -> Any:
    """Return the columns of records, or of an array of structs or fields; others as they are."""
    if isinstance(value, np.ndarray) and value.dtype.names:
        return {name: value[name] for name in value.dtype.names}
    if isinstance(value, Mapping) and value and all(str(key).isdecimal() for key in value):
        # A column by the numbers of its rows, as pandas writes it.
        return list(value.values())
    is_list = isinstance(value, list) or (
        isinstance(value, np.ndarray) and value.dtype == object and value.ndim > 0
    )
    if is_list and len(value) and all(isinstance(x, Mapping) for x in value):
        return _channels(value) or _columns([_plain(record) for record in value])
    return value


def _channels(records: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """
    Return the series of records that hold one each beside its name, {} if they are no such.

    They are the signals of a scope of Simulink and of a recorder of dSPACE. A unit stands behind
    the name; without names of their own they are called by number.
    """
    found: dict[str, Any] = {}
    for k, record in enumerate(records):
        own = {key.lower(): value for key, value in record.items()}
        said = own.get('label', own.get('name', 0))
        series = [x for x in own.values() if isinstance(x, np.ndarray) and len(x) > len(records)]
        if len(series) != 1 or not (isinstance(said, str) or np.size(said) == 0):
            return {}
        name = said if isinstance(said, str) and said else str(k)
        unit = own.get('unit')
        name = f'{name} [{unit}]' if isinstance(unit, str) and unit else name
        found[name if name not in found else f'{name} {k}'] = series[0]
    return found


def _unpacked_mat(path: Path) -> int:
    """Return what the packed variables of a MAT file unpack to [bytes], or too much."""
    most, found = most_unpacked(path), 0
    with path.open('rb') as stream:
        # Version and order of bytes; another version packs nothing, or is read by h5py.
        order = {b'\x00\x01IM': '<', b'\x01\x00MI': '>'}.get(stream.read(128)[124:])
        while order and len(tag := stream.read(8)) == 8 and found <= most:
            kind, length = struct.unpack(f'{order}II', tag)
            data = stream.read(min(length, path.stat().st_size))
            if kind == _PACKED:
                data = zlib.decompressobj().decompress(data, most - found + 1)
                found += len(data)
            if kind in (_ARRAY, _PACKED) and found <= most:
                _check_types(path, memoryview(data), order)
    return found


def _check_types(path: Path, data: memoryview, order: str) -> None:
    """Refuse types that are none: scipy looks them up in a table of 20 and ends the process."""
    waiting = [data]
    while waiting:
        part, at = waiting.pop(), 0
        while at + 8 <= len(part):
            kind, length = struct.unpack_from(f'{order}II', part, at)
            at += 8
            if kind >> 16:  # a short one, whose length and data stand in its tag
                kind, length = kind & 0xFFFF, 0
            if kind not in _TYPES:
                raise DataError(f'{path} is no readable MAT file: it has data of type {kind}')
            if kind == _ARRAY:
                waiting.append(part[at : at + length])
            at += -(-length // 8) * 8


def _read_mat(path: Path) -> dict[str, Any]:
    from scipy.io import loadmat

    with path.open('rb') as stream:
        if stream.read(len(SIGNATURE)) == SIGNATURE:
            return _read_hdf5(path)
    try:
        check_size(path, _unpacked_mat(path))
    except zlib.error as error:
        raise DataError(f'{path} is no readable MAT file: {error}') from error
    with readable(path, 'MAT file'):
        try:
            content = loadmat(path, simplify_cells=True)
        # MATLAB 7.3 writes HDF5 behind a header of its own, which scipy knows and does not read.
        except NotImplementedError:
            return _read_hdf5(path)
    return _flatten({name: value for name, value in content.items() if not name.startswith('__')})


def _read_hdf5(path: Path) -> dict[str, Any]:
    return _flatten(read_hdf5(path))


def _read_npz(path: Path) -> dict[str, Any]:
    variables: dict[str, Any] = {}
    kind = 'NPZ file of plain arrays'
    with readable(path, kind), np.load(path, allow_pickle=False) as content:
        if isinstance(content, np.ndarray):
            raise ValueError('it is an NPY file')
        check_size(path, sum(entry.file_size for entry in content.zip.infolist()))
        for name in content.files:
            try:
                variables.update(_flatten({name: content[name]}))
            except ValueError as error:
                if 'allow_pickle' not in str(error):
                    raise
                # Objects of Python are not loaded: they could run code.
                variables[name] = np.empty((), dtype=object)
    return variables


def _read_npy(path: Path) -> dict[str, Any]:
    with readable(path, 'NPY file of a plain array'):
        table = np.load(path, mmap_mode='r', allow_pickle=False)
    if table.dtype.names:
        return _flatten(_by_name(table))
    if table.ndim != 2:
        raise DataError(f'{path} holds an array of shape {table.shape}: a table is needed')
    # There are more samples than quantities.
    parts = table.T if table.shape[0] > table.shape[1] else table
    return {str(k): part for k, part in enumerate(parts)}


def _unpacked_parquet(form: Any) -> int:
    """Return what the columns of a Parquet file unpack to [bytes], each by its own width."""
    found = 0
    for k in range(form.num_row_groups):
        group = form.row_group(k)
        for column in map(group.column, range(form.num_columns)):
            width = _WIDTHS.get(column.physical_type, 8)
            found += max(width * column.num_values, column.total_uncompressed_size)
    return found


def _read_parquet(path: Path) -> dict[str, Any]:
    try:
        from pyarrow import parquet
    except ImportError:
        raise DataError(
            f'{path} is a Parquet file, which needs pyarrow: pip install pyarrow, or save the '
            'table as CSV'
        ) from None
    with readable(path, 'Parquet file', io=False):
        check_size(path, _unpacked_parquet(parquet.read_metadata(path)))
        table = parquet.read_table(path)
    variables: dict[str, Any] = {}
    for name in table.column_names:
        values = table[name].to_numpy()
        if values.dtype.kind in 'Mm':
            values = values.astype('datetime64[ns]').astype(np.int64)
        elif values.dtype == object:
            values = table[name].to_pylist()
        variables |= _flatten({name: values})
    return variables


def _read_text(path: Path) -> dict[str, Any]:
    """Read a table of text or JSON, which may be packed."""
    kind, content = read_unpacked(path)
    if kind in JSON_SUFFIXES:
        return _read_json(path, content)
    if content.startswith(b'header:'):
        raise DataError(
            f'{path} is what ros2 topic echo prints: let it write a table, with --csv, or record '
            'a bag'
        )
    return dict(read_text_table(path, content))


def _read_json(path: Path, raw: bytes) -> dict[str, Any]:
    """Read an object of lists, a list of records, or a record in each line."""
    try:
        text = raw.decode('utf-8-sig')
        try:
            content = json.loads(text)
        except json.JSONDecodeError:
            content = [json.loads(line) for line in _whole_lines(text)]
            if not content:
                raise
    except (ValueError, RecursionError) as error:
        raise DataError(
            f'{path} is no readable JSON: {error}; a list of records, an object of lists, or a '
            'record in each line can be read'
        ) from error
    if isinstance(content, Mapping):
        # As pandas writes a table with its names beside it, or a record by the number of each row.
        if isinstance(content.get('columns'), list) and isinstance(content.get('data'), list):
            rows = zip(*content['data'], strict=False)
            return _flatten(dict(zip(map(str, content['columns']), rows, strict=False)))
        if not all(key.isdecimal() and isinstance(x, Mapping) for key, x in content.items()):
            return _flatten(content)
        content = list(content.values())
    if isinstance(content, list) and content and all(isinstance(x, list) for x in content):
        return _flatten({str(k): part for k, part in enumerate(zip(*content, strict=False))})
    if not isinstance(content, list) or not all(isinstance(x, Mapping) for x in content):
        raise DataError(
            f'{path} holds no records with names: give a list of records, an object of lists, or '
            'a record in each line'
        )
    return _flatten(_columns([_plain(record) for record in content]))


def _whole_lines(text: str) -> list[str]:
    """Return the lines that hold something, without a last one that a logger did not end."""
    lines = [line for line in text.splitlines() if line.strip()]
    is_cut = lines and not text.endswith('\n') and not lines[-1].rstrip().endswith('}')
    return lines[:-1] if is_cut else lines


def _columns(records: Sequence[Mapping[str, Any]]) -> dict[str, list[Any]]:
    """Return the values of each name in plain records, NaN where a record does not have it."""
    names = dict.fromkeys(name for record in records for name in record)
    columns: dict[str, list[Any]] = {}
    for name in names:
        values = [record.get(name) for record in records]
        width = next((len(x) for x in values if isinstance(x, list)), None)
        if width is not None:
            values = [[np.nan] * width if x is None else x for x in values]
        columns[name] = values
    return columns


def _plain(record: Mapping[str, Any], prefix: str = '') -> dict[str, Any]:
    """Return a mapping whose inner mappings and records are entries of dotted names."""
    plain: dict[str, Any] = {}
    for name, given in record.items():
        value = _by_name(given)
        if isinstance(value, Mapping):
            plain.update(_plain(value, f'{prefix}{name}.'))
        else:
            plain[f'{prefix}{name}'] = value
    return plain


_READERS: dict[str, Callable[[Path], dict[str, Any]]] = {
    '.mat': _read_mat,
    '.h5': _read_hdf5,
    '.hdf5': _read_hdf5,
    '.npz': _read_npz,
    '.npy': _read_npy,
    '.parquet': _read_parquet,
}
