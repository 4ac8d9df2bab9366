# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Any python-can interface by name, with what it needs and nothing it does not take."""

from __future__ import annotations

import can
import pytest

from sosml_friction.actuators.bus.open_bus import open_bus
from sosml_friction.exceptions import ActuatorError, ConfigurationError


@pytest.fixture
def opened(monkeypatch):
    """Note what python-can is asked to open, and open nothing."""
    calls = []

    def bus(**arguments):
        calls.append(arguments)

    monkeypatch.setattr(can, 'Bus', bus)
    return calls


@pytest.mark.parametrize('interface', ['socketcan', 'pcan', 'gs_usb', 'somebody_elses'])
def test_an_interface_gets_channel_and_bit_rate(opened, interface):
    open_bus(interface, 'can0', 1_000_000)
    assert opened == [{'interface': interface, 'channel': 'can0', 'bitrate': 1_000_000}]


def test_frames_over_udp_do_not_leave_the_machine(opened):
    """They move a joint; python-can's default sends them to the whole network segment."""
    open_bus('udp_multicast', '239.74.163.2', 1_000_000)
    assert opened == [{'interface': 'udp_multicast', 'channel': '239.74.163.2', 'hop_limit': 0}]


@pytest.mark.parametrize(
    ('error', 'kind'),
    [
        (can.CanInterfaceNotImplementedError('no such interface'), ConfigurationError),
        (can.CanInitializationError('no such device'), ActuatorError),
        (OSError(97, 'Address family not supported by protocol'), ActuatorError),
        (TypeError('unexpected keyword'), ActuatorError),
    ],
)
def test_what_cannot_be_opened_is_one_sentence_with_interface_and_reason(monkeypatch, error, kind):
    def bus(**_):
        raise error

    monkeypatch.setattr(can, 'Bus', bus)
    with pytest.raises(kind) as caught:
        open_bus('socketcan', 'can0', 1_000_000)
    text = str(caught.value)
    assert 'socketcan' in text
    assert str(error).split('] ')[-1] in text
    assert '\n' not in text
