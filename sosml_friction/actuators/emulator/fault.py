# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The faults the emulator can be given at run time: one table, docs/faults.md in code."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from sosml_friction.exceptions import ConfigurationError

REQUESTS, REPLIES, BOTH = 'requests', 'replies', 'both'


class FaultPlace(Enum):
    """Where a fault sits."""

    FRAMES = 'frames on the way'
    ACTUATOR = 'actuator'
    BUS = 'bus'


@dataclass(frozen=True)
class FaultArgument:
    """Describe an argument: a number from ``low`` to ``high``, or one of the words ``choices``."""

    name: str
    default: float | str
    low: float = 0.0
    high: float = math.inf
    choices: tuple[str, ...] = ()


@dataclass(frozen=True)
class FaultKind:
    """
    Describe one kind of fault.

    ``event``: it happens once and is not there afterwards; otherwise it stands until it is
    cleared. A fault of the bus has no joint.
    """

    name: str
    place: FaultPlace
    arguments: tuple[FaultArgument, ...] = ()
    event: bool = False


#: Share of the frames that a fault meets, which frames these are, and how long an actuator does
#: not answer [s].
_FRACTION = FaultArgument('fraction', 1.0, high=1.0)
_DIRECTION = FaultArgument('direction', BOTH, choices=(REQUESTS, REPLIES, BOTH))
_REPLIES = FaultArgument('direction', REPLIES, choices=(REQUESTS, REPLIES, BOTH))
_DARK = FaultArgument('seconds', 1.1, high=3600.0)

FAULTS = (
    # Frames are lost.
    FaultKind('drop', FaultPlace.FRAMES, (_FRACTION, _DIRECTION)),
    # Frames arrive so much later [s], in order.
    FaultKind('delay', FaultPlace.FRAMES, (FaultArgument('seconds', 0.01, high=3600.0), _REPLIES)),
    # Frames arrive twice.
    FaultKind('duplicate', FaultPlace.FRAMES, (_FRACTION, _DIRECTION)),
    # Of two replies of an actuator the second arrives first, whatever lies between them.
    FaultKind('reorder', FaultPlace.FRAMES, (_FRACTION,)),
    # One bit of the data is turned over, as on a serial line without a checksum.
    FaultKind('bit_errors', FaultPlace.FRAMES, (_FRACTION, _REPLIES)),
    # Its cable is cut: powered, but it neither hears nor answers.
    FaultKind('silent', FaultPlace.ACTUATOR),
    # It starts anew: output off, dark meanwhile.
    FaultKind('reboot', FaultPlace.ACTUATOR, (_DARK,), True),
    # As reboot, and its angle is wrong by motor turns, 360 degrees / gear ratio each, until the
    # fault is cleared.
    FaultKind(
        'power_cycle',
        FaultPlace.ACTUATOR,
        (_DARK, FaultArgument('turns', 1.0, low=-1e6, high=1e6)),
    ),
    # Its own watchdog trips now.
    FaultKind('watchdog', FaultPlace.ACTUATOR, (), True),
    # It reports these bits of its error word or status, 0x0002 or 2, and keeps its output off.
    FaultKind('error_bits', FaultPlace.ACTUATOR, (FaultArgument('bits', 2.0, high=0xFFFF),)),
    # Its position does not change any more.
    FaultKind('stuck_encoder', FaultPlace.ACTUATOR),
    # No frame passes; a controller that can, says so in an error frame; up to 10 frames wait in
    # the transmit queue and leave at the end.
    FaultKind('bus_off', FaultPlace.BUS),
    # No frame can be sent: sending fails with this errno, 105, or 0 for none, or the adapter stops
    # reading.
    FaultKind('tx_full', FaultPlace.BUS, (FaultArgument('errno', 0.0, high=105.0),)),
    # The adapter is unplugged.
    FaultKind('adapter_gone', FaultPlace.BUS),
)
_BY_NAME = {kind.name: kind for kind in FAULTS}


@dataclass(frozen=True)
class Fault:
    """Hold a fault, made by :func:`parse_fault`: kind, joint it meets ('' for all), arguments."""

    kind: FaultKind
    joint: str
    values: tuple[tuple[str, float | str], ...]

    @property
    def name(self) -> str:
        """Return the name of its kind."""
        return self.kind.name

    def number(self, argument: str) -> float:
        """Return a number it was given, or the default."""
        return float(dict(self.values)[argument])

    def meets(self, joint: str, direction: str) -> bool:
        """Tell whether it is one of frames, and meets those of ``joint`` in ``direction``."""
        if self.kind.place is not FaultPlace.FRAMES:
            return False
        own = dict(self.values).get('direction', REPLIES)
        return self.joint in ('', joint) and own in (BOTH, direction)

    def __str__(self) -> str:
        words = [self.name]
        if self.joint:
            words.append(f'joint={self.joint}')
        words += [
            f'{name}={value:g}' if isinstance(value, float) else f'{name}={value}'
            for name, value in self.values
        ]
        return ' '.join(words)


def parse_fault(text: str, joints: Sequence[str]) -> Fault:
    """
    Return the fault that ``text`` names: ``drop joint=shoulder fraction=0.5``.

    :raises ConfigurationError: if there is no such fault, joint or argument.
    """
    name, *words = text.split() or ['']
    kind = _BY_NAME.get(name)
    if kind is None:
        raise ConfigurationError(
            f'there is no fault {name!r}: use one of {", ".join(_BY_NAME)}, as in drop '
            'joint=shoulder fraction=0.5'
        )
    arguments = {own.name: own for own in kind.arguments}
    given: dict[str, float | str] = {key: own.default for key, own in arguments.items()}
    joint = ''
    if kind.place is not FaultPlace.BUS:
        arguments['joint'] = FaultArgument('joint', '', choices=tuple(joints))
    for word in words:
        key, _, stated = word.partition('=')
        if key not in arguments:
            raise ConfigurationError(
                f'fault {name} has no argument {word!r}: it takes {", ".join(arguments) or "none"}'
            )
        value = _value(name, arguments[key], stated)
        if key == 'joint':
            joint = str(value)
        else:
            given[key] = value
    return Fault(kind, joint, tuple(given.items()))


def parse_faults(text: str, joints: Sequence[str]) -> tuple[Fault, ...]:
    """
    Return the faults that ``text`` names with semicolons between them; none if it is empty.

    :raises ConfigurationError: if one of them does not exist.
    """
    return tuple(parse_fault(part, joints) for part in text.split(';') if part.strip())


def _value(fault: str, argument: FaultArgument, text: str) -> float | str:
    if argument.choices:
        if text not in argument.choices:
            raise ConfigurationError(
                f'{argument.name} of fault {fault} is {text!r}: use one of '
                f'{", ".join(argument.choices)}'
            )
        return text
    try:
        value = float(int(text, 0)) if text.lower().startswith('0x') else float(text)
    except ValueError:
        value = math.nan
    # Written so that NaN is outside.
    if not argument.low <= value <= argument.high:
        raise ConfigurationError(
            f'{argument.name} of fault {fault} is {text!r}: give a number from {argument.low:g} '
            f'to {argument.high:g}'
        )
    return value
