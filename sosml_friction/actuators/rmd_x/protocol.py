# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Which variant of the RMD-X protocol a motor speaks, by the date its firmware gives (0xB2)."""

from __future__ import annotations

from enum import Enum

from sosml_friction.exceptions import CanProtocolError

# Dates with two digits of build number, as newer firmware gives them. V4.2 by the date of its
# manual (2024-05); V4.4 by the first firmware that was seen with its ranges.
_V4_2_FROM = 20240501_00
_V4_4_FROM = 20260424_02


class Protocol(Enum):
    """
    A layout of frames.

    ``V3``: V3.x to V4.1. ``V4_2``: V4.2 and V4.3, which differ from it only in gains, not used
    here. ``V4_4``: the MOS temperature in 0x9A and the model in blocks of five characters.
    """

    V3 = 'V3.x to V4.1'
    V4_2 = 'V4.2 and V4.3'
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
        if number >= _V4_4_FROM:
            return cls.V4_4
        return cls.V4_2 if number >= _V4_2_FROM else cls.V3
