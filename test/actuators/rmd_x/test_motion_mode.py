# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The motion mode of the RMD-X, packed in bits, with the ranges of two generations of firmware."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.rmd_x.motion_mode import (
    MotionCommand,
    MotionRanges,
    decode_motion_command,
    decode_motion_state,
    encode_motion_command,
    encode_motion_state,
)
from sosml_friction.actuators.rmd_x.protocol import Protocol
from sosml_friction.exceptions import CanProtocolError

OLD = MotionRanges.of(Protocol.V3)
NEW = MotionRanges.of(Protocol.V4_4, 60.0)


def test_the_manuals_command_is_decoded_as_it_says():
    frame = Frame(0x401, bytes.fromhex('E6 66 82 E0 52 33 3B 55'))
    motor, command = decode_motion_command(frame, OLD)
    assert motor == 1
    # Its figures are rounded to two digits.
    assert command.position == pytest.approx(10.00, abs=0.005)
    assert command.velocity == pytest.approx(1.02, abs=0.005)
    assert command.kp == pytest.approx(10.01, abs=0.005)
    assert command.kd == pytest.approx(1.0, abs=0.005)
    assert command.torque == pytest.approx(10.004, abs=0.0005)
    assert encode_motion_command(1, command, OLD) == frame


def test_the_manuals_reply_is_decoded_as_it_says():
    frame = Frame(0x501, bytes.fromhex('01 E6 65 82 EB 55 00 00'))
    motor, state = decode_motion_state(frame, OLD)
    assert motor == 1
    assert round((state.position + 12.5) / 25 * 65535) == 0xE665
    assert round((state.velocity + 45) / 90 * 4095) == 0x82E
    assert round((state.torque + 24) / 48 * 4095) == 0xB55
    assert encode_motion_state(1, state, OLD) == frame


@pytest.mark.parametrize(('ranges', 'torque'), [(OLD, 1.0), (NEW, 2.5)])
def test_the_same_bytes_are_another_torque_with_other_ranges(ranges, torque):
    """The sheet's trap: 1 Nm at +-24 is 2.5 Nm at +-60."""
    frame = Frame(0x401, bytes.fromhex('7F FF 7F F0 00 00 08 54'))
    found = decode_motion_command(frame, ranges)[1].torque
    # The sheet's encoder truncates: one count.
    assert found == pytest.approx(torque, abs=2.0 * ranges.torque / 4095)


def test_nothing_is_half_a_count_beside_zero():
    """The sheet's encoder truncates (7FF), this one rounds to even: either is half a count off."""
    command = MotionCommand(0.0, 0.0, 0.0, 0.0, 0.0)
    decoded = decode_motion_command(encode_motion_command(1, command, OLD), OLD)[1]
    assert abs(decoded.torque) == pytest.approx(24.0 / 4095)
    assert abs(decoded.position) == pytest.approx(12.5 / 65535)
    assert (decoded.kp, decoded.kd) == (0.0, 0.0)
    truncated = Frame(0x401, bytes.fromhex('7F FF 7F F0 00 00 07 FF'))
    assert decode_motion_command(truncated, OLD)[1].torque == pytest.approx(-24.0 / 4095)


def test_the_ranges_of_both_generations():
    assert (OLD.position, OLD.velocity, OLD.kp, OLD.kd, OLD.torque) == (12.5, 45, 500, 5, 24)
    assert (NEW.position, NEW.velocity, NEW.kp, NEW.kd, NEW.torque) == (12.566, 45, 500, 50, 60)
    assert MotionRanges.of(Protocol.V4_2) == OLD
    with pytest.raises(CanProtocolError, match='greatest torque'):
        MotionRanges.of(Protocol.V4_4)


@given(st.sampled_from([OLD, NEW]), st.integers(1, 32), st.binary(min_size=8, max_size=8))
def test_commands_round_trip_over_their_whole_range(ranges, motor, data):
    frame = Frame(0x400 + motor, data)
    assert encode_motion_command(*decode_motion_command(frame, ranges), ranges) == frame


@given(st.sampled_from([OLD, NEW]), st.integers(1, 32), st.binary(min_size=5, max_size=5))
def test_states_round_trip_over_their_whole_range(ranges, motor, data):
    frame = Frame(0x500 + motor, bytes([motor]) + data + b'\0\0')
    assert encode_motion_state(*decode_motion_state(frame, ranges), ranges) == frame


@given(st.tuples(*(st.floats() for _ in range(5))))
def test_values_saturate_or_are_refused(values):
    command = MotionCommand(*values)
    if not all(math.isfinite(value) for value in values):
        with pytest.raises(CanProtocolError, match='not finite'):
            encode_motion_command(1, command, OLD)
        return
    decoded = decode_motion_command(encode_motion_command(1, command, OLD), OLD)[1]
    assert abs(decoded.torque) <= 24.0
    # Rounding is half a count off at most; the slack is for the arithmetic in doubles.
    wanted = min(max(values[4], -24.0), 24.0)
    assert decoded.torque == pytest.approx(wanted, abs=24.0 / 4095 + 1e-12)
    assert decoded.kd == pytest.approx(min(max(values[3], 0.0), 5.0), abs=2.5 / 4095 + 1e-12)


@given(
    st.one_of(st.integers(0, 0x7FF), st.integers(0x3FE, 0x422), st.integers(0x4FE, 0x522)),
    st.one_of(st.binary(max_size=8), st.binary(min_size=8, max_size=8)),
)
def test_garbage_is_a_value_or_a_protocol_error(can_id, data):
    """A value of eight bytes in its own range of identifiers only."""
    for decode, base in ((decode_motion_command, 0x400), (decode_motion_state, 0x500)):
        try:
            motor, _ = decode(Frame(can_id, data), OLD)
        except CanProtocolError:
            # Any other exception fails the test.
            continue
        assert 1 <= motor == can_id - base <= 32
        assert len(data) == 8
