# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What an RMD-X can be asked and told, and what it echoes."""

from typing import Annotated

from sosml_friction.actuators.rmd_x import layout as wire
from sosml_friction.actuators.rmd_x.commands import Command
from sosml_friction.actuators.rmd_x.message import Message, bare, by_command

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


class SetTimeout(Message, command=Command.TIMEOUT, places='B3xI'):
    """
    0xB3: the motor's watchdog [ms], 0 for off; echoed. Written to ROM: not at every start.

    On expiry the output goes off and the brake closes; with 0 the last command runs for ever.
    """

    milliseconds: Annotated[int, wire.whole('timeout')]


ECHOED = (Shutdown, Stop, ReleaseBrake, LockBrake, SetTimeout)
"""What is answered by itself."""

REQUESTS = by_command(
    *ECHOED, Reset, ReadAngle, ReadSingleTurnAngle, ReadEncoder, ReadStatus, ReadMotion,
    ReadPhaseCurrents, ReadMode, ReadPower, ReadUptime, ReadVersion, ReadModel, SetCurrent,
    SetSpeed, SetPosition, SetIncrement,
)  # fmt: skip
