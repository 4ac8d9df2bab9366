# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Bags in SQLite become MCAP bags with the same motion."""

import sys

import numpy as np
import pytest

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.other_bag import copy_bag, is_other_bag
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


@pytest.mark.parametrize('what', ['folder', 'file'])
@pytest.mark.parametrize('topic', ['/arm/joint_states', '/measured'])
def test_a_bag_in_sqlite_becomes_one_in_mcap(tmp_path, sqlite_bag, what, topic):
    folder = sqlite_bag([topic])
    source = folder if what == 'folder' else next(folder.glob('*.db3'))
    assert is_other_bag(source)
    bag = Bag.open(copy_bag(source, tmp_path / 'copy'))
    log = bag.joint_log()
    assert log.names == ('a', 'b')
    assert log.t_ns.tolist() == [5_000_000_000 + k * 10_000_000 for k in range(3)]
    np.testing.assert_array_equal(log.q, Q)
    assert np.isnan(log.v).all()
    np.testing.assert_array_equal(log.tau[1:], 2.0 * Q[1:])
    assert np.isnan(log.tau[0]).all()
    assert bag.text('robot_description') == '<robot name="arm"/>'


def test_two_robots_in_one_bag_are_refused(tmp_path, sqlite_bag):
    folder = sqlite_bag(['/left/joint_states', '/right/joint_states'])
    with pytest.raises(BagError, match='has 2 topics of type sensor_msgs/msg/JointState'):
        copy_bag(folder, tmp_path / 'copy')


def test_a_damaged_bag_is_one_sentence(tmp_path, sqlite_bag):
    folder = sqlite_bag()
    next(folder.glob('*.db3')).write_bytes(b'no database' * 50)
    with pytest.raises(BagError, match='is no readable bag') as caught:
        copy_bag(folder, tmp_path / 'copy')
    assert '\n' not in str(caught.value)


def test_without_rosbags_it_is_said_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, 'rosbags.highlevel', None)
    (tmp_path / 'x.db3').write_bytes(b'')
    with pytest.raises(BagError, match='rosbags, which reads it, is not installed: pip install'):
        copy_bag(tmp_path / 'x.db3', tmp_path / 'copy')
