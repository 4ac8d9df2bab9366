# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Find every whole message of an MCAP file, finished or cut off at any byte, and what is lost.

The mcap library's readers need the end of the file (seeking reader) or take a last message that is
cut short for a whole one (stream reader), and neither looks into a chunk that is cut off. So the
framing (one byte of opcode, eight of length) is followed here, and the library parses the records.

What is read is then compared with what the file says of itself: the message indexes behind each
chunk, the statistics and chunk indexes of the summary, and every checksum that is there. The
summary is never believed instead of the chunks.
"""

from __future__ import annotations

import mmap
import struct
import zlib
from array import array
from collections.abc import Callable
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, ChunkIndex, DataEnd, Footer, Metadata, Schema, Statistics
from mcap.writer import MCAP0_MAGIC as MAGIC

from sosml_friction.arrays import IndexArray
from sosml_friction.bags.chunk_data import DamagedError, Region, decompress
from sosml_friction.exceptions import BagError

_FRAME = struct.Struct('<BQ')
_MESSAGE = struct.Struct('<HIQQ')
_CHUNK = struct.Struct('<QQQII')
_LENGTH = struct.Struct('<Q')
_INDEX = struct.Struct('<HI')
_FOOTER_BYTES = 20
#: A message's frame and what stands before its data.
_HEAD = np.dtype(
    {
        'names': ['opcode', 'length', 'channel', 'log_time_ns'],
        'formats': ['u1', '<u8', '<u2', '<u8'],
        'offsets': [0, 1, 9, 15],
        'itemsize': _FRAME.size + _MESSAGE.size,
    }
)
_NOTHING = np.empty(0, dtype=np.int64)
_COMPRESSIONS = (b'', b'zstd', b'lz4')


@dataclass
class MessageIndex:
    """Where the messages of a file are: parallel arrays, in the order of the file."""

    channel: array[int] = field(default_factory=lambda: array('Q'))
    region: array[int] = field(default_factory=lambda: array('Q'))
    offset: array[int] = field(default_factory=lambda: array('Q'))
    length: array[int] = field(default_factory=lambda: array('Q'))
    log_time_ns: array[int] = field(default_factory=lambda: array('Q'))

    def __len__(self) -> int:
        return len(self.offset)

    @property
    def columns(self) -> tuple[array[int], ...]:
        """Return channel, region, offset, length and log time [ns]."""
        return self.channel, self.region, self.offset, self.length, self.log_time_ns


@dataclass
class McapScan:
    """
    What one file holds.

    ``regions`` is shared by the files of a bag, so that an index says in which file it points.
    ``damage`` says what is wrong with the file, each as what follows its name in a sentence; it is
    empty where the file ends as a closed recording does and has all that it says it has.
    ``read_to`` is the byte up to which it could be followed, ``is_cut`` whether that is before its
    end. ``stated`` is how many messages its statistics count, None where there are none;
    ``beyond`` whether chunks behind a damaged place were searched for.
    """

    path: Path
    regions: list[Region]
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    messages: MessageIndex = field(default_factory=MessageIndex)
    metadata: list[Metadata] = field(default_factory=list)
    damage: list[str] = field(default_factory=list)
    is_cut: bool = False
    read_to: int = 0
    stated: int | None = None
    beyond: bool = False

    def type_name(self, channel: Channel) -> str:
        """Return the ``package/msg/Name`` of a channel, or '' where the file does not say."""
        schema = self.schemas.get(channel.schema_id)
        if schema is None:
            return ''
        package, slash, name = schema.name.partition('/')
        return f'{package}/msg/{name}' if slash and '/' not in name else schema.name


class _CutError(DamagedError):
    """A chunk is cut off by the end of the file; what of it is there agrees with itself."""


def scan(path: Path, regions: list[Region], beyond: bool = False) -> McapScan:
    """
    Return the index of an MCAP file up to its last whole message.

    With ``beyond``, chunks behind a damaged place are searched for as well: those that a checksum
    shows to be whole, each once.

    :raises BagError: if the file cannot be read or is no MCAP file.
    """
    found = McapScan(path, regions, beyond=beyond)
    try:
        with path.open('rb') as stream:
            head = stream.read(len(MAGIC))
            if head != MAGIC[: len(head)]:
                raise BagError(
                    f'{path} is not an MCAP file (its first bytes are not those of one): give a '
                    'bag folder, a .mcap file, or a table, of text as .csv'
                )
            if len(head) < len(MAGIC):
                found.is_cut = True
                found.damage.append('after byte 0')
                return found
            with mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
                _Scanner(found, data).run()
    except OSError as error:
        raise BagError(f'{path} cannot be read: {error.strerror}') from error
    return found


@dataclass
class _Content:
    """The messages of the chunk that was read last: how many were there before it."""

    base: int
    before: int
    indexed: set[int] = field(default_factory=set)


class _Scanner:
    """Follow the records of one file."""

    def __init__(self, found: McapScan, data: mmap.mmap) -> None:
        self.found = found
        self.data = data
        self.size = len(data)
        found.regions.append(Region(found.path, 0, self.size, ''))
        self.region = len(found.regions) - 1
        self.chunks: dict[int, int] = {}
        self.taken: set[tuple[int, ...]] = set()
        self.content: _Content | None = None
        self.in_summary = 0
        self.statistics: Statistics | None = None
        self.chunk_indexes: dict[int, tuple[int, int, int, int]] = {}

    def run(self) -> None:
        """Read all records; where one is cut off or damaged, stop there or search on."""
        found = self.found
        try:
            self._follow()
        except DamagedError as error:
            reason = str(error)
            found.is_cut = True
            found.damage.append(f'after byte {found.read_to}' + (f': {reason}' if reason else ''))
        if found.beyond and found.damage:
            self._search()

    def _follow(self) -> None:
        """Follow the records up to the end; raise at the first that is cut off or damaged."""
        found, data, size = self.found, self.data, self.size
        position = found.read_to = len(MAGIC)
        while position + _FRAME.size <= size:
            opcode, length = _FRAME.unpack_from(data, position)
            start = position + _FRAME.size
            stop = start + length
            content = self.content
            if opcode != Opcode.MESSAGE_INDEX:
                self._close_content()
            if opcode == Opcode.CHUNK:
                if not found.beyond:
                    self._chunk(start, stop)
                elif stop > size or not self._is_known(position):
                    self._chunk_or_nothing(start, stop)
                self._took(position, stop)
            elif stop > size:
                break
            elif opcode == Opcode.FOOTER:
                self._footer(position, start, stop)
                return
            elif self.in_summary:
                self._summary(opcode, start, stop)
            elif opcode == Opcode.DATA_END:
                self._data_end(position, start, stop)
            elif opcode == Opcode.MESSAGE_INDEX:
                self._message_index(start, stop)
            elif (
                opcode == Opcode.MESSAGE
                and self.chunks
                and not self._is_message(content, start, stop)
            ):
                self._note('has a message outside of its chunks that is none')
            else:
                self._take(data, opcode, start, stop, self.region)
            position = found.read_to = stop
        raise DamagedError

    def _chunk(self, start: int, stop: int) -> None:
        """Index the messages of a chunk, of one that is cut off those that are there."""
        if self.in_summary:
            raise DamagedError('a chunk stands in its summary')
        data, size = self.data, self.size
        header = _chunk_header(data, start, size)
        if header is None:
            raise DamagedError
        crc, name, declared, first, length = header
        if first + length > stop:
            raise DamagedError
        whole = first + length <= size
        last = min(first + length, size)
        if name not in _COMPRESSIONS:
            raise DamagedError(
                f'it has chunks compressed with {name.decode("ascii", "replace")[:20]!r}: only '
                'zstd, lz4 and none can be read'
            )
        content: bytes | mmap.mmap = data
        region, begin, there, end = self.region, first, last, first + length
        if name:
            chunk = Region(self.found.path, first, last, name.decode(), declared)
            content = decompress(chunk, data[first:last])
            region, begin, there, end = len(self.found.regions), 0, len(content), declared
        right = there == end and (not crc or zlib.crc32(memoryview(content)[begin:there]) == crc)
        if whole and not right:
            raise DamagedError('the checksum of a chunk does not match')
        if name:
            self.found.regions.append(chunk)
        self.content = _Content(begin, len(self.found.messages))
        listed = self._listed(stop, begin) if whole else _NOTHING
        inner_whole = self._records(content, region, begin, there, end, listed)
        if not whole:
            raise _CutError
        if not inner_whole or stop > size:
            raise DamagedError

    def _listed(self, stop: int, base: int) -> IndexArray:
        """Return where the indexes behind a chunk say that its messages begin, in order."""
        data, size, starts = self.data, self.size, []
        while stop + _FRAME.size + _INDEX.size <= size:
            opcode, length = _FRAME.unpack_from(data, stop)
            first, stop = stop + _FRAME.size + _INDEX.size, stop + _FRAME.size + length
            if opcode != Opcode.MESSAGE_INDEX or stop > size:
                break
            pairs = np.frombuffer(data[first : stop - (stop - first) % 16], dtype='<u8')
            starts.append(pairs[1::2].astype(np.int64) + base)
        return np.sort(np.concatenate(starts)) if starts else _NOTHING

    def _messages(
        self, data: bytes | mmap.mmap, region: int, start: int, stop: int, listed: IndexArray
    ) -> int:
        """
        Take the messages that follow each other from a byte on, and return where they end.

        An index is not trusted: a message begins where it says only if the frame before it ends
        there. From the first that does not, records are read one by one.
        """
        skipped = int(np.searchsorted(listed, start))
        listed = listed[skipped : int(np.searchsorted(listed, stop - _HEAD.itemsize, 'right'))]
        if len(listed) < 2 or listed[0] != start:
            return start
        # A head for every byte, of which those listed are copied.
        heads = np.ndarray(stop - start - _HEAD.itemsize + 1, _HEAD, data, start, (1,))
        head = heads[listed - start]
        length = head['length'].astype(np.int64)
        ends = listed + _FRAME.size + length
        # Not by the end, which a length without measure makes negative.
        fits = (length >= _MESSAGE.size) & (length <= stop - listed - _FRAME.size)
        good = (head['opcode'] == Opcode.MESSAGE) & fits
        good[1:] &= listed[1:] == ends[:-1]
        channel = head['channel']
        good &= np.isin(channel, list(self.found.channels))
        count = len(good) if good.all() else int(np.argmin(good))
        regions = np.full(count, region)
        rows = (
            *(channel, regions, listed + _HEAD.itemsize, length - _MESSAGE.size),
            head['log_time_ns'],
        )
        for column, values in zip(self.found.messages.columns, rows, strict=True):
            column.frombytes(values[:count].astype(np.uint64).tobytes())
        return int(ends[count - 1]) if count else start

    def _records(
        self,
        data: bytes | mmap.mmap,
        region: int,
        start: int,
        stop: int,
        end: int,
        listed: IndexArray,
    ) -> bool:
        """
        Index the records of a chunk's content; return whether the last one is whole.

        In a chunk that is cut off ``stop`` is before the ``end`` that it states. ``listed`` is
        where its index says that messages begin.
        """
        other = True
        while start < stop:
            if other and len(listed):
                start = self._messages(data, region, start, stop, listed)
                if start == stop:
                    break
            if start + _FRAME.size > stop:
                return False
            opcode, length = _FRAME.unpack_from(data, start)
            start += _FRAME.size
            other = opcode in (Opcode.SCHEMA, Opcode.CHANNEL)
            if not (other or opcode == Opcode.MESSAGE) or start + length > end:
                raise DamagedError('a chunk holds what is no message')
            if start + length > stop:
                return False
            self._take(data, opcode, start, start + length, region)
            start += length
        return True

    def _take(
        self, data: bytes | mmap.mmap, opcode: int, start: int, stop: int, region: int
    ) -> None:
        """Take note of one whole record that is not a chunk."""
        found = self.found
        if opcode == Opcode.MESSAGE:
            if stop - start < _MESSAGE.size:
                raise DamagedError
            channel_id, _, log_time_ns, _ = _MESSAGE.unpack_from(data, start)
            if channel_id not in found.channels:
                raise DamagedError('a message is of a channel that was not announced')
            begin = start + _MESSAGE.size
            row = (channel_id, region, begin, stop - begin, log_time_ns)
            for column, value in zip(found.messages.columns, row, strict=True):
                column.append(value)
        elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            if (other := self._announce(opcode, data[start:stop])) is not None:
                kind = 'types' if opcode == Opcode.SCHEMA else 'topics'
                raise DamagedError(f'two {kind} have the number {other.id}')
        elif opcode == Opcode.METADATA:
            found.metadata.append(_parse(Metadata.read, data[start:stop]))
        elif opcode == 0:
            # No record has this opcode; a disk that lost power fills files with zeros.
            raise DamagedError

    def _announce(self, opcode: int, body: bytes) -> Schema | Channel | None:
        """Take note of a type or a topic; return one that contradicts an earlier announcement."""
        if opcode == Opcode.SCHEMA:
            schema: Schema = _parse(Schema.read, body)
            return None if self.found.schemas.setdefault(schema.id, schema) == schema else schema
        channel: Channel = _parse(Channel.read, body)
        return None if self.found.channels.setdefault(channel.id, channel) == channel else channel

    def _is_message(self, content: _Content | None, start: int, stop: int) -> bool:
        """
        Tell whether a record behind a chunk can be the message that it says it is.

        One wrong bit makes a message of an index, of a channel that there is.
        """
        if stop - start < _MESSAGE.size:
            return False
        (channel_id, *_) = _MESSAGE.unpack_from(self.data, start)
        is_index = content is not None and self._is_index(content, start, stop)
        return channel_id in self.found.channels and not is_index

    def _message_index(self, start: int, stop: int) -> None:
        """Compare an index of messages with the chunk before it."""
        content = self.content
        if content is None or stop - start < _INDEX.size:
            self._note('has an index that stands behind no chunk')
            return
        if not self._is_index(content, start, stop):
            self._note('has a chunk whose index does not agree with its messages')
        content.indexed.add(_INDEX.unpack_from(self.data, start)[0])

    def _is_index(self, content: _Content, start: int, stop: int) -> bool:
        """Tell whether a record lists the messages of one channel in a chunk as they are."""
        channel_id, length = _INDEX.unpack_from(self.data, start)
        start += _INDEX.size
        index, before = self.found.messages, content.before
        own = np.array(index.channel[before:]) == channel_id
        times = np.array(index.log_time_ns[before:])[own]
        # An index points to the frame of a message, and from where its chunk begins.
        offsets = np.array(index.offset[before:])[own]
        offsets -= np.uint64(content.base + _FRAME.size + _MESSAGE.size)
        if not length == stop - start == 16 * len(times):
            return False
        pairs = np.frombuffer(self.data[start:stop], dtype='<u8').reshape(-1, 2)
        pairs = pairs[np.argsort(pairs[:, 1], kind='stable')]
        return bool((pairs[:, 0] == times).all() and (pairs[:, 1] == offsets).all())

    def _note(self, damage: str) -> None:
        """Take note of damage that leaves the rest readable."""
        if damage not in self.found.damage:
            self.found.damage.append(damage)

    def _close_content(self) -> None:
        """See that the indexes behind a chunk, where there are any, are those of all channels."""
        content, self.content = self.content, None
        if content is not None and content.indexed:
            held = set(self.found.messages.channel[content.before :])
            if held - content.indexed:
                self._note('lacks the index of a chunk')

    def _data_end(self, position: int, start: int, stop: int) -> None:
        crc = _parse(DataEnd.read, self.data[start:stop]).data_section_crc
        if crc and zlib.crc32(memoryview(self.data)[:position]) != crc:
            self.found.damage.append('does not have the checksum that it was closed with')
        self.in_summary = stop

    def _summary(self, opcode: int, start: int, stop: int) -> None:
        found, body = self.found, self.data[start:stop]
        if opcode == Opcode.STATISTICS:
            self.statistics = _parse(Statistics.read, body)
            found.stated = self.statistics.message_count
        elif opcode == Opcode.CHUNK_INDEX:
            index = _parse(ChunkIndex.read, body)
            self.chunk_indexes[index.chunk_start_offset] = (
                index.chunk_length,
                index.message_start_time,
                index.message_end_time,
                index.uncompressed_size,
            )
        elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            other = self._announce(opcode, body)
            if isinstance(other, Schema):
                found.damage.append(f'has another type {other.name} in its summary')
            elif other is not None:
                found.damage.append(f'has another topic {other.topic} in its summary')

    def _footer(self, position: int, start: int, stop: int) -> None:
        """Compare what the file says of itself with what was read of it."""
        found, data = self.found, self.data
        if not self.in_summary or stop - start != _FOOTER_BYTES:
            raise DamagedError
        footer = _parse(Footer.read, data[start:stop])
        if data[stop : stop + len(MAGIC)] != MAGIC:
            raise DamagedError
        found.read_to = stop
        extra = self.size - stop - len(MAGIC)
        if extra:
            found.damage.append(f'has {extra} bytes behind its end')
        begins = 0 if position == self.in_summary else self.in_summary
        summary = zlib.crc32(memoryview(data)[self.in_summary : stop - 4])
        if footer.summary_start != begins or footer.summary_crc not in (0, summary):
            found.damage.append('has a damaged summary')
        there = {
            start: (length, *_CHUNK.unpack_from(data, start + _FRAME.size)[:3])
            for start, length in self.chunks.items()
        }
        if self.chunk_indexes and self.chunk_indexes != there:
            found.damage.append(
                f'lists {len(self.chunk_indexes)} chunks that are not those that are there, '
                f'{len(self.chunks)}'
            )
        self._compare_statistics()

    def _compare_statistics(self) -> None:
        found, stated = self.found, self.statistics
        if stated is None:
            return
        times = found.messages.log_time_ns
        counts = enumerate(np.bincount(np.array(found.messages.channel, dtype=np.int64)).tolist())
        own = {key: n for key, n in stated.channel_message_counts.items() if n}
        held = {key: n for key, n in counts if n}
        if stated.message_count != len(times) or (own and own != held):
            found.damage.append(
                f'counts {stated.message_count} messages where {len(times)} are there'
            )
        elif stated.chunk_count != len(self.chunks):
            found.damage.append(
                f'counts {stated.chunk_count} chunks where {len(self.chunks)} are there'
            )
        elif times and (min(times), max(times)) != (
            stated.message_start_time,
            stated.message_end_time,
        ):
            found.damage.append('states other times than its messages have')

    def _search(self) -> None:
        """Read the chunks behind a damaged place that a checksum shows to be whole, each once."""
        self._announced()
        data, size = self.data, self.size
        for position, (length, *_) in sorted(self.chunk_indexes.items()):
            if position not in self.chunks and position + length <= size:
                self._try(position, position + length)
        position = self.found.read_to if self.found.is_cut else size
        while (position := data.find(bytes([Opcode.CHUNK]), position)) >= 0:
            if position + _FRAME.size > size:
                return
            stop = position + _FRAME.size + _FRAME.unpack_from(data, position)[1]
            # One that the summary lists may have another length in its damaged frame.
            if position in self.chunks:
                position += self.chunks[position]
            else:
                position = stop if self._try(position, stop) else position + 1

    def _try(self, position: int, stop: int) -> bool:
        """Take the chunk between two bytes, if one is there; return whether it is."""
        start, size = position + _FRAME.size, self.size
        header = _chunk_header(self.data, start, size) if start < stop <= size else None
        # By its lengths alone nearly anything else is told from a chunk.
        if header is None or not header[0] or header[3] + header[4] != stop:
            return False
        if self._is_known(position):
            return True
        try:
            self._chunk_or_nothing(start, stop)
        except DamagedError:
            return False
        self._took(position, stop)
        return True

    def _is_known(self, position: int) -> bool:
        """Tell whether a chunk like this one was taken, from its checksum, size and first time."""
        if position + _FRAME.size + _CHUNK.size > self.size:
            return False
        like = _CHUNK.unpack_from(self.data, position + _FRAME.size)
        return like[3] != 0 and like in self.taken

    def _took(self, position: int, stop: int) -> None:
        self.chunks[position] = stop - position
        if self.found.beyond:
            self.taken.add(_CHUNK.unpack_from(self.data, position + _FRAME.size))

    def _chunk_or_nothing(self, start: int, stop: int) -> None:
        """Take a chunk, or drop what of it was taken before it proved to be none."""
        kept = len(self.found.messages)
        try:
            self._chunk(start, stop)
        except _CutError:
            raise
        except DamagedError:
            for column in self.found.messages.columns:
                del column[kept:]
            raise

    def _announced(self) -> None:
        """Take the topics that the summary names, where its checksum is right."""
        data = self.data
        self.in_summary = 0
        footer = self.size - len(MAGIC) - _FOOTER_BYTES
        if footer < len(MAGIC) or data[self.size - len(MAGIC) :] != MAGIC:
            return
        try:
            stated = _parse(Footer.read, data[footer : footer + _FOOTER_BYTES])
            start, stop = stated.summary_start, footer - _FRAME.size
            if not len(MAGIC) <= start < stop or not stated.summary_crc:
                return
            whole = memoryview(data)[start : footer + _FOOTER_BYTES - 4]
            if zlib.crc32(whole) != stated.summary_crc:
                return
            while start + _FRAME.size <= stop:
                opcode, length = _FRAME.unpack_from(data, start)
                start += _FRAME.size
                if start + length <= stop:
                    self._summary(opcode, start, start + length)
                start += length
        except DamagedError:
            return


def _chunk_header(
    data: mmap.mmap, start: int, size: int
) -> tuple[int, bytes, int, int, int] | None:
    """Return checksum, compression, size, first byte and length of a chunk's data, None if cut."""
    if start + _CHUNK.size > size:
        return None
    _, _, declared, crc, name_length = _CHUNK.unpack_from(data, start)
    start += _CHUNK.size
    name = data[start : start + min(name_length, 64)]
    start += name_length
    if start + _LENGTH.size > size:
        return None
    (length,) = _LENGTH.unpack_from(data, start)
    return crc, name, declared, start + _LENGTH.size, length


def _parse(read: Callable[[ReadDataStream], Any], body: bytes) -> Any:
    try:
        return read(ReadDataStream(BytesIO(body)))
    except (McapError, struct.error, ValueError, OverflowError, MemoryError) as error:
        raise DamagedError from error
