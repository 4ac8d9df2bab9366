# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The servo bridge's codec and the check of its DBC."""

from __future__ import annotations

import contextlib
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.servo.dbc import Mode, ServoCommand, ServoDbc, ServoFlag, ServoState
from sosml_friction.exceptions import CanProtocolError, ConfigurationError
from sosml_friction.share import share_directory

PATH = share_directory() / 'config' / 'elbow_servo.dbc'
DBC = ServoDbc(PATH)
COUNTS = st.integers(-(2**15), 2**15 - 1)
BYTE = st.integers(0, 255)


def test_the_published_state_passes_both_ways():
    frame = Frame(0x171, bytes.fromhex('1D 18 0C FE EE 02 01 07'))
    state = DBC.decode_state(frame)
    assert state.position == pytest.approx(1.2346)
    assert (state.velocity, state.current) == (pytest.approx(-0.5), pytest.approx(0.75))
    assert (state.status, state.sequence_echo) == (ServoFlag.OUTPUT_ON, 7)
    assert DBC.encode_state(ServoState(1.2346, -0.5, 0.75, ServoFlag.OUTPUT_ON, 7)) == frame


@pytest.mark.parametrize(
    ('text', 'command'),
    [
        ('00 07 00 00 00 00 00 00', ServoCommand(Mode.OFF, 7)),
        ('01 08 88 13 00 00 00 00', ServoCommand(Mode.POSITION, 8, 1.0)),
        ('02 FF 18 FC 00 00 00 00', ServoCommand(Mode.CURRENT, 255, -1.0)),
    ],
)
def test_commands_have_the_layout_of_the_facts_sheet(text, command):
    frame = Frame(0x170, bytes.fromhex(text))
    assert DBC.encode_command(command) == frame
    decoded = DBC.decode_command(frame)
    assert (decoded.mode, decoded.sequence) == (command.mode, command.sequence)
    assert decoded.target == pytest.approx(command.target)


@given(COUNTS, COUNTS, st.integers(-(2**15) + 1, 2**15 - 1), BYTE, BYTE)
def test_state_round_trips_over_its_whole_range(position, velocity, current, status, echo):
    state = ServoState(
        position * 0.0002, velocity * 0.001, current * 0.001, ServoFlag(status), echo
    )
    frame = DBC.encode_state(state)
    assert [int.from_bytes(frame.data[i : i + 2], 'little', signed=True) for i in (0, 2, 4)] == [
        position,
        velocity,
        current,
    ]
    assert DBC.encode_state(DBC.decode_state(frame)) == frame


@given(st.sampled_from([Mode.POSITION, Mode.CURRENT]), BYTE, COUNTS)
def test_command_round_trips_over_its_whole_range(mode, sequence, counts):
    scale = 0.0002 if mode is Mode.POSITION else 0.001
    frame = DBC.encode_command(ServoCommand(mode, sequence, counts * scale))
    assert int.from_bytes(frame.data[2:4], 'little', signed=True) == counts
    assert DBC.encode_command(DBC.decode_command(frame)) == frame


def test_a_current_that_is_not_measured_is_nan_both_ways():
    frame = DBC.encode_state(ServoState(0.0, 0.0, math.nan, ServoFlag(0), 0))
    assert frame.data[4:6] == b'\x00\x80'
    assert math.isnan(DBC.decode_state(frame).current)


def test_a_great_negative_current_does_not_become_not_available():
    frame = DBC.encode_state(ServoState(0.0, 0.0, -1e9, ServoFlag(0), 0))
    assert DBC.decode_state(frame).current == pytest.approx(-32.767)


def test_targets_saturate_and_are_rounded_to_nearest():
    frame = DBC.encode_command(ServoCommand(Mode.POSITION, 0, 1e9))
    assert DBC.decode_command(frame).target == pytest.approx(32767 * 0.0002)
    frame = DBC.encode_command(ServoCommand(Mode.POSITION, 0, 0.00019))
    assert DBC.decode_command(frame).target == pytest.approx(0.0002)


@pytest.mark.parametrize('value', [math.nan, math.inf])
def test_what_is_not_finite_is_never_sent(value):
    with pytest.raises(CanProtocolError, match='not finite'):
        DBC.encode_command(ServoCommand(Mode.POSITION, 0, value))


@given(st.sampled_from([0x170, 0x171, 0x141]), st.binary(max_size=8))
def test_garbage_is_a_value_or_a_protocol_error(can_id, data):
    for decode in (DBC.decode_command, DBC.decode_state):
        with contextlib.suppress(CanProtocolError):
            decode(Frame(can_id, data))


def test_an_unknown_mode_is_a_protocol_error():
    with pytest.raises(CanProtocolError):
        DBC.decode_command(Frame(0x170, bytes([3, 0, 0, 0, 0, 0, 0, 0])))


@pytest.mark.parametrize(
    ('old', 'new', 'sentence'),
    [
        ('"rad/s"', '"deg/s"', "signal velocity .* has the unit 'deg/s': it must be 'rad/s'"),
        ('SG_ current ', 'SG_ amps ', 'has no signal current'),
        ('servo_state:', 'state:', 'has no message servo_state'),
        ('BO_ 368 ', 'BO_ 2147484016 ', '29-bit identifier'),
        ('(0.001,0)', '(0,0)', 'has the scale 0 and the offset 0: give an integer signal a scale'),
        ('(0.001,0)', f'(0.001,{"9" * 400})', 'has the scale 0.001 and the offset inf: give an'),
    ],
)
def test_a_dbc_that_does_not_fit_is_refused_in_one_sentence(tmp_path, old, new, sentence):
    text = PATH.read_text()
    keep = [line for line in text.splitlines() if not line.startswith(('CM_', 'VAL_'))]
    file = tmp_path / 'other.dbc'
    file.write_text('\n'.join(keep).replace(old, new) + '\n')
    with pytest.raises(ConfigurationError, match=sentence):
        ServoDbc(file)


def test_another_layout_with_the_same_signals_is_taken(tmp_path):
    file = tmp_path / 'other.dbc'
    file.write_text(PATH.read_text().replace('(0.0002,0)', '(0.0001,0)').replace('368', '290'))
    other = ServoDbc(file)
    assert other.command_id == 290
    frame = other.encode_command(ServoCommand(Mode.POSITION, 1, 1.0))
    assert int.from_bytes(frame.data[2:4], 'little') == 10000


RENAMED = (
    'servo_command=EB_CMD',
    'servo_state=EB_STATE',
    'servo_command.target_position=PosRef',
    'servo_state.position=PosAct',
    'servo_state.sequence_echo=Ctr',
)


@pytest.fixture
def renamed(tmp_path):
    """Return the shipped DBC under the names another bridge gives the same things."""
    text = PATH.read_text()
    for ours, theirs in (
        ('servo_command', 'EB_CMD'),
        ('servo_state', 'EB_STATE'),
        ('target_position', 'PosRef'),
        ('sequence_echo', 'Ctr'),
        (' position ', ' PosAct '),
    ):
        text = text.replace(ours, theirs)
    file = tmp_path / 'renamed.dbc'
    file.write_text(text)
    return file


def test_another_bridges_names_are_mapped_to_ours(renamed):
    other = ServoDbc(renamed, RENAMED)
    command = ServoCommand(Mode.POSITION, 8, 1.0)
    assert other.encode_command(command) == DBC.encode_command(command)
    assert other.decode_command(DBC.encode_command(command)).target == pytest.approx(1.0)
    frame = Frame(0x171, bytes.fromhex('1D 18 0C FE EE 02 01 07'))
    assert other.decode_state(frame) == DBC.decode_state(frame)
    assert other.encode_state(other.decode_state(frame)) == frame


def test_without_the_map_the_name_that_is_missing_is_told(renamed):
    with pytest.raises(ConfigurationError, match='has no message servo_command'):
        ServoDbc(renamed)
    with pytest.raises(ConfigurationError, match='has no signal position'):
        ServoDbc(renamed, [entry for entry in RENAMED if 'PosAct' not in entry])


@pytest.mark.parametrize(
    'entry', ['speed=Speed', 'servo_state.position', 'servo_state.angle=A', '']
)
def test_a_map_of_what_does_not_exist_is_refused_with_what_does(entry):
    with pytest.raises(ConfigurationError, match=r'servo_state\.position') as caught:
        ServoDbc(PATH, [entry])
    assert repr(entry) in str(caught.value)


@pytest.mark.parametrize('content', [None, 'this is no DBC', '\x00\x01'])
def test_a_file_that_is_no_dbc_is_refused_in_one_sentence(tmp_path, content):
    file = tmp_path / 'broken.dbc'
    if content is not None:
        file.write_text(content)
    with pytest.raises(ConfigurationError) as caught:
        ServoDbc(file)
    assert str(file) in str(caught.value)
    assert '\n' not in str(caught.value)
