# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Reading and writing the identifier of an RMD-X on 0x300."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.rmd_x.identifier import MotorId, ReadId, SetId, decode_id, encode_id
from sosml_friction.exceptions import CanProtocolError


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('79 00 00 00 00 00 00 02', SetId(2)),
        ('79 00 01 00 00 00 42 02', MotorId(2)),
        ('79 00 01 00 00 00 00 00', ReadId()),
    ],
)
def test_published_frames_pass_both_ways(text, message):
    frame = Frame(0x300, bytes.fromhex(text))
    assert encode_id(message) == frame
    assert decode_id(frame) == message


@given(st.integers(1, 32))
def test_every_id_round_trips(motor):
    for message in (SetId(motor), MotorId(motor)):
        assert decode_id(encode_id(message)) == message


@pytest.mark.parametrize('motor', [0, 33])
def test_an_id_no_motor_has_is_refused(motor):
    with pytest.raises(CanProtocolError, match='between 1 and 32'):
        encode_id(SetId(motor))


@given(
    st.sampled_from([0x300, 0x141]),
    st.one_of(st.binary(max_size=8), st.binary(min_size=7, max_size=7).map(lambda x: b'\x79' + x)),
)
def test_garbage_is_a_value_or_a_protocol_error(can_id, data):
    try:
        message = decode_id(Frame(can_id, data))
    except CanProtocolError:
        # Any other exception fails the test.
        return
    assert (can_id, data[0]) == (0x300, 0x79)
    assert decode_id(encode_id(message)) == message


@given(st.integers(0, 1), st.integers(0, 255), st.integers(0, 2**16 - 1))
def test_only_ids_a_motor_can_have_are_taken(read, motor, number):
    """Writing: byte 7 is the id; reading: bytes 6 and 7 are 0x240 and the id, or nothing yet."""
    data = bytearray(8)
    data[0], data[2] = 0x79, read
    data[6:] = number.to_bytes(2, 'little') if read else bytes([0, motor])
    own = number - 0x240 if read else motor
    frame = Frame(0x300, bytes(data))
    if read and number == 0:
        assert decode_id(frame) == ReadId()
    elif 1 <= own <= 32:
        assert decode_id(frame) == (MotorId(own) if read else SetId(own))
    else:
        with pytest.raises(CanProtocolError, match='between 1 and 32'):
            decode_id(frame)
