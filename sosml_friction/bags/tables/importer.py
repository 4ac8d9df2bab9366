# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Turn a recording of any kind of file into a bag, as a mapping says."""

import math
import os
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sosml_friction.arrays import BoolArray, FloatArray, IndexArray
from sosml_friction.bags.controllers import controller_tags
from sosml_friction.bags.joint_log import LARGEST, JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.bags.sampling import RATES, repeated_rows
from sosml_friction.bags.tables.data_file import DataFile
from sosml_friction.bags.tables.lost_sign import with_sign
from sosml_friction.bags.tables.mapping import ImportMapping, Series, Signal, read_mapping
from sosml_friction.bags.tables.missing_markers import missing_markers
from sosml_friction.bags.tables.overflow import without_overflow
from sosml_friction.bags.tables.units import ANGULAR_UNITS, LINEAR_UNITS, TIME_UNITS
from sosml_friction.bags.wrap import wrap_period
from sosml_friction.exceptions import BagError, ConfigurationError, DataError
from sosml_friction.model.urdf_joints import read_joints
from sosml_friction.text_file import read_text

#: Takes a sentence about what was done to the data.
Tell = Callable[[str], None]
#: More repeated stamps than these are no slips of a logger: the time is too coarse.
_REPEATED = 0.05
#: Share by which a period may miss that of a counter's register: the joint moves during the jump.
_REGISTER = 0.02


def import_recording(
    source: str | Path,
    mapping: str | Path | ImportMapping,
    destination: str | Path,
    tell: Tell = lambda sentence: None,
) -> Path:
    """
    Write the recording ``source`` as the bag ``destination`` and return its path.

    The bag holds joint_states (SI units; a quantity no joint has stays an empty array; NaN stays
    NaN), joint_temperatures and controller_reference where mapped, and the robot's and model's
    description where the mapping names their files; what a controller's command had added to it is
    ``injected_effort``. The stamp is the start time (0 unless given) plus the time in the file. If
    anything is wrong, nothing is written.

    :param mapping: a file, or what was read from one.
    :param tell: is given a sentence on everything that was done to the data unasked.
    :raises ConfigurationError: if the mapping is wrong (see
        :mod:`sosml_friction.bags.tables.mapping`) or a joint is not in its URDF.
    :raises DataError: if the file does not hold what the mapping says, or time does not increase.
    :raises BagError: if the bag exists or cannot be written.
    """
    destination = Path(destination)
    plan = mapping if isinstance(mapping, ImportMapping) else read_mapping(mapping)
    if destination.exists():
        raise BagError(
            f'{destination} exists and is not overwritten: choose another name or remove it'
        )
    reading = _Reading(source, plan, tell)
    log = reading.log()
    positions = {name: loop.reference for name, loop in plan.controllers.items()}
    reference = reading.table('reference', positions)
    injected = reading.table('injected signal', plan.injected)
    robot_description = None if plan.urdf is None else _robot_description(plan.urdf, plan)
    model_description = None if plan.model is None else read_text(plan.model, 'model')
    # Made beside its place and moved there whole, so that no half of a bag is ever found.
    existing = next(parent for parent in destination.absolute().parents if parent.exists())
    try:
        with tempfile.TemporaryDirectory(
            prefix='.sosml_import_', dir=existing, ignore_cleanup_errors=True
        ) as workshop:
            made = write_joint_log(
                log,
                Path(workshop) / destination.name,
                robot_description,
                model_description,
                reference,
                injected,
            )
            destination.parent.mkdir(parents=True, exist_ok=True)
            os.rename(made, destination)
    except OSError as error:
        raise BagError(
            f'{destination} cannot be written: {error.strerror}: choose another place'
        ) from error
    return destination


def read_recording(
    source: str | Path, plan: ImportMapping, tell: Tell = lambda sentence: None
) -> JointLog:
    """
    Return the JointLog that a data file holds according to a mapping.

    Samples that repeat the stamp before them are left out. A position that wraps is unwrapped.

    :raises DataError: if the file does not hold what the mapping says, or time does not increase.
    :raises ConfigurationError: if the mapping does not fit the file.
    """
    return _Reading(source, plan, tell).log()


class _Reading:
    """Read a data file by a mapping: its stamps first, then quantities in SI units."""

    def __init__(self, source: str | Path, plan: ImportMapping, tell: Tell) -> None:
        self.data = data = DataFile(source, plan.rows, plan.columns)
        self.path, self.plan, self.tell = data.path, plan, tell
        for sentence in data.remarks:
            tell(sentence)
        first = next(iter(plan.joints.values()))['position'].series
        count = len(self._series(first if plan.time is None else plan.time))
        if count == 0:
            raise DataError(f'{self.path} holds no samples: give a recording')
        #: Stamps of all samples of the file [ns].
        self.t_ns = self._stamps(count)
        new = np.diff(self.t_ns) != 0
        #: Which samples do not repeat the stamp before them.
        self.kept = np.append(True, new)
        if not self.kept.all():
            what = 'stamp' if (~self.kept & ~self._repeats(self.t_ns)).any() else 'sample'
            tell(
                f'{self.path}: {int(np.sum(~new))} of {count} samples repeat the {what} before '
                'them and are left out'
            )

    def log(self) -> JointLog:
        """Return the motion of all joints."""
        plan, arrays = self.plan, {}
        for quantity in ('position', 'velocity', 'effort', 'temperature'):
            signals = {n: own[quantity] for n, own in plan.joints.items() if quantity in own}
            arrays[quantity] = self.table(quantity, signals)
        unknown = np.full((int(self.kept.sum()), len(plan.joints)), np.nan)
        q, v, tau = (
            unknown if (own := arrays[quantity]) is None else own
            for quantity in ('position', 'velocity', 'effort')
        )
        gains = {
            name: {key: self._one_number(value) for key, value in loop.gains.items()}
            for name, loop in plan.controllers.items()
        }
        tags = {**plan.tags, **controller_tags(gains)}
        t_ns = self.t_ns[self.kept]
        return JointLog(tuple(plan.joints), t_ns, q, v, tau, arrays['temperature'], tags)

    def table(self, what: str, signals: Mapping[str, Signal]) -> FloatArray | None:
        """Return one quantity of all joints (N, n), NaN where a joint has none, None where all."""
        if not signals:
            return None
        kept = self.kept
        table = np.full((int(kept.sum()), len(self.plan.joints)), np.nan)
        for j, name in enumerate(self.plan.joints):
            if name not in signals:
                continue
            values = self._values(signals[name], f'{what} of {name}')
            if len(values) != len(kept):
                raise DataError(
                    f'{self.path} has {len(kept)} samples of time and {len(values)} of the '
                    f'{what} of {name} ({signals[name].series.variable!r}): they must be as many'
                )
            table[:, j] = values[kept]
        return table

    def _repeats(self, t_ns: IndexArray) -> BoolArray:
        """Return which samples (N,) repeat all that the file has of the one before them."""
        series = [x for x in self.data.series().values() if len(x) == len(t_ns)]
        return repeated_rows([t_ns, *series])

    def _series(self, series: Series) -> NDArray[Any]:
        """Return one series (N,) of the file."""
        values = self.data[series.variable]
        name = series.variable
        if series.column is not None or series.row is not None:
            what, index = ('column', series.column) if series.row is None else ('row', series.row)
            if values.ndim != 2:
                raise DataError(
                    f'the variable {name!r} of {self.path} has shape {values.shape}: it is no '
                    f'table, so remove {what} from the mapping'
                )
            table = values.T if what == 'column' else values
            if index is None or index >= len(table):
                raise DataError(
                    f'the variable {name!r} of {self.path} has {len(table)} {what}s: {what} '
                    f'{index} (counted from 0) does not exist'
                )
            return np.asarray(table[index])
        values = np.atleast_1d(values)
        if values.ndim != 1:
            raise DataError(
                f'the variable {name!r} of {self.path} has shape {values.shape}: say in the '
                'mapping which column or row of it is meant'
            )
        return values

    def _one_number(self, value: float | str) -> float:
        """Return a number of the mapping, or the one that the variable of this name holds."""
        if not isinstance(value, str):
            return value
        values = self.data[value]
        if values.size != 1 or not np.isfinite(values).all():
            raise DataError(
                f'the variable {value!r} of {self.path} has shape {values.shape}: one finite '
                'number is needed'
            )
        return float(values.reshape(()))

    def _values(self, signal: Signal, what: str) -> FloatArray:
        """Return a signal in SI units, (N,), without the jumps of a wrap."""
        values: FloatArray = self._series(signal.series).astype(np.float64)
        signed = None if what.startswith('position') else with_sign(values)
        if signed is not None:
            self.tell(
                f'{self.path}: the {what} has whole numbers up to {np.nanmax(values):.10g} and '
                f'none below 0, and jumps between them: read with the sign that it lost, from '
                f'{np.nanmin(signed):.10g} to {np.nanmax(signed):.10g}'
            )
            values = signed
        for marker in missing_markers(values, what.partition(' ')[0]):
            is_marker = values == marker
            self.tell(
                f'{self.path}: the {what} is {marker:.10g} in {int(is_marker.sum())} of '
                f'{len(values)} samples, far from all others: taken as missing'
            )
            values[is_marker] = np.nan
        period = signal.wrap
        if period is None and len(values) == len(self.t_ns):
            period = recognised_wrap((self.t_ns - self.t_ns[0]) * 1e-9, values, signal.unit)
            if period is not None:
                self.tell(
                    f'{self.path}: the {what} wraps at a period of {period:.6g} {signal.unit} and '
                    "was unwrapped (say 'wrap: no' in the mapping if it is not so, or another "
                    'period)'
                )
        if period:
            known = np.isfinite(values)
            values[known] = np.unwrap(values[known], period=period)
        for factor in (signal.factor, self._one_number(signal.scale)):
            if factor != 1.0:
                values = values * factor
        offset = self._one_number(signal.offset)
        if offset != 0.0:
            values = values + offset
        wrong = np.flatnonzero(np.abs(values) >= LARGEST)
        if len(wrong):
            raise DataError(
                f'{self.path}: the {what} is {values[wrong[0]]:g} at index {wrong[0]}, and '
                f'{len(wrong)} times in all no value of a joint: check its unit and scale, or '
                'leave it empty'
            )
        return values

    def _stamps(self, count: int) -> IndexArray:
        """Return the stamps (N,) [ns], strictly increasing."""
        plan = self.plan
        if plan.time is None:
            assert plan.sample_rate is not None
            rate = self._one_number(plan.sample_rate)
            if not 0.0 < rate < 1e9 or count * 1e9 / rate >= 2**62:
                raise DataError(
                    f'the sample rate in {self.path} is {rate:g} Hz: give the samples per second'
                )
            t_ns = np.rint(np.arange(count) * (1e9 / rate)).astype(np.int64)
            what = f'a sample rate of {rate:g} Hz'
        else:
            counted = self._series(plan.time)
            time = without_overflow(counted)
            if time is not counted:
                first = int(np.argmax(counted[1:] < counted[:-1])) + 1
                self.tell(
                    f'{self.path}: {plan.time.variable} begins anew at index {first}, where its '
                    'register is full, and goes on from there'
                )
            if plan.ns_per_time_unit == TIME_UNITS['d']:
                # Spreadsheets count days from 1900 or 1904, MATLAB from the year 0.
                time = time - time[0]
            what = f'the time {plan.time.variable!r} of {self.path}'
            if not np.isfinite(time).all():
                k = int(np.flatnonzero(~np.isfinite(time))[0])
                raise DataError(f'{what} is {time[k]} at index {k}: each sample needs its time')
            if float(np.abs(time).max()) * plan.ns_per_time_unit >= 2**62:
                raise DataError(
                    f'{what} reaches {np.abs(time).max():g}: check its unit in the mapping'
                )
            if time.dtype.kind in 'iu':
                t_ns = time.astype(np.int64) * plan.ns_per_time_unit
            else:
                t_ns = np.rint(time * plan.ns_per_time_unit).astype(np.int64)
            if plan.nanoseconds is not None:
                t_ns = t_ns + self._series(plan.nanoseconds).astype(np.int64)
        steps = np.diff(t_ns)
        repeated = steps == 0
        if repeated.sum() > _REPEATED * len(steps):
            # A logger that writes each sample twice has lost nothing.
            repeated &= ~self._repeats(t_ns)[1:]
        wrong = steps < 0 if repeated.sum() <= _REPEATED * len(steps) else steps <= 0
        if wrong.any():
            k = int(np.flatnonzero(wrong)[0]) + 1
            raise DataError(
                f'{what} does not increase at index {k} ({t_ns[k - 1]} ns, then {t_ns[k]} ns), '
                f'and {int(wrong.sum())} times in all: check its unit, sort the samples, or, '
                'where its digits are too few, give sample_rate instead'
            )
        step = float(np.median(steps[~repeated])) if not repeated.all() else 0.0
        if step > 0.0 and not RATES[0] <= 1e9 / step <= RATES[1]:
            self.tell(
                f'{what} makes {1e9 / step:.4g} samples per second, where joints are recorded at '
                f'{RATES[0]:.0f} to {RATES[1]:.0f}: check its unit in the mapping'
            )
        if t_ns[0] < 0 and plan.start_time_ns == 0:
            # A trigger is the 0 of many loggers: what counts is the time between samples.
            self.tell(
                f'{what} begins {-1e-9 * int(t_ns[0]):.6g} s before 0, which no stamp of a bag '
                'may be: it is counted from the first sample'
            )
            return t_ns - t_ns[0]
        t_ns = t_ns + plan.start_time_ns
        if t_ns[0] < 0:
            raise DataError(
                f'{what} begins {-int(t_ns[0])} ns before 0: set start_time in {plan.path} so '
                'that no stamp is negative'
            )
        return t_ns


def recognised_wrap(time: FloatArray, values: FloatArray, unit: str) -> float | None:
    """Return the period [its unit] at which a position jumps back, None if it does not."""
    period = wrap_period(time, values)
    if period is None or unit != 'counts':
        return period
    # A counter has some number of bits.
    register = 2.0 ** round(math.log2(period))
    return register if abs(period / register - 1.0) < _REGISTER else period


def _robot_description(path: Path, plan: ImportMapping) -> str:
    """Return the URDF's text after checking that it has the joints, of the kind the units say."""
    text = read_text(path, 'URDF')
    try:
        stated = read_joints(text).joints
    except ConfigurationError as error:
        raise ConfigurationError(f'{path} is no readable URDF: {error}') from error
    joints = {name: joint.kind for name, joint in stated.items()}
    missing = [name for name in plan.joints if name not in joints]
    if missing:
        raise ConfigurationError(
            f'joint {", ".join(missing)} is not in {path}, which has '
            f'{", ".join(joints)}: use the names of the URDF in '
            'the mapping'
        )
    for name, signals in plan.joints.items():
        wrong = LINEAR_UNITS if joints[name] in ('revolute', 'continuous') else ANGULAR_UNITS
        for quantity, signal in signals.items():
            if signal.unit in wrong:
                raise ConfigurationError(
                    f'joint {name} is {joints[name]} in {path} and its {quantity} is in '
                    f'{signal.unit}: correct the unit in {plan.path} or the URDF'
                )
    return text
