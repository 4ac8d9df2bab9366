# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Reading up to the last whole message of a file cut or damaged anywhere."""

import os
import struct
from contextlib import closing

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.writer import CompressionType, Writer

from sosml_friction.bags import chunk_data, mcap_scan
from sosml_friction.bags.bag import Bag
from sosml_friction.bags.mcap_scan import scan
from sosml_friction.bags.message_store import MessageStore
from sosml_friction.bags.recorder import BagRecorder
from sosml_friction.exceptions import BagError

JOINT_STATE = 'sensor_msgs/msg/JointState'
MESSAGES = 150

LAYOUTS = {
    'none': {'compression': CompressionType.NONE, 'chunk_size': 4096},
    'zstd': {'compression': CompressionType.ZSTD, 'chunk_size': 4096},
    'lz4': {'compression': CompressionType.LZ4, 'chunk_size': 4096},
    'one zstd chunk': {'compression': CompressionType.ZSTD},
    'fastwrite': {'use_chunking': False},
    'no checksums': {'compression': CompressionType.NONE, 'enable_crcs': False},
}


def payload(k):
    """Return bytes found nowhere else in the file, and not compressible to nothing."""
    return b'<%06d>' % k + os.urandom(64) + b'</%06d>' % k


ENTRIES = [
    (f'/{"ab"[k % 2]}/joint_states', JOINT_STATE, payload(k), 10**9 + k * 20_000_000)
    for k in range(MESSAGES)
]
EXPECTED = [(topic, log_time_ns, cdr) for topic, _, cdr, log_time_ns in ENTRIES]


def opened(path):
    """Return the bag at a path, or None and why it is none; let any other error through."""
    try:
        return Bag.open(path), ''
    except BagError as error:
        return None, str(error)


@pytest.fixture(scope='module', params=['own', *LAYOUTS])
def whole(request, tmp_path_factory, foreign_mcap):
    """Return the bytes of a whole recording, and whether its messages stand in it as they are."""
    folder = tmp_path_factory.mktemp('whole')
    if request.param == 'own':
        with BagRecorder(folder / 'bag') as recorder:
            for topic, kind, cdr, log_time_ns in ENTRIES:
                recorder.add_topic(topic, kind)
                recorder.write(topic, cdr, log_time_ns)
        return (folder / 'bag' / 'bag_0.mcap').read_bytes(), True
    options = LAYOUTS[request.param]
    path = foreign_mcap(folder / 'x.mcap', ENTRIES, **options)
    plain = options.get('compression', CompressionType.NONE) == CompressionType.NONE
    return path.read_bytes(), plain or not options.get('use_chunking', True)


@pytest.fixture(scope='module')
def place(tmp_path_factory):
    return tmp_path_factory.mktemp('cut') / 'cut.mcap'


def test_a_whole_file_is_read_whole(whole, place):
    data, _ = whole
    place.write_bytes(data)
    bag = Bag.open(place)
    assert not bag.recovered
    assert bag.recovery == ''
    assert list(bag.timeline()) == EXPECTED


@given(data=st.data())
@settings(max_examples=80, deadline=None)
def test_a_file_cut_at_any_byte_is_read_to_its_last_whole_message(whole, place, data):
    content, plain = whole
    ends = [content.find(cdr) + len(cdr) for _, _, cdr in EXPECTED]
    # Anywhere, and where it matters most: around the last byte of a message.
    edges = [end + i for end in ends if plain for i in (-1, 0, 1)] or [0]
    cut = data.draw(st.integers(0, len(content) - 1) | st.sampled_from(edges))
    place.write_bytes(content[:cut])
    expected = sum(end <= cut for end in ends) if plain else None
    bag, reason = opened(place)
    if bag is None:
        assert reason.startswith(f'{place} holds no whole message')
        assert not expected
        return
    found = list(bag.timeline())
    assert found == EXPECTED[: len(found)]
    assert bag.recovered
    assert bag.messages_read == len(found)
    assert f'{len(found)} messages, up to the last whole one, were read' in bag.recovery
    if plain:
        assert len(found) == expected


@pytest.mark.parametrize('name', ['zstd', 'lz4', 'one zstd chunk'])
def test_a_compressed_chunk_that_is_cut_gives_what_it_has(name, tmp_path, foreign_mcap):
    # Large enough for several compressed blocks: only whole blocks can be decompressed.
    entries = [('/joint_states', JOINT_STATE, os.urandom(4000), 10**9 + k) for k in range(200)]
    options = {**LAYOUTS[name], 'chunk_size': 10**7}
    path = foreign_mcap(tmp_path / 'x.mcap', entries, **options)
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    bag = Bag.open(path)
    assert 20 < bag.messages_read < 110
    assert [cdr for _, cdr in bag.messages('/joint_states')] == [
        cdr for _, _, cdr, _ in entries[: bag.messages_read]
    ]


@given(data=st.data())
@settings(max_examples=80, deadline=None)
def test_bytes_that_are_wrong_never_raise_anything_but_a_bag_error(whole, place, data):
    content = bytearray(whole[0])
    for _ in range(data.draw(st.integers(1, 6))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    place.write_bytes(content)
    bag, reason = opened(place)
    with pytest.MonkeyPatch.context() as patch:
        # Record by record, without the help of an index, it is the same.
        patch.setattr(mcap_scan._Scanner, '_listed', lambda *_: np.empty(0, dtype=np.int64))
        plain, same = opened(place)
    assert reason == same
    if bag is None:
        assert str(place) in reason
    else:
        assert len(list(bag.timeline())) == bag.messages_read
        assert list(bag.timeline()) == list(plain.timeline())
        assert bag.recovery == plain.recovery


@pytest.mark.parametrize('length', [0, 21, 2**40, 2**62, 2**63 - 32, 2**63 - 1, 2**64 - 1])
def test_a_message_of_a_length_without_measure_is_where_reading_ends(place, foreign_mcap, length):
    """In a file without checksums, and in each of its first two chunks' messages."""
    whole = foreign_mcap(place.with_name('plain.mcap'), ENTRIES, **LAYOUTS['no checksums'])
    content = whole.read_bytes()
    for k in range(60):
        start = content.find(ENTRIES[k][2]) - 30
        place.write_bytes(content[:start] + struct.pack('<Q', length) + content[start + 8 :])
        bag, _ = opened(place)
        assert (0 if bag is None else bag.messages_read) == k


def test_zeros_after_a_power_loss_end_the_recording(whole, place):
    content, plain = whole
    half = len(content) // 2
    place.write_bytes(content[:half] + bytes(len(content) - half))
    bag, reason = opened(place)
    if bag is None:
        assert not plain
        assert 'no whole message' in reason
        return
    assert bag.recovered
    # Without a checksum nothing tells that the message in which the zeros begin is wrong.
    good = [message for message in bag.timeline() if message in EXPECTED]
    assert good == EXPECTED[: len(good)]
    assert bag.messages_read - len(good) <= 1


def test_a_checksum_that_does_not_match_ends_the_recording(tmp_path, foreign_mcap):
    path = foreign_mcap(tmp_path / 'x.mcap', ENTRIES, **LAYOUTS['none'])
    content = bytearray(path.read_bytes())
    content[content.find(EXPECTED[100][2]) + 20] ^= 1
    path.write_bytes(content)
    bag = Bag.open(path)
    assert bag.recovered
    assert 50 < bag.messages_read <= 100
    assert list(bag.timeline()) == EXPECTED[: bag.messages_read]


def test_an_unknown_compression_is_named(tmp_path, foreign_mcap):
    path = foreign_mcap(tmp_path / 'x.mcap', ENTRIES)
    path.write_bytes(path.read_bytes().replace(b'\x04\x00\x00\x00zstd', b'\x04\x00\x00\x00zpaq'))
    with pytest.raises(BagError, match="chunks compressed with 'zpaq': only zstd, lz4 and none"):
        Bag.open(path)


@pytest.mark.parametrize('name', ['none', 'zstd'])
def test_a_file_that_changes_after_it_was_opened_is_noticed(name, tmp_path, foreign_mcap):
    path = foreign_mcap(tmp_path / 'x.mcap', ENTRIES, **LAYOUTS[name])
    regions = []
    index = scan(path, regions).messages
    path.write_bytes(path.read_bytes()[:500])
    with (
        closing(MessageStore(regions)) as store,
        pytest.raises(BagError, match='has changed since it was'),
    ):
        store.fetch(index.region[-1], index.offset[-1], index.length[-1])


def test_an_old_two_part_type_name_is_understood(tmp_path, foreign_mcap):
    path = foreign_mcap(tmp_path / 'x.mcap', [('/a', 'sensor_msgs/JointState', b'', 5)])
    assert Bag.open(path).topics == {'/a': (JOINT_STATE, 1)}


def write_messages_behind_chunks(path, topics):
    """Write messages into chunks of 10, but every 11th behind its chunk, as the format allows."""
    with path.open('wb') as stream:
        writer = Writer(stream)
        writer.start('ros2', 'test')
        schema = writer.register_schema(JOINT_STATE, 'ros2msg', b'x')
        channels = {topic: writer.register_channel(topic, 'cdr', schema) for topic in topics}
        for k, (topic, log_time_ns, cdr) in enumerate(EXPECTED):
            builder = writer._Writer__chunk_builder
            if k % 11 == 10:
                writer._Writer__finalize_chunk()
                writer._Writer__chunk_builder = None
            writer.add_message(channels.get(topic, 1), log_time_ns, cdr, log_time_ns)
            writer._Writer__chunk_builder = builder
        writer.finish()


def test_messages_outside_of_chunks_are_read_where_the_file_counts_them(tmp_path):
    path = tmp_path / 'x.mcap'
    write_messages_behind_chunks(path, ['/a/joint_states', '/b/joint_states'])
    bag = Bag.open(path)
    assert bag.recovery == ''
    assert list(bag.timeline()) == EXPECTED
    # One that is gone is missed by the statistics, whatever stands behind it.
    content = path.read_bytes()
    end = content.find(EXPECTED[10][2]) + len(EXPECTED[10][2])
    length = 22 + len(EXPECTED[10][2])
    path.write_bytes(content[: end - length - 9] + content[end:])
    bag = Bag.open(path)
    assert bag.messages_read == MESSAGES - 1
    assert bag.recovered


def test_an_index_that_one_bit_makes_a_message_is_none(tmp_path):
    path = tmp_path / 'x.mcap'
    write_messages_behind_chunks(path, ['/joint_states'])
    content = bytearray(path.read_bytes())
    # Opcode 7, length, channel 1, ten entries of 16 bytes; as a message it is of channel 1.
    frame = struct.pack('<BQHI', 7, 6 + 160, 1, 160)
    places = [at for at in range(len(content)) if content.startswith(frame, at)]
    assert len(places) == MESSAGES // 11
    content[places[2]] = 5
    path.write_bytes(content[: places[5]])
    found = scan(path, [])
    assert len(found.messages) == 65
    assert found.damage[0] == 'has a message outside of its chunks that is none'


@pytest.mark.parametrize('compression', [CompressionType.ZSTD, CompressionType.LZ4])
def test_a_chunk_larger_than_any_is_read_unless_it_packs_as_no_recording_does(
    tmp_path, foreign_mcap, monkeypatch, compression
):
    monkeypatch.setattr(chunk_data, 'LARGEST_CHUNK', 4096)
    path = foreign_mcap(tmp_path / 'x.mcap', ENTRIES, compression=compression)
    bag = Bag.open(path)
    assert bag.recovery == ''
    assert list(bag.timeline()) == EXPECTED
    # What of it was cut off says nothing against the rest.
    noise = [('/a', JOINT_STATE, os.urandom(70_000), 10**9 + k) for k in range(80)]
    whole = foreign_mcap(tmp_path / 'y.mcap', noise, compression, 10**8).read_bytes()
    path.write_bytes(whole[: len(whole) // 60])
    assert Bag.open(path).messages_read == 1
    foreign_mcap(path, [('/a', JOINT_STATE, bytes(10**6), 10**9)], compression=compression)
    with pytest.raises(
        BagError, match=r'a chunk of \d+ bytes holds more than the \d+ that can be'
    ):
        Bag.open(path)
