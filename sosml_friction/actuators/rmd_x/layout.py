# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Where the values of an RMD-X message lie in its 8 bytes, and how each stands there."""

from __future__ import annotations

import math
import re
import struct
import types
from collections.abc import Callable, Collection
from dataclasses import dataclass, fields
from typing import Any, ClassVar, get_type_hints

from typing_extensions import dataclass_transform

from sosml_friction.actuators.rmd_x.commands import Command, ErrorFlag
from sosml_friction.exceptions import CanProtocolError

ANGLE_RESOLUTION = math.radians(0.01)
CURRENT_RESOLUTION = 0.01
DEGREE = math.radians(1.0)


@dataclass(frozen=True)
class Coding:
    """
    Say how one value stands on the wire.

    ``encode`` takes the value and the range of its place, ``decode`` what stands there; both raise
    CanProtocolError where there is no such value.
    """

    encode: Callable[[Any, range], Any]
    decode: Callable[[Any], Any]


def _range(code: str) -> range:
    """Return what a place holds; nothing where it is no integer."""
    if code == 's':
        return range(0)
    bits = 8 * struct.calcsize(f'<{code}')
    return range(-(1 << (bits - 1)), 1 << (bits - 1)) if code.islower() else range(1 << bits)


def counts(value: float, resolution: float, span: range) -> int:
    """Return the nearest count, saturated to what the place holds."""
    number = value / resolution
    if not math.isfinite(number):
        raise CanProtocolError(f'the value {value} cannot be sent: it is not finite')
    return min(max(round(number), span[0]), span[-1])


def integer(what: str, value: int, span: range) -> int:
    """Return ``value``; one that does not fit is a mistake, not something to saturate."""
    if value != value or not span[0] <= value <= span[-1] or int(value) != value:
        raise CanProtocolError(
            f'{what} {value} cannot be sent: it must be {span[0]} to {span[-1]}'
        )
    return int(value)


def scaled(resolution: float, decode: Callable[[int], Any]) -> Coding:
    """Return the coding of a quantity in counts of ``resolution``, rounded and saturated."""
    return Coding(lambda value, span: counts(value, resolution, span), decode)


def whole(what: str) -> Coding:
    """Return the coding of an integer that is refused where it does not fit."""
    return Coding(lambda value, span: integer(what, value, span), int)


def answered_command(commands: Collection[Command], what: str) -> Coding:
    """Return the coding of byte 0 of a reply to several commands."""

    def encode(command: int, _: range) -> int:
        if command not in commands:
            raise CanProtocolError(f'command {command:#04x} is not answered with {what}')
        return command

    return Coding(encode, Command)


def characters(length: int) -> Coding:
    """Return the coding of up to ``length`` printable ASCII characters."""

    def encode(text: str, _: range) -> bytes:
        if len(text) > length or not all(' ' <= character <= '~' for character in text):
            raise CanProtocolError(
                f'the model {text!r} cannot be sent: {length} ASCII characters fit'
            )
        return text.encode('ascii')

    return Coding(encode, _text)


def _text(data: bytes) -> str:
    text = data.split(b'\0')[0].rstrip(b' ')
    if not all(0x20 <= byte < 0x7F for byte in text):
        raise CanProtocolError(f'the model {text.hex(" ").upper()} is no text')
    return text.decode('ascii')


def _max_speed(speed: float, span: range) -> int:
    """Return [degrees/s]; 0 would mean "no limit", which nobody asks for by a small number."""
    if not speed > 0.0:
        raise CanProtocolError(f'the speed limit {speed} cannot be sent: it must be positive')
    return max(1, counts(speed, DEGREE, span))


def _angle(count: int) -> float:
    return math.radians(count / 100.0)


ANGLE = scaled(ANGLE_RESOLUTION, _angle)
CURRENT = scaled(CURRENT_RESOLUTION, lambda count: count / 100.0)
DEGREES = scaled(DEGREE, lambda count: count * DEGREE)
TEMPERATURE = scaled(1.0, int)
TENTHS = scaled(0.1, lambda count: count / 10.0)
# To the motor 0 is no limit.
MAX_SPEED = Coding(_max_speed, lambda count: count * DEGREE if count else math.inf)
SWITCH = Coding(lambda on, _: int(on), lambda count: count != 0)
ERRORS = Coding(lambda errors, _: int(errors) & 0xFFFF, ErrorFlag)


@dataclass_transform(frozen_default=True)
@dataclass(frozen=True)
class Message:
    """
    Say something in 8 bytes; this one says nothing but its command.

    ``command`` is byte 0. A subclass is a frozen dataclass: the type of a field says how its value
    is coded, ``places`` where the values lie, in the order of the fields or of ``sequence``: all 8
    bytes in the codes of :mod:`struct`, little endian, byte 0 first; ``x`` is not used. Where no
    place is left for the command, the first value stands in byte 0.
    """

    command: ClassVar[Command]
    _struct: ClassVar[struct.Struct] = struct.Struct('<B7x')
    _values: ClassVar[list[tuple[str, Coding, range]]] = []
    _begins_with_command: ClassVar[bool] = True

    def __init_subclass__(
        cls, command: Command, places: str = '', sequence: tuple[str, ...] = (), **kwargs: Any
    ) -> None:
        super().__init_subclass__(**kwargs)
        cls.command = command
        dataclass(frozen=True)(cls)
        if not places:
            return
        hints = get_type_hints(cls, include_extras=True)
        names = sequence or tuple(field.name for field in fields(cls))
        found = re.findall(r'(\d*)([a-zA-Z])', places.replace('x', ' '))
        # Seven characters are one value, seven bytes are seven.
        codes = ''.join(code if code == 's' else int(n or 1) * code for n, code in found)
        cls._begins_with_command = len(codes) == len(names) + 1
        cls._struct = struct.Struct(f'<{places}')
        cls._values = [
            (name, hints[name].__metadata__[0], _range(code))
            for name, code in zip(names, codes[cls._begins_with_command :], strict=True)
        ]

    def pack(self) -> bytes:
        """Return the 8 bytes; a CanProtocolError if there is no such value."""
        places = [self.command] if self._begins_with_command else []
        places += [c.encode(getattr(self, name), span) for name, c, span in self._values]
        return self._struct.pack(*places)

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """Return what 8 bytes say; a CanProtocolError if that is nothing the protocol allows."""
        places = cls._struct.unpack(data)[cls._begins_with_command :]
        values = zip(cls._values, places, strict=True)
        return cls(**{name: coding.decode(place) for (name, coding, _), place in values})


def bare(name: str, command: Command) -> type[Message]:
    """Return the message ``name`` that says nothing but its command."""
    return types.new_class(name, (Message,), {'command': command})


def by_command(*kinds: type[Message]) -> dict[int, type[Message]]:
    """Return messages by their byte 0."""
    return {int(kind.command): kind for kind in kinds}
