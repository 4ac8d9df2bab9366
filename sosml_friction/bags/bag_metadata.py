# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What rosbag2 writes about a bag beside its files."""

import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sosml_friction.exceptions import BagError, ConfigurationError
from sosml_friction.yaml_text import read_yaml

METADATA = 'metadata.yaml'
#: Key of a checksum beside rosbag2's ``serialized_metadata`` in the record of that name: the tags
#: of a bag stand outside of its chunks and of theirs.
CHECKSUM = 'sosml_friction_crc32'
#: The key below which rosbag2 writes all of it.
INFORMATION = 'rosbag2_bagfile_information'


def text_checksum(text: str) -> str:
    """Return the CRC-32 of a text in UTF-8, eight digits."""
    return f'{zlib.crc32(text.encode("utf-8")):08x}'


def as_mapping(value: Any) -> dict[Any, Any]:
    """Return a mapping of a document, empty where something else stands."""
    return value if isinstance(value, dict) else {}


def read_metadata(folder: Path) -> dict[Any, Any] | None:
    """Return what is written beside the files in a folder, None where it cannot be read."""
    try:
        found = as_mapping(read_yaml(folder / METADATA)).get(INFORMATION)
    # The messages do not depend on it, so that a broken one is no reason to stop.
    except ConfigurationError:
        return None
    return found if isinstance(found, dict) else None


def refuse_compressed_messages(path: Path, information: Sequence[Mapping[Any, Any]]) -> None:
    """
    Refuse a bag whose messages are compressed one by one.

    :param information: what was written about it, in one place or several.
    :raises BagError: if one of them says so.
    """
    modes = {str(part.get('compression_mode') or '').lower() for part in information}
    if 'message' in modes:
        raise BagError(
            f'{path} was recorded with --compression-mode message, which is not read: record with '
            '--storage-preset-profile zstd_fast instead'
        )
