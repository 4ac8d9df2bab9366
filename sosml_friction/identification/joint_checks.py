# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is wrong with the recording of one joint, before anything is fitted to it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.identification.data_finding import LEFT_OUT, NOTE, REFUSED, DataFinding
from sosml_friction.identification.law.law_fit import jackknife_errors
from sosml_friction.identification.segments import centred_difference
from sosml_friction.model.robot import Robot
from sosml_friction.observers.signal_noise import signal_noise

FloatArray = NDArray[np.float64]

#: Time over which position is differenced to a speed [s]. Chosen, no measurement.
_WINDOW_S = 0.1
#: Motion in one direction for less than this says nothing [s]: a shorter window is not used.
_LEAST_MOTION_S = 0.15
#: Share of saturated samples beyond which the joint is not fitted.
_MOST_SATURATED = 0.2
#: A speed this many times the URDF's limit is no speed of that robot.
_IMPOSSIBLE = 1.5
#: A velocity this many times the slope of position is in another unit.
_OTHER_UNIT = 2.0
#: Largest friction of the wrong sign, as a share of the effort's range, that a delay of effort
#: explains.
_FEIGNED = 0.02
#: Chance that a run of equal extreme efforts is none of saturation.
_CHANCE = 1e-3
_FEWEST_EQUAL = 5


@dataclass(frozen=True)
class JointChecks:
    """
    Hold what was measured of one joint; NaN where the recording does not tell.

    ``travel`` [rad or m]: range of motion. ``top_speed`` [rad/s or m/s]: 99 % quantile of the
    speed as a difference over 0.1 s. ``speed_limit`` and ``effort_limit``: the URDF's.
    ``forwards_s`` and ``backwards_s``: time in motion with known effort. ``position_step`` and
    ``effort_step``: resolutions. ``friction_level`` +- ``friction_level_error`` [Nm or N]: half of
    the change of effort, without gravity, when the velocity changes its sign at the median speed;
    negative where friction would drive. ``velocity_factor``: reported velocity over the slope of
    position. The last two are shares of the samples, 0 to 1.
    """

    travel: float
    top_speed: float
    speed_limit: float
    effort_limit: float
    forwards_s: float
    backwards_s: float
    position_step: float
    effort_step: float
    friction_level: float
    friction_level_error: float
    velocity_factor: float
    without_effort: float
    saturated: float


def check_joint(
    log: JointLog, robot: Robot, i: int
) -> tuple[JointChecks, FloatArray, list[DataFinding]]:
    """
    Return what was measured of joint i, its effort as far as it can be used (N,), and findings.

    :param log: stamps that rise, every position known, joints in the order of ``robot``.
    """
    name, limit = robot.names[i], robot.limits[i]
    way = 'rad' if robot.effort_units[i] == 'Nm' else 'm'
    time, q, tau = log.time, log.q[:, i], log.tau[:, i].copy()
    known = np.isfinite(tau)
    period = float(np.median(np.diff(time)))
    half = max(1, round(0.5 * _WINDOW_S / period))
    v = centred_difference(time, q, half) if len(time) > 2 * half else np.full(len(time), np.nan)
    step, noise = signal_noise(q)
    # One count, or the noise of two positions, is no motion.
    least = (step + 5.0 * np.sqrt(2.0) * noise) / (2 * half * period)
    moving = np.abs(np.nan_to_num(v)) > least
    saturated = _saturated(tau, limit.effort)
    usable = known & moving & ~saturated
    forwards, backwards = (
        float(np.sum(usable & (np.sign(np.nan_to_num(v)) == side))) * period for side in (1, -1)
    )
    speeds = np.abs(v[np.isfinite(v)])
    level = error = np.nan
    if min(forwards, backwards) > _LEAST_MOTION_S:
        level, error = _friction_level(log, robot, i, v, np.where(usable, tau, np.nan), half)
    steps = np.abs(np.diff(tau[known]))
    found = JointChecks(
        travel=float(np.ptp(q)),
        top_speed=float(np.quantile(speeds, 0.99)) if len(speeds) else np.nan,
        speed_limit=limit.velocity,
        effort_limit=limit.effort,
        forwards_s=forwards,
        backwards_s=backwards,
        position_step=step,
        effort_step=float(steps[steps > 0.0].min()) if (steps > 0.0).any() else np.nan,
        friction_level=level,
        friction_level_error=error,
        velocity_factor=_velocity_factor(log.v[:, i], v, moving, half),
        without_effort=float(np.mean(~known)),
        saturated=float(np.mean(saturated)),
    )
    refusal = _refusal(robot, i, q, tau, found) if known.any() else None
    if refusal:
        check, sentence = refusal
        return found, np.full_like(tau, np.nan), [DataFinding(check, name, REFUSED, sentence)]
    findings = []
    if known.any() and not known.all():
        what = (
            f'joint {name} has no effort in {100.0 * found.without_effort:.2g} % of the '
            'samples, which are left out'
        )
        findings.append(DataFinding('without_effort', name, LEFT_OUT, what))
    if saturated.any():
        tau[saturated] = np.nan
        what = (
            f'the effort of joint {name} stays at its extreme in {100.0 * found.saturated:.2g} % '
            'of the samples, which are left out: it is limited there, and no measurement'
        )
        findings.append(DataFinding('saturation', name, LEFT_OUT, what))
    if 0.0 < limit.velocity < found.top_speed:
        what = (
            f'joint {name} moves at {found.top_speed:.3g} {way}/s, faster than the '
            f'{limit.velocity:.3g} its URDF allows'
        )
        findings.append(DataFinding('speed', name, NOTE, what))
    return found, tau, findings


def _refusal(
    robot: Robot, i: int, q: FloatArray, tau: FloatArray, found: JointChecks
) -> tuple[str, str] | None:
    """Return (check, sentence) if the joint cannot be fitted."""
    name, unit, limit = robot.names[i], robot.effort_units[i], robot.limits[i]
    way, convert = ('rad', 'degrees to rad') if unit == 'Nm' else ('m', 'millimetres to m')
    wrong_unit = f'convert {convert} in the driver or the mapping, or correct the URDF'
    room = limit.upper - limit.lower
    outside = max(limit.lower - float(q.min()), float(q.max()) - limit.upper)
    if 0.0 < room < np.inf and outside > 0.5 * room:
        return 'position_unit', (
            f'joint {name} is at {q.min():.4g} to {q.max():.4g} where its URDF allows '
            f'{limit.lower:.4g} to {limit.upper:.4g} {way}: {wrong_unit}'
        )
    if limit.velocity > 0.0 and found.top_speed > _IMPOSSIBLE * limit.velocity:
        return 'position_unit', (
            f'joint {name} moves at {found.top_speed:.3g} where its URDF allows '
            f'{limit.velocity:.3g} {way}/s: {wrong_unit}'
        )
    if found.saturated > _MOST_SATURATED:
        extreme = float(np.nanmax(np.abs(tau)))
        return 'saturation', (
            f'the effort of joint {name} stays at its extreme of {extreme:.4g} {unit} in '
            f'{100.0 * found.saturated:.0f} % of the samples, where it is limited and no '
            'measurement: move more slowly, with less load, or raise the limit'
        )
    known = tau[np.isfinite(tau)]
    moved = found.forwards_s + found.backwards_s
    if moved <= _LEAST_MOTION_S:
        return 'no_motion', (
            f'joint {name} does not move while its effort is known (its range is '
            f'{found.travel:.3g} {way}): record motion in both directions at several speeds'
        )
    if len(known) and np.ptp(known) == 0.0:
        return 'constant_effort', (
            f'the effort of joint {name} is {known[0]:.4g} {unit} in every sample though it '
            'moves, so it is not measured: let the driver fill it'
        )
    if min(found.forwards_s, found.backwards_s) <= _LEAST_MOTION_S:
        side = 'forwards' if found.forwards_s > found.backwards_s else 'backwards'
        return 'one_direction', (
            f'joint {name} moves in one direction only ({side}, {moved:.3g} s), where friction '
            'cannot be told from gravity: record motion in both directions'
        )
    if np.isfinite(found.velocity_factor) and not (
        1.0 / _OTHER_UNIT < found.velocity_factor < _OTHER_UNIT
    ):
        return 'velocity_unit', (
            f'the velocity of joint {name} is {found.velocity_factor:.3g} times the slope of its '
            f'position: report it in {way}/s with the sign of the position, or leave it out'
        )
    level = found.friction_level
    if level < -3.0 * found.friction_level_error and -level > _FEIGNED * float(np.ptp(known)):
        return 'dissipation', (
            f'the effort of joint {name} is {-2.0 * level:.3g} {unit} smaller when it moves '
            'forwards than backwards, so friction would drive it: turn the sign of its effort, '
            'or of its position, in the driver or the mapping'
        )
    return None


def _saturated(tau: FloatArray, limit: float) -> NDArray[np.bool_]:
    """
    Return where effort is limited, (N,): runs of equal samples at an extreme.

    At the URDF's limit five in a row are enough. Elsewhere a run must be longer than chance makes
    it, judged by how often neighbours away from the extremes are equal. Where most of them are (a
    coarse or noise-free effort), only the URDF's limit tells.
    """
    result = np.zeros(len(tau), dtype=bool)
    known = tau[np.isfinite(tau)]
    if len(known) < _FEWEST_EQUAL or np.ptp(known) == 0.0:
        return result
    equal = np.append(False, tau[1:] == tau[:-1])
    for extreme in (known.min(), known.max()):
        at = tau == extreme
        inner = np.isfinite(tau) & (tau != known.min()) & (tau != known.max())
        share = float(np.mean(equal[inner])) if inner.any() else 1.0
        at_limit = 0.0 < limit < np.inf and abs(extreme) >= 0.98 * limit
        if share > 0.5 and not at_limit:
            continue
        fewest = _FEWEST_EQUAL
        if share > 0.0 and not at_limit:
            fewest = max(fewest, 1 + int(np.ceil(np.log(_CHANCE / len(tau)) / np.log(share))))
        edges = np.flatnonzero(np.diff(at)) + 1
        for run in np.split(np.arange(len(tau)), edges):
            if at[run[0]] and len(run) >= fewest:
                result[run] = True
    return result


def _velocity_factor(
    reported: FloatArray, v: FloatArray, moving: NDArray[np.bool_], half: int
) -> float:
    """Return reported velocity over slope of position, each over a window, NaN if not told."""
    both = moving & np.isfinite(reported) & np.isfinite(v)
    if both.sum() < 2 * half:
        return np.nan
    # The noise of a differenced position is far above it, that of the mean over a window is not.
    mean = np.convolve(np.nan_to_num(reported), np.full(2 * half, 0.5 / half), mode='same')
    return float(mean[both] @ v[both] / (v[both] @ v[both]))


def _friction_level(
    log: JointLog, robot: Robot, i: int, v: FloatArray, tau: FloatArray, half: int
) -> tuple[float, float]:
    """
    Return the part of effort that is odd in velocity, at the median speed, and its error.

    Least squares of tau on the sign of velocity, its size beyond the median speed, acceleration,
    the model's gravity and a constant: an error of gravity or inertia then hardly counts as
    friction. The error is the jackknife over stretches of 1 s.
    """
    a = centred_difference(log.time, v, half)
    rows = np.flatnonzero(np.isfinite(a) & np.isfinite(v) & np.isfinite(tau))[:: max(1, half // 2)]
    groups = np.unique(log.time[rows].astype(np.int64), return_inverse=True)[1]
    if len(rows) < 20 or groups.max() < 3:
        return np.nan, np.nan
    sign = np.sign(v[rows])
    median = float(np.median(np.abs(v[rows])))
    g = np.array([robot.gravity(q)[i] for q in log.q[rows]])
    columns = [sign, v[rows] - sign * median, a[rows], g, np.ones(len(rows))]
    # A column that does not vary is the constant once more.
    X = np.column_stack([c for k, c in enumerate(columns) if k in (0, 4) or np.ptp(c) > 1e-9])
    norms = np.linalg.norm(X, axis=0)
    theta = np.linalg.lstsq(X / norms, tau[rows], rcond=1e-9)[0]
    errors = jackknife_errors(X / norms, tau[rows] - X / norms @ theta, groups)
    return float(theta[0] / norms[0]), float(errors[0] / norms[0])
