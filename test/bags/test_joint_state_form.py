# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""JointStateForm: what rclpy reads out of bytes and packs into them, without rclpy."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip('rclpy')

from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState

from sosml_friction.bags.joint_state_form import JointStateForm, of_message, plain

FIELDS = ('position', 'velocity', 'effort')


def message(
    names, t_ns=1_700_000_000_123_456_789, frame_id='', fields=FIELDS, shift=0.0
) -> JointState:
    """Return a message whose numbers tell field and joint."""
    result = JointState(name=list(names))
    result.header.stamp.sec, result.header.stamp.nanosec = divmod(t_ns, 10**9)
    result.header.frame_id = frame_id
    for k, field in enumerate(fields):
        setattr(result, field, [10.0 * k + i + shift for i in range(len(names))])
    return result


@given(
    st.lists(st.text('abäz_', max_size=9), min_size=1, max_size=9, unique=True),
    st.text('abcß/', max_size=9),
    st.randoms(use_true_random=False),
)
def test_numbers_are_read_and_written_as_by_rclpy(names, frame_id, random):
    joints = random.sample(names, random.randint(1, len(names)))
    sent = message(names, frame_id=frame_id)
    for cdr in (bytes(serialize_message(sent)), of_message(sent)):
        form = JointStateForm(plain(cdr), joints)
        assert form.is_known
        assert form.fits(cdr)
        assert form.source == (tuple(names), frame_id)
        t_ns, numbers = form.read(cdr)
        assert t_ns == 1_700_000_000_123_456_789
        rows = [names.index(name) for name in joints]
        np.testing.assert_array_equal(numbers, [[10.0 * k + i for i in rows] for k in range(3)])
        efforts = -numbers[2]
        parts = (x.tobytes() for x in (numbers[0], numbers[1], efforts))
        got = deserialize_message(form.write(cdr, *parts), JointState)
        wanted = JointState(header=sent.header, name=joints)
        wanted.position, wanted.velocity = numbers[0].tolist(), numbers[1].tolist()
        wanted.effort = efforts.tolist()
        assert got == wanted


@pytest.mark.parametrize('fields', [(), ('position',), ('position', 'velocity'), ('effort',)])
def test_what_a_message_does_not_have_is_nan(fields):
    sent = JointState(name=['a', 'b'])
    for field in fields:
        setattr(sent, field, [1.0, 2.0])
    cdr = of_message(sent)
    _, numbers = JointStateForm(cdr, ['b', 'a']).read(cdr)
    for field, row in zip(FIELDS, numbers, strict=True):
        np.testing.assert_array_equal(row, [2.0, 1.0] if field in fields else [np.nan] * 2)


def test_an_array_of_another_length_is_nan():
    sent = message(['a', 'b'])
    sent.effort = [1.0]
    cdr = of_message(sent)
    _, numbers = JointStateForm(cdr, ['a']).read(cdr)
    np.testing.assert_array_equal(numbers, [[0.0], [10.0], [np.nan]])


def test_other_stamps_and_numbers_fit_and_nothing_else():
    cdr = of_message(message(['a', 'b']))
    form = JointStateForm(cdr, ['a'])
    assert form.fits(of_message(message(['a', 'b'], t_ns=5, shift=3.0)))
    assert not form.fits(of_message(message(['a', 'c'])))
    assert not form.fits(of_message(message(['a', 'b'], frame_id='x')))
    shorter = message(['a', 'b'])
    shorter.velocity = []
    shorter.effort = [1.0, 2.0, 3.0, 4.0, 5.0]
    other = of_message(shorter)
    assert len(other) == len(cdr)
    assert not form.fits(other)


def test_joints_that_are_not_there_are_not_known():
    form = JointStateForm(of_message(message(['a', 'b'])), ['a', 'z'])
    assert not form.is_known
    assert form.names == ('a', 'b')


def test_what_only_rclpy_can_read_is_written_anew():
    cdr = bytearray(of_message(message(['a', 'b'], frame_id='base')))
    # A text that is no UTF-8, which rclpy replaces.
    cdr[cdr.index(b'base')] = 0xFF
    anew = plain(bytes(cdr))
    assert deserialize_message(anew, JointState) == deserialize_message(bytes(cdr), JointState)
    names = bytearray(of_message(message(['ab', 'c'])))
    names[names.index(b'ab')] = 0xFF
    form = JointStateForm(plain(bytes(names)), ['c'])
    np.testing.assert_array_equal(form.read(plain(bytes(names)))[1], [[1.0], [11.0], [21.0]])
