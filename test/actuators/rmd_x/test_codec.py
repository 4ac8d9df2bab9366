# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The RMD-X codec: published vectors both ways, round trips, saturation, garbage."""

from __future__ import annotations

import contextlib
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.rmd_x import codec as rmd_x
from sosml_friction.actuators.rmd_x.commands import Protocol
from sosml_friction.exceptions import CanProtocolError

C, E = rmd_x.Command, rmd_x.ErrorFlag
V3, V4_4 = Protocol.V3, Protocol.V4_4
DEGREE = math.radians(1.0)

# 1.6 of the facts sheet, and the layouts of its 1.2 where it prints no vector.
REQUESTS = [
    ('A1 00 00 00 64 00 00 00', rmd_x.SetCurrent(1.0)),
    ('A1 00 00 00 9C FF 00 00', rmd_x.SetCurrent(-1.0)),
    ('A2 00 00 00 10 27 00 00', rmd_x.SetSpeed(100 * DEGREE)),
    ('A2 00 00 00 F0 D8 FF FF', rmd_x.SetSpeed(-100 * DEGREE)),
    ('A4 00 F4 01 A0 8C 00 00', rmd_x.SetPosition(360 * DEGREE, 500 * DEGREE)),
    ('A4 00 F4 01 60 73 FF FF', rmd_x.SetPosition(-360 * DEGREE, 500 * DEGREE)),
    ('92 00 00 00 00 00 00 00', rmd_x.ReadAngle()),
    ('9A 00 00 00 00 00 00 00', rmd_x.ReadStatus()),
    ('9C 00 00 00 00 00 00 00', rmd_x.ReadMotion()),
    ('60 00 00 00 00 00 00 00', rmd_x.ReadEncoder()),
    ('76 00 00 00 00 00 00 00', rmd_x.Reset()),
    ('77 00 00 00 00 00 00 00', rmd_x.ReleaseBrake()),
    ('78 00 00 00 00 00 00 00', rmd_x.LockBrake()),
    ('80 00 00 00 00 00 00 00', rmd_x.Shutdown()),
    ('81 00 00 00 00 00 00 00', rmd_x.Stop()),
    ('B1 00 00 00 00 00 00 00', rmd_x.ReadUptime()),
    ('B2 00 00 00 00 00 00 00', rmd_x.ReadVersion()),
    ('B3 00 00 00 E8 03 00 00', rmd_x.SetTimeout(1000)),
]
REPLIES = [
    *(
        (f'{of:02X} {values}', rmd_x.Motion(50, i, v * DEGREE, q * DEGREE, C(of)))
        for of in (0x9C, 0xA1, 0xA2, 0xA4)
        for values, i, v, q in (
            ('32 64 00 F4 01 2D 00', 1.0, 500, 45),
            ('32 9C FF 0C FE D3 FF', -1.0, -500, -45),
        )
    ),
    ('60 00 00 00 10 27 00 00', rmd_x.Encoder(10000)),
    ('92 00 00 00 A0 8C 00 00', rmd_x.Angle(360 * DEGREE)),
    ('92 00 00 00 60 73 FF FF', rmd_x.Angle(-360 * DEGREE)),
    ('9A 32 00 01 E5 01 04 00', rmd_x.Status(50, True, 48.5, E.UNDER_VOLTAGE)),
    ('77 00 00 00 00 00 00 00', rmd_x.ReleaseBrake()),
    ('80 00 00 00 00 00 00 00', rmd_x.Shutdown()),
    ('81 00 00 00 00 00 00 00', rmd_x.Stop()),
    ('B1 00 00 00 00 00 00 10', rmd_x.Uptime(268435456)),
    ('B2 00 00 00 2E 89 34 01', rmd_x.Version(20220206)),
    ('B3 00 00 00 E8 03 00 00', rmd_x.SetTimeout(1000)),
    ('B5 58 38 53 32 56 31 30', rmd_x.Model('X8S2V10')),
    ('F1 00 00 00 00 00 00 00', rmd_x.TimeoutExpired()),
]
REPLIES_BY_PROTOCOL = [
    ('B5 01 02 50 32 30 2D 36', rmd_x.ModelBlock(2, 'P20-6'), V4_4),
    ('9A 32 28 01 E5 01 04 00', rmd_x.Status(50, True, 48.5, E.UNDER_VOLTAGE, 40), V4_4),
]


def same(decoded, expected):
    assert type(decoded) is type(expected)
    for key, value in vars(expected).items():
        found = getattr(decoded, key)
        if isinstance(value, float):
            assert found == pytest.approx(value, abs=1e-12)
        else:
            assert found == value


@pytest.mark.parametrize(('text', 'request_'), REQUESTS)
def test_published_requests_pass_both_ways(text, request_):
    frame = Frame(0x141, bytes.fromhex(text))
    assert rmd_x.encode_request(1, request_) == frame
    motor, decoded = rmd_x.decode_request(frame)
    assert motor == 1
    same(decoded, request_)


@pytest.mark.parametrize(
    ('text', 'reply', 'protocol'), [*((*row, V3) for row in REPLIES), *REPLIES_BY_PROTOCOL]
)
def test_published_replies_pass_both_ways(text, reply, protocol):
    frame = Frame(0x241, bytes.fromhex(text))
    assert rmd_x.encode_reply(1, reply, protocol) == frame
    motor, decoded = rmd_x.decode_reply(frame, protocol)
    assert motor == 1
    same(decoded, reply)


def test_every_command_byte_has_its_vector():
    """None is coded without having been held against the sheet."""
    seen = {int(row[0][:2], 16) for row in (*REQUESTS, *REPLIES, *REPLIES_BY_PROTOCOL)}
    assert seen == {int(command) for command in C}


@pytest.mark.parametrize('protocol', list(Protocol))
def test_what_does_not_depend_on_the_firmware_is_the_same_in_all(protocol):
    for text, reply in REPLIES:
        if not isinstance(reply, rmd_x.Model):
            frame = Frame(0x241, bytes.fromhex(text))
            same(rmd_x.decode_reply(frame, protocol)[1], reply)


def test_a_reply_is_no_request_and_that_of_another_firmware_no_reply():
    with pytest.raises(CanProtocolError, match='Motion is no request'):
        rmd_x.encode_request(1, rmd_x.Motion(1, 0.0, 0.0, 0.0))
    for reply, protocol in ((rmd_x.Model('X8'), V4_4), (rmd_x.ModelBlock(1, 'X8'), V3)):
        with pytest.raises(CanProtocolError, match=f'is no reply of {protocol.value}'):
            rmd_x.encode_reply(1, reply, protocol)


def test_what_is_said_to_all_is_answered_by_each():
    frame = Frame(0x280, bytes.fromhex('80 00 00 00 00 00 00 00'))
    assert rmd_x.decode_request(frame) == (0, rmd_x.Shutdown())
    assert rmd_x.decode_reply(Frame(0x242, frame.data)) == (2, rmd_x.Shutdown())


def test_the_error_word_of_the_manual_is_a_set_of_flags():
    frame = Frame(0x241, bytes.fromhex('9A 19 00 00 E0 01 16 00'))
    assert rmd_x.decode_reply(frame)[1].errors == E.STALL | E.UNDER_VOLTAGE | E.OVER_CURRENT
    assert rmd_x.flag_names(0x0016) == 'stall, under_voltage, over_current'
    assert rmd_x.flag_names(0) == 'none'
    assert rmd_x.flag_names(0x8002) == 'stall, unknown 0x8000'


# ---- round trips over everything the wire can carry: bytes -> value -> bytes

I16 = st.integers(-(2**15), 2**15 - 1)
I32 = st.integers(-(2**31), 2**31 - 1)
U8, U16, U32 = (st.integers(0, 2**bits - 1) for bits in (8, 16, 32))


@given(st.integers(1, 32), I16)
def test_current_round_trips_over_its_whole_range(motor, counts):
    frame = rmd_x.encode_request(motor, rmd_x.SetCurrent(counts / 100.0))
    got_motor, request = rmd_x.decode_request(frame)
    assert (got_motor, round(request.current * 100)) == (motor, counts)
    assert rmd_x.encode_request(motor, request) == frame


@given(I32, U16)
def test_speed_and_position_commands_round_trip_over_their_whole_range(counts, speed):
    for message in (
        rmd_x.SetSpeed(counts * rmd_x.ANGLE_RESOLUTION),
        rmd_x.SetPosition(counts * rmd_x.ANGLE_RESOLUTION, max(speed, 1) * DEGREE),
    ):
        frame = rmd_x.encode_request(7, message)
        assert int.from_bytes(frame.data[4:8], 'little', signed=True) == counts
        assert rmd_x.encode_request(*rmd_x.decode_request(frame)) == frame


@given(st.integers(1, 32), I32)
def test_angle_round_trips_over_its_whole_range(motor, counts):
    frame = rmd_x.encode_reply(motor, rmd_x.Angle(counts * rmd_x.ANGLE_RESOLUTION))
    assert int.from_bytes(frame.data[4:8], 'little', signed=True) == counts
    assert rmd_x.encode_reply(*rmd_x.decode_reply(frame)) == frame


@given(
    st.sampled_from(list(Protocol)), st.sampled_from(list(C)), st.binary(min_size=7, max_size=7)
)
def test_whatever_decodes_says_the_same_when_it_is_sent_again(protocol, command, rest):
    """For requests and replies of every command: decode, encode, decode is decode."""
    data = bytes([command]) + rest
    for base, decode, encode, firmware in (
        (0x140, rmd_x.decode_request, rmd_x.encode_request, ()),
        (0x240, rmd_x.decode_reply, rmd_x.encode_reply, (protocol,)),
    ):
        try:
            motor, message = decode(Frame(base + 3, data), *firmware)
        except CanProtocolError:
            continue
        if getattr(message, 'max_speed', 0.0) == math.inf:
            # "No limit" is understood and never sent.
            with pytest.raises(CanProtocolError):
                encode(motor, message)
            continue
        again = encode(motor, message, *firmware)
        assert decode(again, *firmware) == (motor, message)


# ---- saturation, rounding, refusal


def test_values_saturate_at_what_the_wire_carries_and_are_rounded_to_nearest():
    assert rmd_x.encode_request(1, rmd_x.SetCurrent(1e9)).data[4:6] == b'\xff\x7f'
    assert rmd_x.encode_request(1, rmd_x.SetCurrent(-1e9)).data[4:6] == b'\x00\x80'
    # The SDK truncates 1.159 A to 115 counts.
    assert rmd_x.encode_request(1, rmd_x.SetCurrent(1.159)).data[4:6] == b'\x74\x00'
    assert rmd_x.encode_request(1, rmd_x.SetSpeed(1e9)).data[4:8] == b'\xff\xff\xff\x7f'
    assert rmd_x.encode_reply(1, rmd_x.Angle(-1e9)).data[4:8] == b'\x00\x00\x00\x80'
    motion = rmd_x.encode_reply(1, rmd_x.Motion(1000, 1e9, -1e9, 1e9))
    assert motion.data == bytes.fromhex('A1 7F FF 7F 00 80 FF 7F')
    status = rmd_x.encode_reply(1, rmd_x.Status(-1000, False, 1e9, E(0)))
    assert status.data == bytes.fromhex('9A 80 00 00 FF FF 00 00')


def test_a_small_speed_limit_does_not_become_no_limit():
    frame = rmd_x.encode_request(1, rmd_x.SetPosition(1.0, 0.1 * DEGREE))
    assert frame.data[2:4] == b'\x01\x00'
    for speed in (0.0, -1.0, math.nan):
        with pytest.raises(CanProtocolError, match='must be positive'):
            rmd_x.encode_request(1, rmd_x.SetPosition(1.0, speed))


@pytest.mark.parametrize('value', [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize(
    'make',
    [
        rmd_x.SetCurrent,
        rmd_x.SetSpeed,
        lambda x: rmd_x.SetPosition(x, 1.0),
    ],
)
def test_what_is_not_finite_is_never_sent(make, value):
    with pytest.raises(CanProtocolError):
        rmd_x.encode_request(1, make(value))


@pytest.mark.parametrize('milliseconds', [-1, 2**32])
def test_a_setting_that_does_not_fit_is_refused_and_not_saturated(milliseconds):
    with pytest.raises(CanProtocolError, match='cannot be s'):
        rmd_x.encode_request(1, rmd_x.SetTimeout(milliseconds))


@pytest.mark.parametrize('value', [math.nan, math.inf])
def test_an_angle_that_is_not_finite_is_never_sent(value):
    with pytest.raises(CanProtocolError, match='not finite'):
        rmd_x.encode_reply(1, rmd_x.Angle(value))


@pytest.mark.parametrize('motor', [0, 33, -1])
def test_an_id_outside_1_to_32_is_refused(motor):
    with pytest.raises(CanProtocolError, match='between 1 and 32'):
        rmd_x.encode_request(motor, rmd_x.ReadAngle())


# ---- garbage


@given(
    st.sampled_from(list(Protocol)),
    st.one_of(st.integers(0, 0x7FF), st.sampled_from([0x141, 0x160, 0x241, 0x260, 0x280])),
    st.binary(max_size=8),
)
def test_garbage_is_a_value_or_a_protocol_error(protocol, can_id, data):
    frame = Frame(can_id, data)
    # Any other exception fails the test.
    with contextlib.suppress(CanProtocolError):
        assert 0 <= rmd_x.decode_request(frame)[0] <= 32
    with contextlib.suppress(CanProtocolError):
        assert 1 <= rmd_x.decode_reply(frame, protocol)[0] <= 32


@given(st.integers(0, 255), st.binary(min_size=7, max_size=7))
def test_eight_bytes_of_a_known_command_are_a_value(command, rest):
    """Those whose every payload has a meaning: no measurement is ever refused."""
    frame = Frame(0x241, bytes([command]) + rest)
    always = {*rmd_x.MOTION_COMMANDS, C.ENCODER, C.ANGLE, C.STATUS, C.UPTIME}
    if command in always:
        assert rmd_x.decode_reply(frame)[0] == 1
    elif command not in set(C):
        with pytest.raises(CanProtocolError, match='unknown command'):
            rmd_x.decode_reply(frame)


@pytest.mark.parametrize(
    ('text', 'protocol', 'sentence'),
    [
        ('B5 FF FF FF FF FF FF FF', V3, 'is no text'),
    ],
)
def test_a_reply_that_means_nothing_is_refused(text, protocol, sentence):
    with pytest.raises(CanProtocolError, match=sentence):
        rmd_x.decode_reply(Frame(0x241, bytes.fromhex(text)), protocol)


@pytest.mark.parametrize(
    ('text', 'sentence'),
    [
        ('A3 00 00 00 00 00 00 00', 'unknown command 0xa3'),
    ],
)
def test_a_request_that_means_nothing_is_refused(text, sentence):
    with pytest.raises(CanProtocolError, match=sentence):
        rmd_x.decode_request(Frame(0x141, bytes.fromhex(text)))


# ---- the variants


@pytest.mark.parametrize(
    ('date', 'protocol'),
    [
        (20180101, V3),
        (20220206, V3),
        (20240430, V3),
        (20240501, V3),
        (2024050100, V3),
        (2026042401, V3),
        (2026042402, V4_4),
        (20260425, V4_4),
    ],
)
def test_the_firmwares_date_tells_the_layout(date, protocol):
    assert Protocol.of_version(date) is protocol


@pytest.mark.parametrize('date', [0, 1, 20221306, 20220200, 2**32 - 1, 99999999])
def test_a_version_that_is_no_date_is_refused(date):
    with pytest.raises(CanProtocolError, match='is no date'):
        Protocol.of_version(date)
