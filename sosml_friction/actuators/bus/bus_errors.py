# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What python-can says when the bus itself is in trouble, in two forms each."""

import errno
from enum import IntFlag

import can

_FULL_ERRNOS = (errno.ENOBUFS, errno.EAGAIN, errno.EWOULDBLOCK)
_FULL_WORDS = ('transmit buffer full', 'no buffer space', 'transmit queue is full')


class BusTrouble(IntFlag):
    """Classes of SocketCAN's error frames, bits of their identifier."""

    TRANSMIT_TIMEOUT = 0x001
    LOST_ARBITRATION = 0x002
    CONTROLLER = 0x004
    PROTOCOL = 0x008
    TRANSCEIVER = 0x010
    NOT_ACKNOWLEDGED = 0x020
    BUS_OFF = 0x040
    BUS_ERROR = 0x080
    RESTARTED = 0x100


def bus_trouble(message: can.Message) -> BusTrouble:
    """Return what an error frame says; nothing for any other frame."""
    if not message.is_error_frame:
        return BusTrouble(0)
    return BusTrouble(message.arbitration_id & 0x1FF)


def trouble_names(trouble: BusTrouble) -> str:
    """Return the set bits as words."""
    names = [(flag.name or '').lower().replace('_', ' ') for flag in BusTrouble if trouble & flag]
    return ', '.join(names) or 'none'


def is_transmit_full(error: BaseException) -> bool:
    """
    Tell whether a failed send means "transmit buffer full": the bus is there, but does not take.

    python-can raises it with an errno (ENOBUFS), or by words alone when its own wait timed out.
    """
    code = getattr(error, 'error_code', None)
    if code is None and isinstance(error, OSError):
        code = error.errno
    if code is not None:
        return code in _FULL_ERRNOS
    return any(words in str(error).lower() for words in _FULL_WORDS)
