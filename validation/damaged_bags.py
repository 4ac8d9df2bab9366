# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Bags with one kind of damage each, for the reliability run."""

from __future__ import annotations

import shutil
import struct
from collections.abc import Callable
from pathlib import Path

import lz4.frame
import numpy as np
import zstandard
from mcap.opcode import Opcode
from mcap.writer import CompressionType, Writer

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.message_definitions import message_definition
from sosml_friction.bags.recorder import BagRecorder
from sosml_friction.bags.repair import repair_bag
from sosml_friction.bags.serialization import serialize_joint_state
from sosml_friction.exceptions import BagError
from validation.silent import SilentError

Rng = np.random.Generator
#: Share of the cases in which the bag is repaired as well.
_REPAIRED = 0.2
_FRAME = struct.Struct('<BQ')
_JOINT_STATE = 'sensor_msgs/msg/JointState'
_TAGS = {'worn': 'yes', 'controller.shoulder': '{"kind": "cascade", "kp": 12.5, "kv": 3.0}'}
#: As the recorder writes, with and without metadata.yaml; and as rosbag2 does, which gives its
#: chunks and its summary a checksum, and nothing else one.
LAYOUTS = ('own', 'own file', 'plain', 'zstd', 'lz4')
Message = tuple[str, int, bytes]
Content = tuple[list[Message], dict[str, str]]


def messages(rng: Rng) -> list[Message]:
    """Return two joints' motion at 100 Hz, received a little late, and one text."""
    begins = 10**18 + int(rng.integers(10**15))
    found: list[Message] = [('/robot_description', begins, b'\0\1\0\0' + rng.bytes(300))]
    for k in range(150):
        t_ns = begins + k * 10_000_000
        values = [rng.normal(size=2).tolist() for _ in range(3)]
        cdr = serialize_joint_state(t_ns, ('shoulder', 'elbow'), *values)
        found.append(
            (f'/{"ab"[k % 2]}/joint_states', t_ns + int(rng.integers(1, 10**6)), bytes(cdr))
        )
    return found


def write(layout: str, folder: Path, content: list[Message]) -> Path:
    """Write the messages as a bag of one layout."""
    kinds = {topic: _JOINT_STATE for topic, _, _ in content}
    kinds['/robot_description'] = 'std_msgs/msg/String'
    if layout.startswith('own'):
        with BagRecorder(folder, _TAGS) as recorder:
            for topic, t_ns, cdr in content:
                recorder.add_topic(topic, kinds[topic])
                recorder.write(topic, cdr, t_ns)
        return folder
    folder.mkdir()
    compression = {'plain': 'NONE', 'zstd': 'ZSTD', 'lz4': 'LZ4'}[layout]
    with (folder / f'{folder.name}_0.mcap').open('wb') as stream:
        writer = Writer(stream, chunk_size=2000, compression=CompressionType[compression])
        writer.start(profile='ros2', library='libmcap 1.1.0')
        channels: dict[str, int] = {}
        for topic, t_ns, cdr in content:
            if topic not in channels:
                definition = message_definition(kinds[topic]).encode()
                schema = writer.register_schema(kinds[topic], 'ros2msg', definition)
                channels[topic] = writer.register_channel(topic, 'cdr', schema, {})
            writer.add_message(channels[topic], t_ns, cdr, t_ns)
        writer.finish()
    return folder


def read(path: Path) -> tuple[Content, str]:
    """Return what is in a bag, and what it says is wrong with it."""
    bag = Bag.open(path)
    return (list(bag.timeline()), bag.tags), bag.recovery


def records(data: bytes) -> list[tuple[int, int, int]]:
    """Return opcode, first byte and end of each record of a file."""
    found, position = [], 8
    while position + _FRAME.size <= len(data) - 8:
        opcode, length = _FRAME.unpack_from(data, position)
        stop = position + _FRAME.size + length
        found.append((opcode, position, stop))
        position = stop
    return found


def pieces(data: bytes, rng: Rng) -> list[tuple[int, int]]:
    """Return first byte and end of each chunk; half the time with the indexes behind it."""
    with_indexes, found = rng.random() < 0.5, list[tuple[int, int]]()
    for opcode, start, stop in records(data):
        if opcode == Opcode.CHUNK:
            found.append((start, stop))
        elif opcode == Opcode.MESSAGE_INDEX and with_indexes:
            found[-1] = (found[-1][0], stop)
    return found


def bits(data: bytes, _: bytes, rng: Rng) -> bytes:
    """Flip one to eight bits."""
    changed = bytearray(data)
    for place in rng.integers(0, len(data), int(rng.integers(1, 9))):
        changed[place] ^= 1 << int(rng.integers(8))
    return bytes(changed)


def opcodes(data: bytes, _: bytes, rng: Rng) -> bytes:
    """Flip one bit of the frame of a record."""
    changed = bytearray(data)
    _, start, _ = records(data)[rng.integers(len(records(data)))]
    place = start if rng.random() < 0.5 else start + int(rng.integers(_FRAME.size))
    changed[place] ^= 1 << int(rng.integers(8))
    return bytes(changed)


def cut(data: bytes, _: bytes, rng: Rng) -> bytes:
    """Cut the end off."""
    return data[: rng.integers(len(data))]


def hole(data: bytes, _: bytes, rng: Rng) -> bytes:
    """Take a stretch out, or fill it with zeros."""
    first, last = sorted(rng.integers(0, len(data), 2).tolist())
    return data[:first] + bytes(last - first) * int(rng.random() < 0.5) + data[last:]


def splice(data: bytes, other: bytes, rng: Rng) -> bytes:
    """Put the end of another bag behind the beginning of this, half the time between records."""
    if rng.random() < 0.5:
        ends = [[stop for _, _, stop in records(one)] for one in (data, other)]
        first, last = (int(rng.choice(one)) for one in ends)
    else:
        first, last = int(rng.integers(len(data))), int(rng.integers(len(other)))
    return data[:first] + other[last:]


def drop(data: bytes, _: bytes, rng: Rng) -> bytes:
    """Take one to three chunks out."""
    chunks = pieces(data, rng)
    chosen = sorted(rng.permutation(len(chunks))[: rng.integers(1, 4)], reverse=True)
    for k in chosen:
        data = data[: chunks[k][0]] + data[chunks[k][1] :]
    return data


def double(data: bytes, _: bytes, rng: Rng) -> bytes:
    """Put a chunk in once more, somewhere behind a chunk."""
    chunks = pieces(data, rng)
    first, last = chunks[rng.integers(len(chunks))]
    place = chunks[rng.integers(len(chunks))][1]
    return data[:place] + data[first:last] + data[place:]


def reorder(data: bytes, _: bytes, rng: Rng) -> bytes:
    """Let two chunks change places."""
    chunks = pieces(data, rng)
    if len(chunks) < 2:
        return double(data, data, rng)
    (a, b), (c, d) = (chunks[k] for k in sorted(rng.permutation(len(chunks))[:2]))
    return data[:a] + data[c:d] + data[b:c] + data[a:b] + data[d:]


def bomb(data: bytes, _: bytes, rng: Rng) -> bytes:
    """Put in a chunk that decompresses to much more than it takes, and may lie about it."""
    size = int(2 ** rng.uniform(24, 28))
    kind = 'zstd' if rng.random() < 0.5 else 'lz4'
    pack = zstandard.compress if kind == 'zstd' else lz4.frame.compress
    packed = pack(bytes(size))
    stated = int(rng.choice([size, len(packed), 0, 2**40, 2**63]))
    body = struct.pack('<QQQI', 1, 2, stated, 0) + struct.pack('<I', len(kind)) + kind.encode()
    body += struct.pack('<Q', len(packed)) + packed
    place = pieces(data, rng)[0][1]
    return data[:place] + _FRAME.pack(Opcode.CHUNK, len(body)) + body + data[place:]


BAG_DAMAGES: dict[str, Callable[[bytes, bytes, Rng], bytes]] = {
    'bits flipped': bits,
    'frames of records': opcodes,
    'end cut off': cut,
    'stretch lost or zero': hole,
    'two bags spliced': splice,
    'chunks dropped': drop,
    'chunks doubled': double,
    'chunks reordered': reorder,
    'bombs': bomb,
    'metadata.yaml': bits,
}


class DamagedBags:
    """Damage one bag of each layout in one way, again and again; a call is one case."""

    def __init__(self, kind: str, place: Path) -> None:
        rng = np.random.default_rng(0)
        self.kind, self.place = kind, place
        self.bags: dict[str, tuple[Path, bytes, bytes, Content]] = {}
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir()
        for layout in ('own',) if kind == 'metadata.yaml' else LAYOUTS:
            folder, other = (
                write(layout, place / f'{name}_{layout.replace(" ", "_")}', messages(rng))
                for name in ('bag', 'other')
            )
            path = next(folder.glob('*.mcap'))
            if layout == 'own file':
                (folder / 'metadata.yaml').unlink()
            content, wrong = read(folder)
            if wrong:
                raise RuntimeError(wrong)
            second = next(other.glob('*.mcap')).read_bytes()
            self.bags[layout] = (path, path.read_bytes(), second, content)

    def __call__(self, rng: Rng) -> bool:
        """Run a case; return whether the bag said that it is damaged."""
        path, data, other, whole = self.bags[str(rng.choice(list(self.bags)))]
        damage = BAG_DAMAGES[self.kind]
        if self.kind == 'metadata.yaml':
            beside = path.parent / 'metadata.yaml'
            kept = beside.read_bytes()
            beside.write_bytes(damage(kept, kept, rng))
            try:
                return self._judge(path.parent, whole, rng)
            finally:
                beside.write_bytes(kept)
        path.write_bytes(damage(data, other, rng))
        try:
            return self._judge(path.parent, whole, rng)
        finally:
            path.write_bytes(data)

    def _judge(self, path: Path, whole: Content, rng: Rng) -> bool:
        if self.kind != 'two bags spliced' and rng.random() < _REPAIRED:
            self._repair(path, whole)
        content, wrong = read(path)
        if content != whole and not wrong:
            lost = len(whole[0]) - len(content[0])
            raise SilentError(
                f'{path.name}: {lost} messages less, or others, or other tags, and not a word'
            )
        return bool(wrong)

    def _repair(self, path: Path, whole: Content) -> None:
        """See that repair makes a whole bag of messages that were recorded, each once."""
        saved = self.place / 'saved'
        shutil.rmtree(saved, ignore_errors=True)
        try:
            repair_bag(path, saved)
        except BagError:
            return
        if saved.exists():
            (found, _), wrong = read(saved)
            if wrong or not set(found) <= set(whole[0]) or len(set(found)) != len(found):
                raise SilentError(f'repair of {path.name} saves what was not recorded')
