# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Messages of MCAP files by their place."""

from __future__ import annotations

import mmap
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sosml_friction.arrays import IndexArray
from sosml_friction.bags.chunk_data import DamagedError, Region, decompress
from sosml_friction.exceptions import BagError


class MessageStore:
    """Fetch messages by their place; holds the open files and one decompressed chunk."""

    def __init__(self, regions: list[Region]) -> None:
        self._regions = regions
        self._files: dict[Path, mmap.mmap] = {}
        self._content: tuple[int, bytes] = (-1, b'')

    def fetch(self, region: int, offset: int, length: int) -> bytes:
        """Return the bytes of one message; a BagError if the file has changed since the scan."""
        place = self._regions[region]
        try:
            if place.compression == '':
                message = self._file(place.path)[offset : offset + length]
            else:
                if self._content[0] != region:
                    data = self._file(place.path)[place.start : place.stop]
                    self._content = (region, decompress(place, data))
                message = self._content[1][offset : offset + length]
        except (OSError, ValueError, DamagedError):
            message = b''
        if len(message) != length:
            raise BagError(f'{place.path} has changed since it was opened: open the bag again')
        return message

    def fetch_all(self, region: int, offset: IndexArray, length: int) -> NDArray[np.uint8]:
        """
        Return the bytes of K messages of one region and one length, (K, length), a copy.

        :raises BagError: as :meth:`fetch`.
        """
        # What is fetched first finds out whether the region can be read, and the last what is
        # there of it.
        last = int(offset.max())
        self.fetch(region, last, length)
        if not length:
            return np.empty((len(offset), 0), dtype=np.uint8)
        place = self._regions[region]
        content = self._content[1] if place.compression else self._file(place.path)
        # A message for every byte, of which those wanted are copied.
        messages = np.ndarray((last + 1, length), np.uint8, content, 0, (1, 1))
        return messages[offset]

    def _file(self, path: Path) -> mmap.mmap:
        if path not in self._files:
            with path.open('rb') as stream:
                self._files[path] = mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ)
        return self._files[path]

    def close(self) -> None:
        """Close the files."""
        for data in self._files.values():
            data.close()
        self._files.clear()
