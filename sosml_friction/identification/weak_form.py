# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction straight from position and effort: no observer, and nothing differentiated twice."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline
from scipy.signal import savgol_coeffs, savgol_filter
from scipy.sparse import csr_array
from scipy.stats import t as t_distribution

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.identification.law_fit import LawFit, fit_law, jackknife_errors
from sosml_friction.identification.segments import Segment, unsure_sign
from sosml_friction.model.parameter import NOT_IDENTIFIABLE, Parameter
from sosml_friction.model.robot import Robot
from sosml_friction.model.smooth_sign import smooth_sign
from sosml_friction.observers.first_order import FirstOrder
from sosml_friction.observers.friction_estimator import FrictionEstimator, Stretch
from sosml_friction.observers.signal_noise import signal_noise

FloatArray = NDArray[np.float64]

#: Test functions overlap: each begins a quarter of the support after the one before, which makes
#: them a basis of cubic splines.
_PIECES = 4
#: A test function spans at least so many samples.
_FEWEST_SAMPLES = 20
#: Degree of the polynomial whose slope is the velocity.
_DEGREE = 3
#: Largest share of standstill in a test function.
_REST = 0.5
_LEVEL = 0.95


@dataclass(frozen=True)
class WeakSettings:
    """
    Say how the weak form looks at a recording.

    ``support_s``: how long each test function is; longer averages more noise, but friction that
    changes within it is told less well. ``window_s``: over what a local cubic gives the velocity
    at which friction is looked up. ``cluster_s``: test functions in the same stretch of so long
    are taken to share their noise. ``zero_band`` [rad/s or m/s]: slower is standstill, where the
    law's sign is not smooth. ``refit_inertia``: whether the joint's inertia is fitted too.
    """

    support_s: float = 0.2
    window_s: float = 0.12
    cluster_s: float = 1.0
    zero_band: float = 1e-3
    refit_inertia: bool = False

    def __post_init__(self) -> None:
        for name in ('support_s', 'window_s', 'cluster_s', 'zero_band'):
            if not getattr(self, name) > 0.0:
                raise ConfigurationError(
                    f'weak-form setting {name} is {getattr(self, name)}: it must be positive'
                )


@dataclass(frozen=True)
class WeakFit:
    """
    Hold one joint's fit.

    ``inertia`` is None where it was not asked for, and is then as the model says. Else it is the
    inertia of a robot of one joint, rotor included [kg m2 or kg], or with more joints the factor
    on all inertial torque of the joint. ``middle`` (K,) [s] and ``means`` (K,) [Nm or N] are the
    test functions and what friction is on average under each, with the model's inertia;
    ``support_s`` is how long each is. ``tau_f`` (N,) joins the means by lines, one number per
    sample; NaN where there are none.
    """

    fit: LawFit
    inertia: Parameter | None
    middle: FloatArray
    means: FloatArray
    support_s: float
    tau_f: FloatArray

    def levels(self, segments: Sequence[Segment]) -> FloatArray:
        """Return friction in each segment, by the test functions within it; NaN without any."""
        margin = 0.5 * self.support_s
        levels = np.full(len(segments), np.nan)
        for k, segment in enumerate(segments):
            inside = (self.middle >= segment.start_s + margin - 1e-9) & (
                self.middle <= segment.end_s - margin + 1e-9
            )
            known = self.means[inside & np.isfinite(self.means)]
            if len(known):
                levels[k] = np.mean(known)
        return levels


class WeakForm:
    """
    Pose p' = tau + C^T q' - g - tau_f as a regression on position and effort.

    Multiplied by a test function phi that vanishes at both of its ends, and integrated by parts:

        integral phi tau_f dt = integral phi (tau + C^T q' - g) dt + integral phi' p dt,

    where p dt = M dq needs positions only. phi is a cubic B-spline: summed by parts once more,
    phi' p weighs positions with phi'', which is continuous, so that encoder noise averages out.
    Divided by the integral of phi, the right side is a mean of friction [Nm or N]; the law is
    fitted to such means with its own terms averaged in the same way.

    :param log: the recording; its joints include the robot's. Velocities in it are not used.
    :param effort_hold: where in an interval effort holds, as for
        :class:`~sosml_friction.observers.friction_estimator.FrictionEstimator`.
    :param maximum_gap_s: a longer step between samples is a hole.
    """

    def __init__(
        self,
        log: JointLog,
        robot: Robot,
        effort_hold: Sequence[str] | str = 'start',
        settings: WeakSettings | None = None,
        maximum_gap_s: float = 0.05,
    ) -> None:
        self.settings = settings or WeakSettings()
        self.robot = robot
        log = log.select(robot.names)
        self.time = log.time
        steps = np.diff(self.time)
        self._step = float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else np.inf
        # A cubic needs more than four samples.
        self._half = max(2, round(0.5 * self.settings.window_s / self._step))
        gain = np.linalg.norm(savgol_coeffs(2 * self._half + 1, _DEGREE, deriv=1)) / self._step
        self._v_noise = [float(gain) * signal_noise(q)[1] for q in log.q.T]
        log = replace(log, v=self._velocity(log, maximum_gap_s))
        # The estimator makes the intervals; the observer it asks for is not run.
        unused = FirstOrder({'cutoff': [1.0] * robot.n})
        estimator = FrictionEstimator(robot, [unused], effort_hold, 'message', maximum_gap_s)
        self._support = max(self.settings.support_s, _FEWEST_SAMPLES * self._step)
        twisted = robot if self.settings.refit_inertia else None
        self._pieces = [
            _Piece(self.time, log, stretch, self._support, twisted)
            for stretch in estimator.stretches(log)
        ]

    def _velocity(self, log: JointLog, maximum_gap_s: float) -> FloatArray:
        """Return the slope of a cubic through a window about each sample, (N, n)."""
        v = np.full(log.q.shape, np.nan)
        steps = np.diff(self.time)
        known = np.asarray(np.isfinite(log.q).all(axis=1))
        joined: NDArray[np.bool_] = (
            known[1:] & known[:-1] & (steps >= 0.0) & (steps <= maximum_gap_s)
        )
        width = 2 * self._half + 1
        for run in np.split(np.arange(len(log)), np.flatnonzero(~joined) + 1):
            # A repeated stamp is no sample of its own.
            run = run[np.append(True, np.diff(self.time[run]) > 0.0)]
            if known[run[0]] and len(run) > width:
                rise, span = (
                    savgol_filter(x[run], width, _DEGREE, deriv=1, axis=0)
                    for x in (log.q, self.time)
                )
                v[run] = rise / span[:, None]
        return v

    def fit(self, i: int, smoothing_velocity: float = 0.0) -> WeakFit:
        """
        Fit the law to joint ``i``; see :func:`~sosml_friction.identification.law_fit.fit_law`.

        :param smoothing_velocity: v0 of the law's sign, known [rad/s or m/s]: then reversals take
            part. With 0 test functions across a reversal or standstill do not: on which side of
            it a sample is, is not known.
        :raises DataError: if the recording is too short, or has no effort or no motion to fit.
        """
        pieces = [piece for piece in self._pieces if piece.count]
        if not pieces:
            raise DataError(
                f'no {self.settings.support_s:g} s of the recording are without a hole in '
                'position, which the weak form needs: record without gaps'
            )
        v = np.concatenate([piece.v[:, i] for piece in pieces])
        y = np.concatenate([piece.friction(i) for piece in pieces])
        middle = np.concatenate([piece.middle for piece in pieces])
        if not np.isfinite(y).any():
            raise DataError('the effort is missing in every part of the recording')
        ends = np.cumsum([len(piece.v) for piece in pieces])[:-1]

        def means(column: FloatArray) -> FloatArray:
            parts = np.split(column, ends)
            return np.concatenate([p.tests @ c for p, c in zip(pieces, parts, strict=True)])

        if smoothing_velocity > 0.0:
            keep = means((np.abs(v) < smoothing_velocity).astype(float)) < _REST
        else:
            still = np.abs(v) <= self.settings.zero_band
            unsure = [
                unsure_sign(x, self.settings.zero_band, self._half) for x in np.split(v, ends)
            ]
            keep = means((still | np.concatenate(unsure)).astype(float)) == 0.0
        tau_f = np.full(len(self.time), np.nan)
        for piece in pieces:
            inside = piece.covers(self.time)
            tau_f[inside] = np.interp(self.time[inside], piece.middle, piece.friction(i))
        measured = (middle, y, self._support, tau_f)
        clusters = (middle / self.settings.cluster_s).astype(np.int64)
        unit = self.robot.effort_units[i]
        # The mean of f(v + noise) is f + variance f'' / 2: the second difference takes that off.
        off = np.sqrt(3.0) * self._v_noise[i]
        around = np.concatenate([v - off, v, v + off])

        def unbiased(column: FloatArray) -> FloatArray:
            below, at, above = np.split(column, 3)
            return means(at + (2.0 * at - below - above) / 6.0)

        regression = _Regression(around, clusters, unit, unbiased, keep & np.isfinite(y))
        if not self.settings.refit_inertia:
            return WeakFit(regression.fit(y, smoothing_velocity), None, *measured)
        inertial = np.concatenate([piece.inertial(i) for piece in pieces])
        fit, factor = regression.fit_with(y + inertial, inertial, smoothing_velocity)
        return WeakFit(fit, self._inertia(factor), *measured)

    def _inertia(self, factor: Parameter) -> Parameter:
        if self.robot.n > 1:
            return factor
        nominal = float(self.robot.inertia(np.zeros(1))[0, 0])
        low, high = factor.interval or (np.nan, np.nan)
        return Parameter(
            factor.value * nominal,
            'kg m2' if self.robot.effort_units[0] == 'Nm' else 'kg',
            factor.std_error * nominal,
            (low * nominal, high * nominal),
            factor.flags,
        )


class _Piece:
    """Hold the test functions over one stretch, and what they make of it."""

    def __init__(
        self,
        time: FloatArray,
        log: JointLog,
        stretch: Stretch,
        support: float,
        twisted: Robot | None,
    ) -> None:
        rows, samples = stretch.rows, stretch.samples
        end = time[rows]
        middle = end - 0.5 * samples.h
        before = np.append(rows[0], rows[:-1])
        self.v = 0.5 * (log.v[before] + log.v[rows])
        self._forcing = samples.forcing
        begin = float(end[0] - samples.h[0])
        step = support / _PIECES
        fits = np.floor((float(end[-1]) - begin - support) / step + 1e-9)
        self.count = max(0, int(fits) + 1)
        starts = begin + step * np.arange(self.count, dtype=float)
        self.middle = starts + 0.5 * support
        self.tests, slopes = _tests(starts, support, middle, samples.h)
        # integral phi' p dt over the integral of phi.
        self._momentum = slopes @ samples.integral
        self._coriolis = np.zeros_like(self._momentum)
        if twisted is not None and self.count:
            twist = np.array([twisted.coriolis(log.q[k], log.v[k]).T @ log.v[k] for k in rows])
            self._coriolis = self.tests @ twist

    def friction(self, i: int) -> FloatArray:
        """Return the means of tau_f, (K,)."""
        return np.array(self.tests @ self._forcing[:, i] + self._momentum[:, i])

    def inertial(self, i: int) -> FloatArray:
        """Return the means of p' - C^T q' = M q'' + C q', (K,)."""
        return -(self._momentum[:, i] + self._coriolis[:, i])

    def covers(self, time: FloatArray) -> NDArray[np.bool_]:
        return (time >= self.middle[0]) & (time <= self.middle[-1])


def _tests(
    starts: FloatArray, support: float, middle: FloatArray, h: FloatArray
) -> tuple[csr_array, csr_array]:
    """
    Return the matrices (K, N) that integrate phi x and phi' x / h, over the integral of phi.

    :param middle: middles of the intervals (N,) [s]; ``h`` (N,) their lengths.
    """
    phi = BSpline.basis_element(np.linspace(0.0, support, _PIECES + 1), extrapolate=False)
    slope = phi.derivative()
    first = np.searchsorted(middle, starts)
    last = np.searchsorted(middle, starts + support)
    columns = [np.arange(a, b) for a, b in zip(first, last, strict=True)]
    weights, slopes = [], []
    for start, inside in zip(starts, columns, strict=True):
        t = middle[inside] - start
        weight = phi(t) * h[inside]
        weights.append(weight / weight.sum())
        slopes.append(slope(t) / weight.sum())
    bounds = np.append(0, np.cumsum(last - first))
    shape = (len(starts), len(middle))
    if not len(starts):
        return csr_array(shape), csr_array(shape)
    index = np.concatenate(columns)
    return (
        csr_array((np.concatenate(weights), index, bounds), shape=shape),
        csr_array((np.concatenate(slopes), index, bounds), shape=shape),
    )


class _Regression:
    """Fit the law to means, alone or with another column."""

    def __init__(
        self,
        v: FloatArray,
        clusters: NDArray[np.int64],
        unit: str,
        means: Callable[[FloatArray], FloatArray],
        keep: NDArray[np.bool_],
    ) -> None:
        self.v, self.clusters, self.unit, self.means, self.keep = v, clusters, unit, means, keep

    def fit(
        self,
        y: FloatArray,
        smoothing_velocity: float,
        project: Callable[[FloatArray], FloatArray] = lambda column: column,
    ) -> LawFit:
        return fit_law(
            self.v,
            project(y),
            self.clusters,
            self.unit,
            lag=lambda column: project(self.means(column)),
            keep=self.keep,
            smoothing_velocity=smoothing_velocity,
            mean_v=self.means(self.v),
        )

    def fit_with(
        self, y: FloatArray, extra: FloatArray, smoothing_velocity: float
    ) -> tuple[LawFit, Parameter]:
        """Return the law and the factor of ``extra`` (K,), fitted together."""
        z = np.where(self.keep, extra, 0.0)
        size = float(z @ z)
        if not size > 0.0:
            raise DataError('the joint did not accelerate: its inertia cannot be fitted')

        # Frisch-Waugh: what is left of y and of all columns beside z gives the same friction.
        def project(column: FloatArray) -> FloatArray:
            column = np.where(self.keep, column, 0.0)
            return np.array(column - z * (z @ column) / size)

        fit = self.fit(y, smoothing_velocity, project)
        v, parameters = self.v, fit.parameters
        sign = smooth_sign(v, smoothing_velocity)
        shapes = [sign, v, np.ones_like(v)]
        values = [parameters[name].value for name in ('coulomb', 'viscous', 'bias')]
        if fit.law == 'stribeck':
            v_s, S = parameters['stribeck_velocity'].value, parameters['stribeck'].value
            fade = sign * np.exp(-np.abs(v) / v_s)
            shapes += [fade, fade * np.abs(v) * S / v_s**2]
            values += [S, 0.0]
        X = np.column_stack([self.means(shape) for shape in shapes])[self.keep]
        rest = y[self.keep] - X @ np.array(values)
        z = z[self.keep]
        factor = float(z @ rest) / size
        X = np.column_stack([X, z])
        norms = np.linalg.norm(X, axis=0)
        _, groups = np.unique(self.clusters[self.keep], return_inverse=True)
        errors = jackknife_errors(X / norms, rest - factor * z, groups) / norms
        error = float(errors[-1])
        freedom = max(fit.clusters - X.shape[1], 1)
        half = error * float(t_distribution.ppf(0.5 + _LEVEL / 2.0, freedom))
        known = factor - half > 0.0
        return fit, Parameter(
            factor if known else np.nan,
            '1',
            error if known else np.nan,
            (max(factor - half, 0.0), max(factor + half, 0.0)),
            () if known else (NOT_IDENTIFIABLE,),
        )
