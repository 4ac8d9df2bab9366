# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The words of the RMD-X protocol: its commands, error bits and modes."""

from enum import IntEnum, IntFlag


class Command(IntEnum):
    """Byte 0 of a frame."""

    ENCODER = 0x60
    MODE = 0x70
    POWER = 0x71
    RESET = 0x76
    BRAKE_RELEASE = 0x77
    BRAKE_LOCK = 0x78
    SHUTDOWN = 0x80
    STOP = 0x81
    ANGLE = 0x92
    SINGLE_TURN_ANGLE = 0x94
    STATUS = 0x9A
    MOTION = 0x9C
    PHASE_CURRENTS = 0x9D
    CURRENT = 0xA1
    SPEED = 0xA2
    POSITION = 0xA4
    INCREMENT = 0xA8
    UPTIME = 0xB1
    VERSION = 0xB2
    TIMEOUT = 0xB3
    MODEL = 0xB5
    TIMEOUT_EXPIRED = 0xF1


MOTION_COMMANDS = (
    Command.MOTION,
    Command.CURRENT,
    Command.SPEED,
    Command.POSITION,
    Command.INCREMENT,
)
"""Commands answered by :class:`Motion`."""


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
