# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One joint that follows a reference under its cascade of loops."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numba.extending import register_jitable

from sosml_friction.arrays import FloatArray
from sosml_friction.compiled import compiled
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.simulation.integrator import runge_kutta_step
from sosml_friction.simulation.simulated import Simulated

#: Names of the joint's parameters M, B, C and bias, in this order.
PARAMETERS = ('inertia', 'viscous', 'coulomb', 'bias')
#: Steps of the integration in a sample at least, and the time constants of the sign's slope in
#: one at most: of the fourth order, which leaves e^-1 to 0.7 %.
_FEWEST_STEPS, _TIME_CONSTANTS = 2, 1.0


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


def simulate_closed_loop(
    reference: FloatArray,
    step: float,
    controller: CascadeController,
    parameters: Mapping[str, float],
    start: float,
    smoothing_velocity: float,
    steps: int | None = None,
) -> Simulated:
    """
    Follow a reference from rest, and return what the joint does.

        M q'' = effort - B q' - C tanh(q' / v0) - bias,

    with as many steps in a sample as the slope of the sign needs.

    :param reference: wanted position at each sample (N,) [rad or m].
    :param start: position at the first sample [rad or m].
    :param smoothing_velocity: v0 [rad/s or m/s], positive.
    :param steps: of the integration in a sample, None for :func:`steps_in_sample`.
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
    gains = np.array([controller.kp, controller.kv, controller.scale, controller.limit])
    return Simulated(*_run(
        theta, np.asarray(reference, dtype=float), float(step), gains, float(start),
        float(smoothing_velocity), steps or steps_in_sample(parameters, step, smoothing_velocity),
    ))  # fmt: skip


def steps_in_sample(
    parameters: Mapping[str, float], step: float, smoothing_velocity: float
) -> int:
    """Return in how many steps a sample of ``step`` [s] is to be integrated."""
    slope = parameters['coulomb'] / smoothing_velocity + parameters['viscous']
    constants = step * slope / parameters['inertia']
    return max(_FEWEST_STEPS, int(np.ceil(constants / _TIME_CONSTANTS)))


@register_jitable  # type: ignore[untyped-decorator]
def _acceleration(known: tuple[float, ...], t: float, q: float, v: float) -> float:
    M, B, C, bias, v0, effort = known
    return float((effort - bias - B * v - C * np.tanh(v / v0)) / M)


@compiled
def _run(
    theta: FloatArray,
    reference: FloatArray,
    step: float,
    gains: FloatArray,
    start: float,
    v0: float,
    steps: int,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    M, B, C, bias = theta
    kp, kv, scale, limit = gains
    q, v, effort = np.empty_like(reference), np.empty_like(reference), np.empty_like(reference)
    here, speed, last, last_mean = start, 0.0, start, start
    for k in range(len(reference)):
        q[k], v[k] = here, speed
        mean = 0.5 * (here + last)
        command = kp * kv * (reference[k] - here) - kv * (mean - last_mean) / step
        last, last_mean = here, mean
        effort[k] = scale * min(max(command, -limit), limit)
        known = (M, B, C, bias, v0, effort[k])
        for _ in range(steps):
            here, speed = runge_kutta_step(_acceleration, known, here, speed, step / steps)
    return q, v, effort
