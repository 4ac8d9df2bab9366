# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Bags in SQLite are read as those of MCAP are."""

import sqlite3
import sys
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.other_bag import copy_bag, is_other_bag
from sosml_friction.bags.source import bag_hash, bag_name
from sosml_friction.exceptions import BagError

Q = np.array([[0.0, 1.0], [0.1, 1.1], [0.2, 1.2]])


@pytest.fixture
def sqlite_bag(tmp_path):
    """Return a writer of a bag as ros2 bag record -s sqlite3 makes it."""
    rosbag2 = pytest.importorskip('rosbags.rosbag2')
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    kinds = store.types

    def make(topics=('/arm/joint_states',)):
        folder = tmp_path / 'recorded'
        with rosbag2.Writer(
            folder, version=9, storage_plugin=rosbag2.StoragePlugin.SQLITE3
        ) as writer:
            name = 'std_msgs/msg/String'
            text = writer.add_connection('/arm/robot_description', name, typestore=store)
            message = kinds[name](data='<robot name="arm"/>')
            writer.write(text, 1, store.serialize_cdr(message, name))
            name = 'sensor_msgs/msg/JointState'
            for topic in topics:
                states = writer.add_connection(topic, name, typestore=store)
                for k, q in enumerate(Q):
                    stamp = kinds['builtin_interfaces/msg/Time'](sec=5, nanosec=k * 10_000_000)
                    header = kinds['std_msgs/msg/Header'](stamp=stamp, frame_id='')
                    effort = q * 2.0 if k else np.array([])
                    message = kinds[name](header, ['a', 'b'], q, np.array([]), effort)
                    writer.write(states, 2 + k, store.serialize_cdr(message, name))
        return folder

    return make


@pytest.mark.parametrize('what', ['folder', 'file', 'file alone'])
@pytest.mark.parametrize('topic', ['/arm/joint_states', '/measured'])
def test_a_bag_in_sqlite_is_read_as_one_in_mcap(sqlite_bag, what, topic):
    folder = sqlite_bag([topic])
    source = folder if what == 'folder' else next(folder.glob('*.db3'))
    if what == 'file alone':
        (folder / 'metadata.yaml').unlink()
    assert is_other_bag(source)
    bag = Bag.open(source)
    log = bag.joint_log()
    assert bag.path == source
    assert not bag.recovered
    assert log.names == ('a', 'b')
    assert log.t_ns.tolist() == [5_000_000_000 + k * 10_000_000 for k in range(3)]
    np.testing.assert_array_equal(log.q, Q)
    assert np.isnan(log.v).all()
    np.testing.assert_array_equal(log.tau[1:], 2.0 * Q[1:])
    assert np.isnan(log.tau[0]).all()
    assert bag.text('robot_description') == '<robot name="arm"/>'
    assert bag_name(source) == source.stem
    assert bag_hash(source) == bag_hash(folder)


def test_a_bag_of_ros_1_is_read(tmp_path):
    rosbag1 = pytest.importorskip('rosbags.rosbag1')
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    kinds, name = store.types, 'sensor_msgs/msg/JointState'
    with rosbag1.Writer(tmp_path / 'x.bag') as writer:
        states = writer.add_connection('/joint_states', name, typestore=store)
        for k, q in enumerate(Q):
            stamp = kinds['builtin_interfaces/msg/Time'](sec=5, nanosec=k * 10_000_000)
            header = kinds['std_msgs/msg/Header'](seq=k, stamp=stamp, frame_id='')
            message = kinds[name](header, ['a', 'b'], q, np.array([]), 2.0 * q)
            writer.write(states, 2 + k, store.serialize_ros1(message, name))
        name = 'sensor_msgs/msg/Temperature'
        header = kinds['std_msgs/msg/Header'](seq=0, stamp=stamp, frame_id='b')
        warm = writer.add_connection('/joint_temperatures', name, typestore=store)
        writer.write(warm, 9, store.serialize_ros1(kinds[name](header, 30.5, 0.0), name))
    log = Bag.open(tmp_path / 'x.bag').joint_log()
    assert log.temperature[-1, 1] == 30.5
    np.testing.assert_array_equal(log.q, Q)
    np.testing.assert_array_equal(log.tau, 2.0 * Q)
    assert np.isnan(log.v).all()


def test_of_two_robots_the_namespace_chooses(sqlite_bag):
    folder = sqlite_bag(['/left/joint_states', '/right/joint_states'])
    with pytest.raises(BagError, match='choose one by its namespace'):
        Bag.open(folder).joint_log()
    np.testing.assert_array_equal(Bag.open(folder, 'left').joint_log().q, Q)


def test_its_tags_are_kept_and_its_copy_is_not(sqlite_bag, monkeypatch, tmp_path):
    folder = sqlite_bag()
    text = (folder / 'metadata.yaml').read_text()
    assert 'custom_data: null' in text
    text = text.replace('custom_data: null', 'custom_data: {payload: 2 kg}')
    (folder / 'metadata.yaml').write_text(text)
    monkeypatch.setattr('tempfile.tempdir', str(tmp_path / 'copies'))
    Path(tmp_path / 'copies').mkdir()
    bag = Bag.open(folder)
    assert bag.tags == {'payload': '2 kg'}
    assert list((tmp_path / 'copies').iterdir())
    del bag
    assert not list((tmp_path / 'copies').iterdir())


def test_messages_compressed_one_by_one_are_refused(sqlite_bag):
    folder = sqlite_bag()
    text = (folder / 'metadata.yaml').read_text()
    text = text.replace("compression_mode: ''", 'compression_mode: MESSAGE')
    (folder / 'metadata.yaml').write_text(text)
    with pytest.raises(BagError, match='compression-mode message, which is not read'):
        Bag.open(folder)


def test_a_folder_with_mcap_is_a_bag_of_mcap(tmp_path, sqlite_bag):
    folder = copy_bag(sqlite_bag(), tmp_path / 'copy')
    (folder / 'x.db3').write_bytes(b'')
    assert not is_other_bag(folder)
    np.testing.assert_array_equal(Bag.open(folder).joint_log().q, Q)


def test_a_damaged_bag_is_one_sentence(sqlite_bag):
    folder = sqlite_bag()
    next(folder.glob('*.db3')).write_bytes(b'no database' * 50)
    with pytest.raises(BagError, match='is no readable bag') as caught:
        Bag.open(folder)
    assert '\n' not in str(caught.value)


def test_a_bag_that_cannot_be_read_to_its_end_leaves_nothing(tmp_path):
    pytest.importorskip('rosbags.rosbag1')
    (tmp_path / 'x.bag').write_bytes(b'#ROSBAG V2.0\n' + bytes(4096))
    with pytest.raises(BagError, match='is no readable bag'):
        copy_bag(tmp_path / 'x.bag', tmp_path / 'copy')
    assert not (tmp_path / 'copy').exists()


def test_a_bag_without_joint_states_is_told(sqlite_bag):
    folder = sqlite_bag()
    with closing(sqlite3.connect(next(folder.glob('*.db3')))) as base:
        base.execute('DELETE FROM messages')
        base.commit()
    with pytest.raises(
        BagError, match=r'holds no message of type sensor_msgs/msg/JointState: it has /arm'
    ):
        Bag.open(folder)


def test_without_rosbags_it_is_said_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, 'rosbags.highlevel', None)
    (tmp_path / 'x.bag').write_bytes(b'')
    with pytest.raises(BagError, match='rosbags, which reads it, is not installed: pip install'):
        copy_bag(tmp_path / 'x.bag', tmp_path / 'copy')
