# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The adapter's end of slcan over TCP, for emulated actuators."""

import contextlib
import select
import socket
import time
from typing import Any

import can

from sosml_friction.actuators.bus.slcan_lines import SlcanLines

_OK = b'\r'
_VERSION = b'V1013\r'
_SERIAL_NUMBER = b'NEMUL\r'
_STATUS = b'F00\r'
# Bit 7: bus error, as CAN232 tells bus-off.
_BUS_ERROR = b'F80\r'


class SlcanServerBus(can.BusABC):
    """
    Listen on a TCP port and be the slcan adapter of the one client that connects.

    python-can's ``slcan`` interface with channel ``socket://127.0.0.1:PORT`` is the other end.
    Frames: t and T; commands: C, O, L, S, s, V, v, N, F, Z and what else a client sends are
    acknowledged and have no effect: there is no bit rate, no arbitration and no acknowledgement
    by other nodes here. An acknowledgement waits for the next frame sent or the next pause, as a
    USB adapter's packets do. Frames sent while no client has opened the channel are dropped, as
    on a bus without a listener. When the client goes, the next one is accepted.

    :attr:`fault` may be set to ``bus_off`` (frames are answered with a bell, the status F tells
    it, none passes), ``tx_full`` (nothing is read, so that the client's frames pile up in the
    line) or ``adapter_gone`` (the connection is closed and none accepted); '' for none.

    :param channel: ``HOST:PORT``; port 0 takes a free one, see :attr:`port`.
    :raises can.CanInitializationError: if the port cannot be listened on.
    """

    def __init__(self, channel: str = '127.0.0.1:29536', **kwargs: Any) -> None:
        self._listener: socket.socket | None = None
        #: A socket, or something like one.
        self._client: Any = None
        self._listen(str(channel))
        #: Whether a client has opened the channel.
        self.connected = False
        self._lines = SlcanLines()
        self._answers = b''
        self.malformed = 0
        self.fault = ''
        self._can_protocol = can.CanProtocol.CAN_20
        super().__init__(channel=channel, **kwargs)
        host = str(channel).rpartition(':')[0] or '127.0.0.1'
        self.channel_info = f'slcan server on {host}:{self.port}'

    def _listen(self, channel: str) -> None:
        host, _, port = channel.rpartition(':')
        try:
            self._listener = socket.create_server((host or '127.0.0.1', int(port)), backlog=1)
        except (OSError, ValueError, OverflowError) as error:
            raise can.CanInitializationError(
                f'cannot listen for slcan on {channel}: {error}'
            ) from error
        self._listener.setblocking(False)

    @property
    def port(self) -> int:
        """Return the port that is listened on, 0 for none."""
        return 0 if self._listener is None else int(self._listener.getsockname()[1])

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send a frame to the client, if there is one."""
        if self._client is None or not self.connected or self.fault:
            return
        identifier = (
            f'T{msg.arbitration_id:08X}' if msg.is_extended_id else (f't{msg.arbitration_id:03X}')
        )
        self._write(f'{identifier}{msg.dlc:d}{bytes(msg.data).hex().upper()}\r'.encode())

    def _write(self, data: bytes) -> None:
        data, self._answers = self._answers + data, b''
        try:
            if self._client is not None:
                self._client.sendall(data)
        except OSError:
            self._drop_client()

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        deadline = None if timeout is None else time.monotonic() + timeout
        while True:
            if self.fault in ('tx_full', 'adapter_gone'):
                if self.fault == 'adapter_gone':
                    self._drop_client()
                if timeout:
                    time.sleep(timeout)
                return None, False
            line = self._lines.pop()
            if line is not None:
                message = self._take(line)
                if message is not None:
                    return message, False
                continue
            wait = None if deadline is None else max(0.0, deadline - time.monotonic())
            if self._client is None and self._listener is None:
                self._accept()
            source: Any = self._client or self._listener
            ready, _, _ = select.select([source], [], [], wait)
            if not ready:
                if self._answers:
                    self._write(b'')
                return None, False
            if self._client is None:
                self._accept()
            else:
                self._read()

    def _accept(self) -> None:
        assert self._listener is not None
        with contextlib.suppress(BlockingIOError, ConnectionError):
            client, _ = self._listener.accept()
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            client.settimeout(1.0)
            self._client = client

    def _read(self) -> None:
        try:
            data = self._client.recv(4096)
        except BlockingIOError:
            return
        except OSError:
            data = b''
        if data:
            self._lines.feed(data)
        else:
            self._drop_client()

    def _drop_client(self) -> None:
        if self._client is not None:
            self._client.close()
        self._client = None
        self.connected = False
        self._answers = b''
        self._lines.clear()

    def _take(self, line: str) -> can.Message | None:
        command = line[:1]
        if command in ('t', 'T'):
            message = _parse(line) if self.connected else None
            if self.fault:
                message = None
                self._answers += b'\a'
            elif message is None:
                self.malformed += self.connected
                self._answers += b'\a'
            else:
                self._answers += b'z\r' if command == 't' else b'Z\r'
            return message
        if command == '':
            return None
        if command in ('O', 'L', 'C'):
            self.connected = command != 'C'
        status = _BUS_ERROR if self.fault else _STATUS
        answer = {'V': _VERSION, 'v': _VERSION, 'N': _SERIAL_NUMBER, 'F': status}
        self._write(answer.get(command, _OK))
        return None

    def shutdown(self) -> None:
        """Close the connection and the port."""
        super().shutdown()
        self._drop_client()
        if self._listener is not None:
            self._listener.close()


def _parse(line: str) -> can.Message | None:
    extended = line[0] == 'T'
    start = 9 if extended else 4
    try:
        identifier = int(line[1:start], 16)
        dlc = int(line[start])
        data = bytes.fromhex(line[start + 1 :])
    except (ValueError, IndexError):
        return None
    if len(data) != dlc or dlc > 8 or identifier > (0x1FFFFFFF if extended else 0x7FF):
        return None
    return can.Message(
        timestamp=time.time(),
        arbitration_id=identifier,
        is_extended_id=extended,
        dlc=dlc,
        data=data,
    )
