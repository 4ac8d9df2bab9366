# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The RMD-X codec: published vectors both ways, round trips, saturation, garbage."""

from __future__ import annotations

import contextlib
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sosml_friction.actuators import rmd_x
from sosml_friction.actuators.frame import Frame
from sosml_friction.exceptions import CanProtocolError

E = rmd_x.ErrorFlag
REQUESTS = [
    ('A1 00 00 00 64 00 00 00', rmd_x.SetCurrent(1.0)),
    ('A1 00 00 00 9C FF 00 00', rmd_x.SetCurrent(-1.0)),
    ('92 00 00 00 00 00 00 00', rmd_x.ReadAngle()),
    ('9A 00 00 00 00 00 00 00', rmd_x.ReadStatus()),
    ('B2 00 00 00 00 00 00 00', rmd_x.ReadVersion()),
    ('80 00 00 00 00 00 00 00', rmd_x.Shutdown()),
    ('81 00 00 00 00 00 00 00', rmd_x.Stop()),
]
REPLIES = [
    ('A1 32 64 00 F4 01 2D 00', rmd_x.Motion(50, 1.0, math.radians(500), math.radians(45))),
    ('A1 32 9C FF 0C FE D3 FF', rmd_x.Motion(50, -1.0, math.radians(-500), math.radians(-45))),
    ('92 00 00 00 A0 8C 00 00', rmd_x.Angle(math.radians(360))),
    ('92 00 00 00 60 73 FF FF', rmd_x.Angle(math.radians(-360))),
    ('9A 32 00 01 E5 01 04 00', rmd_x.Status(50, True, 48.5, E.UNDER_VOLTAGE)),
    ('B2 00 00 00 2E 89 34 01', rmd_x.Version(20220206)),
    ('80 00 00 00 00 00 00 00', rmd_x.Shutdown()),
    ('81 00 00 00 00 00 00 00', rmd_x.Stop()),
]


@pytest.mark.parametrize(('text', 'request_'), REQUESTS)
def test_published_requests_pass_both_ways(text, request_):
    frame = Frame(0x141, bytes.fromhex(text))
    assert rmd_x.encode_request(1, request_) == frame
    assert rmd_x.decode_request(frame) == (1, request_)


@pytest.mark.parametrize(('text', 'reply'), REPLIES)
def test_published_replies_pass_both_ways(text, reply):
    frame = Frame(0x241, bytes.fromhex(text))
    assert rmd_x.encode_reply(1, reply) == frame
    motor, decoded = rmd_x.decode_reply(frame)
    assert motor == 1
    assert type(decoded) is type(reply)
    for key, value in vars(reply).items():
        assert float(getattr(decoded, key)) == pytest.approx(float(value), abs=1e-12)


def test_the_error_word_of_the_manual_is_a_set_of_flags():
    frame = Frame(0x241, bytes.fromhex('9A 19 00 00 E0 01 16 00'))
    assert rmd_x.decode_reply(frame)[1].errors == E.STALL | E.UNDER_VOLTAGE | E.OVER_CURRENT
    assert rmd_x.flag_names(0x0016) == 'stall, under_voltage, over_current'
    assert rmd_x.flag_names(0) == 'none'
    assert rmd_x.flag_names(0x8002) == 'stall, unknown 0x8000'


@given(st.integers(1, 32), st.integers(-(2**15), 2**15 - 1))
def test_current_round_trips_over_its_whole_range(motor, counts):
    frame = rmd_x.encode_request(motor, rmd_x.SetCurrent(counts / 100.0))
    got_motor, request = rmd_x.decode_request(frame)
    assert (got_motor, round(request.current * 100)) == (motor, counts)
    assert rmd_x.encode_request(motor, request) == frame


@given(st.integers(1, 32), st.integers(-(2**31), 2**31 - 1))
def test_angle_round_trips_over_its_whole_range(motor, counts):
    frame = rmd_x.encode_reply(motor, rmd_x.Angle(counts * rmd_x.ANGLE_RESOLUTION))
    assert int.from_bytes(frame.data[4:8], 'little', signed=True) == counts
    assert rmd_x.encode_reply(*rmd_x.decode_reply(frame)) == frame


@given(
    st.integers(-128, 127),
    *(st.integers(-(2**15), 2**15 - 1) for _ in range(3)),
)
def test_motion_round_trips_over_its_whole_range(temperature, current, speed, angle):
    reply = rmd_x.Motion(temperature, current / 100, math.radians(speed), math.radians(angle))
    frame = rmd_x.encode_reply(5, reply)
    assert rmd_x.encode_reply(*rmd_x.decode_reply(frame)) == frame


@given(st.integers(-128, 127), st.booleans(), st.integers(0, 2**16 - 1), st.integers(0, 2**16 - 1))
def test_status_round_trips_over_its_whole_range(temperature, released, voltage, errors):
    reply = rmd_x.Status(temperature, released, voltage / 10, E(errors))
    frame = rmd_x.encode_reply(32, reply)
    assert rmd_x.encode_reply(*rmd_x.decode_reply(frame)) == frame
    assert int(rmd_x.decode_reply(frame)[1].errors) == errors


@given(st.integers(0, 2**32 - 1))
def test_version_round_trips_over_its_whole_range(date):
    frame = rmd_x.encode_reply(1, rmd_x.Version(date))
    assert rmd_x.decode_reply(frame) == (1, rmd_x.Version(date))


@given(st.floats(-327.0, 327.0))
def test_current_is_rounded_to_the_nearest_count(current):
    _, request = rmd_x.decode_request(rmd_x.encode_request(1, rmd_x.SetCurrent(current)))
    assert abs(request.current - current) <= 0.005 + 1e-9


def test_rounding_is_to_nearest_not_toward_zero():
    frame = rmd_x.encode_request(1, rmd_x.SetCurrent(1.159))
    assert rmd_x.decode_request(frame)[1].current == 1.16


@pytest.mark.parametrize(('current', 'counts'), [(1e6, 32767), (-1e6, -32768)])
def test_current_saturates(current, counts):
    frame = rmd_x.encode_request(1, rmd_x.SetCurrent(current))
    assert int.from_bytes(frame.data[4:6], 'little', signed=True) == counts


@pytest.mark.parametrize('value', [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_never_sent(value):
    with pytest.raises(CanProtocolError, match='not finite'):
        rmd_x.encode_request(1, rmd_x.SetCurrent(value))
    with pytest.raises(CanProtocolError, match='not finite'):
        rmd_x.encode_reply(1, rmd_x.Angle(value))


@pytest.mark.parametrize('motor', [0, 33, -1])
def test_an_id_outside_1_to_32_is_refused(motor):
    with pytest.raises(CanProtocolError, match='between 1 and 32'):
        rmd_x.encode_request(motor, rmd_x.ReadAngle())


@given(st.integers(0, 0x7FF), st.binary(max_size=8))
def test_garbage_is_a_value_or_a_protocol_error(can_id, data):
    for decode in (rmd_x.decode_request, rmd_x.decode_reply):
        with contextlib.suppress(CanProtocolError):
            decode(Frame(can_id, data))


@given(st.sampled_from([0x141, 0x241]), st.binary(min_size=8, max_size=8))
def test_garbage_on_a_motors_own_identifier_is_a_value_or_a_protocol_error(can_id, data):
    decode = rmd_x.decode_request if can_id == 0x141 else rmd_x.decode_reply
    known = {int(command) for command in rmd_x.Command}
    if data[0] in known:
        assert decode(Frame(can_id, data))[0] == 1
    else:
        with pytest.raises(CanProtocolError, match='unknown command'):
            decode(Frame(can_id, data))
