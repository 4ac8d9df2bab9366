# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the name of a column says: quantity, unit, joint, and whether it was measured."""

import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from sosml_friction.bags.tables.units import (
    LINEAR_UNITS,
    SPELLINGS,
    UNITS,
    WRITTEN,
    known_units,
    plain_unit,
)

#: Words for a quantity; short ones as in the equations of robots.
_QUANTITIES = {
    'time': 't time timestamp stamp clock zeit sec secs seconds nanos nanosec nanosecs '
    'nanoseconds',
    'position': 'q qpos pos position positions ang angle angles theta phi encoder enc winkel lage',
    'velocity': 'qd dq qdot qvel vel velocity velocities speed speeds spd omega dtheta thetadot '
    'rpm erpm drehzahl geschwindigkeit',
    'acceleration': 'qdd ddq qddot qacc acc accel acceleration accelerations',
    'effort': 'tau torque torques trq eff effort efforts force moment current currents cur curr i '
    'iq amps voltage voltages volt volts load loads qfrc drehmoment kraft strom motorstrom '
    'motormoment',
    'temperature': 'temp temperature temperatures temperatur',
    'injected': 'pulse pulses injected excitation dither perturbation chirp',
}
#: Words that give way to others: a servo's load is its effort, and the position of a load is that
#: of its side; pulses may be added to a command, or come from an encoder.
_WEAK = frozenset(('load', 'loads', 'pulse', 'pulses'))
_WORDS = {word: quantity for quantity, text in _QUANTITIES.items() for word in text.split()}
#: At the end of a name these are words for a quantity, and "position_in" is what goes in.
_NO_UNITS = _WORDS.keys() - _WEAK | {'in'}
#: Of what was commanded: it may stand for what was not measured.
_COMMANDS = frozenset((
    'target', 'ref', 'reference', 'cmd', 'command', 'commanded', 'desired', 'des', 'setpoint',
    'sp', 'soll', 'sollwert', 'goal', 'wanted', 'demand', 'trajectory', 'd', 'action', 'actions',
    'planned', 'referenz', 'vorgabe',
))  # fmt: skip
#: Of what is no joint: neither is a measurement of one.
_WISHES = _COMMANDS | frozenset((
    'error', 'err', 'limit', 'max', 'min', 'tcp', 'eef', 'cartesian', 'wrench', 'external', 'ext',
    'batt', 'battery', 'bus', 'vbus', 'ibus', 'supply', 'pose', 'orientation', 'quaternion',
    'quat', 'imu', 'odom',
))  # fmt: skip
#: Of these, what may be short for a joint.
_SHORT = frozenset(('sp', 'd'))
_FILLERS = frozenset((
    'actual', 'act', 'measured', 'meas', 'feedback', 'fbk', 'fb', 'joint', 'joints', 'state',
    'states', 'motor', 'raw', 'value', 'data', 'estimate', 'estimated', 'est', 'present',
    'filtered', 'filt', 'control', 'ist', 'istwert', 'msr', 'hat', 'mot',
))  # fmt: skip
#: Of a part of an effort that a model tells, as tau_g, or an observer: nobody measured it.
_COMPUTED = frozenset((
    'computed', 'predicted', 'simulated', 'model', 'gravity', 'grav', 'g', 'coriolis', 'c',
    'friction', 'fric', 'f', 'inertia', 'ff', 'feedforward', 'comp', 'compensation', 'residual',
    'disturbance', 'hat',
))  # fmt: skip
#: What turns is in no unit of length: theta_m is that of the motor.
_ANGLES = frozenset(('ang', 'angle', 'angles', 'theta', 'phi', 'winkel'))
#: Names of two words that are one: currents of a motor's axes, and derivatives.
_JOINED = (
    (re.compile(r'(?i)\b([iuv])[ _]q\b'), r'\1q'),
    (re.compile(r'(?i)\b(q|theta|phi)[ _]?dot'), 'qd'),
    (re.compile(r'(?i)\b(q|theta|phi)[ _]?ddot'), 'qdd'),
)
#: What German puts before a quantity without a blank: Sollwinkel, Istposition.
_PREFIX = re.compile(r'(?i)(sollwert|soll|istwert|ist|referenz|vorgabe)(?=.)')
#: Where a word begins in ActPos, in QMsr and in J1Pos.
_OF_CAMELS = re.compile(r'(?<=[a-z])(?=[A-Z])|(?<=[A-Z0-9])(?=[A-Z][a-z])')
#: A bracket with the number of a column, or of a motor: [3], [ID:001], (J1).
_NUMBER = re.compile(r'[\[(]((id|axis|joint|j|motor|servo|node)\W?)?\d+[\])]', re.IGNORECASE)
#: The one with which a name ends.
_BY_NUMBER = re.compile(rf'{_NUMBER.pattern}$', re.IGNORECASE)
#: A unit behind a name: in brackets, behind a stroke (q / rad), or behind a comma.
_BEHIND = re.compile(r'\s*([\[(][^\[\]()]*[\])]$|[/,].*$)')
#: The same behind a blank, if it has a sign that no word has: 1/min, %, °/s.
_SIGN = re.compile(r'(.*\S)\s+(\S*[°º˚%/]\S*)')
#: Unit that a word for the quantity has with it, where none is written.
_BY_WORD = {
    'torque': 'Nm', 'torques': 'Nm', 'trq': 'Nm', 'tau': 'Nm', 'drehmoment': 'Nm', 'force': 'N',
    'kraft': 'N', 'current': 'A', 'currents': 'A', 'cur': 'A', 'curr': 'A', 'i': 'A', 'iq': 'A',
    'amps': 'A', 'strom': 'A', 'motorstrom': 'A', 'motormoment': 'Nm', 'voltage': 'V',
    'voltages': 'V', 'volt': 'V', 'volts': 'V',
    'rpm': 'rpm', 'drehzahl': 'rpm',
}  # fmt: skip


class HeaderWord(NamedTuple):
    """
    Hold what a name says.

    ``quantity``: ``time``, ``position``, ``velocity``, ``acceleration``, ``effort``,
    ``temperature``, ``injected`` or ''; ``unit`` is the mapping's or ''; ``joint`` what is left of
    the name, a number or a name or ''; ``is_wish``: what was commanded or is no joint's.
    ``is_unit_written``: whether the unit stands there, or comes with the word; ``strange``: what
    stands in the place of a unit and is none that is known, or ''; ``is_computed``: whether it is
    what a model or an observer tells; ``is_command``: whether it was commanded.
    """

    quantity: str = ''
    unit: str = ''
    joint: str = ''
    is_wish: bool = False
    is_unit_written: bool = False
    strange: str = ''
    is_computed: bool = False
    is_command: bool = False

    @property
    def is_foreign(self) -> bool:
        """Tell whether it was neither measured at a joint nor commanded to it."""
        return self.is_computed or (self.is_wish and not self.is_command)

    @property
    def objection(self) -> str:
        """Return the sentence on what stands in the place of a unit, '' where all is well."""
        if not self.strange:
            return ''
        known = f' ({known_units(self.quantity)})' if self.quantity in WRITTEN else ''
        return f'[{self.strange}] in its name is no unit that is known{known}'


def read_headers(names: Iterable[str], joints: Iterable[str] = ()) -> dict[str, HeaderWord]:
    """
    Return what the names of one table say, where these ``joints`` are known.

    What is short for a wish may be the name of a joint: q_sp is that of the shoulder's pitch where
    all that was measured has a joint in its name, as q_sr has, and a set point beside q. So may be
    what is short for a unit: pos_m is that of the motor beside pos_l.
    """
    ends = _ends(joints)
    words = {name: read_header(name, ends) for name in names}
    kinds = ('position', 'velocity', 'effort')
    own = {w.joint for w in words.values() if w.quantity in kinds and not w.is_wish}
    for name, word in words.items():
        if own and '' not in own and word.is_wish and word.quantity in kinds and not word.joint:
            words[name] = read_header(name, ends, _WISHES - _SHORT)
        rest, letter = _last_letter(name)
        beside = [n for n in words if n != name and _last_letter(n)[0] == rest]
        beside = [n for n in beside if _last_letter(n)[1].isalpha()]
        if word.unit == letter and beside and not any(words[n].unit for n in beside):
            joint = '_'.join(filter(None, (word.joint, word.unit)))
            words[name] = word._replace(unit='', is_unit_written=False, joint=joint)
    return words


def _last_letter(name: str) -> tuple[str, str]:
    """Return a name without its last letter before a number, and the letter: pos_[0] and m."""
    number = _BY_NUMBER.search(name)
    end = len(name) if number is None else number.start()
    return name[: end - 1] + name[end:], name[end - 1 : end]


def without_unit(name: str) -> str:
    """Return a name without the unit behind it, as it is where there is none."""
    return _BEHIND.sub('', _bracketed(name))


def _bracketed(name: str) -> str:
    """Return a name with brackets about a unit that stands behind a blank and is no word."""
    behind = _SIGN.fullmatch(name)
    is_unit = behind is not None and plain_unit(behind[2]) in SPELLINGS
    return f'{behind[1]} [{behind[2]}]' if behind and is_unit else name


def _ends(joints: Iterable[str]) -> list[list[str]]:
    """Return, longest first, what a column may call these joints: turn is of arm_turn_joint."""
    known = [[part.lower() for part in _parts(name, _WISHES)] for name in joints]
    known = [own[:-1] if own[-1:] == ['joint'] else own for own in known]
    return sorted((own[k:] for own in known for k in range(len(own))), key=len, reverse=True)


def _parts(name: str, wishes: frozenset[str]) -> list[str]:
    """Return the words of a name, and the numbers behind those that are known."""
    bare = name.replace('_', ' ')
    for pattern, one in _JOINED:
        bare = pattern.sub(one, bare)
    words = [w for w in re.split(r'[^a-zA-Z0-9°]+', bare) if w]
    words = [
        part
        for word in words
        for part in ([word] if word.lower() in SPELLINGS else _OF_CAMELS.split(word))
    ]
    words = [part for word in words for part in _compound(word)]
    parts: list[str] = []
    for word in words:
        # "q1" is q of joint 1; "joint1" has the number alone.
        split = re.fullmatch(r'([a-zA-Z]+)(\d+)', word)
        known = split is not None and split[1].lower() in {*_WORDS, *_FILLERS, *wishes}
        parts += [split[1], split[2]] if split is not None and known else [word]
    return parts


def _compound(word: str) -> list[str]:
    """Return the two parts of Sollwinkel, or a word as it is."""
    prefix = _PREFIX.match(word)
    parts = [word[: prefix.end()], word[prefix.end() :]] if prefix else [word]
    return parts if len(parts[-1]) > 1 and parts[-1].lower() in _WORDS else [word]


def _without_joint(words: list[str], ends: Sequence[list[str]]) -> list[str]:
    """Return the words of a name with '' for those that are the name of a joint."""
    for own in ends:
        for k in range(len(words) - len(own) + 1):
            if words[k : k + len(own)] == own:
                return [*words[:k], *[''] * len(own), *words[k + len(own) :]]
    return words


def read_header(
    name: str, ends: Sequence[list[str]] = (), wishes: frozenset[str] = _WISHES
) -> HeaderWord:
    """
    Return what the name of a column says of it.

    :param ends: words, in small letters, that are the name of a joint and so no unit.
    """
    unit = WRITTEN['time'].get(plain_unit(name), '')
    if unit and len(name) > 1:
        return HeaderWord('time', unit, is_unit_written=True)
    name = _bracketed(name)
    # A bracket with a number is the column of a table; of others that with a unit comes first.
    brackets = sorted(
        re.finditer(r'[\[(]\s*([^\[\]()]*?)\s*[\])]', _NUMBER.sub('', name)),
        key=lambda own: plain_unit(own[1]) not in SPELLINGS,
    )
    bracket = brackets[0] if brackets else None
    bare = name if bracket is None else name.replace(bracket[0], ' ')
    parts = _parts(bare, wishes)
    lower = [part.lower() for part in parts]
    others = _without_joint(lower, ends)
    found = [part for part in lower if part in _WORDS]
    found = [part for part in found if part not in _WEAK] or found
    is_word = frozenset(found)
    quantity = _WORDS[found[-1]] if found else ''
    said = None if bracket is None else plain_unit(bracket[1])
    # The unit of cur_mA[0], a column of a table, stands before its number.
    number = _BY_NUMBER.search(name)
    behind = 0 if number is None else len(_parts(number[0], wishes))
    before, low_before = others[: len(others) - behind], lower[: len(lower) - behind]
    if found and len(found[-1]) == 1 and said in SPELLINGS - set(WRITTEN.get(quantity, ())):
        # A letter may be anything, and its unit says what: t [s] and T [K], q [rad] and q [A].
        found, quantity = [], ''
    written = _written_unit(said, before, quantity, found)
    by_word = _BY_WORD.get(found[-1], '') if found else ''
    if not quantity and said is not None:
        quantity = next((q for q, units in WRITTEN.items() if said in units), '')
        written = WRITTEN.get(quantity, {}).get(said, '')
    elif not written and len(before) > 1 < len(before[-1]) and (not found or len(found[-1]) == 1):
        # The unit behind a name, or a letter, says what it is of: j1_deg, t1_Nm.
        last = {q: _written_unit(None, before, q, [low_before[-2]]) for q in UNITS}
        own = next((q for q, unit in last.items() if unit and UNITS[q][unit]), '')
        found, quantity, written = ([], own, last[own]) if own else (found, quantity, written)
    strange = ''
    if bracket is not None and not written:
        inside = re.split(r'[^a-zA-Z0-9°]+', bracket[1].lower())
        plain = all(w.isdecimal() or w in _FILLERS for w in inside)
        strange = '' if plain else bracket[1]
    of_units = {part for own in WRITTEN.get(quantity, ()) for part in (own, *own.split('/'))}
    of_units = {part for part in of_units if not part.isdecimal()}
    rest = [
        part
        for part, low, other in zip(parts, lower, others, strict=True)
        if low not in is_word
        and low not in wishes
        and low not in _FILLERS
        and not (other in of_units and written)
    ]
    return HeaderWord(
        quantity,
        written or ('' if strange else by_word),
        '_'.join(rest),
        any(p in wishes for p in lower),
        bool(written),
        strange,
        any(p in _COMPUTED for p in lower),
        any(p in wishes & _COMMANDS for p in lower),
    )


def are_units(cells: Sequence[str]) -> bool:
    """Tell whether most cells of a line that are not empty are units, or in brackets."""
    full = [cell for cell in cells if cell.strip('-')]
    known = [
        plain_unit(c) in SPELLINGS or re.fullmatch(r'[\[(].*[\])]', c) is not None for c in full
    ]
    return 2 * sum(known) > len(full)


def _written_unit(bracket: str | None, lower: list[str], quantity: str, found: list[str]) -> str:
    """Return the unit in brackets, or at the end of a name whose quantity is a whole word."""
    units = WRITTEN.get(quantity, {})
    if bracket is not None:
        return units.get(bracket, '')
    if not found or len(lower) < 2:
        return ''
    # "velocity_rad_s" and "pos_deg"; a single letter behind "q" may be anything: "q_m".
    two = '/'.join(lower[-2:])
    if two in units:
        return units[two]
    last = lower[-1]
    if units.get(last) in LINEAR_UNITS and found[-1] in _ANGLES:
        return ''
    if last in units and (len(last) > 1 or len(found[-1]) > 2) and last not in _NO_UNITS:
        return units[last]
    return ''
