# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The stretches of an MCAP file that hold messages, and what compressed ones decompress to."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

#: Bytes that a chunk may decompress to (rosbag2 makes chunks of 768 kB; one is held in memory), or
#: how many times its compressed size: joint states of seven joints that stand still, at 1 kHz and
#: with stamps alone that change, pack to 1/29 with zstd and to 1/14 with lz4.
LARGEST_CHUNK = 256 * 2**20
LARGEST_RATIO = 50


class DamagedError(Exception):
    """A record contradicts itself or what is before it; the text says how."""


@dataclass(frozen=True)
class Region:
    """
    A stretch of a file that holds messages: all of it, or the data of one compressed chunk.

    ``compression`` is '' (offsets of messages count from the file's first byte), 'zstd' or 'lz4'
    (they count from the first decompressed byte, of which there are at most ``size``).
    """

    path: Path
    start: int
    stop: int
    compression: str
    size: int = 0


def decompress(region: Region, data: bytes) -> bytes:
    """
    Return what a chunk's data decompress to, as far as they go when they are cut off.

    No more is made than the chunk says that it holds, and no more than ``LARGEST_CHUNK`` or
    ``LARGEST_RATIO`` times its data.
    """
    most = max(LARGEST_CHUNK, LARGEST_RATIO * len(data))
    more = min(region.size, most) + 1
    failure: type[Exception]
    if region.compression == 'zstd':
        import zstandard

        failure = zstandard.ZstdError
    else:
        failure = RuntimeError
    try:
        if region.compression == 'zstd':
            content = zstandard.ZstdDecompressor().stream_reader(data).read(more)
        else:
            import lz4.frame

            content = lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=more)
    except (failure, MemoryError) as error:
        raise DamagedError('a chunk cannot be decompressed') from error
    if len(content) > region.size:
        raise DamagedError(f'a chunk holds more than the {region.size} bytes it says')
    if len(content) > most:
        raise DamagedError(
            f'a chunk of {len(data)} bytes holds more than the {most} that can be read of it: '
            'record with smaller chunks'
        )
    return bytes(content)
