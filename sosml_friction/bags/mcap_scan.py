# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Find every whole message of an MCAP file, finished or cut off at any byte.

The mcap library's readers need the end of the file (seeking reader) or take a last message that is
cut short for a whole one (stream reader), and neither looks into a chunk that is cut off. So the
framing (one byte of opcode, eight of length) is followed here, and the library parses the records.
"""

from __future__ import annotations

import mmap
import struct
import zlib
from array import array
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Metadata, Schema
from mcap.writer import MCAP0_MAGIC as MAGIC

from sosml_friction.exceptions import BagError

_FRAME = struct.Struct('<BQ')
_MESSAGE = struct.Struct('<HIQQ')
_CHUNK = struct.Struct('<QQQII')
_LENGTH = struct.Struct('<Q')


@dataclass(frozen=True)
class Region:
    """
    A stretch of a file that holds messages: all of it, or the data of one compressed chunk.

    ``compression`` is '' (offsets of messages count from the file's first byte), 'zstd' or 'lz4'
    (they count from the first decompressed byte).
    """

    path: Path
    start: int
    stop: int
    compression: str


@dataclass
class MessageIndex:
    """Where the messages of one channel are: parallel arrays, in the order of the file."""

    region: array[int] = field(default_factory=lambda: array('L'))
    offset: array[int] = field(default_factory=lambda: array('Q'))
    length: array[int] = field(default_factory=lambda: array('Q'))
    log_time_ns: array[int] = field(default_factory=lambda: array('Q'))

    def __len__(self) -> int:
        return len(self.offset)


@dataclass
class McapScan:
    """
    What one file holds.

    ``regions`` is shared by the files of a bag, so that an index says in which file it points.
    ``complete`` is False when the file does not end as a closed recording does; ``read_to`` is the
    byte up to which it could be followed.
    """

    path: Path
    regions: list[Region]
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    messages: dict[int, MessageIndex] = field(default_factory=dict)
    metadata: list[Metadata] = field(default_factory=list)
    complete: bool = False
    read_to: int = 0

    def type_name(self, channel: Channel) -> str:
        """Return the ``package/msg/Name`` of a channel, or '' where the file does not say."""
        schema = self.schemas.get(channel.schema_id)
        if schema is None:
            return ''
        package, slash, name = schema.name.partition('/')
        return f'{package}/msg/{name}' if slash and '/' not in name else schema.name


class _DamagedError(Exception):
    """A record contradicts itself: nothing behind it can be trusted."""


def scan(path: Path, regions: list[Region]) -> McapScan:
    """
    Return the index of an MCAP file up to its last whole message.

    :raises BagError: if the file cannot be read, is no MCAP file, or uses an unknown compression.
    """
    found = McapScan(path, regions)
    try:
        with path.open('rb') as stream:
            head = stream.read(len(MAGIC))
            if head != MAGIC[: len(head)]:
                raise BagError(
                    f'{path} is not an MCAP file (its first bytes are not those of one): give a '
                    'bag folder or a .mcap file'
                )
            if len(head) < len(MAGIC):
                return found
            with mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
                _scan_file(found, data)
    except OSError as error:
        raise BagError(f'{path} cannot be read: {error.strerror}') from error
    return found


def _scan_file(found: McapScan, data: mmap.mmap) -> None:
    """Follow the records of a file; stop at the first that is cut off or damaged."""
    size = len(data)
    found.regions.append(Region(found.path, 0, size, ''))
    region = len(found.regions) - 1
    position = len(MAGIC)
    found.read_to = position
    try:
        while position + _FRAME.size <= size:
            opcode, length = _FRAME.unpack_from(data, position)
            start = position + _FRAME.size
            stop = start + length
            if opcode == Opcode.CHUNK:
                whole = _scan_chunk(found, data, region, start, stop)
            elif stop > size:
                return
            else:
                whole = True
                _take(found, data, opcode, start, stop, region)
            if not whole:
                return
            position = found.read_to = stop
            if opcode == Opcode.FOOTER:
                found.complete = data[stop : stop + len(MAGIC)] == MAGIC
                return
    except _DamagedError:
        return


def _scan_chunk(found: McapScan, data: mmap.mmap, region: int, start: int, stop: int) -> bool:
    """Index the messages of a chunk; return whether all of it is there."""
    size = len(data)
    if start + _CHUNK.size > size:
        return False
    _, _, _, crc, name_length = _CHUNK.unpack_from(data, start)
    start += _CHUNK.size
    name = data[start : start + name_length]
    start += name_length
    if start + _LENGTH.size > size:
        return False
    (length,) = _LENGTH.unpack_from(data, start)
    start += _LENGTH.size
    if start + length > stop:
        raise _DamagedError
    stop = start + length
    whole = stop <= size
    stop = min(stop, size)
    if name == b'':
        if whole and crc and zlib.crc32(data[start:stop]) != crc:
            raise _DamagedError
        inner_whole = _scan_records(found, data, region, start, stop)
    else:
        chunk = Region(found.path, start, stop, name.decode('ascii', 'replace'))
        content = decompress(chunk, data[start:stop])
        if whole and crc and zlib.crc32(content) != crc:
            raise _DamagedError
        found.regions.append(chunk)
        inner_whole = _scan_records(found, content, len(found.regions) - 1, 0, len(content))
    if whole and not inner_whole:
        raise _DamagedError
    return whole


def _scan_records(
    found: McapScan, data: bytes | mmap.mmap, region: int, start: int, stop: int
) -> bool:
    """Index the records of a chunk's content; return whether the last one is whole."""
    while start < stop:
        if start + _FRAME.size > stop:
            return False
        opcode, length = _FRAME.unpack_from(data, start)
        start += _FRAME.size
        if start + length > stop:
            return False
        _take(found, data, opcode, start, start + length, region)
        start += length
    return True


def _take(
    found: McapScan, data: bytes | mmap.mmap, opcode: int, start: int, stop: int, region: int
) -> None:
    """Take note of one whole record that is not a chunk."""
    if opcode == Opcode.MESSAGE:
        if stop - start < _MESSAGE.size:
            raise _DamagedError
        channel_id, _, log_time_ns, _ = _MESSAGE.unpack_from(data, start)
        index = found.messages.get(channel_id)
        if index is None:
            raise _DamagedError
        index.region.append(region)
        index.offset.append(start + _MESSAGE.size)
        index.length.append(stop - start - _MESSAGE.size)
        index.log_time_ns.append(log_time_ns)
    elif opcode == Opcode.SCHEMA:
        schema = _parse(Schema.read, data[start:stop])
        found.schemas[schema.id] = schema
    elif opcode == Opcode.CHANNEL:
        channel = _parse(Channel.read, data[start:stop])
        found.channels[channel.id] = channel
        found.messages.setdefault(channel.id, MessageIndex())
    elif opcode == Opcode.METADATA:
        found.metadata.append(_parse(Metadata.read, data[start:stop]))
    elif opcode == 0:
        # No record has this opcode; a disk that lost power fills files with zeros.
        raise _DamagedError


def _parse(read: Callable[[ReadDataStream], Any], body: bytes) -> Any:
    try:
        return read(ReadDataStream(BytesIO(body)))
    except (McapError, struct.error, ValueError) as error:
        raise _DamagedError from error


def decompress(region: Region, data: bytes) -> bytes:
    """
    Return what a chunk's data decompress to, as far as they go when they are cut off.

    :raises BagError: if the compression is not one of MCAP's.
    """
    decoder: Any
    failure: type[Exception]
    if region.compression == 'zstd':
        import zstandard

        decoder, failure = zstandard.ZstdDecompressor().decompressobj(), zstandard.ZstdError
    elif region.compression == 'lz4':
        import lz4.frame

        decoder, failure = lz4.frame.LZ4FrameDecompressor(), RuntimeError
    else:
        raise BagError(
            f'{region.path} has chunks compressed with {region.compression!r}: only zstd, lz4 and '
            'none can be read'
        )
    try:
        return bytes(decoder.decompress(data))
    except failure as error:
        raise _DamagedError from error


class MessageStore:
    """Fetch messages by their place; holds the open files and one decompressed chunk."""

    def __init__(self, regions: list[Region]) -> None:
        self._regions = regions
        self._files: dict[Path, mmap.mmap] = {}
        self._content: tuple[int, bytes] = (-1, b'')

    def fetch(self, region: int, offset: int, length: int) -> bytes:
        """
        Return the bytes of one message.

        :raises BagError: if the file is no longer what it was when it was scanned.
        """
        place = self._regions[region]
        try:
            if place.compression == '':
                message = self._file(place.path)[offset : offset + length]
            else:
                if self._content[0] != region:
                    data = self._file(place.path)[place.start : place.stop]
                    self._content = (region, decompress(place, data))
                message = self._content[1][offset : offset + length]
        except (OSError, ValueError, _DamagedError):
            message = b''
        if len(message) != length:
            raise BagError(f'{place.path} has changed since it was opened: open the bag again')
        return message

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


@contextmanager
def open_store(regions: list[Region]) -> Iterator[MessageStore]:
    """Open a store for the length of a ``with`` block."""
    store = MessageStore(regions)
    try:
        yield store
    finally:
        store.close()
