# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The words of the RMD-X protocol: its commands, error bits, modes and indices."""

from __future__ import annotations

from enum import IntEnum, IntFlag


class Command(IntEnum):
    """Byte 0 of a frame."""

    FUNCTION = 0x20
    READ_GAINS = 0x30
    GAINS_TO_RAM = 0x31
    GAINS_TO_ROM = 0x32
    READ_ACCELERATION = 0x42
    ACCELERATION_TO_ROM = 0x43
    ENCODER = 0x60
    ENCODER_RAW = 0x61
    ENCODER_OFFSET = 0x62
    ENCODER_OFFSET_TO_ROM = 0x63
    ENCODER_ZERO_TO_ROM = 0x64
    MODE = 0x70
    POWER = 0x71
    RESET = 0x76
    BRAKE_RELEASE = 0x77
    BRAKE_LOCK = 0x78
    SHUTDOWN = 0x80
    STOP = 0x81
    SINGLE_TURN_ENCODER = 0x90
    ANGLE = 0x92
    SINGLE_TURN_ANGLE = 0x94
    STATUS = 0x9A
    MOTION = 0x9C
    PHASE_CURRENTS = 0x9D
    CURRENT = 0xA1
    SPEED = 0xA2
    POSITION = 0xA4
    SINGLE_TURN_POSITION = 0xA6
    INCREMENT = 0xA8
    UPTIME = 0xB1
    VERSION = 0xB2
    TIMEOUT = 0xB3
    BITRATE = 0xB4
    MODEL = 0xB5
    ACTIVE_REPLY = 0xB6
    TIMEOUT_EXPIRED = 0xF1


MOTION_COMMANDS = (
    Command.MOTION,
    Command.CURRENT,
    Command.SPEED,
    Command.POSITION,
    Command.INCREMENT,
)
"""Commands answered by :class:`Motion`."""

ENCODER_COMMANDS = (
    Command.ENCODER,
    Command.ENCODER_RAW,
    Command.ENCODER_OFFSET,
    Command.ENCODER_OFFSET_TO_ROM,
    Command.ENCODER_ZERO_TO_ROM,
)
"""Commands answered by :class:`Encoder`."""


class ErrorFlag(IntFlag):
    """Bits of the error word; several may be set, and bits of other firmware are kept."""

    STALL = 0x0002
    UNDER_VOLTAGE = 0x0004
    OVER_VOLTAGE = 0x0008
    OVER_CURRENT = 0x0010
    POWER_OVERRUN = 0x0040
    CALIBRATION_WRITE = 0x0080
    OVER_SPEED = 0x0100
    BOARD_OVER_TEMPERATURE = 0x0800
    MOTOR_OVER_TEMPERATURE = 0x1000
    ENCODER_CALIBRATION = 0x2000
    ENCODER_DATA = 0x4000


def flag_names(word: int) -> str:
    """Return the set bits as words, ``unknown 0x..`` for bits without a name, ``none`` for 0."""
    names = [flag.name.lower() for flag in ErrorFlag if word & flag and flag.name]
    unknown = word & ~sum(ErrorFlag)
    if unknown:
        names.append(f'unknown {unknown:#06x}')
    return ', '.join(names) or 'none'


class ControlMode(IntEnum):
    """Which of its loops the motor runs (0x70)."""

    CURRENT = 1
    SPEED = 2
    POSITION = 3


class FunctionIndex(IntEnum):
    """What 0x20 sets."""

    CLEAR_MULTI_TURN = 1
    ID_FILTER = 2
    REPORT_ERRORS = 3
    SAVE_MULTI_TURN = 4
    SET_ID = 5
    POSITION_MAX = 6
    POSITION_MIN = 7


class AccelerationIndex(IntEnum):
    """Which acceleration 0x42 and 0x43 are about."""

    POSITION_ACCELERATION = 0
    POSITION_DECELERATION = 1
    SPEED_ACCELERATION = 2
    SPEED_DECELERATION = 3


class GainIndex(IntEnum):
    """Which gain 0x30 to 0x32 are about since V4.2."""

    CURRENT_KP = 1
    CURRENT_KI = 2
    SPEED_KP = 4
    SPEED_KI = 5
    POSITION_KP = 7
    POSITION_KI = 8
    POSITION_KD = 9
