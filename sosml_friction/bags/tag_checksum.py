# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A checksum for the tags of a bag, which stand outside of its chunks and of theirs."""

import zlib

#: Key of the checksum, beside rosbag2's ``serialized_metadata`` in the record of this name.
CHECKSUM = 'sosml_friction_crc32'


def text_checksum(text: str) -> str:
    """Return the CRC-32 of a text in UTF-8, eight digits."""
    return f'{zlib.crc32(text.encode("utf-8")):08x}'
