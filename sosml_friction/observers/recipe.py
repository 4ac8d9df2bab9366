# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Gains from stated quantities: noise, friction and motion, or a bandwidth."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.robot import Robot
from sosml_friction.observers.conditions import Conditions

FloatArray = NDArray[np.float64]

#: Bandwidth [rad/s] where none is given: settles in 0.1 s, well inside a plateau's trim.
BANDWIDTH = 40.0
#: Knee and smoothing of the law that a Kalman observer is told [rad/s or m/s]: friction levels off
#: over hundredths of a radian per second, and a knee told wrong by three costs little.
STRIBECK_VELOCITY = 0.03
SMOOTHING_VELOCITY = 0.005
#: Passes what friction does in a tenth of a second [1/s].
QUASI_STATIC_CUTOFF = 100.0
#: How fast process noise is adapted [1/s].
ADAPTATION_RATE = 5.0
#: How near standstill friction may jump: some widths of the smooth sign [rad/s or m/s].
CROSSING_VELOCITY = 0.02

Gains = dict[str, list[float]]


def gains_for_bandwidth(bandwidth: float, momentum_noise: Sequence[float]) -> dict[str, Gains]:
    """
    Return gains of one bandwidth w for the observers that have one.

    FO: c0 = w. FO with prefilter: both poles at 2 w. Linear second order: wn = w, damping ratio
    0.5. SOSML: that linear observer, S2 = w^2 and T2 = w, and on top S1 = 0.1 S2 s_p, small enough
    that noise of the momentum (standard deviation s_p) does not feel it, and T1 = 1.6 sqrt(S1).
    All then follow a slow disturbance with the same delay, 1 / w.

    :param bandwidth: w [rad/s], positive.
    :param momentum_noise: s_p per joint [Nm s or N s], >= 0.
    :raises ConfigurationError: if a number is out of range.
    """
    if not 0.0 < bandwidth < np.inf or not all(0.0 <= s < np.inf for s in momentum_noise):
        raise ConfigurationError(
            f'bandwidth {bandwidth} rad/s and momentum noise {list(momentum_noise)}: the first '
            'must be positive, the second not negative, both finite'
        )
    w, s_p = np.full(len(momentum_noise), bandwidth), np.array(momentum_noise, dtype=float)
    return {
        'quasi_static': _gains(cutoff=w),
        'first_order': _gains(cutoff=w),
        'first_order_prefiltered': _gains(cutoff=2.0 * w, prefilter_cutoff=2.0 * w),
        'linear_second_order': _gains(natural_frequency=w, damping_ratio=0.5 + 0.0 * w),
        'sosml': _sosml(w, 0.5, s_p),
        'sosml_explicit': _sosml_explicit(w, 0.5, s_p),
    }


def gains_for_conditions(conditions: Conditions) -> dict[str, Gains]:
    """
    Return the gains of every observer for the noise, the friction and the motion.

    Each balances the noise it lets through against the square of the error it makes after a jump
    D, averaged over the time T between jumps; s_p and s_X are the noise of the momentum and of its
    integral. With the error of a unit step response e(t) and J = integral of e^2, in units of
    1/w, the mean square is noise^2 + D^2 J / (w T):

    * FO: noise c0 s_p, J = 1/2, so c0 = (D^2 / (4 T s_p^2))^(1/3);
    * quasi-static: has no noise of positions to balance, w = 100 1/s;
    * linear second order: noise wn^2 s_X, J = zeta + 1 / (4 zeta) = 1 at zeta = 1/2, so
      wn = (D^2 / (4 T s_X^2))^(1/5);
    * FO with prefilter, both poles at w: noise w^2 s_X, J = 5/4, so w = (5/4)^(1/5) wn;
    * SOSML: S2 = wn^2, T2 = 0.8 wn, S1 = 0.1 S2 s_p, T1 = 1.6 sqrt(S1);
    * Kalman: a jump D every T seconds is, as a random walk, D / sqrt(T) per root second;
    * Kalman with crossings: a tenth of that between reversals. At a change of sign D / 2 in the
      IMM, which believes in a jump for a third of T, and 0.3 D where one filter is widened;
    * Kalman, adaptive: never less than a tenth of that, e-fold in a fifth of a second;
    * smoother: a tenth of that away from standstill. Near it, where the velocity of a sinusoid of
      top speed V passes with the acceleration pi V / T, the variance D^2 within
      exp(-(v / v_c)^2): crossing rate^2 = D^2 sqrt(pi) V / (T v_c); without a top speed it is the
      Kalman observer's model, smoothed;
    * with the law in its state: a friction of D / 2 is expected, a tenth of it beside the law.

    """
    c = conditions
    D, T = c.friction_jump, c.reversal_time
    c0 = np.cbrt(D**2 / (4.0 * T * c.momentum_noise**2))
    wn = (D**2 / (4.0 * T * c.integral_noise**2)) ** 0.2
    both = 1.25**0.2 * wn
    rate = D / np.sqrt(T)
    steady = {'position_noise': c.position_noise, 'disturbance_rate': 0.1 * rate}
    return {
        'quasi_static': _gains(cutoff=np.full(len(D), QUASI_STATIC_CUTOFF)),
        'first_order': _gains(cutoff=c0),
        'first_order_prefiltered': _gains(cutoff=both, prefilter_cutoff=both),
        'linear_second_order': _gains(natural_frequency=wn, damping_ratio=0.5 + 0.0 * wn),
        'sosml': _sosml(wn, 0.4, c.momentum_noise),
        'sosml_explicit': _sosml_explicit(wn, 0.4, c.momentum_noise),
        'kalman': _gains(position_noise=c.position_noise, disturbance_rate=rate),
        'kalman_scheduled': _gains(**steady, crossing_jump=0.3 * D),
        'kalman_adaptive': _gains(**steady, adaptation_rate=ADAPTATION_RATE + 0.0 * D),
        'kalman_imm': _gains(**steady, crossing_jump=0.5 * D, jump_memory=T / 3.0),
        'kalman_stribeck': _gains(
            position_noise=c.position_noise,
            friction=0.5 * D,
            viscous=0.5 * D,
            residual=0.05 * D,
            residual_time=T,
            stribeck_velocity=STRIBECK_VELOCITY + 0.0 * D,
            smoothing_velocity=SMOOTHING_VELOCITY + 0.0 * D,
        ),
        'smoother': _smoother(c, rate),
    }


def recipe_gains(
    robot: Robot,
    bandwidth: float,
    position_noise: Sequence[float] = (),
    velocity_noise: Sequence[float] = (),
    friction_jump: Sequence[float] = (),
    reversal_time: Sequence[float] = (),
) -> dict[str, Gains]:
    """
    Return gains from what is stated of a robot, one value for each joint.

    With ``friction_jump`` all four quantities are needed and ``bandwidth`` is not used:
    :func:`gains_for_conditions`, at posture zero. Without it the observers that have a bandwidth
    get gains: :func:`gains_for_bandwidth`, with a sliding term if ``velocity_noise`` is known.

    :raises ConfigurationError: if a number is missing or out of range.
    """
    zero = np.zeros(robot.n)
    if len(friction_jump):
        return gains_for_conditions(
            Conditions.of(
                robot, zero, position_noise, velocity_noise, friction_jump, reversal_time
            )
        )
    noise = np.array(velocity_noise if len(velocity_noise) else zero, dtype=float)
    if len(noise) != robot.n:
        raise ConfigurationError(
            f'velocity_noise has {len(noise)} values for the {robot.n} joints '
            f'{", ".join(robot.names)}: give one for each'
        )
    momentum_noise = np.sqrt(robot.inertia(zero) ** 2 @ noise**2)
    return gains_for_bandwidth(bandwidth, momentum_noise.tolist())


def _gains(**values: FloatArray) -> Gains:
    return {name: column.tolist() for name, column in values.items()}


def _smoother(c: Conditions, rate: FloatArray) -> Gains:
    crossing_velocity = CROSSING_VELOCITY + 0.0 * rate
    if c.top_speed is None:
        steady, crossing = rate, 0.0 * rate
    else:
        steady = 0.1 * rate
        passages = np.sqrt(np.pi) * c.top_speed / (c.reversal_time * crossing_velocity)
        crossing = c.friction_jump * np.sqrt(passages)
    return _gains(
        position_noise=c.position_noise,
        disturbance_rate=steady,
        crossing_rate=crossing,
        crossing_velocity=crossing_velocity,
    )


def _sosml(wn: FloatArray, zeta: float, momentum_noise: FloatArray) -> Gains:
    sliding = 0.1 * wn**2 * momentum_noise
    return _gains(
        sliding=sliding,
        sliding_root=1.6 * np.sqrt(sliding),
        linear=wn**2,
        linear_damping=2.0 * zeta * wn,
    )


def _sosml_explicit(wn: FloatArray, zeta: float, momentum_noise: FloatArray) -> Gains:
    # A boundary layer of three standard deviations: noise stays inside, and the stiffness S1 / eps
    # there is a thirtieth of S2. Without noise there is no sliding term, and any layer will do.
    boundary = np.where(momentum_noise > 0.0, 3.0 * momentum_noise, 1.0)
    return {**_sosml(wn, zeta, momentum_noise), **_gains(boundary=boundary)}
