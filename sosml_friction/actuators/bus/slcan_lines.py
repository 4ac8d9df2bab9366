# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Cut a stream of bytes into the lines of the slcan protocol."""

from collections import deque

_END = b'\r'
_BELL = b'\a'
# The longest line of classic CAN is 27 characters; what grows beyond this has no line end.
_LONGEST = 4096


class SlcanLines:
    """Collect bytes and hand out whole lines without their end; a bell ends a line as well."""

    def __init__(self) -> None:
        self._rest = b''
        self._lines: deque[str] = deque()

    def feed(self, data: bytes) -> None:
        """Take bytes as they came from the line."""
        *whole, rest = (self._rest + data.replace(_BELL, _BELL + _END)).split(_END)
        self._rest = rest[-_LONGEST:]
        self._lines.extend(line.decode('ascii', errors='replace') for line in whole)

    def pop(self) -> str | None:
        """Return the oldest line, or None."""
        return self._lines.popleft() if self._lines else None

    def clear(self) -> None:
        """Forget everything."""
        self._rest = b''
        self._lines.clear()
