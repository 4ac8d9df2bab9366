# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Output error of a recording: with its controller where that is known, else its effort."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.identification.inverse_model import InverseFits
from sosml_friction.identification.law.jackknife import jackknife_errors
from sosml_friction.identification.output_error.output_error_fit import (
    OutputErrorFit,
    estimated,
    relative_error,
)
from sosml_friction.model.laws import unit_of
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.robot import Robot
from sosml_friction.simulation.cascade_loop import (
    PARAMETERS,
    CascadeController,
    simulate_closed_loop,
    steps_in_sample,
)
from sosml_friction.simulation.recorded.controlled_joint import ControlledJoint
from sosml_friction.simulation.simulated import Simulated

#: Name of the fit beside the observers.
OUTPUT_ERROR = 'output_error'
#: Width of the sign that is simulated where none is known, as a share of the top speed.
_SHARPNESS = 1e-3
_LOWER = np.array([1e-9, 0.0, 0.0, -np.inf])
#: Length of a stretch whose samples may share their noise [s], and the fewest of them.
_CLUSTER_S, _FEWEST_CLUSTERS = 1.0, 8
#: Distance from a bound that counts as on it, as a share of the first guess.
_AT_BOUND = 1e-3


@dataclass(frozen=True)
class ClosedLoopCheck:
    """
    Hold how well a simulation under the recorded controller follows the recording.

    ``position_error`` and ``effort_error`` [%] are 100 |simulated - measured| / |measured|, with
    the ``parameters`` of the fit ``source``.
    """

    source: str
    parameters: Mapping[str, float]
    position_error: float
    effort_error: float


@dataclass(frozen=True)
class OutputErrorFits:
    """
    Hold what forward simulation says of a recording.

    ``joints[joint]`` is the fit where it was asked for; ``modes[joint]`` is ``controller`` or
    ``measured_effort``; ``unavailable[joint]`` says why there is none. ``closed_loop[joint]`` are
    simulations with parameters that were fitted otherwise.
    """

    joints: Mapping[str, OutputErrorFit] = field(default_factory=dict)
    modes: Mapping[str, str] = field(default_factory=dict)
    unavailable: Mapping[str, str] = field(default_factory=dict)
    closed_loop: Mapping[str, ClosedLoopCheck] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Return the entry ``output_error`` of ``sosml fit --json``."""
        return {
            'joints': {
                joint: {
                    'mode': self.modes[joint],
                    'parameters': fit.parameters,
                    'position_error': fit.position_error,
                    'effort_error': fit.effort_error,
                }
                for joint, fit in self.joints.items()
            },
            'unavailable': self.unavailable,
            'closed_loop': self.closed_loop,
        }


def closed_loop_checks(
    log: JointLog,
    robot: Robot,
    controlled: Mapping[str, ControlledJoint],
    inverse: InverseFits,
    smoothing_velocity: Mapping[str, float],
) -> dict[str, ClosedLoopCheck]:
    """
    Simulate each joint under its controller with the parameters of the inverse model.

    Only a robot of one joint that gravity does not move; others have no entry.

    :param smoothing_velocity: v0 of each joint, 0 where it is not known [rad/s or m/s].
    """
    checks: dict[str, ClosedLoopCheck] = {}
    for name, loop in controlled.items():
        fit = inverse.joints.get(name, {}).get('symmetric')
        if fit is None or not is_alone(robot, log):
            continue
        parameters = {key: float(fit.parameters[key].value) for key in PARAMETERS}
        i = log.names.index(name)
        q, effort, time = log.q[:, i], log.tau[:, i], log.time
        known = np.isfinite(q) & np.isfinite(effort) & np.isfinite(loop.reference)
        steps = np.diff(time)
        if not known.all() or not np.isfinite(list(parameters.values())).all():
            continue
        step = float(np.median(steps))
        if not np.allclose(steps, step, rtol=0.05, atol=0.0):
            continue
        width = smoothing_velocity.get(name, 0.0) or sharp_sign(q, step)
        run = simulate_closed_loop(
            loop.reference, step, loop.controller, parameters, float(q[0]), width
        )
        checks[name] = ClosedLoopCheck(
            'inverse_model.symmetric',
            parameters,
            relative_error(run.q, q),
            relative_error(run.effort, effort),
        )
    return checks


def fit_controlled(
    log: JointLog,
    robot: Robot,
    joint: str,
    loop: ControlledJoint,
    start: Mapping[str, float],
    smoothing_velocity: float,
) -> OutputErrorFit:
    """
    Fit the joint of a robot that :func:`is_alone` so that it moves as it was measured.

    :param start: first guess, by :data:`~sosml_friction.simulation.cascade_loop.PARAMETERS`.
    :raises DataError: as of :func:`fit_output_error`.
    """
    i = log.names.index(joint)
    steps = np.diff(log.time)
    width = smoothing_velocity or sharp_sign(log.q[:, i], float(np.median(steps)))
    try:
        return fit_output_error(
            log.time,
            log.q[:, i],
            log.tau[:, i],
            loop.reference,
            loop.controller,
            robot.effort_units[i],
            start,
            width,
        )
    except ConfigurationError as error:
        raise DataError(str(error)) from error


def first_guess(
    robot: Robot, i: int, parameters: Mapping[str, Parameter] | None
) -> dict[str, float]:
    """Return inertia of the model and friction of another fit, 0 where it does not say."""
    inertia = float(robot.inertia(np.zeros(robot.n))[i, i])
    guess = {'inertia': inertia}
    for name in PARAMETERS[1:]:
        p = (parameters or {}).get(name)
        guess[name] = float(p.value) if p is not None and np.isfinite(p.value) else 0.0
    return guess


def is_alone(robot: Robot, log: JointLog) -> bool:
    """Return whether a robot is one joint that gravity does not move."""
    if robot.n != 1:
        return False
    ends = np.nanquantile(log.q[:, 0], [0.0, 0.5, 1.0])
    return not any(np.abs(robot.gravity(np.array([q]))).max() > 0.0 for q in ends)


def sharp_sign(q: FloatArray, step: float) -> float:
    """Return a smoothing velocity that is small beside the motion [rad/s or m/s]."""
    speed = np.abs(q[50:] - q[:-50]) / (50 * step) if len(q) > 50 else np.abs(np.diff(q)) / step
    return _SHARPNESS * max(float(np.nanmax(speed, initial=0.0)), 1e-9)


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
    groups = _groups(time)
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
    stretch = ((time - time[:1]) / _CLUSTER_S).astype(np.int64)
    return np.array(np.unique(stretch, return_inverse=True)[1], dtype=np.int64)
