# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Output error: simulate a joint under its known controller until it moves as it was measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.stats import t as t_distribution

from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.identification.law.law_fit import LawFit, jackknife_errors
from sosml_friction.model.laws import unit_of
from sosml_friction.model.parameter import AT_BOUND, NOT_IDENTIFIABLE, Parameter

FloatArray = NDArray[np.float64]

#: What is simulated and fitted.
PARAMETERS = ('inertia', 'viscous', 'coulomb', 'bias')
_LOWER = np.array([1e-9, 0.0, 0.0, -np.inf])
_LEVEL = 0.95
_FEWEST_CLUSTERS = 8
#: So close to a bound, as a share of the first guess, is at it.
_AT_BOUND = 1e-3
#: Steps of the integration in a sample, and their share of what is stable at the sign's slope.
_FEWEST_STEPS, _STABLE = 4, 0.5


@dataclass(frozen=True)
class CascadeController:
    """
    Hold a position loop about a velocity loop.

        effort = scale clip(kp kv (reference - q) - kv v, -limit, limit),

    with v the backward difference of the mean of the last two positions, computed at each sample
    and held until the next.

    :param kp: position gain [1/s].
    :param kv: velocity gain [command per rad/s or m/s].
    :param scale: effort of a command of 1 [Nm or N].
    :param limit: largest command.
    """

    kp: float
    kv: float
    scale: float = 1.0
    limit: float = np.inf


@dataclass(frozen=True)
class Simulated:
    """Hold position (N,) [rad or m] and effort (N,) [Nm or N] of a simulated joint."""

    q: FloatArray
    effort: FloatArray


@dataclass(frozen=True)
class OutputErrorFit:
    """
    Hold the fit of one joint.

    ``position_error`` and ``effort_error`` [%] are 100 |simulated - measured| / |measured|; effort
    that drives the simulation has none, NaN. ``residual_std`` [rad or m] is of the position, over
    ``samples`` in ``clusters`` independent pieces; ``smoothing_velocity`` is what was simulated.
    """

    parameters: Mapping[str, Parameter]
    position_error: float
    effort_error: float
    simulated: Simulated
    residual_std: float
    samples: int
    clusters: int
    smoothing_velocity: float

    def law_fit(self, effort_unit: str) -> LawFit:
        """
        Return friction as other fits hold it, without inertia.

        ``relative_error`` is of the position [%]; the residual is one of position, so that
        ``residual_std`` [Nm or N] is not known.
        """
        names = ('coulomb', 'viscous', 'stribeck', 'stribeck_velocity', 'bias')
        S = self.parameters.get('stribeck')
        law = 'stribeck' if S is not None and np.isfinite(S.value) else 'coulomb_viscous'
        parameters = {
            name: self.parameters.get(
                name,
                Parameter(
                    np.nan,
                    unit_of(name, effort_unit),
                    flags=(NOT_IDENTIFIABLE,),
                    reason='the simulation has Coulomb and viscous friction only',
                ),
            )
            for name in names
        }
        return LawFit(
            law,
            parameters,
            np.nan,
            self.position_error,
            self.samples,
            self.clusters,
            self.smoothing_velocity,
        )


def simulate_closed_loop(
    reference: FloatArray,
    step: float,
    controller: CascadeController,
    parameters: Mapping[str, float],
    start: float,
    smoothing_velocity: float,
) -> Simulated:
    """
    Follow a reference from rest, and return what the joint does.

        M q'' = effort - B q' - C tanh(q' / v0) - bias,

    by the midpoint rule, with as many steps in a sample as the slope of the sign needs.

    :param reference: wanted position at each sample (N,) [rad or m].
    :param step: time between samples [s].
    :param parameters: M, B, C and bias as ``inertia``, ``viscous``, ``coulomb`` and ``bias``.
    :param start: position at the first sample [rad or m].
    :param smoothing_velocity: v0 [rad/s or m/s], positive.
    :raises ConfigurationError: if a parameter is missing or cannot be simulated.
    """
    missing = [name for name in PARAMETERS if name not in parameters]
    if missing:
        raise ConfigurationError(
            f'the simulation has no {", ".join(missing)}: give {", ".join(PARAMETERS)}'
        )
    theta = np.array([parameters[name] for name in PARAMETERS], dtype=float)
    if not (np.isfinite(theta).all() and theta[0] > 0.0 and step > 0.0):
        raise ConfigurationError(
            f'the simulation has inertia {theta[0]:g}, other parameters {theta[1:].tolist()} and '
            f'a step of {step} s: all must be finite, inertia and step positive'
        )
    if not smoothing_velocity > 0.0:
        raise ConfigurationError(
            f'the smoothing velocity is {smoothing_velocity}: the simulation needs a positive one'
        )
    steps = _steps(theta, step, smoothing_velocity)
    return _run(theta, reference, step, controller, start, smoothing_velocity, steps)


def fit_output_error(
    time: FloatArray,
    q: FloatArray,
    effort: FloatArray,
    reference: FloatArray,
    controller: CascadeController,
    effort_unit: str,
    start: Mapping[str, float],
    smoothing_velocity: float,
    cluster_s: float = 1.0,
) -> OutputErrorFit:
    """
    Fit inertia, viscous and Coulomb friction and bias so that the simulation moves as measured.

    For one joint that gravity does not move, from rest. Noise is taken to be in the position
    alone, and none of it is differentiated. Standard errors are those of the linearised fit, by
    leaving out one stretch of ``cluster_s`` after the other; intervals are 95 %. A stiff
    controller makes the position insensitive to friction: the errors say how much.

    :param time: of the samples (N,) [s], even.
    :param q: measured position (N,) [rad or m].
    :param effort: measured effort (N,) [Nm or N]; it is compared, not fitted.
    :param reference: the controller's wanted position (N,) [rad or m].
    :param effort_unit: ``Nm`` or ``N``.
    :param start: first guess, as for :func:`simulate_closed_loop`.
    :raises DataError: if samples are missing, uneven or too few, or there is no motion.
    :raises ConfigurationError: if the first guess cannot be simulated.
    """
    columns = (time, q, effort, reference)
    if len({len(column) for column in columns}) != 1 or not all(
        np.isfinite(column).all() for column in columns
    ):
        raise DataError(
            'output error needs time, position, effort and reference at every sample: cut the '
            'recording to where all four are known'
        )
    groups = (np.arange(len(time)) * 0) if len(time) < 2 else _groups(time, cluster_s)
    if int(groups.max(initial=0)) + 1 < _FEWEST_CLUSTERS:
        raise DataError(
            f'the recording has {len(time)} samples, less than {_FEWEST_CLUSTERS} stretches of '
            f'{cluster_s:g} s: record longer'
        )
    steps = np.diff(time)
    step = float(np.median(steps))
    if not np.allclose(steps, step, rtol=0.05, atol=0.0):
        raise DataError('the samples are not evenly spaced: output error simulates at one rate')
    if not np.ptp(q) > 0.0:
        raise DataError('the joint did not move: record motion in both directions')
    first = simulate_closed_loop(
        reference, step, controller, start, float(q[0]), smoothing_velocity
    )
    guess = np.array([start[name] for name in PARAMETERS], dtype=float)
    scale = np.maximum(np.abs(guess), 1e-3 * float(np.abs(first.effort).max()) + 1e-12)
    # Held while the parameters change, or the residual would jump.
    count = 2 * _steps(guess, step, smoothing_velocity)
    size = float(np.std(q))

    def residual(theta: FloatArray) -> FloatArray:
        run = _run(theta, reference, step, controller, q[0], smoothing_velocity, count)
        return np.nan_to_num((run.q - q) / size, nan=1e3, posinf=1e3, neginf=-1e3)

    found = least_squares(
        residual, np.maximum(guess, _LOWER), x_scale=scale, bounds=(_LOWER, np.inf)
    )
    run = _run(found.x, reference, step, controller, q[0], smoothing_velocity, count)
    norms = np.linalg.norm(found.jac, axis=0)
    # The solver stays a little inside of its bounds.
    free = found.x - _LOWER > _AT_BOUND * scale
    errors = np.full(len(PARAMETERS), np.nan)
    errors[free] = jackknife_errors(found.jac[:, free] / norms[free], found.fun, groups)
    errors = errors / norms
    freedom = int(groups.max()) + 1 - len(PARAMETERS)
    quantile = float(t_distribution.ppf(0.5 + _LEVEL / 2.0, freedom))
    inertia_unit = 'kg m2' if effort_unit == 'Nm' else 'kg'
    units = [inertia_unit, *(unit_of(name, effort_unit) for name in PARAMETERS[1:])]
    parameters = {}
    for name, unit, value, error in zip(PARAMETERS, units, found.x, errors, strict=True):
        half = quantile * error
        known = np.isfinite(half)
        interval = (float(value - half), float(value + half)) if known else None
        flags = () if known else (AT_BOUND,)
        parameters[name] = Parameter(float(value), unit, float(error), interval, flags)
    return OutputErrorFit(
        parameters,
        _percent(run.q, q),
        _percent(run.effort, effort),
        run,
        float(np.std(run.q - q)),
        len(q),
        int(groups.max()) + 1,
        smoothing_velocity,
    )


def _groups(time: FloatArray, cluster_s: float) -> NDArray[np.int64]:
    stretch = ((time - time[0]) / cluster_s).astype(np.int64)
    return np.array(np.unique(stretch, return_inverse=True)[1], dtype=np.int64)


def _percent(simulated: FloatArray, measured: FloatArray) -> float:
    size = float(np.linalg.norm(measured))
    return 100.0 * float(np.linalg.norm(simulated - measured)) / size if size > 0.0 else np.nan


def _steps(theta: FloatArray, step: float, smoothing_velocity: float) -> int:
    slope = (theta[2] / smoothing_velocity + theta[1]) / theta[0]
    return max(_FEWEST_STEPS, int(np.ceil(step * slope / _STABLE)))


def _run(
    theta: FloatArray,
    reference: FloatArray,
    step: float,
    controller: CascadeController,
    start: float,
    smoothing_velocity: float,
    steps: int,
) -> Simulated:
    gains = np.array([controller.kp, controller.kv, controller.scale, controller.limit])
    q, effort = _integrate(
        theta, np.asarray(reference, dtype=float), step, gains, float(start),
        smoothing_velocity, steps,
    )  # fmt: skip
    return Simulated(q, effort)


@njit(cache=True)
def _integrate(
    theta: FloatArray,
    reference: FloatArray,
    step: float,
    gains: FloatArray,
    start: float,
    v0: float,
    steps: int,
) -> tuple[FloatArray, FloatArray]:
    M, B, C, bias = theta
    kp, kv, scale, limit = gains
    q, effort = np.empty(len(reference)), np.empty(len(reference))
    x, v, last, last_mean = start, 0.0, start, start
    h = step / steps
    for k in range(len(reference)):
        q[k] = x
        mean = 0.5 * (x + last)
        command = kp * kv * (reference[k] - x) - kv * (mean - last_mean) / step
        last, last_mean = x, mean
        force = scale * min(max(command, -limit), limit)
        effort[k] = force
        for _ in range(steps):
            a = (force - bias - B * v - C * np.tanh(v / v0)) / M
            middle = v + 0.5 * h * a
            a = (force - bias - B * middle - C * np.tanh(middle / v0)) / M
            x += h * middle
            v += h * a
    return q, effort
