# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Where the values of an RMD-X message lie in its 8 bytes, and how each stands there."""

from __future__ import annotations

import math
import struct
import types
from collections.abc import Callable
from dataclasses import MISSING, dataclass, field, fields
from typing import Any, ClassVar, NamedTuple

from typing_extensions import dataclass_transform

from sosml_friction.actuators.rmd_x.commands import Command
from sosml_friction.exceptions import CanProtocolError

ANGLE_RESOLUTION = math.radians(0.01)
DEGREE = math.radians(1.0)


class Scale(NamedTuple):
    """Say what a count is worth, and return the value of a number of them."""

    resolution: float
    value: Callable[[int], Any]


ANGLE = Scale(ANGLE_RESOLUTION, lambda count: math.radians(count / 100.0))
CURRENT = Scale(0.01, lambda count: count / 100.0)
DEGREES = Scale(DEGREE, lambda count: count * DEGREE)
TEMPERATURE = Scale(1.0, int)
TENTHS = Scale(0.1, lambda count: count / 10.0)
#: What a code of :mod:`struct` holds.
_RANGES = {'b': (-(2**7), 2**7 - 1), 'h': (-(2**15), 2**15 - 1), 'i': (-(2**31), 2**31 - 1),
           'H': (0, 2**16 - 1)}  # fmt: skip
# To the motor 0 is no limit.
MAX_SPEED = Scale(DEGREE, lambda count: count * DEGREE if count else math.inf)


def at(byte: int, code: str, kind: Any, *, default: Any = MISSING) -> Any:
    """
    Return a field that begins at a byte, in a code of :mod:`struct`, little endian.

    :param kind: a :class:`Scale`, whose counts are rounded and saturated; or a type: what of it
        does not fit is refused.
    """
    return field(default=default, metadata={'place': (byte, code, kind)})


@dataclass_transform(frozen_default=True, field_specifiers=(at,))
@dataclass(frozen=True)
class Message:
    """Say something in 8 bytes: ``command`` in byte 0, and the fields of a subclass, by ``at``."""

    command: ClassVar[Command]
    _struct: ClassVar[struct.Struct]
    #: Of each value in the order of the bytes: its name, its code and its kind.
    _values: ClassVar[list[tuple[str, str, Any]]]
    _begins_with_command: ClassVar[bool]

    def __init_subclass__(cls, command: Command, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        cls.command = command
        dataclass(frozen=True)(cls)
        places = sorted((*own.metadata['place'][:2], own.name) for own in fields(cls))
        cls._begins_with_command = not places or places[0][0] > 0
        form, end = ('<B', 1) if cls._begins_with_command else ('<', 0)
        for byte, code, _ in places:
            form += f'{byte - end}x{code}'
            end = byte + struct.calcsize(f'<{code}')
        cls._struct = struct.Struct(f'{form}{8 - end}x')
        kinds = {own.name: own.metadata['place'][2] for own in fields(cls)}
        cls._values = [(name, code, kinds[name]) for _, code, name in places]

    def pack(self) -> bytes:
        """Return the 8 bytes; a CanProtocolError if there is no such value."""
        head = [self.command] if self._begins_with_command else []
        try:
            own = [_raw(getattr(self, name), code, kind) for name, code, kind in self._values]
            return self._struct.pack(*head, *own)
        except (struct.error, ValueError) as error:
            raise CanProtocolError(f'{self} cannot be sent: {error}') from error

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return what 8 bytes say; a CanProtocolError if that is nothing the protocol allows."""
        raw = cls._struct.unpack(data)[cls._begins_with_command :]
        values = zip(cls._values, raw, strict=True)
        return cls(**{name: _value(own, kind) for (name, _, kind), own in values})


def _raw(value: Any, code: str, kind: Any) -> Any:
    """Return what stands on the wire for a value."""
    if isinstance(kind, Scale):
        number = value / kind.resolution
        if not math.isfinite(number):
            raise ValueError('it is not finite')
        low, high = _RANGES[code]
        return min(max(round(number), low), high)
    if kind is str:
        size = struct.calcsize(code)
        if len(value) > size or not (value.isascii() and value.isprintable()):
            raise ValueError(f'{size} ASCII characters fit')
        return value.encode('ascii')
    return value


def _text(data: bytes) -> str:
    text = data.split(b'\0')[0].rstrip(b' ')
    if not all(0x20 <= byte < 0x7F for byte in text):
        raise CanProtocolError(f'the model {text.hex(" ").upper()} is no text')
    return text.decode('ascii')


def _value(raw: Any, kind: Any) -> Any:
    """Return what stands on the wire as a value."""
    if isinstance(kind, Scale):
        return kind.value(raw)
    return _text(raw) if kind is str else kind(raw)


def bare(name: str, command: Command) -> type[Message]:
    """Return the message ``name`` that says nothing but its command."""
    return types.new_class(name, (Message,), {'command': command})


def by_command(*kinds: type[Message]) -> dict[int, type[Message]]:
    """Return messages by their byte 0."""
    return {int(kind.command): kind for kind in kinds}
