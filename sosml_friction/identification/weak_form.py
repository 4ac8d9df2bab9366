# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction straight from position and effort: no observer, and nothing differentiated twice."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_coeffs, savgol_filter

from sosml_friction.arrays import BoolArray, Entry, FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.sampling import held_share
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.identification.body_doubt import BodyDoubt
from sosml_friction.identification.effort_timing import EffortTiming
from sosml_friction.identification.friction_fit import FitSettings
from sosml_friction.identification.law.friction_memory import followed
from sosml_friction.identification.law.law_curve import fitted_law
from sosml_friction.identification.law.law_fit import LawFit
from sosml_friction.identification.law.law_rows import LawRows
from sosml_friction.identification.segments import Segment, unsure_sign
from sosml_friction.identification.spline_test_functions import PIECES, SplineTestFunctions
from sosml_friction.identification.stamp_checks import SURE, lateness
from sosml_friction.identification.velocity_smoother import JointNoise, VelocitySmoother
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.robot import Robot
from sosml_friction.observers.momentum_sampler import MomentumSampler, Stretch
from sosml_friction.observers.momentum_samples import MomentumSamples
from sosml_friction.observers.signal_noise import white_noise

#: Fewest samples in a test function: two in each of its pieces. With 20, one of
#: ``test/identification/test_low_rates.py`` at 25 Hz had no test function without a reversal.
_FEWEST_SAMPLES = 2 * PIECES
#: Degree of the polynomial whose slope is the velocity.
_DEGREE = 3
#: Speeds in standard deviations of their noise: below the first the joint counts as at standstill;
#: above the second the law is so straight over the noise that its mean needs no correction.
#: Chosen, no measurement.
_NOISES, _STRAIGHT = 5.0, 40.0
#: Largest share of the slowest speed that is left out as standstill.
_STANDSTILL = 0.8
#: Share of the torque below which what a law leaves is rounding.
_EXACT = 1e-6
#: Length of a test function [s]: a longer one averages more noise, but blurs friction that changes
#: within it. Chosen, no measurement.
_SUPPORT_S = 0.1
#: Length of the local cubic whose slope is the velocity at which the law is evaluated [s]. Chosen,
#: no measurement.
_WINDOW_S = 0.12
#: Length of a cluster, whose test functions may share their noise [s]. Chosen, no measurement.
_CLUSTER_S = 1.0
#: Samples on either side of a change of sign that a smoothed velocity leaves unsure.
_SMOOTHED = 5


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
        :class:`~sosml_friction.observers.momentum_sampler.MomentumSampler`.
    :param maximum_gap_s: a longer step between samples is a hole.
    :param timing: when effort of each joint acts, by name, instead of ``effort_hold``.
    :param doubt: what the bodies are off by, and how surely.
    """

    def __init__(
        self,
        log: JointLog,
        robot: Robot,
        effort_hold: Sequence[str] | str = 'start',
        settings: FitSettings | None = None,
        maximum_gap_s: float = 0.05,
        timing: Mapping[str, EffortTiming] | None = None,
        doubt: BodyDoubt | None = None,
    ) -> None:
        self.settings = settings or FitSettings()
        self._zero_band = self.settings.segments.zero_band
        if not self._zero_band > 0.0:
            # There the law jumps.
            raise ConfigurationError(
                f'weak-form setting zero_band is {self._zero_band}: it must be positive'
            )
        self.robot, self._doubt = robot, doubt
        log = log.select(robot.names)
        self.time = log.time
        steps = np.diff(self.time)
        self._step = float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else np.inf
        # Of the step before each sample.
        self._held = np.append(1.0, held_share(self.time))
        # A cubic needs more than four samples.
        self._half = _half_window(self._step)
        gain = np.linalg.norm(savgol_coeffs(2 * self._half + 1, _DEGREE, deriv=1)) / self._step
        v = self._velocity(log, maximum_gap_s)
        self._q_noise = [self._position_noise(log, i, x) for i, x in enumerate(v.T)]
        self._v_noise = [float(gain) * noise for noise in self._q_noise]
        self._sampler = MomentumSampler(robot, effort_hold, 'message', maximum_gap_s)
        #: One standard error of the later sample's share, (n,).
        self._unsure = np.zeros(robot.n)
        for joint, its in (timing or {}).items():
            i = robot.names.index(joint)
            self._sampler.later_weight[i] = its.later(self._step)
            self._unsure[i] = its.std_error / self._step
        self._support = max(_SUPPORT_S, _FEWEST_SAMPLES * self._step)
        # Variance of the velocity given the recording, (N, n); NaN: it has a noise of its own.
        self._variance = np.full_like(log.q, np.nan)
        self._unsmoothed: WeakForm | None = None
        self._tests: list[SplineTestFunctions] = []
        self._take(replace(log, v=v))

    def _take(self, log: JointLog) -> None:
        """Pose the regression with the velocities of ``log``."""
        self._rows: dict[tuple[int, float | None], LawRows] = {}
        # Of joints whose friction follows its law over a distance: how far it is from it, (N,).
        self._lags: dict[int, FloatArray] = {}
        twisted = self.robot if self.settings.refit_inertia else None
        self._log, self._stretches, self._pieces = log, [], []
        stretches = self._sampler.stretches(log)
        if not self._tests:
            # They depend on positions and stamps, which smoothed velocities do not change.
            self._tests = [
                SplineTestFunctions(self.time, each, self._support) for each in stretches
            ]
        for stretch, tests in zip(stretches, self._tests, strict=True):
            lost, samples = self._lost_effort(stretch), stretch.samples
            stretch = replace(stretch, samples=replace(samples, forcing=samples.forcing + lost))
            self._stretches.append(stretch)
            late = self._unsure * self._rise(stretch)
            if tests.count:
                self._pieces.append(_Piece(tests, log, stretch, twisted, lost, late))

    def _lost_effort(self, stretch: Stretch) -> FloatArray:
        """
        Return what lost samples add to the forcing, on the line between neighbours, (N, n).

        Over an interval of m periods m - 1 samples are lost. With their efforts on that line only
        the m-th part of the hold is left: w' - 1/2 = (w - 1/2) / m, w the later sample's weight.
        """
        lost = 1.0 - self._held[stretch.rows]
        return (0.5 - self._sampler.later_weight) * lost[:, None] * self._rise(stretch)

    def _rise(self, stretch: Stretch) -> FloatArray:
        """Return the later minus the earlier effort of each interval, 0 if unknown, (N, n)."""
        rows, tau = stretch.rows, self._log.tau
        rise = tau[rows] - tau[np.append(rows[0], rows[:-1])]
        return np.where(np.isfinite(rise), rise, 0.0)

    def with_laws(self, fits: Sequence[LawFit | None], lag: FloatArray | None = None) -> WeakForm:
        """
        Return the weak form with velocities smoothed by the torque that drove the joints.

        :class:`~sosml_friction.identification.velocity_smoother.VelocitySmoother` sees ripple
        that the slope of a position does not. Exact positions stay as they are.

        :param fits: the law of each joint; None where it has none.
        :param lag: how much more than these laws friction is before each sample, (N, n).
        """
        # Less than the rounding of a number is no noise: most third differences were 0.
        rounding = np.spacing(np.max(np.abs(np.nan_to_num(self._log.q)), axis=0))
        if not (np.array(self._q_noise) > rounding).all():
            return self
        noise, factor = [], np.ones(self.robot.n)
        for i, fit in enumerate(fits):
            forcing = np.concatenate([each.samples.forcing[:, i] for each in self._stretches])
            known = forcing[np.isfinite(forcing)]
            level = float(np.sqrt(np.mean(known**2))) if len(known) else 0.0
            if not level > 0.0:
                return self
            noise.append(
                JointNoise(
                    self._q_noise[i],
                    white_noise(forcing),
                    # Friction without a law is anything up to the torque.
                    max(fit.residual_std, _EXACT * level) if fit else level,
                    self._v_noise[i],
                    self._zero_band,
                    self._support,
                )
            )
            if fit and fit.extra and fit.extra[0].value > 0.0:
                factor[i] = fit.extra[0].value
        laws = [fitted_law(fit) if fit else None for fit in fits]
        v = self._log.v.copy()
        variance = np.full_like(v, np.nan)
        for stretch in self._stretches:
            rows = stretch.rows
            if len(rows) > _FEWEST_SAMPLES:
                samples = MomentumSamples(*(column[1:] for column in stretch.samples.columns))
                if lag is not None:
                    samples = replace(samples, forcing=samples.forcing - lag[rows[1:]])
                v[rows], variance[rows] = VelocitySmoother(
                    samples, self._log.q[rows], v[rows], laws, noise, factor, self._half
                ).run()
        # Its laws are found, and their searches have columns of all rows: they are forgotten.
        self._rows = {asked: replace(rows) for asked, rows in self._rows.items()}
        form = copy(self)
        form._variance, form._unsmoothed = variance, self
        form._take(replace(self._log, v=v))
        return form

    def with_memory(self, fits: Sequence[LawFit | None]) -> WeakForm:
        """
        Return the weak form with velocities smoothed by friction that follows over a distance.

        That is :mod:`~sosml_friction.identification.law.friction_memory`. Where no joint shows it,
        nothing changes.

        :param fits: the law of each joint by this form; None where it has none.
        """
        if self._unsmoothed is None or not self._lags:
            return self
        lag = np.zeros_like(self._log.q)
        for i, its in self._lags.items():
            lag[:, i] = its
        form = self._unsmoothed.with_laws(fits, lag)
        # A joint whose velocities are surer without it keeps them.
        lost = np.isfinite(self._variance).any(axis=0) & ~np.isfinite(form._variance).any(axis=0)
        return self if lost.any() else form

    def _velocity(self, log: JointLog, maximum_gap_s: float) -> FloatArray:
        """Return the slope of a cubic through a window about each sample, (N, n)."""
        v = np.full(log.q.shape, np.nan)
        steps = np.diff(self.time)
        known = np.asarray(np.isfinite(log.q).all(axis=1))
        joined: BoolArray = known[1:] & known[:-1] & (steps >= 0.0) & (steps <= maximum_gap_s)
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

    def _position_noise(self, log: JointLog, i: int, v: FloatArray) -> float:
        """Return the noise of positions [rad or m]: the encoder's, and motion in wrong stamps."""
        encoder = white_noise(log.q[:, i])
        late_s, sure = lateness(log, i, self._step)
        known = v[np.isfinite(v)]
        if sure < SURE or not len(known):
            return encoder
        return float(np.hypot(encoder, late_s * np.sqrt(np.mean(known**2))))

    def fit(self, i: int, smoothing_velocity: float | None = None) -> WeakFit:
        """
        Fit the law to joint ``i``, by :func:`~..law.law_search.search_law`.

        A test function is used if it has no reversal and only speeds above v0, ``zero_band`` and
        five times the noise of velocity. Below, the sign is too steep to be evaluated at a
        smoothed velocity with noise.

        :param smoothing_velocity: v0 of the law's sign, known [rad/s or m/s], 0 for the sign
            itself; None where it is to be found.
        :raises DataError: if the recording is too short, or has no effort or no motion to fit.
        """
        rows = self.rows(i, smoothing_velocity)
        means = rows.y
        if rows.extra is not None:
            means = means - rows.extra[:, 0]
        middle = np.concatenate([piece.tests.middle for piece in self._pieces])
        tau_f = np.full(len(self.time), np.nan)
        for piece in self._pieces:
            known = piece.tests.middle
            inside = (self.time >= known[0]) & (self.time <= known[-1])
            tau_f[inside] = np.interp(self.time[inside], known, self._friction(piece, i))
        fit = rows.fit(self.robot.effort_units[i])
        inertia = self._inertia(fit.extra[0]) if fit.extra else None
        return WeakFit(fit, inertia, middle, means, self._support, tau_f)

    def law(self, i: int) -> LawFit:
        """
        Return the law of joint ``i`` that fits best, without what the data know of it.

        :raises DataError: as for :meth:`fit`.
        """
        return self.rows(i).law(self.robot.effort_units[i])

    def rows(self, i: int, smoothing_velocity: float | None = None) -> LawRows:
        """
        Return the regression of joint ``i``; parameters and errors as for :meth:`fit`.

        Velocities are those of the recording, then the slow ones minus and plus sqrt(3) standard
        deviations of their noise, from which ``lag`` computes unbiased means.
        """
        asked = i, smoothing_velocity
        if asked not in self._rows:
            self._rows[asked] = self._posed(i, smoothing_velocity)
        return self._rows[asked]

    def _posed(self, i: int, smoothing_velocity: float | None) -> LawRows:
        pieces = self._pieces
        if not pieces:
            raise DataError(
                f'no {_SUPPORT_S:g} s of the recording are without a hole in '
                'position, which the weak form needs: record without gaps'
            )

        def joined(of: Callable[[_Piece], NDArray[Entry]]) -> NDArray[Entry]:
            return np.concatenate([of(piece) for piece in pieces])

        v = joined(lambda piece: piece.v[:, i])
        y = joined(lambda piece: self._friction(piece, i))
        lost = joined(lambda piece: piece.tests.weights @ piece.lost[:, i])
        late = joined(lambda piece: piece.tests.weights @ piece.late[:, i])
        if not np.isfinite(y).any():
            raise DataError('the effort is missing in every part of the recording')
        ends = np.cumsum([len(piece.v) for piece in pieces])[:-1]

        def means(column: FloatArray) -> FloatArray:
            parts = np.split(column, ends)
            return np.concatenate(
                [p.tests.weights @ c for p, c in zip(pieces, parts, strict=True)]
            )

        doubt = None
        if self._doubt is not None:
            doubt = joined(self._bodies)[:, i, 1:]
        extra = None
        if self.settings.refit_inertia:
            extra = joined(lambda piece: piece.inertial(i))[:, None]
            y = y + extra[:, 0]
        ways = {'held': y - lost} if lost.any() else {}
        if late.any():
            ways['late'] = y + late
        # The mean of f(v + noise) is f + variance f'' / 2, which the second difference takes off
        # where v has a noise of its own. A smoothed v is without what is not known of the true
        # one: the mean of friction is then that of f about it. Faster than this the law is next
        # to straight over the noise.
        rows = joined(lambda piece: piece.tests.rows)
        first = joined(lambda piece: piece.tests.before)
        variance = 0.5 * (self._variance[first, i] + self._variance[rows, i])
        # And the mean over both ends of an interval is not that of their mean velocity.
        variance += 0.25 * (self._log.v[rows, i] - self._log.v[first, i]) ** 2
        smoothed = np.isfinite(variance)
        half = _SMOOTHED if smoothed.all() else self._half
        sign = np.where(smoothed, 1.0, -1.0)
        noise = np.where(smoothed, np.sqrt(variance), self._v_noise[i])
        slow = np.flatnonzero(np.abs(v) < _STRAIGHT * noise)
        off = np.sqrt(3.0) * noise[slow]
        around = np.concatenate([v, v[slow] - off, v[slow] + off])

        def about(column: FloatArray) -> FloatArray:
            at = column[: len(v)].copy()
            below, above = np.split(column[len(v) :], 2)
            at[slow] += sign[slow] * (below + above - 2.0 * at[slow]) / 6.0
            return at

        path = np.abs(v) * (self.time[rows] - self.time[first])
        begun = np.isin(np.arange(len(v)), np.append(0, ends))

        def following(column: FloatArray, distance: FloatArray) -> FloatArray:
            at, x = about(column), distance[: len(v)]
            return means(followed(at, path / x, begun) if (x > 0.0).all() else at)

        def beyond(zero_band: float) -> LawRows:
            still = np.abs(v) <= np.maximum(zero_band, _NOISES * noise)
            unsure = [unsure_sign(x, zero_band, half) for x in np.split(v, ends)]
            keep = means((still | np.concatenate(unsure)).astype(float)) == 0.0
            known = keep & np.isfinite(y)
            if extra is not None and not float(np.sum(extra[known] ** 2)) > 0.0:
                raise DataError('the joint did not accelerate: its inertia cannot be fitted')
            return LawRows(
                around,
                y,
                (joined(lambda piece: piece.tests.middle) / _CLUSTER_S).astype(np.int64),
                known,
                means(v),
                lambda column: means(about(column)),
                smoothing_velocity or 0.0,
                smoothing_velocity is None,
                self.settings.form,
                extra,
                ways=ways,
                unsure=doubt,
            )

        zero_band = self._zero_band
        v0 = smoothing_velocity
        found = beyond(max(zero_band, v0 or 0.0))
        if v0 is None:
            # What is slow enough to be called standstill is not the slowest that was recorded.
            speeds = np.abs(found.mean_v[found.keep])
            slowest = float(np.quantile(speeds, 0.02)) if len(speeds) else 0.0
            v0 = min(found.smoothing(), _STANDSTILL * slowest)
            found = beyond(v0) if v0 > zero_band else found
        if self._unsmoothed is None:
            return found
        if smoothed.any():
            # The same rows, so that nothing but the velocities differs.
            before = self._unsmoothed.rows(i, smoothing_velocity)
            keep = before.keep & found.keep
            found = replace(found, keep=keep, unsmoothed=replace(before, keep=keep))
        memory = found.memory(following)
        if memory is None:
            return found.with_trend()
        if memory.shown:
            dry = about(memory.dry)
            self._lags[i] = np.zeros(len(self.time))
            self._lags[i][rows] = followed(dry, path / memory.distance, begun) - dry
        return found.with_memory(memory).with_trend()

    def _friction(self, piece: _Piece, i: int) -> FloatArray:
        """Return the means of tau_f beside the bodies that the motion shows, (K,)."""
        tau_f = piece.friction(i)
        return tau_f if self._doubt is None else tau_f + self._bodies(piece)[:, i, 0]

    def _bodies(self, piece: _Piece) -> FloatArray:
        """Return what bodies that are off add to the means of a piece, (K, n, 1 + U)."""
        if piece.bodies is None:
            assert self._doubt is not None
            tests = piece.tests
            q, v = (tests.weights @ x[tests.rows] for x in (self._log.q, self._log.v))
            a = np.gradient(v, tests.middle, axis=0) if len(v) > 1 else np.zeros_like(v)
            piece.bodies = self._doubt.efforts(self.robot, q, v, a)
        return piece.bodies

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


def _half_window(step: float) -> int:
    """Return the samples on either side of the cubic whose slope is the velocity."""
    return max(2, round(0.5 * _WINDOW_S / step))


def shown_by_slope(step: float, frequency: float) -> float:
    """
    Return which share of a sine of the velocity its slope shows, less than 0 where it is reversed.

    :param step: between samples [s]; ``frequency`` [Hz] of the sine.
    """
    half, w = _half_window(step), 2.0 * np.pi * frequency
    weights = savgol_coeffs(2 * half + 1, _DEGREE, deriv=1, delta=step, use='dot')
    return float(weights @ np.sin(w * step * np.arange(-half, half + 1))) / w


class _Piece:
    """Hold what the test functions over one stretch make of a motion."""

    def __init__(
        self,
        tests: SplineTestFunctions,
        log: JointLog,
        stretch: Stretch,
        twisted: Robot | None,
        lost_effort: FloatArray,
        late_effort: FloatArray,
    ) -> None:
        self.tests = tests
        self.v = 0.5 * (log.v[tests.before] + log.v[tests.rows])
        # Of the forcing: the part of lost samples, and of one standard error of when it acts.
        self.lost, self.late, self._forcing = lost_effort, late_effort, stretch.samples.forcing
        self.bodies: FloatArray | None = None
        self._coriolis = np.zeros_like(tests.momentum)
        if twisted is not None:
            q, v = log.q[tests.rows], log.v[tests.rows]
            twist = [twisted.coriolis(*at).T @ at[1] for at in zip(q, v, strict=True)]
            self._coriolis = tests.weights @ np.array(twist)

    def friction(self, i: int) -> FloatArray:
        """Return the means of tau_f, (K,)."""
        return np.array(self.tests.weights @ self._forcing[:, i] + self.tests.momentum[:, i])

    def inertial(self, i: int) -> FloatArray:
        """Return the means of p' - C^T q' = M q'' + C q', (K,)."""
        return -(self.tests.momentum[:, i] + self._coriolis[:, i])
