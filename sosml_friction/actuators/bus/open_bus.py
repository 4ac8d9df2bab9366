# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Open any python-can interface by name, with one sentence when that fails."""

import os
import socket
from typing import Any

import can

from sosml_friction.actuators.bus.slcan_client import SlcanClient
from sosml_friction.actuators.bus.slcan_pty import PTY_PREFIX, SlcanPtyBus
from sosml_friction.actuators.bus.slcan_server import SlcanServerBus
from sosml_friction.exceptions import ActuatorError, ConfigurationError

SLCAN_SERVER = 'slcan_server'


def open_bus(interface: str, channel: str, bitrate: int) -> can.BusABC:
    """
    Open a CAN bus; a ConfigurationError or an ActuatorError says why it cannot be.

    :param interface: a python-can interface (``socketcan``, ``slcan``, ``virtual``,
        ``udp_multicast``, ``pcan``, ...) or ``slcan_server``, the adapter's end of slcan on TCP.
    :param channel: as that interface wants it: ``can0``, ``/dev/ttyACM0@1000000``,
        ``socket://127.0.0.1:29536``, ``127.0.0.1:29536`` or ``pty:/tmp/can`` for
        ``slcan_server``.
    :param bitrate: bit/s, set where the interface can.
    """
    arguments: dict[str, Any] = {'channel': channel, 'bitrate': bitrate}
    try:
        if interface == SLCAN_SERVER:
            return (SlcanPtyBus if channel.startswith(PTY_PREFIX) else SlcanServerBus)(channel)
        if interface == 'slcan':
            if not channel.startswith('socket://'):
                # A USB adapter may reset when it is opened: python-can's own pause stays.
                return SlcanClient(**arguments)
            bus = SlcanClient(sleep_after_open=0.0, **arguments)
            _send_at_once(bus)
            return bus
        if interface in ('virtual', 'udp_multicast', 'socketcand'):
            del arguments['bitrate']
        if interface == 'udp_multicast':
            # What moves a joint is not for the network: by default it would leave this machine.
            arguments['hop_limit'] = 0
        return can.Bus(interface=interface, **arguments)
    except can.CanInterfaceNotImplementedError as error:
        raise ConfigurationError(
            f'CAN interface {interface!r} cannot be used: {_one_line(error)}'
        ) from error
    except (can.CanError, ValueError, TypeError, OSError, NotImplementedError) as error:
        raise ActuatorError(
            f'CAN interface {interface} on {channel} cannot be opened: {_one_line(error)}'
        ) from error


def _send_at_once(bus: SlcanClient) -> None:
    """Keep TCP from holding a frame back until the one before is acknowledged."""
    with socket.socket(fileno=os.dup(bus.serialPortOrig.fileno())) as connection:
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)


def _one_line(error: Exception) -> str:
    return ' '.join(str(error).split())
