# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is known of the columns of one file, and the entries of a mapping that follow from it."""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.tables import series_evidence as evidence
from sosml_friction.bags.tables.data_file import DataFile
from sosml_friction.bags.tables.file_kind import TEXT_SUFFIXES, file_kind
from sosml_friction.bags.tables.header_words import HeaderWord, read_header, read_headers
from sosml_friction.bags.tables.importer import recognised_wrap
from sosml_friction.bags.tables.lost_sign import with_sign
from sosml_friction.bags.tables.mapping import FILL_IN
from sosml_friction.bags.tables.missing_markers import missing_markers
from sosml_friction.bags.tables.proposed_mapping import Guess
from sosml_friction.bags.tables.series_evidence import counts_samples
from sosml_friction.bags.tables.units import LINEAR_UNITS, TIME_UNITS, UNITS
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.model.urdf_joints import read_joints

#: Two figures of one quantity agree if they are this close: units are further apart.
SAME = 0.05
#: Spans that a joint has in rad: less may be metres, more degrees or a shaft that turns freely.
_RAD_SPAN = (0.5, 4.0 * math.pi)
#: No joint that moves less is as far from 0 in rad; at 90 it is in deg. Chosen, no measurement.
_FAR = 2.0 * _RAD_SPAN[1]
#: A slide moves less [m]: more is in mm or, from as many mm on, in counts. Chosen, no
#: measurement.
_LONGEST_SLIDE = 5.0
#: Turns, and the +-12.5 rad of the frames that CAN servos took over from MIT's Mini Cheetah.
_UNIT_OF_WRAP = {
    2.0 * math.pi: 'rad', math.pi: 'rad', 25.0: 'rad', 360.0: 'deg', 180.0: 'deg', 1.0: 'turns',
}  # fmt: skip
#: Units that the numbers alone may tell; of others the name or the user says that it is them.
USUAL_POSITIONS = ('rad', 'deg', 'turns', 'm', 'mm')
USUAL_VELOCITIES = ('rad/s', 'deg/s', 'rpm', 'turns/s', 'm/s', 'mm/s')
#: deg per rpm and rad per turns/s are 5 % apart, which a factor must tell; those of measured
#: velocities are within 1 % as a rule.
_SURELY_SAME = 0.01
#: Whole numbers above this are no measurement in A, V, Nm or N: its resolution would be too
#: coarse for that. Chosen, no measurement.
_COARSE = 20.0
#: A motion has steps of less than this share of its spread; of white noise they are sqrt(2) of it.
#: Chosen, no measurement.
_ROUGH = 0.3
#: What the rate of samples is called in a file [Hz], and the time from one to the next [s].
_RATES, _STEPS = frozenset(('fs', 'fps', 'rate', 'frequency', 'hz')), frozenset(('dt', 'ts', 'te'))
#: A line that says a rate or a step: Sampling period is 1000000 nSec.
_OF_RATE = re.compile(
    r'\W*([a-z]+ )*(sampl|rate|period|interval|freq|fs\b|dt\b)\D{0,20}(?<!\w)[\d.]+\W{0,2}\w*\W*',
    re.IGNORECASE,
)
#: What is called a time and falls in more steps than these is none: t of p, v, t is a torque.
#: Chosen, no measurement.
_FALLS = 0.1
#: The number of a column in its table: qpos[3], qpos_3.
_NUMBER = re.compile(r'_?\[?\d+\]?$')
#: What to do with an array of several recordings, or of several robots.
ONE_RECORDING = 'give one recording of it, as a table of samples and joints'


class RecordedColumns:
    """Hold by joint the columns of its quantities (``roles``), and why, by column."""

    def __init__(
        self,
        data: DataFile,
        urdf_text: str | None,
        time: evidence.Time | None = None,
        rate: float | None = None,
        joints: Iterable[str] = (),
    ) -> None:
        if rate is not None and not 0.0 < rate < 1e9:
            raise ConfigurationError(
                f'a rate of {rate:g} Hz is none: give the samples per second, as --rate 500'
            )
        self.rate = rate
        self.data = data
        self.series = data.series()
        self.result = Guess()
        self.is_named = not all(name.isdecimal() for name in data)
        known = {} if urdf_text is None else read_joints(urdf_text).joints
        self.kinds = {
            name: joint.kind
            for name, joint in known.items()
            if joint.is_single and joint.mimic is None
        }
        self.words = read_headers(self.series, (*joints, *self.kinds))
        for name, word in self.words.items():
            steps = np.diff(self.series[name])
            falls = (steps < 0).mean() if len(steps) else 0.0
            if not self.is_named or (word.quantity == 'time' and falls > _FALLS):
                self.words[name] = HeaderWord()
            elif 'time' in name.lower() and (steps > 0).all():
                # Where each signal has a time of its own: Time_q, q, Time_tau, tau.
                self.words[name] = word._replace(quantity='time')
        self._leave_out_base()
        self.time = evidence.find_time(self.series) if time is None else time
        own = self.time.name
        if rate is not None and not (
            own and (read_header(own).quantity == 'time' or counts_samples(self.series[own]))
        ):
            # A shaft that turns one way grows all the time too.
            self.time = evidence.Time('', '', '')
        for name, values in self.series.items():
            if name not in (self.time.name, self.time.nanoseconds):
                quantity = self.words[name].quantity
                signed = with_sign(values) if quantity in ('velocity', 'effort') else None
                values = values if signed is None else signed
                markers = missing_markers(values, quantity)
                is_marker = np.isin(values, markers)
                self.series[name] = np.where(is_marker, np.nan, values) if markers else values
        self.count = max((len(x) for x in self.series.values()), default=0)
        if not self.count:
            objects = '; save objects of MATLAB, such as timeseries, as structs or numbers'
            is_mat = self.data.path.suffix.lower() == '.mat'
            told = '; '.join(self._of_other_length()) or (
                f'holds no numbers: give a recording{objects if is_mat else ""}'
            )
            raise DataError(f'{self.data.path} {told}')
        if self.time.name and rate is None:
            self._tell_time()
        self.t: FloatArray = np.arange(float(self.count)) / (rate or 1.0)
        if self.time.name and self.time.unit and rate is None:
            self.t = evidence.seconds(self.series, self.time)
            # What repeats a stamp has no slope, and is left out when the file is read.
            new = np.diff(self.t, prepend=-np.inf) != 0.0
            self.t = self.t[new]
            self.series = {name: x[new] for name, x in self.series.items()}
        stamps = (self.time.name, self.time.nanoseconds)
        others = {
            name: x
            for name, x in self.series.items()
            if name not in stamps and not counts_samples(x)
        }
        self.moving = evidence.moving(self.t, others)
        self.rough = {name: evidence.roughness(x) for name, x in self.moving.items()}
        self.slopes = evidence.slopes(self.t, self.moving) if (np.diff(self.t) > 0).any() else []
        self.stated_units: set[str] = set()
        self.roles: dict[str, dict[str, str]] = {}
        self.why: dict[str, str] = {}
        # Positions that are nearly the same: one is measured, the others are its references.
        self.alike: set[str] = set()

    def _leave_out_base(self) -> None:
        """Count the joints of a robot with a free base, a place and a quaternion, behind that."""
        lists: dict[str, list[str]] = {}
        for name in self.series:
            lists.setdefault(_NUMBER.sub('', name), []).append(name)
        for own in list(lists.values()):
            turn = np.array([self.series[name] for name in own[3:7]], float)
            is_base = len(own) > 7 and self.words[own[0]].quantity == 'position'
            if not is_base or not np.allclose(np.sum(turn**2, axis=0), 1.0, atol=1e-3):
                continue
            for names in lists.values():
                # Its velocities and forces are one fewer.
                first = {len(own): 7, len(own) - 1: 6}.get(len(names), 0)
                for k, name in enumerate(names if first else ()):
                    joint = re.sub(r'\d+$', str(k - first), self.words[name].joint)
                    is_of_base = k < first
                    self.words[name] = self.words[name]._replace(joint=joint, is_wish=is_of_base)
            self._remark(f'{own[0]} to {own[6]} are a free base and no joints: left out')

    def _tell_time(self) -> None:
        """Let velocities tell the unit of stamps, where neither their name nor a user does."""
        word = read_header(self.time.name)
        is_said = word.strange or (word.quantity == 'time' and word.unit)
        if is_said or self.time.nanoseconds or self.time.reason == 'stated':
            return
        stamps = (self.series[self.time.name] - self.series[self.time.name][0]).astype(float)
        others = {n: x for n, x in self.series.items() if n != self.time.name}
        size = evidence.step_by_slopes(stamps, evidence.moving(stamps, others))
        unit = next((u for u, ns in TIME_UNITS.items() if size and ns == round(1e9 * size)), '')
        if size and unit != self.time.unit:
            why = f'velocities are the slopes of positions in {unit or f"steps of {size:g} s"}'
            reason = self.time.reason.split('; ')[0]
            self.time = self.time._replace(unit=unit, reason=f'{reason}; {why}')

    def _put_time(self) -> None:
        content, reasons = self.result.content, self.result.reasons
        if self.rate is not None:
            content['sample_rate'] = self.rate
            reasons['sample_rate'] = 'stated'
            if self.time.unit:
                span = float(evidence.seconds(self.series, self.time)[-1])
                rate = (self.count - 1) / span
                if not agree(rate, self.rate):
                    self._remark(
                        f'{self.time.name} makes {rate:.4g} Hz of it, and the rate of '
                        f'{self.rate:g} Hz that was stated was taken'
                    )
        elif self.time.name:
            content['time'] = {'variable': self._variable(self.time.name)}
            content['time']['unit'] = self.time.unit or FILL_IN
            reasons['time'] = self.time.reason
            if self.time.nanoseconds:
                content['time']['nanoseconds'] = self._variable(self.time.nanoseconds)
        else:
            content['sample_rate'] = FILL_IN
            why = next(iter(self._unread('time')), self.time.reason)
            ask = f'give the samples per second, {self._stated_rate() or "or --rate HZ"}'
            reasons['sample_rate'] = f'{why}: {ask}'
        self._tell_runs()

    def _tell_runs(self) -> None:
        """Say where what is called a time begins anew, as where recordings were joined."""
        for name, word in self.words.items():
            # Nanoseconds beside seconds begin anew every second.
            is_clock = word.quantity == 'time' and not evidence.FINE.search(name.lower())
            back = np.flatnonzero(np.diff(self.series[name]) < 0)
            if is_clock and len(back):
                self._remark(
                    f'{name} goes back at index {back[0] + 1}, and {len(back)} times in all: '
                    'recordings behind one another, it seems; give each as a file of its own'
                )

    def _stated_rate(self) -> str:
        """Return the rate that a number of the file speaks for, as an option; '' if none does."""
        for name, value in self.data.constants().items():
            last = re.split(r'[^a-z]+', name.lower())[-1]
            rate = value if last in _RATES else 1.0 / value if last in _STEPS and value else 0.0
            if rate > 0.0:
                return f'as --rate {rate:.6g}, which {name} = {value:g} speaks for'
        said = self._line_of_rate()
        return f'as --rate HZ; its line {said!r} may say it' if said else ''

    def _line_of_rate(self) -> str:
        """Return a line of a text above the table that may say how often was sampled, or ''."""
        if file_kind(self.data.path) not in TEXT_SUFFIXES:
            return ''
        with self.data.path.open('rb') as stream:
            lines = stream.read(4096).decode('latin-1').splitlines()
        return next((line.strip() for line in lines if _OF_RATE.fullmatch(line)), '')

    def _unread(self, *quantities: str) -> list[str]:
        """Return why each column that is called one of these cannot be read as numbers."""
        told = []
        for name in self.data:
            if name not in self.series and read_header(name).quantity in quantities:
                try:
                    self.data[name]
                except DataError as error:
                    told.append(str(error))
        return told

    def _variable(self, name: str) -> str | int:
        return int(name) if name.isdecimal() else name

    def _nearly_same(self, one: str, other: str) -> bool:
        apart = self.moving[one] - self.moving[other]
        return float(np.std(apart)) < SAME * float(np.std(self.moving[one]))

    def _position_unit(self, joint: str) -> tuple[str, str]:
        """Return the unit of a joint's position, FILL_IN where nothing tells, and why."""
        name = self.roles[joint]['position']
        word = self.words[name]
        if word.unit:
            return word.unit, 'stated' if name in self.stated_units else 'its name has the unit'
        if word.strange:
            return FILL_IN, word.objection
        period = self._wrap(name)
        if period in _UNIT_OF_WRAP:
            return _UNIT_OF_WRAP[period], f'it wraps at {period:.6g}'
        velocity = self.roles[joint].get('velocity')
        slope = self._slope(name, velocity)
        if slope is not None and velocity and self.words[velocity].is_unit_written:
            written = self.words[velocity].unit
            fitting = _units_of_slope(slope.factor, (written,), SAME)
            if fitting:
                return fitting[0], f'its slope is {velocity} in {written}'
        kind = self.kinds.get(joint)
        is_timed = bool(self.time.unit) or self.rate is not None
        if slope is not None and velocity and is_timed and not self.words[velocity].unit:
            fitting = _units_of_slope(slope.factor, USUAL_VELOCITIES, _SURELY_SAME)
            if kind is not None:
                fitting = [u for u in fitting if (u in LINEAR_UNITS) == (kind == 'prismatic')]
            if len(fitting) == 1:
                return fitting[0], f'only of {fitting[0]} {velocity} is the slope in a usual unit'
        # Joints that slide say nothing of one that turns.
        alike = {
            j: r['position']
            for j, r in self.roles.items()
            if (self.kinds.get(j) == 'prismatic') == (kind == 'prismatic')
        }
        spans = {j: float(np.ptp(self.moving[x])) for j, x in alike.items() if x in self.moving}
        span = spans.get(joint, 0.0) if kind == 'prismatic' else max(spans.values(), default=0.0)
        if kind == 'prismatic' and span < 1e3 * _LONGEST_SLIDE:
            in_m = span < _LONGEST_SLIDE
            return ('m', 'it slides in the URDF') if in_m else ('mm', f'it moves {span:.3g}')
        values = self.series[name]
        if span > 100.0 and np.isfinite(values).all() and (values == np.rint(values)).all():
            return 'counts', f'whole numbers, {np.ptp(values):.0f} from end to end'
        far = max(map(self._farthest, alike.values()), default=0.0)
        own = spans.get(joint, 0.0)
        if span <= _RAD_SPAN[1] and far > _FAR:
            return FILL_IN, (
                f'it moves {own:.3g}, and one of the joints is at {far:.3g}: deg or mm, it '
                'seems, or rad after many turns'
            )
        widest = max(spans, key=lambda j: spans[j], default=joint)
        moves = f'{own:.3g}' + f', and {widest} {span:.3g}' * (own < span)
        if kind is not None and span < _RAD_SPAN[1]:
            return 'rad', f'it turns in the URDF, and moves {moves}'
        if _RAD_SPAN[0] <= span <= _RAD_SPAN[1] and kind is None:
            most = 'it moves' if len(spans) == 1 else 'the joint that moves most moves'
            return (
                'rad',
                f'taken as rad, as {most} {span:.3g}; it may be deg or turns, or m if it slides',
            )
        return FILL_IN, f'it moves {moves}, which may be rad, deg, m, mm, turns or counts'

    def _farthest(self, position: str) -> float:
        """Return how far from 0 a position without a unit is, moving or not."""
        values = np.abs(self.series[position][np.isfinite(self.series[position])])
        return 0.0 if self.words[position].unit else float(np.max(values, initial=0.0))

    def _counts_per(self, joint: str) -> str:
        """Return the entry that says how much counts of a joint are."""
        slides = self.kinds.get(joint) == 'prismatic'
        return 'counts_per_unit' if slides else 'counts_per_turn'

    def _wrap(self, name: str, unit: str = '') -> float | None:
        return recognised_wrap(self.t, self.series[name].astype(np.float64), unit)

    def _slope(self, position: str, velocity: str | None) -> evidence.Slope | None:
        mine = [s for s in self.slopes if (s.position, s.velocity) == (position, velocity)]
        return mine[0] if mine else None

    def _put_joint(self, joint: str, roles: Mapping[str, str]) -> None:
        own: dict[str, Any] = {}
        self.result.content['joints'][joint] = own
        reasons = self.result.reasons
        unit, why = self._position_unit(joint)
        name = roles['position']
        own['position'] = {'variable': self._variable(name), 'unit': unit}
        if unit == 'counts':
            own['position'][self._counts_per(joint)] = FILL_IN
        period = self._wrap(name, unit)
        if period is not None:
            own['position']['wrap'] = float(f'{period:.9g}')
            why += '; it jumps back by one and the same size'
        known = 'unit open' if unit == FILL_IN else unit
        reasons[f'joints.{joint}.position'] = f'{self.why[name]}; {known}: {why}'
        if 'velocity' in roles:
            own['velocity'], told = self._velocity(joint, unit)
            reasons[f'joints.{joint}.velocity'] = told
        if 'effort' in roles:
            effort = roles['effort']
            word = self.words[effort]
            # What makes a joint slide may be called a torque all the same.
            is_called = word.unit == 'Nm' and not word.is_unit_written
            coarse = self._coarse(effort)
            is_open = is_called and (unit in LINEAR_UNITS or bool(coarse))
            unit = FILL_IN if is_open else word.unit or FILL_IN
            own['effort'] = {'variable': self._variable(effort), 'unit': unit}
            told = self.why[effort]
            if unit == FILL_IN:
                told += f'; {word.objection or coarse or "nothing tells its unit"}: '
                told += 'Nm, N, or A, V or counts with scale: Nm or N per unit'
            elif UNITS['effort'][unit] is None:
                own['effort']['scale'] = FILL_IN
                told += f'; {unit} by its name: the scale is the Nm or N at the joint per {unit}'
            else:
                told += f'; {unit} by its name'
            reasons[f'joints.{joint}.effort'] = told
            most = self._whole_numbers(effort)
            if unit in ('A', 'V', 'Nm', 'N') and most > _COARSE:
                self._remark(
                    f'{effort} has whole numbers up to {most:g} and is taken as {unit}: if it is '
                    f'm{unit}, percent or counts, say so, as {effort}:m{unit}'
                )
        if 'temperature' in roles:
            name = roles['temperature']
            unit = self.words[name].unit or ('degC' if not self.words[name].strange else FILL_IN)
            own['temperature'] = {'variable': self._variable(name), 'unit': unit}

    def _coarse(self, effort: str) -> str:
        """Return why a column without a unit is hardly in Nm or N, '' if it may be."""
        most = self._whole_numbers(effort)
        return f'whole numbers up to {most:g}, per mille or counts, it seems' * (most > _COARSE)

    def _whole_numbers(self, name: str) -> float:
        """Return the largest size of a column of whole numbers, 0 where it has others."""
        values = self.series[name][np.isfinite(self.series[name])]
        is_whole = len(values) > 0 and bool((values == np.rint(values)).all())
        return float(np.abs(values).max()) if is_whole else 0.0

    def _velocity(self, joint: str, unit: str) -> tuple[dict[str, Any], str]:
        """Return the entry of a velocity by the factor between it and the slope of position."""
        position, velocity = (self.roles[joint][role] for role in ('position', 'velocity'))
        entry: dict[str, Any] = {'variable': self._variable(velocity)}
        slope = self._slope(position, velocity)
        written = self.words[velocity].unit
        # What goes with the unit of position, where nothing tells another.
        usual = f'{unit}/s' if UNITS['velocity'].get(f'{unit}/s') else FILL_IN
        si = UNITS['position'].get(unit)
        if slope is None:
            entry['unit'] = written or usual
            why = self.why.get(velocity, 'its place says so')
            others = [s.position for s in self.slopes if s.velocity == velocity and s.cosine > 0.0]
            if others:
                why += f', but it is the slope of {others[0]}: look whether columns are swapped'
                return entry, why
            # Noise about a place is no motion.
            moves = self.rough.get(position, math.inf) < _ROUGH
            if moves and velocity in self.moving:
                entry['scale'] = FILL_IN
                return entry, (
                    f'{why}, but it is not the slope of {position}; a scale says that it is right '
                    'all the same; without this line the velocity comes from position'
                )
            rests = 'the joint rests, so that nothing but the unit of position tells its own'
            return entry, f'{why}; {rests}'
        told = f'slope of {position}, cosine {slope.cosine:.4f}, by a factor of {slope.factor:.4g}'
        if not self.time.unit and self.rate is None:
            entry['unit'] = written or usual
            return entry, f'slope of {position}, cosine {slope.cosine:.4f}, in an unknown time'
        if si is None:
            is_of_counts = unit == 'counts' and agree(slope.factor, 1.0)
            entry['unit'] = written or ('counts/s' if is_of_counts else FILL_IN)
            if entry['unit'] == 'counts/s':
                entry[self._counts_per(joint)] = FILL_IN
            return entry, f'{told}; its unit depends on that of position'
        slides = unit in LINEAR_UNITS
        units = [u for u in USUAL_VELOCITIES if slides == (u in LINEAR_UNITS)]
        units = list(dict.fromkeys([written, *units])) if written else units
        fitting = [u for u in units if agree(slope.factor * si, UNITS['velocity'][u] or 0.0)]
        if fitting and written in ('', *fitting):
            entry['unit'] = fitting[0]
            return entry, told
        entry['unit'] = written or units[0]
        entry['scale'] = FILL_IN
        per = slope.factor * si / (UNITS['velocity'].get(entry['unit']) or 1.0)
        return entry, (
            f'{told}: no unit explains it, but stamps of another rate would; a scale of '
            f'{per:.4g} makes it the slope; without this line the velocity comes from position'
        )

    def _remark(self, sentence: str) -> None:
        if sentence not in self.result.remarks:
            self.result.remarks.append(sentence)

    def _of_other_length(self) -> list[str]:
        """Return a sentence on each variable of another length than most, numbers alone not."""
        told = []
        for name, values in self.data.arrays():
            shape = values.shape
            if len(shape) > 2:
                told.append(f'{name} has the shape {shape}: {ONE_RECORDING}')
            elif shape and self.count not in shape:
                told.append(f'{name} has {max(shape)} values, and most have {self.count}')
        return told


def agree(one: float, other: float, share: float = SAME) -> bool:
    """Tell whether two figures are close enough for one quantity in one unit."""
    return abs(one - other) <= share * abs(other)


def _units_of_slope(factor: float, velocities: Sequence[str], share: float) -> list[str]:
    """Return the units of position whose slope, by a factor, is in one of these of velocity."""
    pairs = [
        (unit, factor * (UNITS['position'][unit] or 0.0), UNITS['velocity'].get(own))
        for unit in USUAL_POSITIONS
        for own in velocities
        if (unit in LINEAR_UNITS) == (own in LINEAR_UNITS)
    ]
    found = (unit for unit, speed, si in pairs if si and agree(speed, si, share))
    return list(dict.fromkeys(found))
