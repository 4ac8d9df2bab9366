# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The adapter's end of slcan on a pseudo-terminal, as a USB adapter's /dev/ttyACM0 looks."""

import contextlib
import os
import tty
from pathlib import Path
from typing import Any

import can

from sosml_friction.actuators.bus.slcan_server import SlcanServerBus

PTY_PREFIX = 'pty:'


class PtyEnd:
    """
    The adapter's side of a pseudo-terminal, used like a socket.

    The other side is held open here too: a client may come and go as at a serial port. What it
    does not read is lost when the line's buffer is full.
    """

    def __init__(self) -> None:
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.name = os.ttyname(self._slave)

    def fileno(self) -> int:
        """Return the descriptor to wait on."""
        return self._master

    def recv(self, size: int) -> bytes:
        """Return what the client wrote."""
        return os.read(self._master, size)

    def sendall(self, data: bytes) -> None:
        """Write to the client."""
        with contextlib.suppress(BlockingIOError):
            os.write(self._master, data)

    def close(self) -> None:
        """Hang up."""
        os.close(self._master)
        os.close(self._slave)


class SlcanPtyBus(SlcanServerBus):
    """
    Be the slcan adapter at a pseudo-terminal; see :class:`SlcanServerBus` for all else.

    python-can's ``slcan`` interface with the path of ``channel``, ``pty:PATH``, is the other end.
    PATH becomes a link to the terminal and is removed at the end.
    """

    def __init__(self, channel: str, **kwargs: Any) -> None:
        self._path = Path(str(channel).removeprefix(PTY_PREFIX))
        try:
            end = self._plug_in()
        except OSError as error:
            raise can.CanInitializationError(
                f'cannot make the terminal {self._path}: {error.strerror}'
            ) from error
        super().__init__(channel, **kwargs)
        self._client = end
        self.channel_info = f'slcan adapter at {self._path}'

    def _plug_in(self) -> PtyEnd:
        end = PtyEnd()
        try:
            self._path.symlink_to(end.name)
        except OSError:
            end.close()
            raise
        return end

    def _listen(self, channel: str) -> None:
        """Have no port: a terminal is simply there."""

    def _accept(self) -> None:
        self._client = self._plug_in()

    def _drop_client(self) -> None:
        if self._client is not None:
            self._path.unlink(missing_ok=True)
        super()._drop_client()
