# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""JointState messages as arrays: all at once as one by one, whatever is between them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.chunk_data import Region
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.bags.joint_state_layout import FIELDS, JointStateLayout
from sosml_friction.bags.joint_states import read_joint_states
from sosml_friction.bags.message_definitions import JOINT_STATE
from sosml_friction.bags.message_store import MessageStore
from sosml_friction.bags.serialization import (
    deserialize,
    message_class,
    serialize,
    serialize_joint_state,
)
from sosml_friction.exceptions import BagError

NUMBERS = st.floats(width=64)
NAMES = st.lists(st.sampled_from(['a', 'elbow', 'gelenk_ä', '', 'wrist_3']), max_size=3)


@st.composite
def messages(draw):
    """Return one message, as rclpy packs it or as the recorder does, or half of one."""
    names = draw(NAMES)
    counts = [draw(st.sampled_from([0, len(names), len(names) + 1])) for _ in FIELDS]
    numbers = [draw(st.lists(NUMBERS, min_size=n, max_size=n)) for n in counts]
    seconds, rest = draw(st.integers(0, 2**31 - 1)), draw(st.integers(0, 999_999_999))
    if draw(st.booleans()):
        cdr = serialize_joint_state(seconds * 1_000_000_000 + rest, names, *numbers)
    else:
        message = message_class(JOINT_STATE)()
        message.header.stamp.sec, message.header.stamp.nanosec = seconds, rest
        message.header.frame_id = draw(st.sampled_from(['', 'base', 'ü']))
        message.name = names
        message.position, message.velocity, message.effort = numbers
        cdr = serialize(message)
    return cdr[: draw(st.integers(4, len(cdr)))] if draw(st.integers(0, 9)) == 0 else cdr


#: Runs of a few messages, over and over: what a topic carries, and where it changes.
STREAMS = st.lists(st.tuples(messages(), st.integers(1, 4)), min_size=1, max_size=8)


def read(folder, stream, fields=FIELDS):
    """Return what is read of messages in a file whose second half is another region."""
    path = folder / 'messages'
    path.write_bytes(b'x' + b''.join(stream))
    length = np.array([len(cdr) for cdr in stream])
    offset = 1 + np.concatenate([[0], np.cumsum(length)[:-1]])
    region = (np.arange(len(stream)) > len(stream) // 2).astype(np.int64)
    whole = Region(path, 0, path.stat().st_size, '')
    store = MessageStore([whole, whole])
    try:
        return read_joint_states(
            store, (region, offset, length), fields, lambda _, cdr: deserialize(cdr, JOINT_STATE)
        )
    finally:
        store.close()


@settings(max_examples=120)
@given(stream=STREAMS)
def test_messages_of_any_layout_are_read_as_rclpy_reads_them(tmp_path_factory, stream):
    folder = tmp_path_factory.mktemp('any')
    stream = [cdr for cdr, times in stream for _ in range(times)]
    fast = read(folder, stream)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(JointStateLayout, 'of', lambda _: None)
        slow = read(folder, stream)
    assert (fast.problem is None) == (slow.problem is None)
    if slow.problem is not None:
        assert fast.problem[0] == slow.problem[0]
        assert str(fast.problem[1]) == str(slow.problem[1])
    np.testing.assert_array_equal(fast.t_ns, slow.t_ns)
    assert fast.names == slow.names
    assert {kind: fast.first(kind) for kind in fast.blocks} == {
        kind: slow.first(kind) for kind in slow.blocks
    }
    kinds = slow.blocks
    if all(len(set(k)) == len(k) and set(n) <= {0, len(k)} for k, n in kinds):
        for name in FIELDS:
            ours, theirs = fast.table(name), slow.table(name)
            np.testing.assert_array_equal(ours.view(np.int64), theirs.view(np.int64))


def test_what_every_publisher_sends_needs_no_rclpy(tmp_path):
    message = message_class(JOINT_STATE)()
    message.name, message.position = ['gelenk_ä', 'b'], [1.0, 2.0]
    message.header.frame_id = 'base'
    packed = serialize(message), serialize_joint_state(5, ['a'], [1.0], [2.0], [3.0])
    for cdr in packed:
        layout = JointStateLayout.of(cdr)
        assert layout is not None
        rows = np.frombuffer(cdr, dtype=np.uint8)[np.newaxis]
        assert layout.shared_by(rows).all()
    assert layout.values(rows, 1).tolist() == [[2.0]]


@pytest.mark.parametrize('change', [0, 1, 12, 20])
def test_a_message_that_is_laid_out_unusually_is_left_to_rclpy(change):
    """Of another endianness or encoding, of a text that does not end, of more names than bytes."""
    cdr = bytearray(serialize_joint_state(5, ['a'], [1.0]))
    assert JointStateLayout.of(bytes(cdr)) is not None
    cdr[change] ^= 0x7F
    assert JointStateLayout.of(bytes(cdr)) is None


def test_of_two_wrong_messages_the_first_is_named(tmp_path):
    good = serialize_joint_state(7, ['a', 'b'], [1.0, 2.0])
    twice = serialize_joint_state(8, ['a', 'a'], [1.0, 2.0])
    stream = [good, good[:30], good, twice]
    found = read(tmp_path, stream)
    assert found.problem is not None
    assert found.problem[0] == 1
    assert found.first((('a', 'a'), (2, 0, 0))) == 3


def test_only_what_is_wanted_is_kept(tmp_path):
    stream = [serialize_joint_state(t, ['a'], [1.0 * t], [2.0], [3.0]) for t in range(5)]
    found = read(tmp_path, stream, ('position',))
    assert all(
        set(values) == {'position'} for blocks in found.blocks.values() for _, values in blocks
    )
    np.testing.assert_array_equal(found.table('position')[:, 0], np.arange(5.0))


def test_a_file_that_was_shortened_meanwhile_is_told(tmp_path):
    count = 200
    log = JointLog(('a',), np.arange(count) * 1_000_000 + 1, *np.ones((3, count, 1)))
    folder = write_joint_log(log, tmp_path / 'bag')
    bag = Bag.open(folder)
    (file,) = folder.glob('*.mcap')
    file.write_bytes(file.read_bytes()[:5000])
    with pytest.raises(BagError, match='has changed since it was opened'):
        bag.joint_log()
