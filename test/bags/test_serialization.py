# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""CDR bytes and messages, both ways."""

import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sosml_friction.bags import serialization
from sosml_friction.bags.serialization import (
    deserialize,
    message_class,
    plain_string,
    plain_temperature,
    serialize,
    serialize_joint_state,
)
from sosml_friction.exceptions import BagError, ConfigurationError


def test_a_message_survives_serialisation():
    message = message_class('sensor_msgs/msg/JointState')(name=['a', 'b'], effort=[1.5, -0.0])
    message.header.stamp.sec = 7
    assert deserialize(serialize(message), 'sensor_msgs/msg/JointState') == message


@pytest.mark.parametrize('length', [0, 1, 3, 8, 20, 50])
def test_bytes_cut_short_are_refused(length):
    whole = serialize(message_class('sensor_msgs/msg/JointState')(name=['shoulder'] * 9))
    with pytest.raises(BagError, match=f'{length} bytes recorded as sensor_msgs/msg/JointState'):
        deserialize(whole[:length], 'sensor_msgs/msg/JointState')


@pytest.mark.parametrize('text', ['', 'a', 'Gelenk ä', 'x' * 5000])
def test_a_text_is_read_without_rclpy_and_left_to_it_where_it_is_cut(text):
    whole = serialize(message_class('std_msgs/msg/String')(data=text))
    assert plain_string(whole) == text
    end = 8 + len(text.encode())
    for cut in (0, 3, 7, end - 1, end):
        assert plain_string(whole[:cut]) is None
    assert plain_string(b'\x00\x00' + whole[2:]) is None


@given(
    st.text(st.characters(exclude_characters='\0', codec='utf-8'), max_size=9),
    st.floats(width=64),
    st.integers(0, 2**31 - 1),
    st.integers(0, 999_999_999),
)
def test_a_temperature_is_read_without_rclpy_as_with_it(joint, celsius, sec, nanosec):
    message = message_class('sensor_msgs/msg/Temperature')(temperature=celsius)
    message.header.frame_id = joint
    message.header.stamp.sec, message.header.stamp.nanosec = sec, nanosec
    whole = serialize(message)
    t_ns, name, value = plain_temperature(whole)
    assert (t_ns, name) == (sec * 10**9 + nanosec, joint)
    np.testing.assert_array_equal(value, celsius)
    assert plain_temperature(whole[:-1]) is None
    assert plain_temperature(whole[:14]) is None


@pytest.mark.parametrize('name', ['nowhere_msgs/msg/Thing', 'sensor_msgs/msg/NoSuchThing'])
def test_a_type_that_is_not_installed_is_named(name):
    with pytest.raises(BagError, match=f'{name} is not installed'):
        message_class(name)


def test_a_machine_without_rclpy_is_told_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, 'rclpy.serialization', None)
    serialization._rclpy_serialization.cache_clear()
    try:
        with pytest.raises(
            ConfigurationError, match=r'rclpy, which decodes .* source ROS 2 Jazzy'
        ):
            serialize(message_class('std_msgs/msg/String')())
    finally:
        serialization._rclpy_serialization.cache_clear()


values = st.lists(st.floats(width=64), max_size=5)


@given(
    t_ns=st.integers(0, 2**31 * 10**9 - 1),
    names=st.lists(st.text(st.characters(exclude_characters='\0', codec='utf-8')), max_size=4),
    position=values,
    velocity=values,
    effort=values,
)
def test_joint_states_are_packed_as_rclpy_and_an_independent_reader_expect(
    t_ns, names, position, velocity, effort
):
    from rosbags.typesys import Stores, get_typestore

    cdr = serialize_joint_state(t_ns, names, position, velocity, effort)
    # The second reader refuses bytes left over at the end.
    other = get_typestore(Stores.ROS2_JAZZY).deserialize_cdr(cdr, 'sensor_msgs/msg/JointState')
    for message in (deserialize(cdr, 'sensor_msgs/msg/JointState'), other):
        assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == t_ns
        assert message.header.frame_id == ''
        assert message.name == names
        for quantity, expected in zip(
            ('position', 'velocity', 'effort'), (position, velocity, effort), strict=True
        ):
            got = np.array(getattr(message, quantity), dtype=np.float64)
            assert got.tobytes() == np.array(expected, dtype=np.float64).tobytes()
