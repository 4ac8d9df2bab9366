# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
One message of the RMD-X protocol: a command with its values and their places.

Protocol V3/V4 of MyActuator ("Servo Motor Control Protocol" V4.2): always 8 bytes, little endian,
two's complement, byte 0 is the command and comes back in the reply. Both directions are here: the
driver needs one, the emulator the other. The sign is the motor's own; which way that turns the
joint is the driver's ``direction``.

What the wire can carry (unit here, counts there): angle 0.01 degree int32, current 0.01 A int16,
speed command 0.01 degree/s int32, angle and speed of the standard reply 1 degree and 1 degree/s
int16, voltage 0.1 V uint16. Values are rounded to the nearest count and saturated.

Not coded, as nothing here sends it: the motion mode (0x400 + id), gains and accelerations (0x30
to 0x43), functions, identifiers and bit rate (0x20, 0x79, 0xB4), positions and encoder values
within a turn (0xA6, 0x90), writing the zero (0x63, 0x64), and unasked replies (0xB6).
"""

from __future__ import annotations

import types
from dataclasses import dataclass, fields
from typing import Any, ClassVar, dataclass_transform, get_type_hints

from sosml_friction.actuators.rmd_x.commands import Command
from sosml_friction.actuators.rmd_x.layout import Layout


@dataclass_transform(frozen_default=True)
@dataclass(frozen=True)
class Message:
    """
    Say something in 8 bytes; this one says nothing but its command.

    ``command`` is byte 0. A subclass is a frozen dataclass: the type of a field says how its value
    is coded, ``places`` where the values lie (see :class:`Layout`), in the order of the fields or
    in that of ``sequence``.
    """

    command: ClassVar[Command]
    layout: ClassVar[Layout] = Layout('B7x')

    def __init_subclass__(
        cls, command: Command, places: str = '', sequence: tuple[str, ...] = (), **kwargs: Any
    ) -> None:
        super().__init_subclass__(**kwargs)
        cls.command = command
        dataclass(frozen=True)(cls)
        if places:
            hints = get_type_hints(cls, include_extras=True)
            names = sequence or tuple(field.name for field in fields(cls))
            cls.layout = Layout(places, **{name: hints[name].__metadata__[0] for name in names})

    def pack(self) -> bytes:
        """
        Return the 8 bytes.

        :raises CanProtocolError: if a value is not finite or no such value exists.
        """
        return self.layout.pack(self, self.command)

    @classmethod
    def unpack(cls, data: bytes) -> Message:
        """
        Return what 8 bytes say.

        :raises CanProtocolError: if they say nothing the protocol allows.
        """
        return cls(**cls.layout.unpack(data))


def bare(name: str, command: Command) -> type[Message]:
    """Return the message ``name`` that says nothing but its command."""
    return types.new_class(name, (Message,), {'command': command})


def by_command(*kinds: type[Message]) -> dict[int, type[Message]]:
    """Return messages by their byte 0."""
    return {int(kind.command): kind for kind in kinds}
