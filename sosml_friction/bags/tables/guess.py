# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Propose what the columns of a recording are, with reasons; what is not told is left open."""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations, permutations

import numpy as np

from sosml_friction.bags.tables import series_evidence as evidence
from sosml_friction.bags.tables.data_file import DataFile
from sosml_friction.bags.tables.mapping import NO_POSITION
from sosml_friction.bags.tables.named_columns import EXPLAINED, LEADS, QUANTITIES, NamedColumns
from sosml_friction.bags.tables.proposed_mapping import Guess
from sosml_friction.bags.tables.recorded_columns import (
    SAME,
    USUAL_POSITIONS,
    USUAL_VELOCITIES,
    agree,
)
from sosml_friction.bags.tables.units import UNITS
from sosml_friction.exceptions import DataError

#: A position may be rougher than another smooth column, such as a temperature, by so much.
_ROUGHER = 10.0
#: A position is smoother than an effort by so much; the files at hand have 10 and more.
_SMOOTHER = 3.0
#: So many columns beside a position that are as smooth are no efforts: of one joint there are not
#: as many. Chosen, no measurement.
_JOINTS = 3
#: The place of a column in its table, behind the name of that: tau[3].
_TABLE_OF = re.compile(r'\[\d+\]$')


def guess_mapping(
    data: DataFile, urdf_text: str | None = None, rate: float | None = None
) -> Guess:
    """
    Return the mapping that the names and the numbers of a file speak for.

    Time is what grows all the time, unless ``rate`` [Hz] stands in its place. A velocity is the
    slope of its position, and the factor between them tells their units. The effort is, of what is
    left, what follows the direction, speed and acceleration of its joint. Words in the names come
    first where there are any. The URDF says what joints are called and whether they turn or slide.

    :raises DataError: if the file holds no series that could be the position of a joint.
    """
    return Guesser(data, urdf_text, rate=rate).guess()


class Guesser(NamedColumns):
    """Find who is what among the columns of one file."""

    def guess(self) -> Guess:
        """Return the mapping that the file speaks for; see :func:`guess_mapping`."""
        self._put_time()
        self._name_positions()
        if not self._by_names():
            self._by_numbers()
        if not self.roles:
            sentences = [*self._of_other_length(), *self._unread(*QUANTITIES)[:1]]
            others = ''.join(f'; {sentence}' for sentence in sentences)
            speeds = [n for n, w in self.words.items() if w.quantity == 'velocity']
            if speeds:
                others += f'; {NO_POSITION.format(speeds[0])}'
            raise DataError(
                f'{self.data.path} holds nothing that looks like the position of a joint{others}: '
                'write the mapping yourself (docs/import.md)'
            )
        self._add_slopes()
        self._drop_references()
        self._add_efforts()
        if not any('effort' in own for own in self.roles.values()):
            sent = [n for n, w in self.words.items() if w.is_command and w.quantity == 'effort']
            said = f'; what was commanded, {", ".join(sent)}, may stand for it' if sent else ''
            self._remark(
                'nothing here is the effort of a joint, and positions alone do not tell friction: '
                f'its torque, force or current is needed{said}'
            )
        positions = [r['position'] for r in self.roles.values() if r['position'] in self.moving]
        for one, other in combinations(positions, 2):
            if self._nearly_same(one, other):
                self._remark(
                    f'{one} and {other} are nearly the same: one may be the reference of a '
                    'controller, and no joint'
                )
            elif ratio := self._ratio(one, other):
                self._remark(
                    f'{other} is {one} times {ratio:.4g}: two encoders of one joint, it seems; '
                    'keep that at whose side the effort is'
                )
        self.result.content['joints'] = {}
        for joint, roles in self.roles.items():
            self._put_joint(joint, roles)
        self._put_remarks()
        return self.result

    def _ratio(self, one: str, other: str) -> float:
        """Return what one position is times another, 0 if they are not of one joint."""
        if not {one, other} <= set(self.moving):
            return 0.0
        first, second = self.moving[one], self.moving[other]
        is_same = abs(np.corrcoef(first, second)[0, 1]) > evidence.SURE
        return is_same * float(np.std(second) / np.std(first))

    def _taken(self) -> set[str]:
        stamps = {self.time.name, self.time.nanoseconds}
        return stamps | {name for own in self.roles.values() for name in own.values()}

    def _free(self) -> list[str]:
        """Return what moves, has no role, and is no wish of a controller."""
        taken = self._taken()
        return [
            name
            for name in self.moving
            if name not in taken
            and not self.words[name].is_wish
            and self.words[name].quantity in ('', 'effort')
        ]

    def _drop_references(self) -> None:
        """Leave out what has no effort and moves as a joint that has one: it is its reference."""
        positions = {j: r['position'] for j, r in self.roles.items()}
        for joint, name in positions.items():
            same = [
                n
                for j, n in positions.items()
                if 'effort' in self.roles.get(j, ()) and {n, name} <= set(self.moving)
                if n != name and self._nearly_same(n, name)
            ]
            if 'effort' not in self.roles[joint] and same:
                del self.roles[joint]
                self._remark(
                    f'{name} is nearly {same[0]} and has no effort: the reference of a '
                    'controller, it seems'
                )

    def _by_numbers(self) -> None:
        """Find the positions by what is the slope of what, else by smoothness."""
        pairs = self._pairs()
        if pairs:
            columns = self._blocks(pairs)
            names = self._numbered(len(columns))
            if len(columns) == 1 and not self.kinds:
                names = ['joint']
            for joint, (position, velocity, why) in zip(names, columns, strict=True):
                self.roles[joint] = {'position': position, 'velocity': velocity}
                self.why.setdefault(position, why)
            return
        free = [n for n in self._free() if np.isfinite(self.rough[n])]
        if not any(map(self._may_be_position, free)):
            return
        if self._tables(free) or self._halves(free):
            return
        rough = self.rough
        smoothest, follows = self._best_pair(free)
        order = sorted(free, key=lambda name: (name != smoothest, rough[name]))
        alike = [n for n in order if self._nearly_same(smoothest, n)]
        measured = smoothest
        if len(alike) > 1:
            leads = {
                n: evidence.lead(self.t, self.moving[n], self.moving[smoothest]) for n in alike
            }
            measured = min(leads, key=lambda n: leads[n])
            self.why[measured] = f'it comes after {", ".join(n for n in alike if n != measured)}'
            for name in alike:
                if name != measured:
                    before = leads[name] - leads[measured]
                    self._remark(
                        f'{name} is nearly {measured} and comes {before:.3g} s before it: the '
                        'reference of a controller, it seems'
                        if before > LEADS * float(np.median(np.diff(self.t)))
                        else f'{name} is nearly {measured} and does not come before it: which of '
                        'them was measured is not told'
                    )
        else:
            self.why[measured] = follows or 'the smoothest column: a position is an integral'
        if not follows and len(order) > 1 and rough[order[1]] < _SMOOTHER * rough[smoothest]:
            self._remark(f'{measured} may be no position: {order[1]} is nearly as smooth')
        (name,) = self._joint_names(['']).values()
        self.roles[name] = {'position': measured}
        self.alike.update(alike)
        others = [n for n in order if n not in alike]
        if len(others) >= _JOINTS and rough[others[-1]] < _SMOOTHER * rough[smoothest]:
            self._remark(
                f'{measured}, {", ".join(others)} are about as smooth as each other: positions of '
                'several joints, it seems, and no effort'
            )
            self.alike.update(others)

    def _numbered(self, count: int) -> list[str]:
        """Return the names of so many joints that have a number alone."""
        return list(self._joint_names([str(k) for k in range(1, count + 1)]).values())

    def _best_pair(self, free: Sequence[str]) -> tuple[str, str]:
        """Return, of the smooth columns, that whose motion explains another best, and why."""
        rough = self.rough
        may = [name for name in free if self._may_be_position(name)]
        smoothest = min(may, key=lambda name: rough[name])
        smooth = [name for name in may if rough[name] <= _ROUGHER * rough[smoothest]]
        # One of many that are as smooth as the position is that of another joint.
        rougher = _SMOOTHER if len(free) > _JOINTS else 1.0
        shares = {
            (one, other): self._share(other, one)
            for one in smooth
            for other in free
            if rough[other] > rougher * rough[one] and not self._nearly_same(one, other)
        }
        best = max(shares, key=lambda pair: shares[pair], default=('', ''))
        if not best[0] or shares[best] < EXPLAINED:
            return smoothest, ''
        return best[0], f'smooth, and its motion explains {best[1]}'

    def _tables(self, free: Sequence[str]) -> bool:
        """Take one table for positions and another, of as many columns, for their efforts."""
        tables: dict[str, list[str]] = {}
        for name in self.series:
            tables.setdefault(_TABLE_OF.sub('', name), []).append(name)
        wide = [own for own in tables.values() if len(own) > 1 and set(own) & set(free)]
        shares: dict[float, list[tuple[str, str]]] = {}
        for positions, efforts in permutations(wide, 2):
            pairs = list(zip(positions, efforts, strict=False))
            both = [(q, e) for q, e in pairs if q in free and e in free]
            rough = [[self.rough[n] for n in own] for own in zip(*both, strict=True)]
            if len(positions) != len(efforts) or not both or np.median(rough[0]) > min(rough[1]):
                continue
            if all(map(self._may_be_position, positions)):
                shares[float(np.median([self._share(e, q) for q, e in both]))] = pairs
        if max(shares, default=0.0) < EXPLAINED:
            return False
        self._pair(
            shares[max(shares)],
            'its table is the smoother of two with as many columns',
            'its table follows the motion, column by column',
        )
        return True

    def _pair(self, pairs: Sequence[tuple[str, str]], position: str, effort: str) -> None:
        """Give (position, effort) to numbered joints, and the reasons of both."""
        for joint, own in zip(self._numbered(len(pairs)), pairs, strict=True):
            self.roles[joint] = dict(zip(('position', 'effort'), own, strict=True))
            self.why.update(zip(own, (position, effort), strict=True))

    def _halves(self, free: Sequence[str]) -> bool:
        """Take the smooth half of the columns for positions, the other for efforts, in order."""
        count, rough = len(free) // 2, self.rough
        smooth = sorted(free, key=lambda name: rough[name])
        if count < 2 or len(free) % 2:
            return False
        if rough[smooth[count]] < _SMOOTHER * rough[smooth[count - 1]]:
            return False
        if any(self._nearly_same(a, b) for a in smooth[:count] for b in smooth[:count] if a < b):
            return False
        positions = [name for name in free if name in smooth[:count]]
        if not all(map(self._may_be_position, positions)):
            return False
        efforts = [name for name in free if name not in positions]
        pairs = list(zip(positions, efforts, strict=True))
        if any(self._share(e, q) < EXPLAINED for q, e in pairs):
            return False
        self._pair(
            pairs,
            'one of the smooth half of the columns',
            'one of the rough half of the columns, in the order of positions',
        )
        return True

    def _may_be_position(self, name: str) -> bool:
        return self.words[name].quantity != 'effort'

    def _pairs(self) -> dict[str, evidence.Slope]:
        """Return the surest velocity of each series that is nobody's slope itself."""
        free = set(self._free())
        may = set(filter(self._may_be_position, free))
        slopes = [
            s for s in self.slopes if {s.position, s.velocity} <= may and s.told > evidence.SLOPE
        ]
        # Of two encoders of one joint, dqm is the slope of qm.
        slopes.sort(key=lambda s: s.velocity not in (f'd{s.position}', f'{s.position}dot'))
        # A velocity's own slope is an acceleration, or an effort that goes with it.
        velocities = {s.velocity for s in slopes if s.cosine > 1.0 - SAME / 10.0}
        pairs: dict[str, evidence.Slope] = {}
        used: set[str] = set()
        for slope in slopes:
            if slope.position in velocities or slope.position in pairs or slope.velocity in used:
                continue
            # What a shaft at two speeds takes is like its velocity: without another column that
            # could be the effort, the factor of a unit must tell them apart.
            others = len(free) - 2 * len(pairs) > 2
            if not (_is_of_units(slope.factor) or (others and slope.told > evidence.SURE)):
                continue
            pairs[slope.position] = slope
            used.add(slope.velocity)
        return pairs

    def _blocks(self, pairs: Mapping[str, evidence.Slope]) -> list[tuple[str, str, str]]:
        """
        Return (position, velocity, reason) of each joint, those that rest included.

        Where all pairs are as many columns apart, positions and velocities are blocks of so many.
        """
        names = list(self.series)
        at = {name: k for k, name in enumerate(names)}
        found = sorted((at[s.position], at[s.velocity], s) for s in pairs.values())
        plain = [
            (s.position, s.velocity, f'{s.velocity} is its slope (cosine {s.cosine:.4f})')
            for _, _, s in found
        ]
        apart = {v - p for p, v, _ in found}
        width = apart.pop()
        first = at[self.time.name] + 1 if self.time.name else 0
        rest = len(names) - first
        inside = all(first <= p < first + width for p, _, _ in found)
        if apart or len(found) >= width or width < 2 or not inside or rest < 2 * width:
            return plain
        known = {position: why for position, _, why in plain}
        resting = f'it rests; its place among the {width} columns of positions says so'
        return [
            (names[first + k], names[first + width + k], known.get(names[first + k], resting))
            for k in range(width)
        ]

    def _add_slopes(self) -> None:
        """
        Give each joint the series that is the slope of its position, if none is called so and is.

        What is nearly so is no velocity unless something else is left that follows the motion.
        """
        may = [
            n for n, w in self.words.items() if w.quantity in ('', 'velocity') and not w.is_wish
        ]
        for joint, roles in self.roles.items():
            for slope in self.slopes:
                if slope.position != roles['position'] or slope.velocity not in may:
                    continue
                known = roles.get('velocity')
                is_open = known is None or (
                    known in self.moving and self._slope(roles['position'], known) is None
                )
                others = [n for n in self._free() if n not in (slope.position, slope.velocity)]
                if (
                    is_open
                    and slope.velocity not in self._taken()
                    and abs(slope.told) > evidence.SLOPE
                    and (
                        slope.told > evidence.SURE
                        or _is_of_units(slope.factor)
                        or any(self._explained(n, joint) >= EXPLAINED for n in others)
                    )
                ):
                    roles['velocity'] = slope.velocity

    def _add_efforts(self) -> None:
        """Give each joint without an effort that of what is left which its motion explains."""
        # A second encoder of a joint has the effort of the first.
        known = [r['position'] for r in self.roles.values() if 'effort' in r]
        without = [
            joint
            for joint, r in self.roles.items()
            if 'effort' not in r and not any(self._ratio(q, r['position']) for q in known)
        ]
        free = [n for n in self._free() if n not in self.alike]
        free = [n for n in free if not any(self._nearly_same(v, n) for v in self._velocities())]
        if not without or not free:
            return
        if len(without) == 1:
            self._best_effort(without[0], free)
            return
        blocks = self._blocks_of(len(self.roles))
        between = self._between(free)
        if between:
            for joint, columns in between.items():
                self._best_effort(joint, columns)
        elif blocks:
            self._effort_block(blocks)
        else:
            named = [n for n in free if self.words[n].quantity == 'effort']
            self._fewer_efforts(without, named if self.is_named else free)

    def _fewer_efforts(self, joints: Sequence[str], efforts: Sequence[str]) -> None:
        """Give each of the efforts that are fewer than joints to that which explains it best."""
        for name in efforts if len(efforts) < len(joints) else ():
            shares = {joint: self._explained(name, joint) for joint in joints}
            best = max(shares, key=lambda joint: float(np.nan_to_num(shares[joint], nan=-1.0)))
            if shares[best] >= EXPLAINED and 'effort' not in self.roles[best]:
                self.roles[best]['effort'] = name
                self.why[name] = f'of {", ".join(joints)} the motion of {best} explains it best'

    def _blocks_of(self, count: int) -> list[list[str]]:
        """Return blocks of so many columns that stand together and have no role."""
        taken = self._taken()
        runs: list[list[str]] = [[]]
        for name in self.series:
            if name in taken or self.words[name].is_wish:
                runs.append([])
            else:
                runs[-1].append(name)
        blocks = [
            run[k : k + count]
            for run in runs
            if len(run) % count == 0
            for k in range(0, len(run), count)
        ]
        # The slopes of velocities are accelerations, where something else may be the effort.
        own = set(self._velocities())
        slopes = {s.velocity for s in self.slopes if s.position in own}
        return [b for b in blocks if not slopes >= set(b) & set(self.moving)] or blocks

    def _velocities(self) -> Iterable[str]:
        return [r['velocity'] for r in self.roles.values() if r.get('velocity') in self.moving]

    def _between(self, free: Sequence[str]) -> dict[str, list[str]]:
        """Return the free columns between each position and the next, if every joint has some."""
        names = list(self.series)
        starts = [names.index(roles['position']) for roles in self.roles.values()]
        ends = [*starts[1:], len(names)]
        found = {
            joint: [n for n in free if start < names.index(n) < end]
            for joint, start, end in zip(self.roles, starts, ends, strict=True)
        }
        return found if all(found.values()) else {}

    def _best_effort(self, joint: str, names: Sequence[str]) -> None:
        shares = {name: self._explained(name, joint) for name in names}
        measured = {n: x for n, x in shares.items() if not self.words[n].is_computed}
        if any(x >= EXPLAINED for x in measured.values()):
            shares = measured
        best = max(shares, key=lambda name: float(np.nan_to_num(shares[name], nan=-1.0)))
        if len(names) == len(self.roles) == 1 and not shares[best] >= EXPLAINED:
            self.roles[joint]['effort'] = best
            self.why[best] = 'the only column that is left, though it does not follow the motion'
            return
        if not shares[best] >= EXPLAINED:
            self._remark(f'no column follows the motion of {joint}: map its effort yourself')
            return
        position = self.roles[joint]['position']
        rough = [self.rough[n] for n in (position, best) if n in self.rough]
        if rough[-1] < _SMOOTHER * rough[0]:
            self._remark(
                f'{best} is about as smooth as {position}: it may be the position of another '
                'joint, and no effort'
            )
        self.roles[joint]['effort'] = best
        rest = ', '.join(n for n in names if n != best)
        self.why[best] = (
            f'direction, speed and acceleration of {position} explain '
            f'{100 * shares[best]:.0f} % of it' + (f', more than of {rest}' if rest else '')
        )

    def _effort_block(self, blocks: Sequence[Sequence[str]]) -> None:
        """Choose, of blocks of one column for each joint, that which was measured."""
        told = []
        for block in blocks:
            pairs = list(zip(block, self.roles, strict=True))
            shares = [self._explained(name, joint) for name, joint in pairs]
            noises = [evidence.noise(self.moving[name]) for name in block if name in self.moving]
            usable = [x for x in shares if math.isfinite(x)]
            if usable and max(usable) >= EXPLAINED:
                told.append((float(np.median(noises)), float(np.median(usable)), block))
        if not told:
            self._remark('no block of columns follows the motion: map the efforts yourself')
            return
        level, _, chosen = max(told, key=lambda entry: entry[0])
        rivals = [f'{b[0]} to {b[-1]}' for _, _, b in told if b is not chosen]
        for joint, name in zip(self.roles, chosen, strict=True):
            self.roles[joint]['effort'] = name
            self.why[name] = f'columns {chosen[0]} to {chosen[-1]} follow the motion of the joints'
        if rivals:
            self._remark(
                f'{chosen[0]} to {chosen[-1]} were taken for the effort, as they are the noisiest '
                f'({level:.2g} of their spread from sample to sample): measured, it seems, where '
                f'{" and ".join(rivals)} are computed'
            )

    def _put_remarks(self) -> None:
        taken = self._taken()
        for sentence in self.data.remarks:
            self._remark(sentence)
        strange = [joint for joint in self.roles if self.kinds and joint not in self.kinds]
        if strange:
            self._remark(
                f'{", ".join(strange)}: not in the URDF, which has {", ".join(self.kinds)}; call '
                'each joint as it does'
            )
        for name, word in self.words.items():
            if word.quantity == 'injected' and name not in taken:
                self._remark(
                    f'{name} may have been added to the command of a controller: if so, map it '
                    'as injected, in the unit of effort'
                )
        constants = {n: x for n, x in self.data.constants().items() if n not in self.series}
        if constants:
            listed = ', '.join(f'{name} = {value:.6g}' for name, value in constants.items())
            self._remark(f'constants of the file, which a scale may name: {listed}')
        for sentence in self._of_other_length():
            self._remark(sentence)
        for sentence in self._unread(*QUANTITIES):
            self._remark(f'not used: {sentence}')
        rest = [n for n in self.series if n not in taken]
        if rest:
            self._remark(f'not used: {", ".join(rest)}')


def _is_of_units(factor: float) -> bool:
    """Tell whether a slope per velocity is that of a position and a velocity in known units."""
    return any(
        place and speed and agree(factor * place, speed)
        for place in map(UNITS['position'].get, USUAL_POSITIONS)
        for speed in map(UNITS['velocity'].get, USUAL_VELOCITIES)
    )
