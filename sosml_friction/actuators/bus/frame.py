# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A CAN frame as the codecs see it, and its two ends on python-can."""

from __future__ import annotations

from typing import NamedTuple

import can


class Frame(NamedTuple):
    """Hold one classic CAN data frame with an 11-bit identifier and up to 8 bytes."""

    can_id: int
    data: bytes

    def to_message(self) -> can.Message:
        """Return the python-can message."""
        return can.Message(
            arbitration_id=self.can_id, data=self.data, is_extended_id=False, is_rx=False
        )

    @classmethod
    def from_message(cls, message: can.Message) -> Frame | None:
        """Return the frame, or None for what the protocols here never use (29-bit, remote, FD)."""
        if (
            message.is_extended_id
            or message.is_remote_frame
            or message.is_error_frame
            or message.is_fd
        ):
            return None
        return cls(message.arbitration_id, bytes(message.data))

    def __str__(self) -> str:
        return f'{self.can_id:#05x} [{self.data.hex(" ").upper()}]'
