# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The faults the emulator can be given at run time: one table, and the words for them."""

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
    """
    Describe one argument of a fault.

    A number lies between ``low`` and ``high``; a word is one of ``choices``.
    """

    name: str
    default: float | str
    description: str
    unit: str = ''
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
    description: str
    arguments: tuple[FaultArgument, ...] = ()
    event: bool = False

    def argument(self, name: str) -> FaultArgument | None:
        """Return the argument called ``name``, or None."""
        return next((own for own in self.arguments if own.name == name), None)


_FRACTION = FaultArgument('fraction', 1.0, 'share of the frames it meets', high=1.0)
_DIRECTION = FaultArgument('direction', BOTH, 'which frames', choices=(REQUESTS, REPLIES, BOTH))
_REPLIES = FaultArgument('direction', REPLIES, 'which frames', choices=(REQUESTS, REPLIES, BOTH))
_DARK = FaultArgument('seconds', 1.1, 'how long it does not answer', 's', high=3600.0)

FAULTS = (
    FaultKind('drop', FaultPlace.FRAMES, 'frames are lost', (_FRACTION, _DIRECTION)),
    FaultKind(
        'delay',
        FaultPlace.FRAMES,
        'frames arrive later, in order',
        (FaultArgument('seconds', 0.01, 'by how much', 's', high=3600.0), _REPLIES),
    ),
    FaultKind('duplicate', FaultPlace.FRAMES, 'frames arrive twice', (_FRACTION, _DIRECTION)),
    FaultKind(
        'reorder',
        FaultPlace.FRAMES,
        'of two replies of an actuator the second arrives first, whatever lies between them',
        (_FRACTION,),
    ),
    FaultKind(
        'bit_errors',
        FaultPlace.FRAMES,
        'one bit of the data is turned over, as on a serial line without a checksum',
        (_FRACTION, _REPLIES),
    ),
    FaultKind(
        'silent',
        FaultPlace.ACTUATOR,
        'its cable is cut: powered, but it neither hears nor answers',
    ),
    FaultKind(
        'reboot', FaultPlace.ACTUATOR, 'it starts anew: output off, dark meanwhile', (_DARK,), True
    ),
    FaultKind(
        'power_cycle',
        FaultPlace.ACTUATOR,
        'as reboot, and its angle is wrong by motor turns, 360 degrees / gear ratio each, until '
        'cleared',
        (_DARK, FaultArgument('turns', 1.0, 'motor turns', low=-1e6, high=1e6)),
    ),
    FaultKind('watchdog', FaultPlace.ACTUATOR, 'its own watchdog trips now', (), True),
    FaultKind(
        'error_bits',
        FaultPlace.ACTUATOR,
        'it reports these bits of its error word or status and keeps its output off',
        (FaultArgument('bits', 2.0, 'the word, 0x0002 or 2', high=0xFFFF),),
    ),
    FaultKind('stuck_encoder', FaultPlace.ACTUATOR, 'its position does not change any more'),
    FaultKind(
        'bus_off',
        FaultPlace.BUS,
        'no frame passes; a controller that can, says so in an error frame; up to 10 frames wait '
        'in the transmit queue and leave at the end',
    ),
    FaultKind(
        'tx_full',
        FaultPlace.BUS,
        'no frame can be sent: sending fails, or the adapter stops reading',
        (FaultArgument('errno', 0.0, 'of the failure: 105, or 0 for none', high=105.0),),
    ),
    FaultKind('adapter_gone', FaultPlace.BUS, 'the adapter is unplugged'),
)
_BY_NAME = {kind.name: kind for kind in FAULTS}


@dataclass(frozen=True)
class Fault:
    """
    Hold one fault: its kind, the joint it meets ('' for all) and its arguments.

    Made from words by :func:`parse_fault`.
    """

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

    :param joints: the joints there are; without ``joint=`` a fault meets them all.
    :raises ConfigurationError: if there is no such fault, joint or argument.
    """
    name, *words = text.split() or ['']
    kind = _BY_NAME.get(name)
    if kind is None:
        raise ConfigurationError(
            f'there is no fault {name!r}: use one of {", ".join(_BY_NAME)}, as in drop '
            'joint=shoulder fraction=0.5'
        )
    given: dict[str, float | str] = {own.name: own.default for own in kind.arguments}
    joint = ''
    for word in words:
        key, _, value = word.partition('=')
        argument = kind.argument(key)
        if key == 'joint' and kind.place is not FaultPlace.BUS:
            if value not in joints:
                raise ConfigurationError(
                    f'fault {name} is for joint {value!r}: use one of {", ".join(joints)}'
                )
            joint = value
        elif argument is None:
            known = [own.name for own in kind.arguments]
            known += [] if kind.place is FaultPlace.BUS else ['joint']
            raise ConfigurationError(
                f'fault {name} has no argument {word!r}: it takes {", ".join(known) or "none"}'
            )
        else:
            given[key] = _value(name, argument, value)
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
