# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The words of the RMD-X protocol: its commands, error bits, modes and variants."""

from __future__ import annotations

from enum import Enum, IntEnum, IntFlag

from sosml_friction.exceptions import CanProtocolError


class Command(IntEnum):
    """Byte 0 of a frame."""

    ENCODER = 0x60
    RESET = 0x76
    BRAKE_RELEASE = 0x77
    BRAKE_LOCK = 0x78
    SHUTDOWN = 0x80
    STOP = 0x81
    ANGLE = 0x92
    STATUS = 0x9A
    MOTION = 0x9C
    CURRENT = 0xA1
    SPEED = 0xA2
    POSITION = 0xA4
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
    """Which of its loops the motor runs."""

    CURRENT = 1
    SPEED = 2
    POSITION = 3


# The first firmware that was seen with the ranges of V4.4: its date with two digits of build
# number, as newer firmware gives it.
_V4_4_FROM = 20260424_02


class Protocol(Enum):
    """
    A layout of frames.

    ``V3``: V3.x to V4.3, which differ only in gains, not used here. ``V4_4``: the MOS temperature
    in 0x9A and the model in blocks of five characters.
    """

    V3 = 'V3.x to V4.3'
    V4_4 = 'V4.4'

    @classmethod
    def of_version(cls, date: int) -> Protocol:
        """
        Return the variant of firmware ``date``, 20220206 or 2026042402.

        :raises CanProtocolError: if that is no date.
        """
        number = date * 100 if date < 10**8 else date
        year, month, day = number // 10**6, number // 10**4 % 100, number // 100 % 100
        if not (2010 <= year <= 2099 and 1 <= month <= 12 and 1 <= day <= 31):
            raise CanProtocolError(
                f'the firmware version {date} is no date like 20220206 or 2026042402: the layout '
                'of its frames is not known'
            )
        return cls.V4_4 if number >= _V4_4_FROM else cls.V3
