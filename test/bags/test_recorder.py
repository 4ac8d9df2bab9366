# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""BagRecorder: rosbag2 format, and what a crash may cost."""

import errno
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader

import sosml_friction
from sosml_friction.bags import recorder as recorder_module
from sosml_friction.bags.bag import Bag
from sosml_friction.bags.recorder import BagRecorder, offered_qos
from sosml_friction.exceptions import BagError

JOINT_STATE = 'sensor_msgs/msg/JointState'
STRING = 'std_msgs/msg/String'
SECOND = 1_000_000_000

CHILD = """
import sys
from sosml_friction.bags.recorder import BagRecorder

folder, step_ns, count = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
recorder = BagRecorder(folder)
recorder.add_topic('/joint_states', 'sensor_msgs/msg/JointState')
k = 0
while k != count:
    recorder.write('/joint_states', k.to_bytes(120, 'little'), 10**18 + k * step_ns)
    print(10**18 + k * step_ns, flush=True)
    k += 1
sys.stdin.read()
"""


def saved(folder):
    """Return the log times of every message that can be read from a bag not yet closed."""
    return [log_time_ns for _, log_time_ns, _ in Bag.open(folder).timeline()]


@pytest.mark.parametrize('count', [-1, 2, 599], ids=['while writing', 'after two', 'between'])
@pytest.mark.parametrize('step_ns', [1_000_000, 30_000_000, 170_000_000, SECOND])
def test_kill_9_loses_no_message_older_than_half_a_second(tmp_path, step_ns, count):
    # The child stops by itself after ``count`` messages, or is killed while it writes (-1).
    lines = count if count > 0 else max(5, 3 * SECOND // step_ns)
    environment = dict(os.environ, PYTHONPATH=str(Path(sosml_friction.__file__).parents[1]))
    with subprocess.Popen(
        [sys.executable, '-c', CHILD, str(tmp_path / 'crash'), str(step_ns), str(count)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=environment,
    ) as child:
        written = [int(child.stdout.readline()) for _ in range(lines)]
        child.send_signal(signal.SIGKILL)
        # What it wrote before the signal reached it is part of the recording too.
        written += [int(line) for line in child.stdout if line.endswith('\n')]
    assert child.returncode == -signal.SIGKILL
    bag = Bag.open(tmp_path / 'crash')
    assert bag.recovered
    assert not (tmp_path / 'crash' / 'metadata.yaml').exists()
    found = list(bag.messages('/joint_states'))
    safe = [t for t in written if t <= written[-1] - SECOND // 2]
    assert len(safe) > 0 or written[-1] - written[0] < SECOND // 2
    assert [t for t, _ in found[: len(safe)]] == safe
    assert [int.from_bytes(cdr, 'little') for _, cdr in found] == list(range(len(found)))


@given(steps=st.lists(st.integers(0, 70_000_000) | st.integers(0, 450_000_000), max_size=40))
@settings(max_examples=60, deadline=None)
def test_at_any_moment_at_most_the_last_half_second_is_unread(tmp_path_factory, steps):
    folder = tmp_path_factory.mktemp('bag') / 'open'
    now, written = 5 * SECOND, []
    with BagRecorder(folder) as recorder:
        recorder.add_topic('/joint_states', JOINT_STATE)
        for step in steps:
            now += step
            recorder.write('/joint_states', b'x', now)
            written.append(now)
            found = saved(folder)
            assert found == written[: len(found)]
            assert all(now - t <= SECOND // 2 for t in written[len(found) :])


def test_a_paused_clock_is_bounded_by_the_monotonic_clock(tmp_path, monkeypatch):
    clock = iter(range(0, 100 * 100_000_000, 100_000_000))
    monkeypatch.setattr(recorder_module, 'monotonic_ns', lambda: next(clock))
    with BagRecorder(tmp_path / 'paused') as recorder:
        recorder.add_topic('/joint_states', JOINT_STATE)
        unread = []
        for k in range(1, 20):
            recorder.write('/joint_states', b'x', SECOND)
            unread.append(k - len(saved(tmp_path / 'paused')))
    # One write per 0.1 s of the clock, a hand-over at the latest after 0.2 s.
    assert max(unread) == 1


def test_a_clock_that_steps_back_is_handed_over_too(tmp_path):
    with BagRecorder(tmp_path / 'back') as recorder:
        recorder.add_topic('/joint_states', JOINT_STATE)
        recorder.write('/joint_states', b'x', 100 * SECOND)
        recorder.write('/joint_states', b'y', 50 * SECOND)
        assert len(saved(tmp_path / 'back')) == 2


def test_many_bytes_in_no_time_are_handed_over(tmp_path):
    with BagRecorder(tmp_path / 'burst') as recorder:
        recorder.add_topic('/robot_description', STRING)
        for k in range(64):
            recorder.write('/robot_description', bytes(16 * 1024), SECOND + k)
        assert len(saved(tmp_path / 'burst')) >= 50


def test_flush_saves_the_last_words_of_a_topic_that_falls_silent(tmp_path):
    with BagRecorder(tmp_path / 'silent') as recorder:
        recorder.add_topic('/joint_states', JOINT_STATE)
        for k in range(10):
            recorder.write('/joint_states', b'x', SECOND + k)
        assert len(saved(tmp_path / 'silent')) == 1
        recorder.flush()
        assert len(saved(tmp_path / 'silent')) == 10


def test_threads_write_side_by_side(tmp_path):
    def work(topic):
        for k in range(400):
            recorder.add_topic(topic, JOINT_STATE)
            recorder.write(topic, k.to_bytes(8, 'little'), SECOND + k * 1_000_000)
            if k % 50 == 0:
                recorder.flush()

    topics = [f'/arm{i}/joint_states' for i in range(4)]
    with BagRecorder(tmp_path / 'threads') as recorder:
        threads = [threading.Thread(target=work, args=(topic,)) for topic in topics]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert recorder.message_count == 1600
    bag = Bag.open(tmp_path / 'threads')
    assert not bag.recovered
    for topic in topics:
        numbers = [int.from_bytes(cdr, 'little') for _, cdr in bag.messages(topic)]
        assert numbers == list(range(400))


@pytest.fixture
def small_bag(tmp_path, joint_state, string):
    folder = tmp_path / 'run_7'
    with BagRecorder(folder, tags={'payload': '2', 'worn': 'yes'}) as recorder:
        recorder.add_topic('/robot_description', STRING)
        recorder.add_topic('/joint_states', JOINT_STATE)
        recorder.add_topic('/left/joint_states', JOINT_STATE)
        recorder.write('/robot_description', string('<robot/>'), 3 * SECOND)
        for k in range(300):
            stamp = 3 * SECOND + k * 10_000_000
            cdr = joint_state(stamp, ['a', 'b'], [k, -k], [], [0.5 * k, float('nan')])
            recorder.write('/joint_states', cdr, stamp + 5, stamp + 2)
        assert recorder.message_count == 301
    return folder


def test_metadata_yaml_is_what_rosbag2_of_jazzy_reads(small_bag):
    assert sorted(path.name for path in small_bag.iterdir()) == ['metadata.yaml', 'run_7_0.mcap']
    text = (small_bag / 'metadata.yaml').read_text()
    assert '&id' not in text
    information = yaml.safe_load(text)['rosbag2_bagfile_information']
    assert information['version'] == 9
    assert information['storage_identifier'] == 'mcap'
    assert information['duration'] == {'nanoseconds': 2_990_000_005}
    assert information['starting_time'] == {'nanoseconds_since_epoch': 3 * SECOND}
    assert information['message_count'] == 301
    assert information['compression_format'] == ''
    assert information['compression_mode'] == ''
    assert information['relative_file_paths'] == ['run_7_0.mcap']
    assert information['files'] == [
        {
            'path': 'run_7_0.mcap',
            'starting_time': {'nanoseconds_since_epoch': 3 * SECOND},
            'duration': {'nanoseconds': 2_990_000_005},
            'message_count': 301,
        }
    ]
    assert information['custom_data'] == {'payload': '2', 'worn': 'yes'}
    assert information['ros_distro']
    topics = information['topics_with_message_count']
    assert [topic['message_count'] for topic in topics] == [1, 300, 0]
    first = topics[0]['topic_metadata']
    assert first['name'] == '/robot_description'
    assert first['type'] == STRING
    assert first['serialization_format'] == 'cdr'
    assert first['type_description_hash'].startswith('RIHS01_')
    # Since version 9 the policies are words, and the profiles a list instead of a text.
    assert first['offered_qos_profiles'] == offered_qos(latched=True)
    assert first['offered_qos_profiles'][0]['durability'] == 'transient_local'
    assert topics[1]['topic_metadata']['offered_qos_profiles'][0]['durability'] == 'volatile'


def test_the_file_says_the_same_as_metadata_yaml(small_bag):
    with (small_bag / 'run_7_0.mcap').open('rb') as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert reader.get_header().profile == 'ros2'
        summary = reader.get_summary()
        records = list(reader.iter_metadata())
        messages = sum(1 for _ in reader.iter_messages())
    beside = yaml.safe_load((small_bag / 'metadata.yaml').read_text())
    assert {record.name for record in records} == {'rosbag2'}
    texts = [yaml.safe_load(record.metadata['serialized_metadata']) for record in records]
    # The first stands there before any message, so that a cut file still tells its version.
    assert texts[0]['version'] == 9
    assert texts[-1] == beside['rosbag2_bagfile_information']
    assert summary.statistics.message_count == messages == 301
    assert all(index.compression == '' for index in summary.chunk_indexes)
    assert all(index.message_index_length > 0 for index in summary.chunk_indexes)
    assert {schema.encoding for schema in summary.schemas.values()} == {'ros2msg'}
    assert {channel.message_encoding for channel in summary.channels.values()} == {'cdr'}
    channel = next(c for c in summary.channels.values() if c.topic == '/robot_description')
    assert yaml.safe_load(channel.metadata['offered_qos_profiles']) == offered_qos(latched=True)
    assert channel.metadata['topic_type_hash'].startswith('RIHS01_')


def test_an_independent_reader_finds_types_counts_stamps_and_values(small_bag):
    from rosbags.interfaces import QosDurability, QosReliability
    from rosbags.rosbag2 import Reader
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    with Reader(small_bag) as reader:
        assert reader.message_count == 301
        assert reader.start_time == 3 * SECOND
        assert reader.duration == 2_990_000_006  # rosbags ends just after the last message
        counts = {c.topic: (c.msgtype, c.msgcount) for c in reader.connections}
        assert counts == {
            '/robot_description': (STRING, 1),
            '/joint_states': (JOINT_STATE, 300),
            '/left/joint_states': (JOINT_STATE, 0),
        }
        qos = {c.topic: c.ext.offered_qos_profiles[0] for c in reader.connections}
        assert qos['/robot_description'].durability == QosDurability.TRANSIENT_LOCAL
        assert qos['/joint_states'].reliability == QosReliability.RELIABLE
        assert qos['/joint_states'].durability == QosDurability.VOLATILE
        seen = 0
        for connection, log_time_ns, cdr in reader.messages():
            message = store.deserialize_cdr(cdr, connection.msgtype)
            if connection.topic == '/robot_description':
                assert message.data == '<robot/>'
                continue
            stamp = message.header.stamp.sec * SECOND + message.header.stamp.nanosec
            assert stamp == 3 * SECOND + seen * 10_000_000
            assert log_time_ns == stamp + 5
            assert message.name == ['a', 'b']
            assert message.position.tolist() == [seen, -seen]
            assert message.velocity.tolist() == []
            assert message.effort[0] == 0.5 * seen
            assert message.effort[1] != message.effort[1]
            seen += 1
        assert seen == 300


def test_an_existing_folder_is_not_overwritten(tmp_path):
    (tmp_path / 'old').mkdir()
    with pytest.raises(BagError, match='old exists and is not overwritten: choose another name'):
        BagRecorder(tmp_path / 'old')
    assert list((tmp_path / 'old').iterdir()) == []


def test_a_place_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / 'file').write_text('')
    with pytest.raises(BagError, match='cannot be made: Not a directory: choose another place'):
        BagRecorder(tmp_path / 'file' / 'bag')


def test_misuse_is_refused_in_a_sentence(tmp_path):
    recorder = BagRecorder(tmp_path / 'bag')
    recorder.add_topic('/joint_states', JOINT_STATE)
    recorder.add_topic('/joint_states', 'sensor_msgs/JointState')
    with pytest.raises(BagError, match='is recorded as sensor_msgs/msg/JointState and cannot be'):
        recorder.add_topic('/joint_states', STRING)
    with pytest.raises(BagError, match=r'nowhere_msgs/msg/Thing .* is not installed'):
        recorder.add_topic('/thing', 'nowhere_msgs/msg/Thing')
    with pytest.raises(BagError, match='/other was not added to the bag'):
        recorder.write('/other', b'', 0)
    with pytest.raises(BagError, match='/joint_states has the time -1 ns'):
        recorder.write('/joint_states', b'', -1)
    recorder.close()
    recorder.close()
    for act in (recorder.flush, lambda: recorder.write('/joint_states', b'', 0)):
        with pytest.raises(BagError, match='is closed: nothing more can be recorded'):
            act()


def test_a_full_disk_is_one_sentence(tmp_path, monkeypatch):
    if not Path('/dev/full').exists():
        pytest.skip('no /dev/full on this system')
    monkeypatch.setattr(Path, 'open', lambda *_, **__: open('/dev/full', 'wb'))  # noqa: SIM115
    with pytest.raises(BagError, match='cannot be written: No space left on device: free or'):
        BagRecorder(tmp_path / 'full')


def test_an_error_in_the_with_block_still_leaves_a_closed_bag(tmp_path):
    def record_and_fail():
        with BagRecorder(tmp_path / 'bag') as recorder:
            recorder.add_topic('/joint_states', JOINT_STATE)
            recorder.write('/joint_states', b'x', 1)
            raise RuntimeError('stop')

    with pytest.raises(RuntimeError, match='stop'):
        record_and_fail()
    assert not Bag.open(tmp_path / 'bag').recovered


def test_a_recorder_that_was_full_and_then_freed_does_not_call_itself_whole(tmp_path, monkeypatch):
    recorder = BagRecorder(tmp_path / 'bag')
    recorder.add_topic('/joint_states', JOINT_STATE)
    for k in range(50):
        recorder.write('/joint_states', b'%010d' % k, 10**9 * k)
    stream = recorder._writer._Writer__stream

    class Full:
        tell = stream.tell
        flush = stream.flush

        def write(self, _):
            raise OSError(errno.ENOSPC, 'No space left on device')

    monkeypatch.setattr(recorder._writer, '_Writer__stream', Full())
    with pytest.raises(BagError, match='No space left on device'):
        recorder.write('/joint_states', b'lost', 10**9 * 50)
    monkeypatch.setattr(recorder._writer, '_Writer__stream', stream)
    with pytest.raises(BagError, match='No space left on device'):
        recorder.write('/joint_states', b'after the hole', 10**9 * 60)
    recorder.close()
    bag = Bag.open(tmp_path / 'bag')
    assert bag.recovered
    assert [int(cdr) for _, cdr in bag.messages('/joint_states')] == list(range(50))
