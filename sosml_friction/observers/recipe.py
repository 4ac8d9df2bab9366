# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Gains from stated quantities: a bandwidth and the noise of the momentum."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.model.robot import Robot
from sosml_friction.observers.configuration import ObserverConfiguration

FloatArray = NDArray[np.float64]

#: Bandwidth [rad/s] where none is given: settles in 0.1 s, well inside a plateau's trim.
BANDWIDTH = 40.0


def gains_from_noise(
    bandwidth: float, momentum_noise: Sequence[float]
) -> dict[str, dict[str, list[float]]]:
    """
    Return the gains of FO and SOSML for one bandwidth.

    FO: c0 = w. SOSML: S2 = w^2 and T2 = w (damping ratio 0.5), which is the linear observer; on
    top S1 = 0.1 S2 s_p, small enough that noise of the momentum (standard deviation s_p) does not
    feel it, and T1 = 1.6 sqrt(S1). Both are then compared at equal bandwidth.

    :param bandwidth: w [rad/s], positive.
    :param momentum_noise: s_p per joint [Nm s or N s], >= 0.
    :raises ConfigurationError: if a number is out of range.
    """
    if not 0.0 < bandwidth < np.inf or not all(0.0 <= s < np.inf for s in momentum_noise):
        raise ConfigurationError(
            f'bandwidth {bandwidth} rad/s and momentum noise {list(momentum_noise)}: the first '
            'must be positive, the second not negative, both finite'
        )
    n = len(momentum_noise)
    sliding = [0.1 * bandwidth**2 * float(s) for s in momentum_noise]
    return {
        'first_order': {'cutoff': [bandwidth] * n},
        'sosml': {
            'sliding': sliding,
            'sliding_root': [1.6 * float(np.sqrt(s)) for s in sliding],
            'linear': [bandwidth**2] * n,
            'linear_damping': [bandwidth] * n,
        },
    }


def configuration_for(
    log: JointLog, robot: Robot, bandwidth: float = BANDWIDTH, effort_hold: str = 'start'
) -> ObserverConfiguration:
    """
    Return an observer configuration for a recording that brings none.

    The momentum noise is measured: the standard deviation of its second difference over sqrt(6),
    robustly (median), which white noise passes and motion hardly does. A recording without
    velocity gets backward differences of position.

    :raises DataError: if the recording is too short to measure its noise, or has no position.
    """
    log = log.select(robot.names)
    has_velocity = bool(np.isfinite(log.v).all(axis=1).any())
    v = log.v if has_velocity else _backward_difference(log)
    usable = np.flatnonzero(np.isfinite(log.q).all(axis=1) & np.isfinite(v).all(axis=1))
    stride = max(1, len(usable) // 5000)
    # Blocks of three neighbours: second differences need no more, and long bags stay cheap.
    middle = usable[1:-1:stride]
    middle = middle[np.isin(middle - 1, usable) & np.isin(middle + 1, usable)]
    if len(usable) < 10 or len(middle) == 0:
        raise DataError(
            f'the recording has {len(usable)} samples with position and velocity of every joint: '
            'ten or more, one after the other, are needed to measure their noise'
        )
    second = np.array(
        [
            sum(
                c * robot.momentum_terms(log.q[k], v[m])[0]
                for c, m in ((1.0, k - 1), (-2.0, k), (1.0, k + 1))
            )
            for k in middle
        ]
    ).reshape(-1, robot.n)
    noise = 1.4826 * np.median(np.abs(second), axis=0) / np.sqrt(6.0)
    step = float(np.median(np.diff(log.time)))
    return ObserverConfiguration(
        robot.names,
        gains_from_noise(bandwidth, noise.tolist()),
        tuple([effort_hold] * robot.n),
        'message' if has_velocity else 'position_difference',
        max(0.05, 25.0 * step),
    )


def _backward_difference(log: JointLog) -> FloatArray:
    """Return the velocity that the estimator will use, NaN where time does not go forwards."""
    h = np.diff(log.time)[:, None]
    v = np.full(log.q.shape, np.nan)
    np.divide(np.diff(log.q, axis=0), h, out=v[1:], where=h > 0.0)
    return v
