# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Measure in a recording what the gains of observers are made from."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.model.robot import Robot
from sosml_friction.observers.conditions import Conditions
from sosml_friction.observers.configuration import ObserverConfiguration
from sosml_friction.observers.friction_estimator import FrictionEstimator
from sosml_friction.observers.recipe import BANDWIDTH, gains_for_bandwidth, gains_for_conditions
from sosml_friction.observers.registry import check_observers, make_observer
from sosml_friction.observers.signal_noise import difference_noise, signal_noise

#: What runs over a recording that says not what to run.
DEFAULT_OBSERVERS = ('first_order', 'sosml')
#: Spans of position slopes that a velocity is compared with [samples].
_SPANS = range(2, 42)
#: A velocity is such a slope if it differs from it by less than this share of its own noise.
_ALIKE = 0.1
#: The joint moves above this multiple of the standard deviation of a velocity that is the slope
#: over ``_SLOPE_S`` [s]. Both chosen, no measurement: normal noise passes 5 once in two million.
_MOVING = 5.0
_SLOPE_S = 0.1


@dataclass(frozen=True)
class LogConditions:
    """
    Hold what was measured, one value for each joint; NaN where the recording does not tell.

    :param step: median interval [s].
    :param velocity_span: number of positions whose slope the velocity is; 0 if it is of another
        origin.
    :param top_speed: largest velocity over a tenth of a second [rad/s or m/s].
    :param friction_jump: friction at positive minus friction at negative velocity.
    :param reversal_time: time in motion over the number of reversals; the whole of it if there
        was none.
    """

    joints: tuple[str, ...]
    posture: FloatArray
    step: float
    position_noise: FloatArray
    velocity_noise: FloatArray
    velocity_span: int
    top_speed: FloatArray
    friction_jump: FloatArray
    reversal_time: FloatArray

    def conditions(self, robot: Robot) -> Conditions:
        """
        Return what gains are made from.

        :raises DataError: if something of a joint could not be measured.
        """
        for joint, jump in zip(self.joints, self.friction_jump, strict=True):
            if jump <= 0.0:
                raise DataError(
                    f'the friction of joint {joint} comes out smaller at positive than at '
                    f'negative velocity, by {-jump:.3g} (check the sign of its effort and the '
                    'model of gravity)'
                )
        for name, meaning in (
            ('position_noise', 'it never moves by a step of its encoder'),
            ('velocity_noise', 'its velocity has no noise'),
            ('friction_jump', 'it does not move, or reports no effort, in both directions'),
            ('reversal_time', 'it does not move'),
        ):
            for joint, value in zip(self.joints, getattr(self, name), strict=True):
                if not 0.0 < value < np.inf:
                    raise DataError(
                        f'{name} of joint {joint} cannot be measured in this recording ({meaning})'
                    )
        noise = self.position_noise, self.velocity_noise
        motion = self.friction_jump, self.reversal_time, self.top_speed
        return Conditions.of(robot, self.posture, *noise, *motion)


def measure_conditions(
    log: JointLog, robot: Robot, effort_hold: tuple[str, ...] = ()
) -> LogConditions:
    """
    Measure noise, friction and motion in a recording.

    * Position noise: by third differences, at least resolution / sqrt(12)
      (:func:`~sosml_friction.observers.signal_noise.signal_noise`).
    * Velocity noise: where the velocity is the least-squares slope of N positions (N = 2 is the
      backward difference), position noise sqrt(12 / (N (N^2 - 1))) / step; otherwise from the
      second difference of the velocity.
    * Friction jump: medians of a linear second-order observer's estimate (20 rad/s) where the
      joint moves forwards and backwards for a tenth of a second or more, their difference.

    :param log: with velocity; without, the backward difference is meant.
    :raises DataError: if the recording is too short, or a joint is missing.
    """
    log = log.select(robot.names)
    # A repeated stamp brings nothing new, and would count as standing still.
    new = np.r_[True, np.diff(log.t_ns) != 0]
    log = JointLog(log.names, log.t_ns[new], log.q[new], log.v[new], log.tau[new])
    source = 'message' if _has_velocity(log) else 'position_difference'
    step = _step(log)
    position_noise = np.array([_noise(q, 3) for q in log.q.T])
    span = _velocity_span(log, position_noise, step) if source == 'message' else 2
    if span:
        velocity_noise = _slope_noise(position_noise, span, step)
    else:
        velocity_noise = np.array([_noise(v, 2) for v in log.v.T])
    width = max(2, round(_SLOPE_S / step))
    speed = np.full(log.q.shape, np.nan)
    speed[width:] = (log.q[width:] - log.q[:-width]) / (log.time[width:] - log.time[:-width])[
        :, None
    ]
    threshold = _MOVING * np.sqrt(2.0) * position_noise / (width * step)
    # Not first order: one count of a coarse encoder is a spike there, and its median is biased.
    gains = {'natural_frequency': [20.0] * robot.n, 'damping_ratio': [0.7] * robot.n}
    estimator = FrictionEstimator(
        robot,
        [make_observer('linear_second_order', gains)],
        list(effort_hold) or 'start',
        source,
        max(0.05, 25.0 * step),
    )
    friction = estimator.batch(log)['linear_second_order']
    jump, reversal_time = np.full(robot.n, np.nan), np.full(robot.n, np.nan)
    for i in range(robot.n):
        direction = np.where(np.abs(speed[:, i]) > threshold[i], np.sign(speed[:, i]), 0.0)
        # What is shorter than the slope that sees it is noise of a joint that is held.
        for first, last in _runs(direction):
            if last - first < width:
                direction[first:last] = 0.0
        levels = [_median(friction[direction == way, i]) for way in (1.0, -1.0)]
        jump[i] = levels[0] - levels[1]
        moving = direction[direction != 0.0]
        if len(moving):
            turns = int(np.count_nonzero(np.diff(moving)))
            reversal_time[i] = len(moving) * step / max(turns, 1)
    top = np.asarray(np.nanmax(np.abs(speed), axis=0, initial=0.0), dtype=float)
    posture = np.array([_median(q) for q in log.q.T])
    return LogConditions(
        robot.names, posture, step, position_noise, velocity_noise, span, top, jump, reversal_time
    )


def configuration_for(
    log: JointLog,
    robot: Robot,
    bandwidth: float | None = None,
    effort_hold: Sequence[str] = (),
    observers: Sequence[str] | None = None,
) -> ObserverConfiguration:
    """
    Return an observer configuration for a recording that brings none, or is to have another.

    :param bandwidth: gains are made for it; if None and ``observers`` are named, from the
        conditions measured in the recording, and :data:`BANDWIDTH` otherwise.
    :param effort_hold: per joint, empty for ``start``.
    :param observers: which; FO and SOSML if None.
    :raises ConfigurationError: if an observer is unknown, or has no gains by bandwidth.
    :raises DataError: if the recording is too short to measure its noise, or has no position.
    """
    log = log.select(robot.names)
    check_observers(observers or ())
    if observers is not None and bandwidth is None:
        measured = measure_conditions(log, robot, tuple(effort_hold))
        try:
            recipe = gains_for_conditions(measured.conditions(robot))
        except DataError as error:
            raise DataError(
                f'{error}: give the observers a bandwidth, or leave them to the recording'
            ) from error
    else:
        momentum_noise = _momentum_noise(log, robot)
        recipe = gains_for_bandwidth(
            BANDWIDTH if bandwidth is None else bandwidth, momentum_noise.tolist()
        )
    chosen = DEFAULT_OBSERVERS if observers is None else observers
    lacking = [name for name in chosen if name not in recipe]
    if lacking:
        raise ConfigurationError(
            f'observer {", ".join(lacking)} has no gains by bandwidth: leave the bandwidth out, '
            f'or choose from {", ".join(recipe)}'
        )
    return ObserverConfiguration(
        robot.names,
        {name: recipe[name] for name in chosen},
        tuple(effort_hold) or ('start',) * robot.n,
        'message' if _has_velocity(log) else 'position_difference',
        max(0.05, 25.0 * _step(log)),
    )


def _momentum_noise(log: JointLog, robot: Robot) -> FloatArray:
    """
    Return the standard deviation of the momentum's noise, (n,).

    That of its second difference over sqrt(6), robustly (median), which white noise passes and
    motion hardly does. A recording without velocity gets backward differences of position.
    """
    v = log.v if _has_velocity(log) else _backward_difference(log)
    usable = np.flatnonzero(np.isfinite(log.q).all(axis=1) & np.isfinite(v).all(axis=1))
    stride = max(1, len(usable) // 5000)
    # Blocks of three neighbours: second differences need no more, and long bags stay cheap.
    middle = usable[1:-1:stride]
    middle = middle[np.isin(middle - 1, usable) & np.isin(middle + 1, usable)]
    if len(usable) < 10 or len(middle) == 0:
        raise _too_short(len(usable))
    inertia, _ = robot.statics(log.q[middle])
    second = v[middle - 1] - 2.0 * v[middle] + v[middle + 1]
    second = np.einsum('kij,kj->ki', inertia, second)
    return difference_noise(second, 2)


def _runs(x: FloatArray) -> list[tuple[int, int]]:
    """Return begin and end of the runs of equal values."""
    edges = np.r_[0, np.flatnonzero(np.diff(x)) + 1, len(x)]
    return list(zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True))


def _too_short(count: int) -> DataError:
    return DataError(
        f'the recording has {count} samples with position and velocity of every joint: '
        'ten or more, one after the other, are needed to measure their noise'
    )


def _step(log: JointLog) -> float:
    steps = np.diff(log.time)
    steps = steps[steps > 0.0]
    if len(steps) < 10:
        raise _too_short(len(log))
    return float(np.median(steps))


def _has_velocity(log: JointLog) -> bool:
    return bool(np.isfinite(log.v).all(axis=1).any())


def _median(values: FloatArray) -> float:
    values = values[np.isfinite(values)]
    return float(np.median(values)) if len(values) else float('nan')


def _noise(x: FloatArray, order: int) -> float:
    """Return the noise of a signal, not less than that of its resolution."""
    quantum, noise = signal_noise(x, order)
    return float(max(quantum / np.sqrt(12.0), noise))


def slope_weights(span: int, step: float) -> FloatArray:
    """Return the weights of ``span`` positions in their least-squares slope, (span,) [1/s]."""
    centred = np.arange(span) - 0.5 * (span - 1)
    return np.asarray(centred / (np.sum(centred**2) * step))


def _slope_noise(position_noise: FloatArray, span: int, step: float) -> FloatArray:
    return np.asarray(position_noise * np.sqrt(12.0 / (span * (span**2 - 1.0))) / step)


def _velocity_span(log: JointLog, position_noise: FloatArray, step: float) -> int:
    """Return of how many positions the velocity is the slope, 0 if of none."""
    for span in _SPANS:
        if span >= len(log):
            break
        weights = slope_weights(span, step)[::-1]
        noise = _slope_noise(position_noise, span, step)
        alike = True
        for q, v, sigma in zip(log.q.T, log.v.T, noise, strict=True):
            error = np.abs(v[span - 1 :] - np.convolve(q, weights, mode='valid'))
            alike = alike and bool(_median(error) <= _ALIKE * sigma)
        if alike:
            return span
    return 0


def _backward_difference(log: JointLog) -> FloatArray:
    """Return the velocity that the estimator will use, NaN where time does not go forwards."""
    h = np.diff(log.time)[:, None]
    v = np.full(log.q.shape, np.nan)
    np.divide(np.diff(log.q, axis=0), h, out=v[1:], where=h > 0.0)
    return v
