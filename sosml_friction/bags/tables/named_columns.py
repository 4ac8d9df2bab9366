# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Which column is what by the words in its name."""

import math
import re
from collections.abc import Mapping, Sequence
from itertools import permutations

import numpy as np

from sosml_friction.bags.tables import series_evidence as evidence
from sosml_friction.bags.tables.header_words import HeaderWord
from sosml_friction.bags.tables.recorded_columns import RecordedColumns
from sosml_friction.bags.tables.units import UNITS

#: Share of an effort's variance that direction, speed and acceleration must explain: of noise in
#: 1000 samples that are 10 each alike, three columns explain 3 %.
EXPLAINED = 0.05
#: Of two efforts of a joint one is not measured there if its motion explains less than this share
#: of what it explains of the other. Chosen, no measurement.
_FOLLOWS = 0.5
#: A reference comes before the position by more than this share of a sample. Chosen, no
#: measurement.
LEADS = 0.01
_CURRENTS = ('A', 'mA')
_LETTERS = re.compile('[a-zA-Z]')
QUANTITIES = ('position', 'velocity', 'effort', 'temperature')


class NamedColumns(RecordedColumns):
    """Give columns to joints by the words in their names, where these agree with the numbers."""

    def _name_positions(self) -> None:
        """Call a column a position if what has the name of a velocity, or efforts, tell that."""
        own = {n: w for n, w in self.words.items() if not w.is_wish and n in self.moving}
        named = {w.joint for w in own.values() if w.quantity == 'position'}
        # "current" is what is now, too, and pulses may be those of an encoder.
        may = [
            n for n, w in own.items() if w.quantity in ('', 'injected') or 'current' in n.lower()
        ]
        found = {
            s.position: (own[s.velocity].joint, f'{s.velocity} is its slope')
            for s in self.slopes
            if s.told > evidence.SURE and s.position in may and s.velocity in own
            if own[s.velocity].quantity == 'velocity' and own[s.velocity].joint not in named
        }
        joints = [joint for joint, _ in found.values()]
        if len(set(joints)) < len(joints):
            # Of a position and its reference the numbers say which was measured.
            return
        if not found and not named:
            found = self._of_efforts(own)
        for name, (joint, why) in found.items():
            strange = self.words[name].strange
            self.words[name] = HeaderWord('position', joint=joint, strange=strange)
            self.why[name] = why

    def _of_efforts(self, own: Mapping[str, HeaderWord]) -> dict[str, tuple[str, str]]:
        """Return joint and reason of columns that efforts of their numbers follow: J1, torque1."""
        efforts = [n for n, w in own.items() if w.quantity == 'effort' and n in self.moving]
        ranks = {n: effort_rank(n, own[n]) for n in efforts}
        best = min(ranks.values(), default=None)
        efforts = [n for n in efforts if ranks[n] == best]
        numbers = {re.sub(r'\D', '', own[n].joint): n for n in efforts}
        plain = {n: re.sub(r'\D', '', w.joint) for n, w in own.items() if not w.quantity}
        pairs = {n: numbers[k] for n, k in plain.items() if k and k in numbers}
        if not 1 < len(pairs) == len(efforts) == len(set(pairs.values())):
            return {}
        if max(self._share(e, q) for q, e in pairs.items()) < EXPLAINED:
            return {}
        return {q: (own[e].joint, f'{e} has its number and follows it') for q, e in pairs.items()}

    def _by_names(self) -> bool:
        """Give columns whose names have a quantity to their joints; tell whether any have."""
        named = {n: w for n, w in self.words.items() if w.quantity in QUANTITIES and not w.is_wish}
        for name in self._references([n for n, w in named.items() if w.quantity == 'position']):
            del named[name]
        keys = dict.fromkeys(w.joint for w in named.values() if w.quantity == 'position')
        if not keys:
            return False
        names = self._joint_names(list(keys))
        for quantity in QUANTITIES:
            own = [n for n, w in named.items() if w.quantity == quantity and n != self.time.name]
            # What is called as the position is comes before what has its number alone. A torque
            # needs no constant, a current a known one, and a voltage is no effort yet.
            rank = {n: (named[n].joint not in names, effort_rank(n, named[n])) for n in own}
            of_joint: dict[str, list[str]] = {}
            for name in sorted(own, key=lambda n: rank[n]):
                joint = self._joint_of_key(named[name].joint, names)
                if joint is not None:
                    of_joint.setdefault(joint, []).append(name)
            for joint, several in of_joint.items():
                roles = self.roles.setdefault(joint, {})
                if quantity == 'velocity':
                    # What has the number of a joint alone may be that of a body.
                    mine = roles.get('position', '')
                    several = [
                        n
                        for n in several
                        if not (rank[n][0] and {mine, n} <= set(self.moving))
                        or self._slope(mine, n)
                    ]
                if quantity == 'effort' and roles.get('position') in self.moving:
                    # What is the same all the time is a limit, a supply or a switch.
                    several = [n for n in several if n in self.moving]
                    several = self._without_supplies(joint, several)
                    several = self._most_explained(joint, several, rank)
                if not several:
                    continue
                roles[quantity], *others = several
                self.why.setdefault(several[0], 'its name says so')
                article = 'an' if quantity == 'effort' else 'a'
                self.alike.update(others)
                for name in others:
                    self._remark(f'{name} is {article} {quantity} too: {several[0]} was taken')
        self.roles = {j: r for j, r in self.roles.items() if 'position' in r}
        return bool(self.roles)

    def _references(self, positions: Sequence[str]) -> list[str]:
        """Return what comes before another position of its number and is nearly that: ASPos.A1."""
        found = []
        for first, second in permutations([n for n in positions if n in self.moving], 2):
            joints = [self.words[n].joint for n in (first, second)]
            numbers = [re.findall(r'\d+', joint) for joint in joints]
            is_pair = joints[0] != joints[1] and numbers[0] == numbers[1] != []
            if is_pair and self._nearly_same(first, second):
                before = evidence.lead(self.t, self.moving[first], self.moving[second])
                if before > LEADS * float(np.median(np.diff(self.t))):
                    found.append(first)
                    self._remark(
                        f'{first} is nearly {second} and comes {before:.3g} s before it: the '
                        'reference of a controller, it seems'
                    )
        return found

    def _without_supplies(self, joint: str, names: Sequence[str]) -> list[str]:
        """Return efforts without voltages that do not follow the motion, which are told."""
        supplies = [
            n
            for n in names
            if self.words[n].unit in ('V', 'mV') and self._explained(n, joint) < EXPLAINED
        ]
        for name in supplies:
            self._remark(f'{name} does not follow the motion: the voltage of a supply, it seems')
        self.alike.update(supplies)
        return [n for n in names if n not in supplies]

    def _most_explained(
        self,
        joint: str,
        names: Sequence[str],
        rank: Mapping[str, tuple[bool, tuple[bool, int, bool]]],
    ) -> list[str]:
        """Return efforts with one first that follows the motion, of those of the same kind."""
        alike = [n for n in names if rank[n][1] == rank[names[0]][1]]
        if len(alike) < 2:
            return list(names)
        shares = {n: self._explained(n, joint) for n in alike}
        # The size of a current, or that of the supply, does not; a command does as well.
        first = next(n for n in alike if shares[n] >= _FOLLOWS * max(shares.values()))
        return [first, *(n for n in names if n != first)]

    def _joint_of_key(self, key: str, names: Mapping[str, str]) -> str | None:
        """Return the joint that what is left of a name means: by all, its number, or its words."""
        if key in names:
            return names[key]
        if len(names) == 1:
            return next(iter(names.values()))
        number = re.findall(r'\d+', key)
        alike = [known for known in names if number and re.findall(r'\d+', known) == number]
        if len(alike) == 1:
            return names[alike[0]]
        # HeadYaw/ElectricCurrent/Sensor is of HeadYaw/Position/Sensor, knee.motor_current of
        # knee.output_position, and applied_torque[0] of joint_pos[0] rather than root_pos[0].
        words = set(key.split('_'))
        of_key = {k: set(k.split('_')) for k in alike or names}
        inside = [k for k, own in of_key.items() if own <= words and (alike or _LETTERS.search(k))]
        longest = max((k.count('_') for k in inside), default=0)
        whole = [k for k in inside if k.count('_') == longest]
        whole = whole or [k for k, own in of_key.items() if words <= own and _LETTERS.search(key)]
        return names[whole[0]] if len(whole) == 1 else None

    def _joint_names(self, keys: Sequence[str], as_in_file: bool = True) -> dict[str, str]:
        """
        Return the name of the joint by what is left of the columns' names.

        Those that differ in their number alone have the names that stand in the file, as in
        messages of ROS, else those of the URDF, in its order or that of their numbers.

        :param as_in_file: whether the keys are in the order of the file.
        """
        of_urdf = list(self.kinds)
        numbers = _numbers(keys)
        forms: dict[str, list[str]] = {}
        for key in keys:
            forms.setdefault(re.sub(r'\d+', '#', key), []).append(key)
        arms = [own for own in forms.values() if len(own) == len(of_urdf) > 1]
        if len(arms) == 1 < len(forms):
            # A gripper beside the arm of the URDF has a name of its own.
            rest = [key for key in keys if key not in arms[0]]
            return {**{k: k for k in rest}, **self._joint_names(arms[0], as_in_file)}
        if numbers:
            keys = sorted(keys, key=lambda key: numbers[key])
        if (numbers or len(keys) == 1) and not set(keys) & set(of_urdf):
            in_file = self._listed(len(keys))
            if as_in_file and in_file:
                self._remark(f'the names of the joints stand in the file: {", ".join(in_file)}')
                return dict(zip(keys, in_file, strict=True))
            if len(of_urdf) == len(keys):
                theirs = _numbers(of_urdf)
                if len(keys) > 1:
                    self._remark(
                        'the joints are in the order of '
                        + ('their numbers' if theirs else 'the URDF')
                    )
                of_urdf.sort(key=lambda name: theirs.get(name, 0))
                return dict(zip(keys, of_urdf, strict=True))
        named: dict[str, str] = {}
        for key in keys:
            whole = [n for n in of_urdf if n == key or n.removesuffix('_joint') == key]
            # The joints of a URDF may have the name of the robot before theirs.
            ends = [n for n in of_urdf if re.search(f'[_/]{re.escape(key)}(_joint)?$', n)]
            found = whole or (ends if key and not key.isdecimal() else [])
            plain = f'joint_{key}' if key.isdecimal() else key or 'joint'
            is_one = len(found) == 1 and found[0] not in named.values()
            named[key] = found[0] if is_one else plain
        return named

    def _listed(self, count: int) -> list[str]:
        """Return the names of so many joints that stand in every row of the file, if they do."""
        texts = self.data.texts()
        lists = [own for own in texts if len(own) == count and set(own) & set(self.kinds)]
        alone = [own[0] for own in texts if len(own) == 1 and own[0] in self.kinds]
        plain = list(dict.fromkeys(alone))
        return lists[0] if lists else plain if len(plain) == count else []

    def _explained(self, name: str, joint: str) -> float:
        position = self.roles[joint]['position']
        if name not in self.moving or position not in self.moving:
            return math.nan
        angle = UNITS['position'].get(self._position_unit(joint)[0]) or 0.0
        return self._share(name, position, angle)

    def _share(self, effort: str, position: str, angle: float = 1.0) -> float:
        return evidence.explained(self.t, self.moving[effort], self.moving[position], angle)


def _numbers(names: Sequence[str]) -> dict[str, int]:
    """Return the number in each name, nothing where they differ in more than one number."""
    found = {name: re.findall(r'\d+', name) for name in names}
    rest = {re.sub(r'\d+', '#', name) for name in names}
    if len(rest) > 1 or any(len(own) != 1 for own in found.values()):
        return {}
    return {name: int(number) for name, (number,) in found.items()}


def effort_rank(name: str, word: HeaderWord) -> tuple[bool, int, bool]:
    """Return the place of an effort by its name and unit among those of one joint."""
    if UNITS['effort'].get(word.unit) is not None:
        kind = 0
    elif not word.unit:
        # What is called so, without a unit, is a torque beside a current.
        kind = 2 if 'effort' in name.lower() else 5
    else:
        kind = 3 if word.unit in _CURRENTS else 4
    return word.is_computed, kind, not word.is_unit_written
