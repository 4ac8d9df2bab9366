# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What python-can says of a bus in trouble."""

from __future__ import annotations

import errno

import can
import pytest

from sosml_friction.actuators.bus.cycle import (
    BusTrouble,
    bus_trouble,
    is_transmit_full,
    trouble_names,
)


@pytest.mark.parametrize(
    ('error', 'full'),
    [
        # python-can 4.3.1 and 4.6.1: the select before the send times out, no errno.
        (can.CanOperationError('Transmit buffer full'), True),
        (can.CanOperationError('Failed to transmit: No buffer space', errno.ENOBUFS), True),
        (OSError(errno.ENOBUFS, 'No buffer space available'), True),
        (BlockingIOError(errno.EAGAIN, 'Resource temporarily unavailable'), True),
        (OSError(errno.ENODEV, 'No such device'), False),
        (OSError(errno.ENETDOWN, 'Network is down'), False),
        (can.CanOperationError('Failed to transmit: No such device', errno.ENODEV), False),
        (can.CanOperationError('adapter gone'), False),
    ],
)
def test_a_full_transmit_buffer_is_told_from_a_lost_bus_in_both_forms(error, full):
    assert is_transmit_full(error) is full


@pytest.mark.parametrize(
    ('identifier', 'trouble', 'words'),
    [
        (0x040, BusTrouble.BUS_OFF, 'bus off'),
        (0x100, BusTrouble.RESTARTED, 'restarted'),
        (
            0x0A8,
            BusTrouble.PROTOCOL | BusTrouble.NOT_ACKNOWLEDGED | BusTrouble.BUS_ERROR,
            'protocol, not acknowledged, bus error',
        ),
    ],
)
def test_an_error_frame_is_a_set_of_troubles(identifier, trouble, words):
    frame = can.Message(arbitration_id=identifier, is_error_frame=True, dlc=8, data=bytes(8))
    found = bus_trouble(frame)
    assert found == trouble
    assert trouble_names(found) == words


def test_a_data_frame_is_no_trouble():
    assert not bus_trouble(can.Message(arbitration_id=0x040, data=bytes(8)))
    assert trouble_names(BusTrouble(0)) == 'none'
