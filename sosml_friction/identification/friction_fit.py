# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""From a recording and its friction estimates to the parameters of every joint."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.signal import lfilter

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.identification.body_doubt import BodyDoubt
from sosml_friction.identification.law.law_fit import LawFit
from sosml_friction.identification.law.law_form import LawForm
from sosml_friction.identification.law.law_rows import LawRows
from sosml_friction.identification.segments import (
    Segment,
    SegmentSettings,
    centred_difference,
    find_segments,
    segment_levels,
    unsure_sign,
)
from sosml_friction.model.laws import law_definition, unit_of
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.robot import Robot
from sosml_friction.observers.observer import Observer
from sosml_friction.regression.body_width import check_tolerance

METHODS = ('auto', 'segments', 'samples', 'weak', 'output_error')
#: What stands for the observer in a fit that uses none.
WEAK_FORM = 'weak_form'
#: The fit beside a refitted rigid body.
REGRESSION = 'regression'

#: Plateaus that begin above this share of the top speed leave the intercept to extrapolation.
REACH = 0.2
#: Largest share that a sample with an unknown sign may have in the observer's output.
_BLUR = 0.2
#: Largest change of velocity within its own window, as a share of v_s, that leaves the knee sharp.
_BLURRED = 0.25
_KNEE = ('stribeck', 'stribeck_velocity', 'exponent')


@dataclass(frozen=True)
class FitSettings:
    """
    Choose how friction is fitted.

    ``method``:

    * ``segments``: the paper's pipeline. One pair per steady window, the level of the estimate
      against the speed of the window's position difference;
    * ``samples``: every sample in motion, the law passed through the observer's own lag before it
      is compared, so that transients count without their lag counting as friction;
    * ``auto``: the regression on position and effort of
      :mod:`~sosml_friction.identification.weak_form`, without an observer, which becomes the
      model; beside it each observer by ``segments`` where the plateaus reach down to a fifth of
      the top speed, else by ``samples``: a Coulomb level extrapolated from fast plateaus is not a
      measurement. Where the method so chosen finds too little, the other;
    * ``weak``: the same as ``auto``;
    * ``output_error``: as ``auto``, and beside it forward simulation until the joint moves as it
      was measured, by :mod:`~sosml_friction.identification.output_error.fits`.

    ``refit_inertia``: whether inertia is fitted too, by the weak form where it is asked for and by
    :mod:`~sosml_friction.identification.inverse_model` in any case.

    ``body_tolerance``: how far each number of the rigid body may be off, as a share of itself;
    None for what the data say, 0 for not at all.

    ``form`` says which law, for every observer and the weak form. ``segments.trim_s`` is
    lengthened to what the slowest observer needs to settle to 1 %.
    """

    method: str = 'auto'
    segments: SegmentSettings = field(default_factory=SegmentSettings)
    #: Samples closer than this are taken to share their noise [s].
    cluster_s: float = 0.5
    refit_inertia: bool = False
    form: LawForm = field(default_factory=LawForm)
    body_tolerance: float | None = None

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise ConfigurationError(f'method is {self.method!r}: use one of {", ".join(METHODS)}')
        if self.body_tolerance is not None:
            check_tolerance(self.body_tolerance)


@dataclass(frozen=True)
class JointFit:
    """
    Hold one joint's fit from one observer, or from none: then ``observer`` is ``weak_form``.

    ``levels`` (K,) are the levels of ``segments``, by
    :func:`~sosml_friction.identification.segments.segment_levels`. ``inertia`` is None where it
    was not fitted together with friction.
    """

    observer: str
    method: str
    unit: str
    fit: LawFit
    segments: tuple[Segment, ...]
    levels: FloatArray
    inertia: Parameter | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return the entry of ``sosml fit --json``."""
        return {
            'method': self.method,
            **self.fit.to_dict(),
            'smoothing_velocity': self.fit.smoothing_velocity,
            'residual_unit': self.unit,
            'segments_used': sum(not segment.rejected for segment in self.segments),
            'segments_rejected': sum(bool(segment.rejected) for segment in self.segments),
            **({} if self.inertia is None else {'inertia': self.inertia}),
        }


@dataclass(frozen=True)
class FrictionFit:
    """
    Hold the fits of a recording.

    ``joints[joint][observer]`` is the fit to use; ``alternatives[joint][observer]`` the other
    method's, where it could be computed. ``unavailable[joint]`` says why a joint has none.
    ``rows[joint][observer]`` are the rows that the fit to use was made to, or would have been:
    several recordings together may identify what one does not.
    """

    joints: Mapping[str, Mapping[str, JointFit]]
    alternatives: Mapping[str, Mapping[str, JointFit]]
    unavailable: Mapping[str, str]
    rows: Mapping[str, Mapping[str, LawRows]] = field(default_factory=dict)

    def changed(self, change: Callable[[str, LawFit], LawFit]) -> FrictionFit:
        """Return the same with ``change(joint, law)`` of each law that is to be used."""
        joints = {
            joint: {name: replace(one, fit=change(joint, one.fit)) for name, one in fits.items()}
            for joint, fits in self.joints.items()
        }
        return replace(self, joints=joints)


def fit_friction(
    log: JointLog,
    estimates: Mapping[str, FloatArray],
    robot: Robot,
    observers: Mapping[str, Observer],
    settings: FitSettings | None = None,
    require: bool = True,
    doubt: BodyDoubt | None = None,
) -> FrictionFit:
    """
    Fit every joint and observer.

    :param estimates: tau_f per observer (N, n) in the robot's joint order, on the log's stamps.
    :param observers: the observers that made them, for their lag.
    :param require: whether to refuse a recording of which no joint can be fitted alone.
    :param doubt: what the bodies are off by, and how surely; None where they are exact.
    :raises DataError: if no joint can be fitted; the sentence names each reason.
    """
    settings = settings or FitSettings()
    log = log.select(robot.names)
    if not (np.diff(log.t_ns) > 0).any():
        raise DataError(
            f'no joint can be fitted. The recording has {len(log)} samples at one stamp: record '
            'motion'
        )
    joints: dict[str, dict[str, JointFit]] = {}
    others: dict[str, dict[str, JointFit]] = {}
    unavailable: dict[str, str] = {}
    rows: dict[str, dict[str, LawRows]] = {}
    for i, name in enumerate(robot.names):
        if not np.isfinite(log.tau[:, i]).any():
            unavailable[name] = 'the recording has no effort of it'
            continue
        task = _JointTask(log, i, robot, list(observers.values()), settings, doubt)
        for observer, tau_f in estimates.items():
            lag_of = observers[observer]
            try:
                chosen, other = task.fit(observer, tau_f[:, i], lag_of)
            except DataError as error:
                unavailable[name] = str(error)
                found = task.best_rows(tau_f[:, i], lag_of)
                if found is not None:
                    rows.setdefault(name, {})[observer] = found
                continue
            rows.setdefault(name, {})[observer] = task.rows(chosen.method, tau_f[:, i], lag_of)
            joints.setdefault(name, {})[observer] = chosen
            if other is not None:
                others.setdefault(name, {})[observer] = other
        if name in joints:
            unavailable.pop(name, None)
    if require and not joints:
        reasons = '; '.join(f'{name}: {reason}' for name, reason in unavailable.items())
        raise DataError(f'no joint can be fitted. {reasons}')
    return FrictionFit(joints, others, unavailable, rows)


class _JointTask:
    """What the fits of one joint have in common."""

    def __init__(
        self,
        log: JointLog,
        i: int,
        robot: Robot,
        observers: Sequence[Observer],
        settings: FitSettings,
        doubt: BodyDoubt | None,
    ) -> None:
        self.unit, self.i = robot.effort_units[i], i
        self.time, q = log.time, log.q[:, i]
        self.step = log.step
        settle = max((self._memory(observer, 0.01) for observer in observers), default=0)
        trim = max(settings.segments.trim_s, settle * self.step)
        self.settings = replace(settings, segments=replace(settings.segments, trim_s=trim))
        self.segments = tuple(find_segments(self.time, q, self.settings.segments))
        self.half = max(1, round(0.5 * settings.segments.window_s / self.step))
        self.v = centred_difference(self.time, q, self.half)
        self.added, *self.unsure = self._bodies(log, robot, doubt)

    def _bodies(self, log: JointLog, robot: Robot, doubt: BodyDoubt | None) -> list[FloatArray]:
        """Return what errors of bodies add to friction, (N,) each: their mean, then its roots."""
        exact = [np.zeros(len(self.time))]
        if doubt is None:
            return exact
        # They change as slowly as the motion does: what is between windows is on a line.
        at = np.arange(0, len(self.time), self.half)
        v = centred_difference(self.time, log.q, self.half)
        a = centred_difference(self.time, v, self.half)
        at = at[np.isfinite(a[at]).all(axis=1)]
        if not len(at):
            return exact
        added = doubt.efforts(robot, log.q[at], v[at], a[at])[:, self.i]
        return [np.interp(self.time, self.time[at], column) for column in added.T]

    def _memory(self, observer: Observer, rest: float) -> int:
        """Return after how many samples ``rest`` of an observer's past is left."""
        _, a = observer.lag_filter(self.step, self.i)
        slowest = max(np.abs(np.roots(a)), default=0.0) if len(a) > 1 else 0.0
        return int(np.ceil(np.log(rest) / np.log(slowest))) if 0.0 < slowest < 1.0 else 0

    def fit(
        self, observer: str, tau_f: FloatArray, lag_of: Observer
    ) -> tuple[JointFit, JointFit | None]:
        order = self._order()
        fits: list[JointFit] = []
        for method in order:
            try:
                fits.append(self._fit_by(method, observer, tau_f, lag_of, fits))
            except DataError:
                chooses = self.settings.method not in ('segments', 'samples')
                if not fits and (method == order[1] or not chooses):
                    raise
        return fits[0], fits[1] if len(fits) > 1 else None

    def _order(self) -> tuple[str, str]:
        """Return the two methods, the one to use first."""
        if self.settings.method == 'samples' or (
            self.settings.method not in ('segments', 'samples') and not self._reaches_down()
        ):
            return 'samples', 'segments'
        return 'segments', 'samples'

    def best_rows(self, tau_f: FloatArray, lag_of: Observer) -> LawRows | None:
        """Return the rows of the first method that has any, though they do not make a fit."""
        for method in self._order():
            try:
                rows = self.rows(method, tau_f, lag_of)
            except DataError:
                continue
            if (rows.keep & np.isfinite(rows.y)).any():
                return rows
        return None

    def _reaches_down(self) -> bool:
        speeds = [abs(segment.velocity) for segment in self.segments if not segment.rejected]
        return bool(speeds) and min(speeds) <= REACH * max(speeds)

    def _fit_by(
        self,
        method: str,
        observer: str,
        tau_f: FloatArray,
        lag_of: Observer,
        others: Sequence[JointFit],
    ) -> JointFit:
        levels = self._levels(tau_f, lag_of)
        rows = self.rows(method, tau_f, lag_of)
        if method == 'samples':
            # A mean velocity bends the knee: the exponent is that of the segments, or the usual.
            found = [x.fit.drawn['exponent'] for x in others if 'exponent' in x.fit.drawn]
            alpha = found[0] if found else self.settings.form.usual
            rows = replace(rows, form=replace(rows.form, alpha=alpha))
        fit = rows.fit(self.unit)
        if method == 'samples':
            fit = self._without_blurred_knee(fit)
        return JointFit(observer, method, self.unit, fit, self.segments, levels)

    def _without_blurred_knee(self, fit: LawFit) -> LawFit:
        """
        Return the fit, its S and v_s as ranges where the velocity is too coarse to tell them.

        The velocity of a sample is a mean over ``window_s``. If it changes by more than a quarter
        of v_s within the window, at most samples near the knee, the mean blurs the knee.
        """
        if 'stribeck' not in fit.law:
            return fit
        v_s = fit.parameters['stribeck_velocity']
        window = 2 * self.half * self.step
        change = np.abs(centred_difference(self.time, self.v, self.half)) * window
        near = np.isfinite(change) & (np.abs(self.v) < 3.0 * v_s.value)
        near &= np.abs(self.v) > self.settings.segments.zero_band
        typical = float(np.median(change[near])) if near.any() else np.inf
        if typical <= _BLURRED * v_s.value:
            return fit
        speed = unit_of('velocity', self.unit)
        reason = (
            f'near the knee the velocity changes by {typical:.2g} {speed} within the '
            f'{window:.2g} s over which it is measured'
        )
        experiment = (
            f'record T3, a slow ladder with plateaus from {v_s.value / 3.0:.1g} {speed}, or use '
            'the weak form'
        )
        parameters = dict(fit.parameters)
        for name in parameters.keys() & set(_KNEE):
            unit = parameters[name].unit
            parameters[name] = Parameter.not_told(unit, reason, (0.0, np.inf), experiment)
        law = self.settings.form.identifier(None)
        names = law_definition(law).parameter_names
        kept = {n: x for n, x in parameters.items() if n in names or n in _KNEE}
        return replace(fit, law=law, parameters=kept)

    def _levels(self, tau_f: FloatArray, lag_of: Observer) -> FloatArray:
        """Return the levels of segments, bodies corrected, while no observer settles."""
        index = np.arange(len(tau_f))
        since = index - np.maximum.accumulate(np.where(np.isfinite(tau_f), -1, index))
        settling = since <= self._memory(lag_of, 0.01)
        levels = segment_levels(self.segments, np.where(settling, np.nan, tau_f))
        return levels + segment_levels(self.segments, self.added)

    def rows(self, method: str, tau_f: FloatArray, lag_of: Observer) -> LawRows:
        """Return what ``method`` is fitted to; a DataError if the observer gave no estimate."""
        if method == 'segments':
            used = np.array([not segment.rejected for segment in self.segments], dtype=bool)
            v = np.array([segment.velocity for segment in self.segments], dtype=float)
            levels = self._levels(tau_f, lag_of)
            return LawRows(
                v,
                levels,
                np.arange(len(v)),
                used,
                v,
                lambda column: column,
                form=self.settings.form,
                unsure=self._seen(lambda column: segment_levels(self.segments, column)),
            )
        unknown = ~np.isfinite(tau_f) | ~np.isfinite(self.v)
        if unknown.all():
            raise DataError(
                'the observer gave no estimate: position, velocity or effort is missing or the '
                'recording has gaps at every sample'
            )
        b, a = lag_of.lag_filter(self.step, self.i)
        # The observer forgets how it was started while its impulse response dies out.
        index = np.arange(len(tau_f))
        since = index - np.maximum.accumulate(np.where(unknown, index, -1))
        settled = since > self._memory(lag_of, 1e-3)
        v = np.nan_to_num(self.v)
        zero_band = self.settings.segments.zero_band
        # The observer passes on for a while what it made of a sign that is not known.
        passed_on = np.abs(lfilter(b, a, unsure_sign(v, zero_band, self.half).astype(float)))
        moving = (np.abs(v) > zero_band) & (passed_on < _BLUR)
        # A velocity is a mean over 2 half samples: a row for each quarter of that loses nothing.
        starts = np.arange(0, len(v), max(1, self.half // 2))
        lengths = np.diff(np.append(starts, len(v)))

        def means(column: FloatArray) -> FloatArray:
            return np.array(np.add.reduceat(column, starts) / lengths)

        def lag(column: FloatArray) -> FloatArray:
            # The disturbance of a step is the mean over its interval, not its value at the end.
            return means(lfilter(b, a, np.append(column[0], 0.5 * (column[1:] + column[:-1]))))

        return LawRows(
            self.v,
            means(tau_f) + lag(self.added),
            (self.time[starts] / self.settings.cluster_s).astype(np.int64),
            np.minimum.reduceat(settled & moving, starts),
            means(self.v),
            lag,
            form=self.settings.form,
            unsure=self._seen(lag),
        )

    def _seen(self, seen: Callable[[FloatArray], FloatArray]) -> FloatArray | None:
        """Return what bodies may be off by, as an observer's rows have it (K, U)."""
        return np.array([seen(column) for column in self.unsure]).T if self.unsure else None
