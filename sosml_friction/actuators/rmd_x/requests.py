# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What an RMD-X can be asked and told, and what it echoes."""

from __future__ import annotations

import math
from typing import Annotated

from sosml_friction.actuators.rmd_x import layout as wire
from sosml_friction.actuators.rmd_x.commands import Command
from sosml_friction.actuators.rmd_x.message import Message, bare, by_command, by_protocol
from sosml_friction.exceptions import CanProtocolError

# ---- commands without a payload; those the motor echoes are also its replies

Shutdown = bare('Shutdown', Command.SHUTDOWN)
"""0x80: output off, the joint is free; the motor echoes it."""
Stop = bare('Stop', Command.STOP)
"""0x81: speed to zero, the motor's own loop holds; the motor echoes it."""
ReleaseBrake = bare('ReleaseBrake', Command.BRAKE_RELEASE)
"""0x77: open the brake; echoed, which can take 150 ms."""
LockBrake = bare('LockBrake', Command.BRAKE_LOCK)
"""0x78: close the brake; echoed, which can take 150 ms."""
Reset = bare('Reset', Command.RESET)
"""0x76: reboot. Not answered; the motor is away for about 1.1 s."""
ReadAngle = bare('ReadAngle', Command.ANGLE)
"""0x92: ask for the multi-turn angle."""
ReadSingleTurnAngle = bare('ReadSingleTurnAngle', Command.SINGLE_TURN_ANGLE)
"""0x94: ask for the angle within one turn."""
ReadEncoder = bare('ReadEncoder', Command.ENCODER)
"""0x60: ask for the encoder's position minus its zero."""
ReadEncoderRaw = bare('ReadEncoderRaw', Command.ENCODER_RAW)
"""0x61: ask for the encoder's raw position."""
ReadEncoderOffset = bare('ReadEncoderOffset', Command.ENCODER_OFFSET)
"""0x62: ask for the encoder's zero."""
SetZeroHere = bare('SetZeroHere', Command.ENCODER_ZERO_TO_ROM)
"""0x64: write the present position to ROM as zero; effective after :class:`Reset`."""
ReadSingleTurnEncoder = bare('ReadSingleTurnEncoder', Command.SINGLE_TURN_ENCODER)
"""0x90: ask a direct-drive motor for its encoder."""
ReadStatus = bare('ReadStatus', Command.STATUS)
"""0x9A: ask for temperature, voltage and errors."""
ReadMotion = bare('ReadMotion', Command.MOTION)
"""0x9C: ask for current, speed and angle without changing the mode."""
ReadPhaseCurrents = bare('ReadPhaseCurrents', Command.PHASE_CURRENTS)
"""0x9D: ask for the currents of the phases."""
ReadMode = bare('ReadMode', Command.MODE)
"""0x70: ask which loop runs."""
ReadPower = bare('ReadPower', Command.POWER)
"""0x71: ask for the electrical power (V3; gone from V4.2)."""
ReadUptime = bare('ReadUptime', Command.UPTIME)
"""0xB1: ask how long the motor has been on."""
ReadVersion = bare('ReadVersion', Command.VERSION)
"""0xB2: ask for the firmware's date."""
ReadGains = bare('ReadGains', Command.READ_GAINS)
"""0x30 up to V4.1: ask for the gains of all loops; answered by :class:`Gains`."""


class ReadModel(Message, command=Command.MODEL, places='BxB5x'):
    """0xB5: ask for the model; since V4.4 for one ``block`` of it, 1 to 3, else ``block`` 0."""

    block: Annotated[int, wire.whole('block')] = 0

    def pack(self) -> bytes:
        """Return ``B5``, or ``B5 01 block``."""
        data = bytearray(super().pack())
        data[1] = self.block != 0
        return bytes(data)

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return the block asked for."""
        return super().unpack(data) if data[1] == 1 else cls()


# ---- commands with a payload


class SetCurrent(Message, command=Command.CURRENT, places='B3xh2x'):
    """0xA1: command the torque-producing current [A]; answered by :class:`Motion`."""

    current: Annotated[float, wire.CURRENT]


class SetSpeed(Message, command=Command.SPEED, places='B3xi'):
    """0xA2: command the speed of the output shaft [rad/s]; answered by :class:`Motion`."""

    speed: Annotated[float, wire.ANGLE]


class SetPosition(
    Message, command=Command.POSITION, places='BxHi', sequence=('max_speed', 'angle')
):
    """
    0xA4: command the multi-turn ``angle`` [rad] with ``max_speed`` [rad/s] on the way.

    Answered by :class:`Motion`. A speed of 0 means "no limit" to the motor: one below 1 degree/s
    is sent as 1 degree/s, and 0 itself is refused.
    """

    angle: Annotated[float, wire.ANGLE]
    max_speed: Annotated[float, wire.MAX_SPEED]


class SetIncrement(SetPosition, command=Command.INCREMENT):
    """0xA8: as :class:`SetPosition`, ``angle`` counted from where the motor is."""


class SetSingleTurnPosition(
    Message,
    command=Command.SINGLE_TURN_POSITION,
    places='BBHH2x',
    sequence=('clockwise', 'max_speed', 'angle'),
):
    """
    0xA6: go to ``angle`` [rad] within one turn, 0 to 359.99 degrees, ``clockwise`` or not.

    Answered by :class:`SingleTurnMotion`; ``max_speed`` as in :class:`SetPosition`.
    """

    angle: Annotated[float, wire.ANGLE_IN_TURN]
    max_speed: Annotated[float, wire.MAX_SPEED]
    clockwise: Annotated[bool, wire.INVERSE_SWITCH] = True


class SetEncoderOffset(Message, command=Command.ENCODER_OFFSET_TO_ROM, places='B3xi'):
    """0x63: write the encoder's zero [counts] to ROM; answered by :class:`Encoder`."""

    counts: Annotated[int, wire.whole('encoder offset')]


class SetTimeout(Message, command=Command.TIMEOUT, places='B3xI'):
    """
    0xB3: the motor's watchdog [ms], 0 for off; echoed. Written to ROM: not at every start.

    On expiry the output goes off and the brake closes; with 0 the last command runs for ever.
    """

    milliseconds: Annotated[int, wire.whole('timeout')]


class SetBitrate(Message, command=Command.BITRATE, places='B6xB'):
    """0xB4: 500000 or 1000000 bit/s after the next power-up; the answer is to be ignored."""

    bitrate: Annotated[int, wire.BITRATE]


class SetActiveReply(Message, command=Command.ACTIVE_REPLY, places='BBBH3x'):
    """
    0xB6: let the motor send the reply to ``of`` by itself every ``period`` [s], 10 ms at least.

    Not answered. The motor then no longer answers requests for that reply.
    """

    of: Annotated[int, wire.whole('command')]
    enabled: Annotated[bool, wire.SWITCH]
    period: Annotated[float, wire.PERIOD]


class Function(Message, command=Command.FUNCTION, places='BB2xI'):
    """0x20: set function ``index`` (:class:`FunctionIndex`) to ``value``; echoed."""

    index: Annotated[int, wire.whole('index')]
    value: Annotated[int, wire.whole('value')]


class ReadAcceleration(Message, command=Command.READ_ACCELERATION, places='BB6x'):
    """0x42: ask for an acceleration; answered by :class:`Acceleration`."""

    index: Annotated[int, wire.whole('index')]


class Acceleration(Message, command=Command.READ_ACCELERATION, places='BB2xI'):
    """The reply to 0x42: ``acceleration`` [rad/s^2] number ``index``."""

    index: Annotated[int, wire.whole('index')]
    acceleration: Annotated[float, wire.DEGREES]


class SetAcceleration(Acceleration, command=Command.ACCELERATION_TO_ROM):
    """0x43: write an acceleration to ROM; echoed."""


class Gains(Message, command=Command.READ_GAINS, places='Bx6B'):
    """0x30 up to V4.1: the gains of all loops, 0 to 255 of the motor's own scale."""

    current_kp: Annotated[int, wire.whole('gain')]
    current_ki: Annotated[int, wire.whole('gain')]
    speed_kp: Annotated[int, wire.whole('gain')]
    speed_ki: Annotated[int, wire.whole('gain')]
    position_kp: Annotated[int, wire.whole('gain')]
    position_ki: Annotated[int, wire.whole('gain')]


class SetGains(Gains, command=Command.GAINS_TO_RAM):
    """0x31 up to V4.1: write the gains to RAM; echoed. Never while the motor moves."""


class StoreGains(Gains, command=Command.GAINS_TO_ROM):
    """0x32 up to V4.1: write the gains to ROM; echoed. Never while the motor moves."""


class ReadGain(Message, command=Command.READ_GAINS, places='BB6x'):
    """0x30 since V4.2: ask for one gain (:class:`GainIndex`); answered by :class:`Gain`."""

    index: Annotated[int, wire.whole('index')]


class Gain(Message, command=Command.READ_GAINS, places='BB2xf'):
    """0x30 since V4.2: one gain (:class:`GainIndex`), a float32."""

    index: Annotated[int, wire.whole('index')]
    value: Annotated[float, wire.FLOAT32]

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return index and value."""
        index, value = cls.layout.unpack(data).values()
        if not math.isfinite(value):
            raise CanProtocolError(f'gain {index} is {value}: it must be finite')
        return cls(index, value)


class SetGain(Gain, command=Command.GAINS_TO_RAM):
    """0x31 since V4.2: write one gain to RAM; echoed. Never while the motor moves."""


class StoreGain(Gain, command=Command.GAINS_TO_ROM):
    """0x32 since V4.2: write one gain to ROM; echoed. Never while the motor moves."""


ECHOED = (Shutdown, Stop, ReleaseBrake, LockBrake, SetTimeout, SetBitrate, Function)
"""What is answered by itself, whatever the firmware."""

_ONE_GAIN = (SetGain, StoreGain, ReadGain)

REQUESTS = by_protocol(
    by_command(
        *ECHOED, Reset, ReadAngle, ReadSingleTurnAngle, ReadEncoder, ReadEncoderRaw,
        ReadEncoderOffset, SetZeroHere, SetEncoderOffset, ReadSingleTurnEncoder, ReadStatus,
        ReadMotion, ReadPhaseCurrents, ReadMode, ReadPower, ReadUptime, ReadVersion, ReadModel,
        SetCurrent, SetSpeed, SetPosition, SetIncrement, SetSingleTurnPosition, SetActiveReply,
        ReadAcceleration, SetAcceleration,
    ),
    (SetGains, StoreGains, ReadGains),
    _ONE_GAIN,
    _ONE_GAIN,
)  # fmt: skip
