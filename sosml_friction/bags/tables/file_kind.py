# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Tell by its name what kind of table a file is."""

from pathlib import Path

TEXT_SUFFIXES = ('.csv', '.tsv', '.txt', '.dat', '.log')
JSON_SUFFIXES = ('.json', '.jsonl', '.ndjson')
SUFFIXES = (
    '.mat', '.npz', '.npy', '.parquet', '.h5', '.hdf5', '.xlsx', *JSON_SUFFIXES, *TEXT_SUFFIXES,
)  # fmt: skip
#: Tables of text and of JSON may be packed.
PACKED = ('.gz', '.bz2', '.xz', '.lzma', '.zip')


def file_kind(path: Path) -> str:
    """
    Return the suffix that says how a file is read, without that of its packing.

    Of one that has that alone it is the suffix itself: what is inside has its own name, or is
    text.
    """
    suffix = path.suffix.lower()
    inner = Path(path.stem).suffix.lower()
    return inner if suffix in PACKED and inner else suffix


def is_table(path: Path) -> bool:
    """Tell whether a recording is a file that sosml import reads."""
    return file_kind(path) in (*SUFFIXES, *PACKED) and path.is_file()


def table_name(path: Path) -> str:
    """Return the name of a table without the suffixes of its kind and its packing."""
    is_packed = path.suffix.lower() in PACKED and file_kind(path) in SUFFIXES
    return Path(path.stem).stem if is_packed else path.stem
