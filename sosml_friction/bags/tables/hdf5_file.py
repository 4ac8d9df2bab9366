# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Read the datasets of an HDF5 file, which MAT files of version 7.3 are too."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sosml_friction.bags.tables.packed_file import check_size, readable
from sosml_friction.exceptions import DataError

SIGNATURE = b'\x89HDF\r\n\x1a\n'
#: What pandas calls the columns of one type, and their names.
_BLOCK, _ITEMS = '_values', '_items'


def read_hdf5(path: Path) -> dict[str, NDArray[Any]]:
    """
    Return the datasets by their paths, with points for strokes; records as they are.

    A unit that a dataset has as an attribute stands behind its name, as ``name [unit]``. Datasets
    of more than two dimensions, such as pictures, are no series and are not read. MATLAB stores
    tables the other way around.

    :raises DataError: if h5py is not there, or the file is damaged or unpacks to too much.
    """
    is_mat = path.suffix.lower() == '.mat'
    try:
        import h5py
    except ImportError:
        what = 'of MATLAB version 7.3 (HDF5)' if is_mat else 'an HDF5 file'
        instead = "save it with '-v7', or " if is_mat else ''
        raise DataError(f'{path} is {what}, which needs h5py: {instead}pip install h5py') from None
    variables: dict[str, NDArray[Any]] = {}

    def take(name: str, item: Any) -> None:
        if not isinstance(item, h5py.Dataset) or name.startswith('#') or item.shape is None:
            return
        parts = [item]
        if h5py.check_ref_dtype(item.dtype):
            # A field of an array of structs, or a cell array.
            parts = [item.file[reference] for reference in item[()].ravel() if reference]
        if any(sum(n > 1 for n in part.shape) > 2 for part in parts):
            return
        size = sum(x.nbytes for x in (*variables.values(), *parts))
        check_size(path, size)
        values = [np.asarray(part).T if is_mat else np.asarray(part) for part in parts]
        if parts != [item] and len({x.size for x in values}) == 1:
            values = [np.column_stack([x.ravel() for x in values])]
        if len(values) == 1:
            variables.update(_named(item, name.replace('/', '.'), values[0]))

    kind = 'MAT file' if is_mat else 'HDF5 file'
    with readable(path, kind, io=False), h5py.File(path, 'r') as content:
        content.visititems(take)
    return variables


def _named(item: Any, name: str, values: NDArray[Any]) -> Iterator[tuple[str, NDArray[Any]]]:
    """Return the series of a dataset by name: its unit behind it, those of pandas by theirs."""
    items = item.parent.get(item.name.removesuffix(_BLOCK) + _ITEMS)
    if name.endswith(_BLOCK) and items is not None and values.ndim == 2:
        columns = [x.decode(errors='replace') for x in items[()].tolist()]
        return zip(columns, values.T, strict=True)
    units = [item.attrs.get(key) for key in ('unit', 'units')]
    texts = [x.decode(errors='replace') if isinstance(x, bytes) else x for x in units]
    unit = next((x for x in texts if isinstance(x, str) and x), '')
    return iter([(f'{name} [{unit}]' if unit else name, values)])
