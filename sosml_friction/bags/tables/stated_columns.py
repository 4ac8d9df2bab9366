# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The mapping of columns whose quantities are stated, as on a command line."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from shlex import quote
from typing import Any

import numpy as np

from sosml_friction.bags.tables import series_evidence as evidence
from sosml_friction.bags.tables import units
from sosml_friction.bags.tables.data_file import DataFile
from sosml_friction.bags.tables.guess import Guesser
from sosml_friction.bags.tables.header_words import HeaderWord
from sosml_friction.bags.tables.mapping import FILL_IN
from sosml_friction.bags.tables.proposed_mapping import Guess
from sosml_friction.bags.tables.recorded_columns import ONE_RECORDING
from sosml_friction.exceptions import ConfigurationError, DataError


@dataclass(frozen=True)
class Columns:
    """
    State what columns are, as on a command line.

    ``time``: ``NAME`` or ``NAME:UNIT``, '' for that which grows all the time; ``rate``: samples
    per second in its place; ``quantities``: by quantity such entries, one for each joint,
    ``position`` among them; ``scales``: Nm or N at the joint per A, V or count, one or one for
    each joint; ``counts_per_turn`` of a position.
    """

    quantities: Mapping[str, Sequence[str]]
    time: str = ''
    scales: Sequence[float] = ()
    counts_per_turn: float | None = None
    rate: float | None = None


def map_columns(data: DataFile, columns: Columns, urdf_text: str | None = None) -> Guess:
    """
    Return the mapping of columns whose quantities are stated; time and units are proposed.

    :raises DataError: if the file does not have a column, or nothing tells a unit: the sentence
        says how to state it.
    :raises ConfigurationError: if an effort that is no torque has no constant.
    """
    return _StatedColumns(data, urdf_text, columns).guess()


class _StatedColumns(Guesser):
    def __init__(self, data: DataFile, urdf_text: str | None, columns: Columns) -> None:
        if columns.time and columns.rate is not None:
            raise ConfigurationError('--time and --rate both say when samples are: give one')
        self.data, self.series, self.columns = data, data.series(), columns
        name, unit = data.split_unit(columns.time)
        time = evidence.find_time(self.series, self._whole(name) if name else '')
        if unit:
            time = time._replace(unit=_known(unit, 'time', columns.time), reason='stated')
        stamps = self.series.get(time.name, np.zeros(1))
        back = np.flatnonzero(np.diff(stamps) < 0)
        if len(back) and columns.rate is None:
            k = int(back[0])
            raise DataError(
                f'{data.path}: {time.name} was stated as time and goes back '
                f'{len(back)} time{"s" if len(back) > 1 else ""}, first at row {k + 2} of the '
                f'data, from {stamps[k]} to {stamps[k + 1]}: sort the rows by it, split the file '
                'where a new recording begins, or name another column, which grows all the time'
            )
        self.named, self.positions = zip(
            *map(self._of_joint, columns.quantities['position']), strict=True
        )
        for column in self.positions:
            # Why one has no numbers says more than that nothing has.
            self._whole(data.split_unit(column)[0])
        super().__init__(data, urdf_text, time, columns.rate, self.named)

    def guess(self) -> Guess:
        """Return the mapping of the columns that are stated."""
        named, positions = self.named, self.positions
        ordered = {
            quantity: self._in_order(quantity, entries, named)
            for quantity, entries in self.columns.quantities.items()
        }
        stated = {
            quantity: [self._stated(quantity, entry) for entry in entries]
            for quantity, entries in {**ordered, 'position': positions}.items()
        }
        count = len(stated['position'])
        for quantity, names in stated.items():
            if len(names) != count:
                raise ConfigurationError(
                    f'{len(names)} columns of {quantity} are stated and {count} of position: name '
                    'one for each joint'
                )
        own = [name for names in stated.values() for name in names]
        twice = [name for name in own if own.count(name) > 1]
        if twice:
            raise ConfigurationError(
                f'column {twice[0]} is stated twice, and each is one quantity of one joint: where '
                'files have a quantity each, put their columns into one table'
            )
        self._put_time()
        if self.rate is None and not self.time.unit:
            if not self.time.name and (unread := self._unread('time')):
                raise DataError(unread[0])
            name = self.time.name and f', time {self.time.name}'
            raise DataError(
                f'{self.data.path}{name}: {self.time.reason}: say which column is time and its '
                'unit, as --time NAME:ms, or, without a time, how many samples a second has, '
                + (self._stated_rate() or 'as --rate 500')
            )
        joints = list(named) if all(named) else self._places(stated['position'])
        strange = [joint for joint in joints if self.kinds and joint not in self.kinds]
        if strange or len(set(joints)) < count:
            known = ', '.join(self.kinds) or 'joint'
            raise ConfigurationError(
                f'the columns of position are stated for {", ".join(joints)}, and the robot has '
                f'{known}: say which joint each is, as --position {known.split(", ")[0]}='
                f'{positions[0]}'
            )
        self.roles = {
            joint: {quantity: names[k] for quantity, names in stated.items()}
            for k, joint in enumerate(joints)
        }
        self.result.content['joints'] = {}
        for k, (joint, roles) in enumerate(self.roles.items()):
            self._put_joint(joint, roles)
            self._close(joint, self.result.content['joints'][joint], k)
        return self.result

    def _places(self, positions: Sequence[str]) -> list[str]:
        """Return the joints of columns by where these are, or by their names."""
        keys = [''] if len(positions) == 1 else [str(k) for k in range(1, len(positions) + 1)]
        at = [list(self.series).index(name) for name in positions]
        names = self._joint_names(keys, at == sorted(at)).values()
        return self._by_place(positions) or list(names)

    def _by_place(self, positions: Sequence[str]) -> list[str]:
        """Return the joints of columns of one list by their places in that of the names."""
        parts = [re.fullmatch(r'(.+)\[(\d+)\]', name) for name in positions]
        lists = {part[1] for part in parts if part}
        if None in parts or len(lists) != 1 or not lists <= set(self.data):
            return []
        names = self._listed(min(self.data[lists.pop()].shape))
        return [names[int(part[2])] for part in parts if part] if len(names) > 1 else []

    def _of_joint(self, entry: str) -> tuple[str, str]:
        """Return the joint, '' if none is named, and the rest of ``JOINT=COLUMN``."""
        parts = entry.split('=')
        for k in range(len(parts)):
            joint, column = '='.join(parts[:k]), '='.join(parts[k:])
            if self.data.find(self.data.split_unit(column)[0]) is not None:
                return joint, column
        return (parts[0], '='.join(parts[1:])) if parts[1:] and parts[0] else ('', entry)

    def _in_order(
        self, quantity: str, entries: Sequence[str], joints: Sequence[str]
    ) -> Sequence[str]:
        """Return the columns of a quantity in the order of the positions, if joints are named."""
        named, columns = zip(*map(self._of_joint, entries), strict=True)
        if not any(named):
            return entries
        if sorted(named) != sorted(joints):
            raise ConfigurationError(
                f'the columns of {quantity} are stated for {", ".join(n or "?" for n in named)}, '
                f'those of position for {", ".join(n or "?" for n in joints)}: name the same '
                'joints, as --position elbow=q2 --effort elbow=tau2'
            )
        return [columns[named.index(joint)] for joint in joints]

    def _whole(self, name: str) -> str:
        """Return the name of a series as the file has it."""
        found = self.data.find_series(name)
        if found not in self.series:
            if self.data.find(name) and self.data[found].ndim < 2:
                raise DataError(
                    f'{self.data.path}: {found!r} has {self.data[found].size} values, and most '
                    f'have {max(map(len, self.series.values()), default=0)}: each sample needs one'
                )
            table = self.data.find(re.sub(r'(\[\d+\])+$', '', name))
            if table and self.data[table].ndim > 2:
                raise DataError(
                    f'{self.data.path}: {table} has the shape {self.data[table].shape}: '
                    f'{ONE_RECORDING}'
                )
            known = ', '.join(self.series) or 'none'
            raise DataError(f'{self.data.path} has no series {name!r}: it has {known}')
        return found

    def _stated(self, quantity: str, entry: str) -> str:
        """Return the column of ``NAME`` or ``NAME:UNIT``, and keep what is known of its unit."""
        name, unit = self.data.split_unit(entry)
        whole = self._whole(name)
        word = self.words[whole]
        said = word.unit if word.quantity == quantity else ''
        if unit:
            said = _known(unit, quantity, entry)
            self.stated_units.add(whole)
        if quantity == 'effort' and word.quantity == 'effort' and word.is_foreign:
            self._remark(
                f'{whole} is by its name not what drives the joint, but external, computed, of a '
                'supply or a limit: friction is in what was measured at the motor'
            )
        strange = '' if unit else word.strange
        # What stands behind a name is as good as what stands behind an option.
        written = bool(unit) or (word.quantity == quantity and word.is_unit_written)
        self.words[whole] = HeaderWord(quantity, said, word.joint, False, written, strange)
        self.why[whole] = 'stated'
        return whole

    def _close(self, joint: str, own: dict[str, Any], index: int) -> None:
        """Fill in what was stated beside the columns; refuse what is still open."""
        position = own['position']
        turn = self.columns.counts_per_turn
        for entry in (position, own.get('velocity', {})):
            if 'counts_per_unit' in entry:
                raise ConfigurationError(
                    f'{entry["variable"]} is in {entry["unit"]} of what slides: say how many a m '
                    'has, as counts_per_unit in a mapping (sosml import --guess writes one, --map '
                    'takes it), or another unit'
                )
            if 'counts_per_turn' in entry:
                if turn is None:
                    raise ConfigurationError(
                        f'{entry["variable"]} is in {entry["unit"]}: give those of a turn, as '
                        '--counts-per-turn 4096, or another unit'
                    )
                entry['counts_per_turn'] = turn
        slides = self.kinds.get(joint) == 'prismatic'
        if position['unit'] == FILL_IN:
            _, why = self._position_unit(joint)
            entry = quote(f'{position["variable"]}:{"mm" if slides else "deg"}')
            other = quote(f'{position["variable"]}:counts')
            raise DataError(
                f'{self.data.path}, position {position["variable"]}: {why}: say which, as '
                f'--position {entry}; in another unit --position {other} --counts-per-turn with '
                'how many of it a turn has'
            )
        if FILL_IN in own.get('velocity', {}).values():
            why = self.result.reasons.pop(f'joints.{joint}.velocity')
            name = own.pop('velocity')['variable']
            self._remark(f'velocity {name} is left out: {why.split("; a scale")[0]}')
        effort = own.get('effort')
        for quantity, entry in own.items() if joint in self.kinds else ():
            if entry['unit'] in (units.ANGULAR_UNITS if slides else units.LINEAR_UNITS):
                raise ConfigurationError(
                    f'joint {joint} {"slides" if slides else "turns"} and its {quantity} '
                    f'{entry["variable"]} is in {entry["unit"]}: correct the unit or the robot'
                )
        if effort is None:
            return
        scales = self.columns.scales
        if effort['unit'] == FILL_IN:
            unit = 'N' if position['unit'] in units.LINEAR_UNITS else 'Nm'
            name = self.roles[joint]['effort']
            objection = self.words[name].objection or self._coarse(name)
            if objection:
                entry, other = (quote(f'{effort["variable"]}:{u}') for u in (unit, 'counts'))
                raise ConfigurationError(
                    f'effort {effort["variable"]}: {objection}: if it is {unit}, --effort '
                    f'{entry}; in another unit --effort {other} --kt with the {unit} that one '
                    'of it makes'
                )
            effort['unit'] = unit
            self.result.reasons[f'joints.{joint}.effort'] = (
                f'taken as {effort["unit"]}, as nothing tells another unit'
            )
        if units.UNITS['effort'][effort['unit']] is None:
            if not scales:
                raise ConfigurationError(
                    f'effort {effort["variable"]} is in {effort["unit"]}: give the Nm (or N) at '
                    f'the joint that one of it makes, as --kt 1.8'
                )
            scale = scales[index % len(scales)]
            self.result.reasons[f'joints.{joint}.effort'] = (
                f'stated, {scale:g} {"N" if position["unit"] in units.LINEAR_UNITS else "Nm"} per '
                f'{effort["unit"].removeprefix("m")}'
            )
            effort['scale'] = scale * {'mA': 1e-3, 'mV': 1e-3}.get(effort['unit'], 1.0)
        elif scales:
            raise ConfigurationError(
                f'--kt is given and effort {effort["variable"]} is in {effort["unit"]}: leave '
                f'--kt out, or state the unit, as --effort {effort["variable"]}:A'
            )


def _known(unit: str, quantity: str, entry: str) -> str:
    found = units.known_unit(unit, quantity)
    if not found:
        raise ConfigurationError(
            f'{entry} has the unknown unit {unit!r}: known are {units.known_units(quantity)}'
        )
    return found
