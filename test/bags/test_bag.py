# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Bag: what was recorded is what is read, and bad bags get a sentence."""

import numpy as np
import pytest
from mcap.writer import CompressionType, Writer

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.message_definitions import TRAJECTORY
from sosml_friction.bags.recorder import BagRecorder
from sosml_friction.bags.serialization import message_class, serialize, serialize_joint_state
from sosml_friction.exceptions import BagError, DataError

JOINT_STATE = 'sensor_msgs/msg/JointState'
TEMPERATURE = 'sensor_msgs/msg/Temperature'
STRING = 'std_msgs/msg/String'
SECOND = 1_000_000_000
NAN = float('nan')


@pytest.fixture
def two_joints(joint_state):
    """Return entries of two joints on a topic, k-th sample at k s."""

    def make(topic='/joint_states', count=4, shift=0.0):
        return [
            (
                topic,
                JOINT_STATE,
                joint_state(
                    k * SECOND,
                    ['shoulder', 'elbow'],
                    [k + shift, -k],
                    [0.5, 0.25],
                    [10.0 * k + shift, NAN],
                ),
                k * SECOND + 7,
            )
            for k in range(1, count + 1)
        ]

    return make


def test_a_bag_lists_its_topics_times_and_messages(tmp_path, record, two_joints, string):
    entries = [('/robot_description', STRING, string('<robot/>'), SECOND), *two_joints()]
    bag = Bag.open(record(tmp_path / 'bag', entries))
    assert bag.topics == {'/robot_description': (STRING, 1), '/joint_states': (JOINT_STATE, 4)}
    assert bag.messages_read == 5
    assert (bag.start_ns, bag.end_ns) == (SECOND, 4 * SECOND + 7)
    assert bag.duration_s == pytest.approx(3.000000007, abs=1e-12)
    assert not bag.recovered
    assert bag.tags == {}
    assert list(bag.messages('joint_states')) == [(t, cdr) for _, _, cdr, t in entries[1:]]
    assert [message.position[0] for _, message in bag.decoded('/joint_states')] == [1, 2, 3, 4]
    assert [(topic, t) for topic, t, _ in bag.timeline()] == [(e[0], e[3]) for e in entries]


@pytest.mark.parametrize('how', ['folder', 'file', 'folder without metadata', 'broken metadata'])
def test_folder_and_file_give_the_same(tmp_path, record, two_joints, how):
    path = record(tmp_path / 'bag', two_joints())
    if how == 'file':
        path = path / 'bag_0.mcap'
    elif how == 'folder without metadata':
        (path / 'metadata.yaml').unlink()
    elif how == 'broken metadata':
        (path / 'metadata.yaml').write_text('rosbag2_bagfile_information: [')
    log = Bag.open(path).joint_log()
    assert log.names == ('shoulder', 'elbow')
    assert log.t_ns.tolist() == [k * SECOND for k in (1, 2, 3, 4)]
    assert log.q.tolist() == [[1, -1], [2, -2], [3, -3], [4, -4]]
    assert log.v.tolist() == [[0.5, 0.25]] * 4
    assert log.tau[:, 0].tolist() == [10, 20, 30, 40]
    assert np.isnan(log.tau[:, 1]).all()
    assert log.temperature is None


@pytest.mark.parametrize('compression', list(CompressionType))
def test_a_bag_of_ros2_bag_record_with_compressed_chunks_is_read(
    tmp_path, foreign_mcap, two_joints, compression
):
    path = foreign_mcap(tmp_path / 'rosbag2_0.mcap', two_joints(count=500), compression, 2000)
    assert Bag.open(path).joint_log().q[:, 0].tolist() == list(range(1, 501))


def test_a_split_bag_is_one_recording(tmp_path, foreign_mcap, two_joints):
    entries = two_joints(count=36)
    for part in range(12):
        foreign_mcap(tmp_path / f'run_{part}.mcap', entries[3 * part : 3 * part + 3])
    bag = Bag.open(tmp_path)
    assert bag.topics == {'/joint_states': (JOINT_STATE, 36)}
    assert bag.joint_log().q[:, 0].tolist() == list(range(1, 37))
    # One damaged part is told, the others are read.
    part = tmp_path / 'run_4.mcap'
    part.write_bytes(part.read_bytes()[:-20])
    bag = Bag.open(tmp_path)
    assert bag.recovered
    assert bag.messages_read == 36
    assert 'run_4.mcap after byte' in bag.recovery
    assert 'run_3' not in bag.recovery


def test_parts_with_equal_times_follow_each_other_by_number(tmp_path, foreign_mcap):
    for part in range(12):
        entry = ('/joint_states', JOINT_STATE, b'%d' % part, 5)
        foreign_mcap(tmp_path / f'run_{part}.mcap', [entry], CompressionType.NONE)
    numbers = [int(cdr) for _, cdr in Bag.open(tmp_path).messages('/joint_states')]
    assert numbers == list(range(12))


def test_messages_are_given_in_the_order_of_log_time(tmp_path, record, two_joints):
    entries = two_joints(count=6)
    bag = Bag.open(record(tmp_path / 'bag', entries[3:] + entries[:3]))
    assert bag.joint_log().q[:, 0].tolist() == [1, 2, 3, 4, 5, 6]
    assert [t for _, t, _ in bag.timeline()] == [entry[3] for entry in entries]


def test_joints_go_by_name_not_by_place(tmp_path, record, joint_state):
    samples = [
        (['a', 'b'], [1, 2], [3, 4], [5, 6]),
        (['b', 'a'], [20, 10], [40, 30], [60, 50]),
        (['c'], [7], [8], [9]),
        (['a', 'b'], [100, 200], [], []),
        ([], [], [], []),
    ]
    entries = [
        ('/joint_states', JOINT_STATE, joint_state(k * SECOND, *sample), k)
        for k, sample in enumerate(samples, start=1)
    ]
    log = Bag.open(record(tmp_path / 'bag', entries)).joint_log()
    assert log.names == ('a', 'b', 'c')
    nan = [NAN] * 3
    np.testing.assert_array_equal(
        log.q, [[1, 2, NAN], [10, 20, NAN], [NAN, NAN, 7], [100, 200, NAN], nan]
    )
    np.testing.assert_array_equal(log.v, [[3, 4, NAN], [30, 40, NAN], [NAN, NAN, 8], nan, nan])
    np.testing.assert_array_equal(log.tau, [[5, 6, NAN], [50, 60, NAN], [NAN, NAN, 9], nan, nan])


def test_no_effort_is_nan_and_refused_only_where_it_is_needed(tmp_path, record, joint_state):
    entries = [
        ('/joint_states', JOINT_STATE, joint_state(k, ['slider'], [1.0], [0.0]), k) for k in (1, 2)
    ]
    log = Bag.open(record(tmp_path / 'bag', entries)).joint_log()
    assert np.isnan(log.tau).all()
    with pytest.raises(DataError, match='joint_states carries no effort for slider: let the driv'):
        log.require_effort()


def test_effort_of_one_joint_is_enough(tmp_path, record, two_joints):
    Bag.open(record(tmp_path / 'bag', two_joints())).joint_log().require_effort()


@pytest.mark.parametrize(
    ('names', 'position', 'velocity', 'effort', 'what'),
    [
        (['a', 'b'], [1], [], [], '2 joint names and 1 values of position'),
        (['a', 'b'], [1, 2], [1, 2, 3], [], '2 joint names and 3 values of velocity'),
        (['a', 'b'], [1, 2], [], [1], '2 joint names and 1 values of effort'),
        ([], [1], [], [], '0 joint names and 1 values of position'),
        (['a', 'a'], [1, 2], [], [], 'joints a, a'),
    ],
)
def test_a_message_that_contradicts_itself_is_named_by_its_stamp(
    tmp_path, record, joint_state, names, position, velocity, effort, what
):
    good = ('/joint_states', JOINT_STATE, joint_state(SECOND, ['a', 'b'], [1, 2]), 1)
    cdr = joint_state(1_500_000_001, names, position, velocity, effort)
    bag = Bag.open(record(tmp_path / 'bag', [good, ('/joint_states', JOINT_STATE, cdr, 2)]))
    with pytest.raises(BagError, match=f'at stamp 1500000001 ns has {what}: each joint needs'):
        bag.joint_log()


def test_messages_without_stamps_are_refused(tmp_path, record, joint_state):
    entries = [('/joint_states', JOINT_STATE, joint_state(0, ['a'], [k]), k) for k in range(3)]
    with pytest.raises(BagError, match=r'joint_states in .* has no stamps'):
        Bag.open(record(tmp_path / 'bag', entries)).joint_log()


def test_bytes_that_are_no_message_are_named(tmp_path, record):
    bag = Bag.open(record(tmp_path / 'bag', [('/joint_states', JOINT_STATE, b'\0\1\0\0ab', 9)]))
    with pytest.raises(BagError, match=r'/joint_states in .*bag at 9 ns: 6 bytes recorded as'):
        bag.joint_log()


def test_temperatures_are_the_last_before_each_sample(tmp_path, record, joint_state, temperature):
    entries = [
        ('/joint_states', JOINT_STATE, joint_state(k * SECOND, ['a', 'b'], [0, 0]), k * SECOND)
        for k in (1, 2, 3, 4)
    ]
    for half, joint, value in [
        (3, 'a', 30.0), (6, 'a', 31.0), (7, 'a', 32.0), (5, 'c', 99.0), (4, 'b', 50.0),
        (7, 'b', NAN),
    ]:  # fmt: skip
        stamp = half * SECOND // 2
        cdr = temperature(stamp, joint, value)
        entries.append(('/joint_temperatures', TEMPERATURE, cdr, stamp))
    log = Bag.open(record(tmp_path / 'bag', entries)).joint_log()
    np.testing.assert_array_equal(
        log.temperature, [[NAN, NAN], [30.0, 50.0], [31.0, 50.0], [32.0, NAN]]
    )


def test_temperatures_of_other_joints_are_not_these(tmp_path, record, two_joints, temperature):
    entries = [*two_joints(), ('/joint_temperatures', TEMPERATURE, temperature(1, 'leg', 1.0), 1)]
    assert Bag.open(record(tmp_path / 'bag', entries)).joint_log().temperature is None


def test_text_is_the_last_that_was_latched(tmp_path, record, string, two_joints):
    entries = [
        ('/model_description', STRING, string('old'), 1),
        ('/model_description', STRING, string('new é'), 2),
        *two_joints(),
    ]
    bag = Bag.open(record(tmp_path / 'bag', entries))
    assert bag.text('model_description') == 'new é'
    assert bag.text('robot_description') is None
    # The last part of a name is a whole part.
    assert bag.text('description') is None
    with pytest.raises(
        BagError, match=r'/joint_states in .* is a sensor_msgs/msg/JointState: a std'
    ):
        bag.text('joint_states')


@pytest.fixture
def two_arms(tmp_path, record, two_joints, string, temperature, joint_state):
    entries = []
    for side, shift in (('left', 0.125), ('right', 0.5)):
        entries += [
            (f'/{side}/robot_description', STRING, string(side), 1),
            (f'/{side}/joint_temperatures', TEMPERATURE, temperature(1, 'elbow', shift), 1),
            (
                f'/{side}/friction_estimate/sosml',
                JOINT_STATE,
                joint_state(1, ['elbow'], [], [], [shift]),
                1,
            ),
            *two_joints(f'/{side}/joint_states', shift=shift),
        ]
    return record(tmp_path / 'arms', entries)


def test_a_single_namespace_needs_no_choice(tmp_path, record, two_joints):
    bag = Bag.open(record(tmp_path / 'bag', two_joints('/left/joint_states', shift=0.5)))
    assert bag.joint_log().q[0, 0] == 1.5


def test_several_joint_states_ask_for_a_choice(two_arms):
    bag = Bag.open(two_arms)
    for ask in (bag.joint_log, lambda: bag.text('robot_description')):
        with pytest.raises(
            BagError, match=r'has 2 topics that end in .*\(/left/.*, /right/.*choose'
        ):
            ask()


@pytest.mark.parametrize(('side', 'shift'), [('left', 0.125), ('/right/', 0.5)])
def test_a_namespace_chooses(two_arms, side, shift):
    bag = Bag.open(two_arms, namespace=side)
    log = bag.joint_log()
    assert log.q[0, 0] == 1 + shift
    assert log.temperature[0, 1] == shift
    assert bag.text('robot_description') == side.strip('/')


def test_a_topic_name_chooses_and_takes_the_temperatures_beside_it(two_arms):
    log = Bag.open(two_arms).joint_log('/right/joint_states')
    assert log.q[0, 0] == 1.5
    assert log.temperature[0, 1] == 0.5


def test_tags_come_with_the_log(tmp_path, joint_state):
    with BagRecorder(tmp_path / 'bag', tags={'worn': 'no', 'payload': '2.0'}) as recorder:
        recorder.add_topic('/joint_states', JOINT_STATE)
        recorder.write('/joint_states', joint_state(5, ['a'], [1.0]), 5)
    for path in (tmp_path / 'bag', tmp_path / 'bag' / 'bag_0.mcap'):
        assert Bag.open(path).joint_log().tags == {'worn': 'no', 'payload': '2.0'}


def test_a_missing_path_is_one_sentence(tmp_path):
    with pytest.raises(BagError, match=r'nowhere does not exist: give a bag folder'):
        Bag.open(tmp_path / 'nowhere')


def test_a_file_that_is_no_bag_is_one_sentence(tmp_path):
    (tmp_path / 'x.mcap').write_text('this is a text')
    with pytest.raises(BagError, match=r'x.mcap is not an MCAP file'):
        Bag.open(tmp_path / 'x.mcap')


@pytest.mark.parametrize(
    ('name', 'sentence'),
    [
        ('notes.txt', 'is no bag: the folder holds no .mcap or .db3 file'),
        ('run_0.db3', 'run_0.db3 is no readable bag: '),
        ('run_0.db3.zstd', 'holds compressed files only .run_0.db3.zstd.: unpack them'),
        ('run_0.mcap.zstd', 'holds compressed files only .run_0.mcap.zstd.: unpack them'),
    ],
)
def test_a_folder_without_mcap_says_what_to_do(tmp_path, name, sentence):
    (tmp_path / name).write_text('x')
    with pytest.raises(BagError, match=sentence):
        Bag.open(tmp_path)


def test_messages_compressed_one_by_one_are_refused(tmp_path, record, two_joints):
    folder = record(tmp_path / 'bag', two_joints())
    metadata = folder / 'metadata.yaml'
    metadata.write_text(
        metadata.read_text().replace("compression_mode: ''", 'compression_mode: MESSAGE')
    )
    with pytest.raises(BagError, match='was recorded with --compression-mode message'):
        Bag.open(folder)


@pytest.mark.parametrize('kind', ['topics', 'no topics', 'no bytes'])
def test_an_empty_bag_is_one_sentence(tmp_path, kind):
    if kind == 'no bytes':
        (tmp_path / 'bag').mkdir()
        (tmp_path / 'bag' / 'bag_0.mcap').touch()
    else:
        with BagRecorder(tmp_path / 'bag') as recorder:
            if kind == 'topics':
                recorder.add_topic('/joint_states', JOINT_STATE)
    with pytest.raises(BagError, match=r'bag holds no (whole )?message: record again'):
        Bag.open(tmp_path / 'bag')


def test_a_bag_without_joint_states_lists_what_it_has(tmp_path, record, string):
    bag = Bag.open(record(tmp_path / 'bag', [('/robot_description', STRING, string('x'), 1)]))
    sentence = r'no messages on joint_states: it has /robot_description \(std_msgs/msg/String, 1 m'
    with pytest.raises(BagError, match=sentence):
        bag.joint_log()
    with pytest.raises(BagError, match='has no topic /scan: it has /robot_description'):
        bag.joint_log('/scan')
    with pytest.raises(BagError, match='has no topic /scan: it has /robot_description'):
        next(bag.messages('/scan'))
    with pytest.raises(
        BagError, match=r'/robot_description in .* is a std_msgs/msg/String: a sens'
    ):
        bag.joint_log('/robot_description')


def test_a_namespace_without_joint_states_is_named(two_arms):
    with pytest.raises(
        BagError, match='no messages on joint_states in the namespace /leg: it has'
    ):
        Bag.open(two_arms, namespace='leg').joint_log()


def test_a_topic_without_messages_is_named(tmp_path, record, string):
    folder = tmp_path / 'bag'
    with BagRecorder(folder) as recorder:
        recorder.add_topic('/joint_states', JOINT_STATE)
        recorder.add_topic('/robot_description', STRING)
        recorder.write('/robot_description', string('x'), 1)
    with pytest.raises(BagError, match=r'/joint_states in .* has no messages: record it again'):
        Bag.open(folder).joint_log('/joint_states')


def test_another_encoding_or_two_types_on_a_topic_are_named(tmp_path, foreign_mcap):
    foreign_mcap(tmp_path / 'a_0.mcap', [('/joint_states', JOINT_STATE, b'', 1)])
    foreign_mcap(tmp_path / 'a_1.mcap', [('/joint_states', STRING, b'', 2)])
    with pytest.raises(
        BagError, match=r'/joint_states in .* is both sensor_msgs/msg/JointState and'
    ):
        Bag.open(tmp_path)
    with (tmp_path / 'json.mcap').open('wb') as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema(JOINT_STATE, 'jsonschema', b'{}')
        channel = writer.register_channel('/joint_states', 'json', schema)
        writer.add_message(channel, 1, b'{}', 1)
        writer.finish()
    with pytest.raises(BagError, match="is encoded as 'json': only cdr"):
        Bag.open(tmp_path / 'json.mcap').joint_log()


def test_the_robot_at_the_root_can_be_chosen_beside_one_in_a_namespace(tmp_path):
    """Namespace / means the root's own topics, not those of every namespace."""
    with BagRecorder(tmp_path / 'two') as recorder:
        for k, topic in enumerate(('/joint_states', '/left/joint_states')):
            recorder.add_topic(topic, JOINT_STATE)
            cdr = serialize_joint_state(k + 1, ['arm'], [float(k)])
            recorder.write(topic, cdr, k + 1)
    assert Bag.open(tmp_path / 'two', '/').joint_log().q.tolist() == [[0.0]]
    assert Bag.open(tmp_path / 'two', 'left').joint_log().q.tolist() == [[1.0]]
    with pytest.raises(BagError, match='namespace'):
        Bag.open(tmp_path / 'two').joint_log()


def trajectory(times, positions, velocities=()):
    message = message_class(TRAJECTORY)()
    message.joint_names = ['shoulder', 'elbow']
    point = message_class('trajectory_msgs/msg/JointTrajectoryPoint')
    for k, t in enumerate(times):
        one = point(positions=positions[k], velocities=velocities[k] if len(velocities) else [])
        one.time_from_start.sec, one.time_from_start.nanosec = divmod(round(t * 1e9), SECOND)
        message.points.append(one)
    return serialize(message)


def test_trajectories_come_as_they_were_sent(tmp_path, record, two_joints):
    slow = trajectory([0.0, 1.5], [[1.0, 2.0], [3.0, 4.0]])
    fast = trajectory([0.25], [[5.0, 6.0]], [[0.5, -0.5]])
    entries = [
        *two_joints(),
        ('/joint_trajectory', TRAJECTORY, slow, SECOND),
        ('/joint_trajectory', TRAJECTORY, fast, 2 * SECOND),
    ]
    first, second = Bag.open(record(tmp_path / 'bag', entries)).trajectories()
    assert (first.log_time_ns, first.names) == (SECOND, ('shoulder', 'elbow'))
    assert first.times.tolist() == [0.0, 1.5]
    assert first.positions.tolist() == [[1.0, 2.0], [3.0, 4.0]]
    assert first.velocities is None
    assert second.times.tolist() == [0.25]
    assert second.velocities.tolist() == [[0.5, -0.5]]
    assert Bag.open(record(tmp_path / 'without', two_joints())).trajectories() == []


@pytest.mark.parametrize(
    ('times', 'positions', 'velocities'),
    [
        ([], [], []),
        ([1.0, 1.0], [[1.0, 2.0]] * 2, []),
        ([1.0], [[1.0]], []),
        ([1.0, 2.0], [[1.0, 2.0]] * 2, [[0.1, 0.1], []]),
    ],
)
def test_a_trajectory_that_contradicts_itself_is_one_sentence(
    tmp_path, record, two_joints, times, positions, velocities
):
    sent = ('/joint_trajectory', TRAJECTORY, trajectory(times, positions, velocities), SECOND)
    bag = Bag.open(record(tmp_path / 'bag', [*two_joints(), sent]))
    with pytest.raises(BagError, match='later time and a value for every joint'):
        bag.trajectories()


def test_a_value_that_no_joint_can_have_is_not_known(tmp_path, record, joint_state):
    values = [0.5, np.inf, -np.inf, 1e300, -1e9, 9.9e8]
    entries = [
        ('/joint_states', JOINT_STATE, joint_state(k, ['j'], [x], [x], [x]), k)
        for k, x in enumerate(values, 1)
    ]
    log = Bag.open(record(tmp_path / 'bag', entries)).joint_log()
    for column in (log.q, log.v, log.tau):
        np.testing.assert_array_equal(column[:, 0], [0.5, *[np.nan] * 4, 9.9e8])


def test_metadata_that_counts_other_messages_is_told(tmp_path, record, two_joints):
    folder = record(tmp_path / 'bag', two_joints())
    beside = folder / 'metadata.yaml'
    for old, new, said in (
        ('message_count: 4', 'message_count: 5', 'metadata.yaml counts 5 messages'),
        ('name: /joint_states', 'name: /joint_stateS', 'other messages of /joint_stateS'),
    ):
        text = beside.read_text()
        beside.write_text(text.replace(old, new))
        bag = Bag.open(folder)
        assert bag.recovered
        assert said in bag.recovery
        assert bag.messages_read == 4
        beside.write_text(text)


def test_tags_are_told_from_damaged_ones(tmp_path, two_joints):
    with BagRecorder(tmp_path / 'bag', {'payload': '2.5 kg'}) as recorder:
        for topic, kind, cdr, t_ns in two_joints():
            recorder.add_topic(topic, kind)
            recorder.write(topic, cdr, t_ns)
    path = tmp_path / 'bag' / 'bag_0.mcap'
    content = path.read_bytes()
    assert Bag.open(path).tags == {'payload': '2.5 kg'}
    # At the beginning and at the end of the file.
    assert content.count(b'2.5 kg') == 2
    path.write_bytes(content.replace(b'2.5 kg', b'7.5 kg', 1))
    bag = Bag.open(path)
    assert 'bag_0.mcap has damaged tags' in bag.recovery
    assert bag.tags == {'payload': '2.5 kg'}
    # A recording that was killed has no checksum but that of its tags.
    path.write_bytes(content.replace(b'2.5 kg', b'7.5 kg', 1)[: len(content) // 2])
    assert Bag.open(path).tags == {}
