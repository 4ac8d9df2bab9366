# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Output error: simulate a joint under its known controller until it moves as it was measured."""

from collections.abc import Mapping

import numpy as np
from scipy.optimize import least_squares

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.exceptions import DataError
from sosml_friction.identification.law.jackknife import jackknife_errors
from sosml_friction.identification.output_error.output_error_fit import (
    OutputErrorFit,
    estimated,
    relative_error,
)
from sosml_friction.model.laws import unit_of
from sosml_friction.simulation.cascade_loop import (
    PARAMETERS,
    CascadeController,
    simulate_closed_loop,
    steps_in_sample,
)
from sosml_friction.simulation.simulated import Simulated

_LOWER = np.array([1e-9, 0.0, 0.0, -np.inf])
#: Length of a stretch whose samples may share their noise [s], and the fewest of them.
_CLUSTER_S, _FEWEST_CLUSTERS = 1.0, 8
#: Distance from a bound that counts as on it, as a share of the first guess.
_AT_BOUND = 1e-3


def fit_output_error(
    time: FloatArray,
    q: FloatArray,
    effort: FloatArray,
    reference: FloatArray,
    controller: CascadeController,
    effort_unit: str,
    start: Mapping[str, float],
    smoothing_velocity: float,
) -> OutputErrorFit:
    """
    Fit inertia, viscous and Coulomb friction and bias so that the simulation moves as measured.

    For one joint that gravity does not move, from rest. Noise is taken to be in the position
    alone, and none of it is differentiated. Standard errors are those of the linearised fit, by
    leaving out one stretch of a second after the other; intervals are 95 %. A stiff
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
    groups = (np.arange(len(time)) * 0) if len(time) < 2 else _groups(time)
    if int(groups.max(initial=0)) + 1 < _FEWEST_CLUSTERS:
        raise DataError(
            f'the recording has {len(time)} samples, less than {_FEWEST_CLUSTERS} stretches of '
            f'{_CLUSTER_S:g} s: record longer'
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
    assert first.effort is not None
    guess = np.array([start[name] for name in PARAMETERS], dtype=float)
    scale = np.maximum(np.abs(guess), 1e-3 * float(np.abs(first.effort).max()) + 1e-12)
    # Held while the parameters change, or the residual would jump.
    count = 2 * steps_in_sample(start, step, smoothing_velocity)
    size = float(np.std(q))

    def moved(theta: FloatArray) -> Simulated:
        values = dict(zip(PARAMETERS, theta.tolist(), strict=True))
        return simulate_closed_loop(
            reference, step, controller, values, float(q[0]), smoothing_velocity, count
        )

    def residual(theta: FloatArray) -> FloatArray:
        left = (moved(theta).q - q) / size
        return np.nan_to_num(left, nan=1e3, posinf=1e3, neginf=-1e3)

    found = least_squares(
        residual, np.maximum(guess, _LOWER), x_scale=scale, bounds=(_LOWER, np.inf)
    )
    run = moved(found.x)
    norms = np.linalg.norm(found.jac, axis=0)
    # The solver stays a little inside of its bounds.
    free = found.x - _LOWER > _AT_BOUND * scale
    errors = np.full(len(PARAMETERS), np.nan)
    errors[free] = jackknife_errors(found.jac[:, free] / norms[free], found.fun, groups)
    errors = errors / norms
    freedom = int(groups.max()) + 1 - len(PARAMETERS)
    inertia_unit = 'kg m2' if effort_unit == 'Nm' else 'kg'
    units = [inertia_unit, *(unit_of(name, effort_unit) for name in PARAMETERS[1:])]
    rows = zip(PARAMETERS, found.x, units, errors, strict=True)
    parameters = {
        name: estimated(value, unit, error, freedom) for name, value, unit, error in rows
    }
    return OutputErrorFit(
        parameters,
        relative_error(run.q, q),
        relative_error(run.effort, effort),
        len(q),
        int(groups.max()) + 1,
        smoothing_velocity,
    )


def _groups(time: FloatArray) -> IndexArray:
    stretch = ((time - time[0]) / _CLUSTER_S).astype(np.int64)
    return np.array(np.unique(stretch, return_inverse=True)[1], dtype=np.int64)
