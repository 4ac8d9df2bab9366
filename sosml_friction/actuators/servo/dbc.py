# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The servo bridge's protocol, read from a DBC file: bytes to physical values and back, no input.

``config/elbow_servo.dbc`` is the default and documents sign and unit of every signal. Another DBC
fits when it has messages ``servo_command`` and ``servo_state`` with the signals and units of
:data:`COMMAND_SIGNALS` and :data:`STATE_SIGNALS`; identifiers, scales and places are its own, and
names too where a map says so.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum, IntFlag
from pathlib import Path
from typing import Any

import cantools

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.exceptions import CanProtocolError, ConfigurationError

COMMAND_SIGNALS = {'mode': '', 'sequence': '', 'target_position': 'rad', 'target_current': 'A'}
STATE_SIGNALS = {
    'position': 'rad',
    'velocity': 'rad/s',
    'current': 'A',
    'status': '',
    'sequence_echo': '',
}


class Mode(IntEnum):
    """What the bridge is asked to do."""

    OFF = 0
    POSITION = 1
    CURRENT = 2


class ServoFlag(IntFlag):
    """Bits of ``status``."""

    OUTPUT_ON = 1
    WATCHDOG = 2
    UNDER_VOLTAGE = 4
    OVER_TEMPERATURE = 8
    POSITION_SENSOR = 16


def flag_names(status: ServoFlag) -> str:
    """Return the bits of a bridge's status as words, 'none' for none."""
    names = [flag.name.lower() for flag in ServoFlag if status & flag and flag.name]
    return ', '.join(names) or 'none'


SERVO_FAULTS = ServoFlag.UNDER_VOLTAGE | ServoFlag.OVER_TEMPERATURE | ServoFlag.POSITION_SENSOR


@dataclass(frozen=True)
class ServoCommand:
    """
    Hold one command.

    ``target``: position [rad] in mode POSITION, current [A] in mode CURRENT, not sent in mode OFF.
    """

    mode: Mode
    sequence: int
    target: float = 0.0


@dataclass(frozen=True)
class ServoState:
    """
    Hold one state, in the servo's own direction.

    ``position`` [rad], ``velocity`` [rad/s], ``current`` [A] or NaN where it is not measured.
    """

    position: float
    velocity: float
    current: float
    status: ServoFlag
    sequence_echo: int


class ServoDbc:
    """
    Encode and decode the two messages of a servo bridge.

    ``position_resolution`` [rad]: the least difference of position that the state can tell;
    ``sequence_count``: how many sequence numbers there are before they wrap.

    :param path: the DBC file.
    :param names: what the file calls things, as ``ours=theirs``: ``servo_state=STATE_1`` for a
        message, ``servo_state.position=Pos`` for a signal.
    :raises ConfigurationError: if it cannot be read, lacks a message, a signal or a unit, or a
        name of the map is none of ours.
    """

    def __init__(self, path: str | Path, names: Sequence[str] = ()) -> None:
        try:
            database = cantools.database.load_file(str(path), database_format='dbc')
        except (OSError, UnicodeDecodeError) as error:
            raise ConfigurationError(f'the DBC {path} cannot be read: {error}') from error
        except Exception as error:  # cantools and its parser have no common root
            reason = ' '.join(str(error).split())
            raise ConfigurationError(f'{path} is not a DBC file: {reason}') from error
        self.path = str(path)
        self._names = _parse_map(names)
        self._signals: dict[str, Any] = {}
        self._theirs: dict[str, str] = {}
        self._command = self._message(database, 'servo_command', COMMAND_SIGNALS)
        self._state = self._message(database, 'servo_state', STATE_SIGNALS)
        signals = self._signals
        self.command_id, self.state_id = int(self._command.frame_id), int(self._state.frame_id)
        self.position_resolution = abs(float(signals['position'].scale))
        self.sequence_count = 1 << min(signals[x].length for x in ('sequence', 'sequence_echo'))
        self._unavailable = -(1 << (signals['current'].length - 1))

    def _message(self, database: Any, ours: str, signals: Mapping[str, str]) -> Any:
        name = self._names.get(ours, ours)
        try:
            message = database.get_message_by_name(name)
        except KeyError as error:
            raise ConfigurationError(
                f'the DBC {self.path} has no message {name}: add it or give another DBC'
            ) from error
        if message.is_extended_frame:
            raise ConfigurationError(
                f'message {name} of the DBC {self.path} has a 29-bit identifier: give it 11 bits'
            )
        present = {signal.name: signal for signal in message.signals}
        for signal, unit in signals.items():
            theirs = self._names.get(f'{ours}.{signal}', signal)
            if theirs not in present:
                raise ConfigurationError(
                    f'message {name} of the DBC {self.path} has no signal {theirs}: add it'
                )
            found = present[theirs].unit or ''
            if found != unit:
                raise ConfigurationError(
                    f'signal {theirs} of message {name} in the DBC {self.path} has the unit '
                    f'{found!r}: it must be {unit!r}'
                )
            scale, offset = map(_finite_or_inf, (present[theirs].scale, present[theirs].offset))
            size = abs(scale) * 2.0 ** present[theirs].length
            if present[theirs].is_float or not (scale and math.isfinite(size + abs(offset))):
                raise ConfigurationError(
                    f'signal {theirs} of message {name} in the DBC {self.path} has the scale '
                    f'{scale:g} and the offset {offset:g}: give an integer signal a scale that is '
                    'not 0, and both finite'
                )
            self._signals[signal] = present[theirs]
            self._theirs[signal] = theirs
        return message

    def encode_command(self, command: ServoCommand) -> Frame:
        """
        Return the command's frame; the target is rounded to the nearest count and saturated.

        :raises CanProtocolError: if the target is not finite.
        """
        values = {'mode': int(command.mode), 'sequence': command.sequence % self.sequence_count}
        if command.mode is not Mode.OFF:
            name = 'target_position' if command.mode is Mode.POSITION else 'target_current'
            values[name] = self._counts(name, command.target)
        return Frame(self.command_id, self._encode(self._command, values))

    def decode_command(self, frame: Frame) -> ServoCommand:
        """
        Return the command in a frame.

        :raises CanProtocolError: if it is not ``servo_command``, too short or of an unknown mode.
        """
        values = self._decode(self._command, frame)
        if values['mode'] not in list(Mode):
            raise CanProtocolError(f'frame {frame} asks for the unknown mode {values["mode"]}')
        mode = Mode(values['mode'])
        target = 0.0
        if mode is not Mode.OFF:
            name = 'target_position' if mode is Mode.POSITION else 'target_current'
            target = self._value(name, values[name])
        return ServoCommand(mode, values['sequence'], target)

    def encode_state(self, state: ServoState) -> Frame:
        """
        Return the state's frame; a NaN current is sent as "not available".

        :raises CanProtocolError: if position or velocity is not finite.
        """
        values = {
            'position': self._counts('position', state.position),
            'velocity': self._counts('velocity', state.velocity),
            'status': int(state.status) & 0xFF,
            'sequence_echo': state.sequence_echo % self.sequence_count,
        }
        if math.isnan(state.current):
            values['current'] = self._unavailable
        else:
            # The lowest count is taken: it says "not available".
            values['current'] = max(self._counts('current', state.current), self._unavailable + 1)
        return Frame(self.state_id, self._encode(self._state, values))

    def decode_state(self, frame: Frame) -> ServoState:
        """
        Return the state in a frame.

        :raises CanProtocolError: if it is not ``servo_state`` or too short.
        """
        values = self._decode(self._state, frame)
        current = math.nan
        if values['current'] != self._unavailable:
            current = self._value('current', values['current'])
        return ServoState(
            position=self._value('position', values['position']),
            velocity=self._value('velocity', values['velocity']),
            current=current,
            status=ServoFlag(values['status']),
            sequence_echo=values['sequence_echo'],
        )

    def _encode(self, message: Any, values: Mapping[str, Any]) -> bytes:
        theirs = {self._theirs[name]: value for name, value in values.items()}
        try:
            return bytes(message.encode(theirs, scaling=False, padding=False, strict=False))
        except (cantools.database.Error, ValueError, KeyError) as error:
            raise CanProtocolError(
                f'{message.name} cannot be encoded: {" ".join(str(error).split())}'
            ) from error

    def _decode(self, message: Any, frame: Frame) -> dict[str, int]:
        if frame.can_id != message.frame_id or len(frame.data) != message.length:
            raise CanProtocolError(
                f'frame {frame} is not {message.name}, {message.frame_id:#05x} with '
                f'{message.length} bytes'
            )
        try:
            values = message.decode(frame.data, decode_choices=False, scaling=False)
            ours = COMMAND_SIGNALS if message is self._command else STATE_SIGNALS
            # Of a multiplexed command only the signals of its mode are there.
            return {name: values[t] for name in ours if (t := self._theirs[name]) in values}
        except (cantools.database.Error, ValueError, KeyError) as error:
            raise CanProtocolError(
                f'frame {frame} is no valid {message.name}: {" ".join(str(error).split())}'
            ) from error

    def _value(self, name: str, raw: int) -> float:
        return float(self._signals[name].conversion.raw_to_scaled(raw, decode_choices=False))

    def _counts(self, name: str, value: float) -> int:
        signal = self._signals[name]
        counts = (value - signal.offset) / signal.scale
        if not math.isfinite(counts):
            raise CanProtocolError(f'{name} {value} cannot be sent: it is not finite')
        half = 1 << (signal.length - 1)
        low, high = (-half, half - 1) if signal.is_signed else (0, 2 * half - 1)
        return min(max(round(counts), low), high)


def _finite_or_inf(number: float) -> float:
    """Return a number of a DBC, whose whole ones may be larger than a double can be."""
    try:
        return float(number)
    except OverflowError:
        return math.inf


def _parse_map(names: Sequence[str]) -> dict[str, str]:
    known = {
        f'{message}{"." if signal else ""}{signal}'
        for message, signals in (
            ('servo_command', COMMAND_SIGNALS),
            ('servo_state', STATE_SIGNALS),
        )
        for signal in ('', *signals)
    }
    result: dict[str, str] = {}
    for entry in names:
        ours, _, theirs = entry.partition('=')
        if ours.strip() not in known or not theirs.strip():
            raise ConfigurationError(
                f'{entry!r} in dbc_map is not OURS=THEIRS: OURS must be one of '
                f'{", ".join(sorted(known))}'
            )
        result[ours.strip()] = theirs.strip()
    return result
