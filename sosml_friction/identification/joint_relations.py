# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
How the columns of a recording must hang together, and which fault makes them.

Each hypothesis predicts one column from the others: the recording as it is, another unit of
position, velocity or effort, a turned sign, a delay. The one with the least misfit is taken, if it
is clearly better than the recording as it is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d

from sosml_friction.arrays import BoolArray, FloatArray, IndexArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.identification.law.jackknife import jackknife_errors
from sosml_friction.identification.segments import centred_difference
from sosml_friction.model.robot import Robot
from sosml_friction.regression.column_norms import column_norms

#: Time over which position is differenced to a speed [s]. Chosen, no measurement.
WINDOW_S = 0.1
#: Most rows on which the body's effort is computed, which bounds the time, and fewest that say
#: something of five parameters. Chosen, no measurement.
ROWS, FEWEST_ROWS = 800, 30
#: The misfit of another hypothesis is at most this share of that of the data as they are. Chosen,
#: no measurement.
WELL = 0.5
#: The rows of one cluster of the jackknife [s].
_CLUSTER_S = 1.0
#: Longest delay that is tried [s], and of an effort that is as late. Chosen, no measurement.
_LONGEST_S, _LATEST_S = 0.06, 0.1
#: A delay is told if it takes this share off the misfit, and more than a period and a half.
_BETTER = 0.7
#: Mean of the sign of velocity over the window where a joint moves in one direction: rounding.
_ONE_WAY = 0.999
#: Speeds that are the highest, and those next to it, as shares of it. Chosen, no measurement.
_AT_TOP, _BELOW_TOP = 0.97, (0.75, 0.94)
#: Fewest samples of either; how much more effort scatters at the highest, and by how many standard
#: errors it falls. Measured on a servo at its limit: 1.7 and 1.8 to 2.8; on five other motions at
#: most 1.0, and never a fall.
_FEWEST_AT_TOP, _SCATTERS, _FALLS = 30, 1.4, 1.5
#: How much the highest speeds of both directions differ at most, and the time over which efforts
#: are one [s]. Chosen, no measurement.
_ONE_TOP, _ONE_S = 0.99, 0.1
#: Times that lost signs are taken from what fits those before. Chosen, no measurement: they settle
#: within ten.
_TURNS = 30
#: A scale nearer to 1 than this is not told: gains of currents and masses differ by as much.
SCALE = 1.5
#: What a reported velocity may be instead of the slope of position, and its factor.
VELOCITY_UNITS: Mapping[str, Mapping[str, float]] = {
    'Nm': {
        'in degrees per second': 180.0 / np.pi,
        'in revolutions per minute': 30.0 / np.pi,
        'in turns per second': 0.5 / np.pi,
        'with the other sign': -1.0,
    },
    'N': {'in mm/s': 1e3, 'with the other sign': -1.0},
}
#: A factor is a unit's if it is within this share of it. Chosen, no measurement.
_NAMED = 0.05
#: What a position may be instead of rad or m, and how many of it one rad or m is. One that was
#: stated in another unit than its own was converted once too often.
_POSITION_UNITS = {
    'Nm': {
        'degrees': 180.0 / np.pi,
        'turns': 0.5 / np.pi,
        'rad that were taken for degrees': np.pi / 180.0,
    },
    'N': {'mm': 1e3, 'cm': 1e2, 'm that were taken for mm': 1e-3},
}
#: Gears, of which gravity tells by its shape. So near to 1 a spring beside other masses has nearly
#: the same: it is one if the masses are the URDF's.
_GEARS = {'rad before a gear of 2': 2.0, 'rad behind a gear of 2': 0.5}


@dataclass(frozen=True)
class Slopes:
    """
    Hold what the positions of all joints say of their motion, (N, n), over a window of 0.1 s.

    ``v`` and ``a`` are NaN at the ends and across holes; ``half``: half of the window [samples].
    """

    time: FloatArray
    v: FloatArray
    a: FloatArray
    half: int

    @classmethod
    def of(cls, log: JointLog) -> Slopes:
        """Return the slopes of a log whose stamps rise."""
        time = log.time
        half = max(1, round(0.5 * WINDOW_S / float(np.median(np.diff(time)))))
        if len(time) <= 2 * half:
            nothing = np.full(log.q.shape, np.nan)
            return cls(time, nothing, nothing, half)
        v = centred_difference(time, log.q, half)
        return cls(time, v, centred_difference(time, v, half), half)

    @property
    def period(self) -> float:
        """Return the median step [s]."""
        return float(np.median(np.diff(self.time)))


@dataclass(frozen=True)
class VelocityRelation:
    """
    Hold a reported velocity beside the slope of position.

    ``factor`` +- ``error``: velocity over slope. ``misfit``: what the slope leaves of the velocity
    by that factor, as a share of its root mean square. ``late_s``: its delay.
    """

    factor: float
    error: float
    misfit: float
    late_s: float = 0.0

    def unit(self, units: Mapping[str, float]) -> str | None:
        """Return the name of the unit whose factor this is, None if of none."""
        off = {name: abs(self.factor / value - 1.0) for name, value in units.items()}
        name = min(off, key=lambda unit: off[unit])
        return name if off[name] < _NAMED else None


def velocity_relation(
    reported: FloatArray, slopes: Slopes, i: int, moving: BoolArray
) -> VelocityRelation | None:
    """
    Return how a reported velocity (N,) follows from position; None if too little moves.

    The noise of a differenced position is far above it, that of the mean over a window is not, so
    both are over a window.
    """
    v, half = slopes.v[:, i], slopes.half
    mean = mean_over(reported, half)
    most = int(_LONGEST_S / slopes.period)
    rows = np.flatnonzero(moving & np.isfinite(v) & _known_around(mean, most))
    if len(rows) < 2 * half:
        return None

    def misfit(shift: int) -> tuple[float, float]:
        x, y = v[rows], mean[rows + shift]
        factor = float(x @ y / (x @ x))
        left = float(np.linalg.norm(y - factor * x))
        return factor, left / max(float(np.linalg.norm(y)), 1e-300)

    misfits = [misfit(k)[1] for k in range(-most, most + 1)]
    late = int(np.argmin(misfits)) - most
    if misfits[late + most] > _BETTER * misfits[most] or abs(late) < 2:
        late = 0
    factor, left = misfit(late)
    x, y = v[rows], mean[rows + late]
    error = _error(x[:, None], y - factor * x, slopes.time[rows])[0]
    return VelocityRelation(factor, float(error), left, late * slopes.period)


def speed_limit(
    log: JointLog, robot: Robot, i: int, slopes: Slopes, usable: BoolArray
) -> tuple[float, BoolArray] | None:
    """
    Return the speed that a drive does not exceed, and the samples at it (N,); None without one.

    At its highest speed a motor lacks voltage: what is commanded has no say any more, so that
    the current drops and scatters, where friction would be as at somewhat slower speeds, or more.
    Both are asked for, at one highest speed in both directions, of what the bodies leave, which
    are free: the weight of a wrong mass falls and scatters too.

    :param usable: samples (N,) with known effort.
    """
    v = slopes.v[:, i]
    known = usable & np.isfinite(slopes.a).all(axis=1)
    speed = np.where(known, np.abs(v), 0.0)
    if not speed.any():
        return None
    sides = [float(np.quantile(speed[s * v > 0.0], 0.99)) for s in (1, -1) if (s * v > 0.0).any()]
    top = max(sides)
    at = speed > _AT_TOP * top
    below = (speed > _BELOW_TOP[0] * top) & (speed < _BELOW_TOP[1] * top)
    if (
        len(sides) < 2
        or min(sides) < _ONE_TOP * top
        or min(at.sum(), below.sum()) < _FEWEST_AT_TOP
    ):
        return None

    groups = [np.flatnonzero(where) for where in (at, below)]
    groups = [rows[:: max(1, len(rows) // ROWS)] for rows in groups]
    rows = np.concatenate(groups)
    is_fast = np.arange(len(rows)) < len(groups[0])
    sign = np.sign(v[rows])
    bodies = robot.torque_regressors(log.q[rows], slopes.v[rows], slopes.a[rows])[:, i]
    bodies = np.column_stack([bodies, slopes.a[rows, i]])
    X = np.column_stack([sign * is_fast, sign * ~is_fast, bodies])
    X /= column_norms(X)
    theta = np.linalg.lstsq(X, log.tau[rows, i], rcond=1e-9)[0]
    friction = (log.tau[rows, i] - X[:, 2:] @ theta[2:]) * sign
    fast, slower = friction[is_fast], friction[~is_fast]
    counts = [max(1.0, where.sum() * slopes.period / _ONE_S) for where in (at, below)]
    error = float(np.hypot(fast.std() / np.sqrt(counts[0]), slower.std() / np.sqrt(counts[1])))
    falls = float(slower.mean() - fast.mean()) > _FALLS * error
    return (top, at) if falls and fast.std() > _SCATTERS * slower.std() else None


def lost_sign(
    log: JointLog, robot: Robot, i: int, slopes: Slopes, usable: BoolArray
) -> tuple[float, float] | None:
    """
    Return what motion leaves of an effort that never changes its sign, (with one, as it is).

    Both are root mean squares of what friction, a constant, and gravity and inertia of free bodies
    leave, as shares of the effort's: X b - s |tau| with the signs s of X b, and X b - tau. None
    where the effort changes its sign, or too little is known. What weighs more than friction has
    one sign by right, and then s is that.

    :param usable: samples (N,) with known effort.
    """
    v, known = slopes.v[:, i], log.tau[np.isfinite(log.tau[:, i]), i]
    one_way = np.abs(mean_over(np.sign(v), slopes.half)) > _ONE_WAY
    rows = np.flatnonzero(usable & one_way & np.isfinite(slopes.a).all(axis=1))
    rows = rows[:: max(1, len(rows) // ROWS)]
    if len(rows) < FEWEST_ROWS or known.min() < 0.0 < known.max():
        return None
    bodies = robot.torque_regressors(log.q[rows], slopes.v[rows], slopes.a[rows])[:, i]
    own = np.column_stack([np.sign(v[rows]), v[rows], slopes.a[rows, i], np.ones(len(rows))])
    U = _basis(np.column_stack([own, bodies]))
    tau = np.abs(log.tau[rows, i])
    whole = float(np.linalg.norm(tau))

    def left(sign: FloatArray) -> float:
        """Return the misfit of the signs that it leads to from those."""
        for _ in range(_TURNS):
            fitted = U @ (U.T @ (sign * tau))
            sign = np.where(fitted < 0.0, -1.0, 1.0)
        return float(np.linalg.norm(np.abs(fitted) - tau)) / whole

    need = np.array(
        [
            robot.inverse_dynamics(*state)[i]
            for state in zip(log.q[rows], slopes.v[rows], slopes.a[rows], strict=True)
        ]
    )
    # What is far from 0 has one sign between changes of it: it says what the rest needs.
    far = tau > np.median(tau)
    by_far = U @ np.linalg.lstsq(U[far], tau[far], rcond=1e-9)[0]
    best = min(left(np.sign(start)) for start in (v[rows], need, by_far))
    return best, float(np.linalg.norm(tau - U @ (U.T @ tau))) / whole


@dataclass(frozen=True)
class Zero:
    """
    Say from where a position counts, by the phase of gravity over it.

    ``at`` [rad]: where the URDF has what is read as 0; ``scale`` of the gravity that acts so, and
    ``misfit`` what it leaves; ``upright``: what gravity of any scale that masses may have leaves
    with 0 as it is.
    """

    at: float
    scale: float
    misfit: float
    upright: float


@dataclass(frozen=True)
class EffortRelation:
    """
    Hold the effort of a joint beside what its bodies need to move as they did.

    ``scale`` +- ``error``: the reported effort over that of the URDF's bodies and the armature,
    beside friction in its simplest form (sign of velocity, velocity, a constant). Misfits are
    shares of the effort's standard deviation that are left: ``alone`` by friction alone, ``free``
    with the bodies by their scale, ``as_it_is`` with scale 1. ``gravity`` and ``inertia``: the
    scale of either, NaN where the motion does not tell it. ``unit``: the unit of position with
    which the bodies fit clearly better, their ``unit_scale`` and ``unit_misfit``. ``late_s``:
    delay of the effort, which takes the misfit from ``free`` to ``late_misfit``. ``zero``: None
    where gravity tells nothing of it.
    """

    scale: float
    error: float
    alone: float
    free: float
    as_it_is: float
    gravity: float
    inertia: float
    unit: str | None = None
    unit_scale: float = np.nan
    unit_misfit: float = np.nan
    late_s: float = 0.0
    late_misfit: float = np.nan
    zero: Zero | None = None

    @property
    def tells(self) -> bool:
        """Tell whether the bodies explain half of the variance that friction leaves."""
        return abs(self.scale) > 5.0 * self.error and self.free**2 < 0.5 * self.alone**2

    @property
    def by_bodies(self) -> float:
        """Return what the bodies leave in the unit as it is, of any mass or from any zero."""
        zero, turned = self.zero, np.inf
        if zero is not None and 1.0 / SCALE < zero.scale < SCALE:
            turned = zero.misfit
        return min(self.free, self.as_it_is, turned)

    @property
    def fits(self) -> bool:
        """Tell whether the bodies explain the effort with the positions as they are."""
        return self.tells and self.as_it_is**2 < 0.5 * self.alone**2


def effort_relation(
    log: JointLog,
    robot: Robot,
    i: int,
    slopes: Slopes,
    usable: BoolArray,
    free_rotor: bool = False,
) -> EffortRelation | None:
    """
    Return how the effort of joint i follows from the motion; None if too little is known.

    :param free_rotor: whether its armature is not known: acceleration alone shows nothing then.
    """
    # What is differenced over a window twice is a mean over it twice: so is the other side.
    effort = mean_over(mean_over(log.tau[:, i], slopes.half), slopes.half)
    sign = mean_over(mean_over(np.sign(slopes.v[:, i]), slopes.half), slopes.half)
    slow = mean_over(slopes.v[:, i], slopes.half)
    known = np.isfinite(slopes.a).all(axis=1) & usable
    for column in (effort, sign, slow):
        known &= np.isfinite(column)
    rows = np.flatnonzero(known)
    rows = rows[:: max(1, len(rows) // ROWS)]
    if len(rows) < FEWEST_ROWS:
        return None
    q, v, a = log.q[rows], slopes.v[rows], slopes.a[rows]
    tau = effort[rows]
    rotor = [a[:, i]] if free_rotor else []
    friction = np.column_stack([sign[rows], slow[rows], np.ones(len(rows)), *rotor])
    size = float(np.std(tau))
    if size == 0.0:
        return None

    def left(columns: FloatArray, y: FloatArray) -> tuple[FloatArray, float, float]:
        """Return the factors of columns, the misfit, and the error of the first factor."""
        norms = column_norms(columns)
        X = columns / norms
        theta = np.linalg.lstsq(X, y, rcond=1e-9)[0]
        residual = y - X @ theta
        error = _error(X, residual, slopes.time[rows])[0] / norms[0]
        return theta / norms, float(np.sqrt(np.mean(residual**2))) / size, float(error)

    def bodies(per_unit: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return inertial and gravity effort of joint i with positions over ``per_unit`` (n,)."""
        states = zip(q / per_unit, v / per_unit, a / per_unit, strict=True)
        both = np.array(
            [(robot.inverse_dynamics(*state)[i], robot.gravity(state[0])[i]) for state in states]
        )
        return both[:, 0] - both[:, 1], both[:, 1]

    inertial, gravity = bodies(np.ones(robot.n))
    whole_effort = inertial + gravity
    alone = left(friction, tau)[1]
    as_it_is = left(friction, tau - whole_effort)[1]
    if np.ptp(whole_effort) <= 1e-12 * size:
        return EffortRelation(np.nan, np.nan, alone, alone, as_it_is, np.nan, np.nan)
    theta, free, error = left(np.column_stack([whole_effort, friction]), tau)
    parts = [np.nan, np.nan]
    columns = [(k, x) for k, x in enumerate((gravity, inertial)) if np.ptp(x) > 1e-6 * size]
    if len(columns) == 1:
        parts[columns[0][0]] = float(theta[0])
    if len(columns) == 2:
        found = left(np.column_stack([*(x for _, x in columns), friction]), tau)[0]
        parts = [float(found[0]), float(found[1])]
    unit, unit_scale, unit_misfit = None, np.nan, np.nan
    turns = robot.effort_units[i] == 'Nm'
    tried = _POSITION_UNITS[robot.effort_units[i]] | (_GEARS if turns else {})
    for name, per_unit in tried.items():
        for own in (np.ones(robot.n), np.full(robot.n, per_unit)):
            own = own.copy()
            own[i] = per_unit
            column = np.sum(bodies(own), axis=0)
            if np.ptp(column) <= 1e-12 * size:
                continue
            other, misfit, _ = left(np.column_stack([column, friction]), tau)
            if name in _GEARS:
                misfit = left(friction, tau - column)[1]
            if 1 / 3 < other[0] < 3.0 and not misfit >= unit_misfit:
                unit, unit_scale, unit_misfit = name, float(other[0]), misfit
    zero = None
    if turns:
        # About its axis gravity turns with the joint: g(q + z) = cos z g(q) + sin z g(q + pi / 2).
        quarter = np.where(np.arange(robot.n) == i, 0.5 * np.pi, 0.0)
        turned = [gravity, robot.statics(q + quarter)[1][:, i]]
        if min(map(np.ptp, turned)) > 1e-6 * size:
            found, upright, _ = left(np.column_stack([gravity, friction]), tau - inertial)
            # With the other sign it is upside down, another zero, and masses are no other ones.
            scale = np.clip(found[0], 1.0 / SCALE, SCALE)
            if scale != found[0]:
                upright = left(friction, tau - inertial - scale * gravity)[1]
            found, misfit, _ = left(np.column_stack([*turned, friction]), tau - inertial)
            at, turned_scale = np.arctan2(found[1], found[0]), np.hypot(*found[:2])
            zero = Zero(float(at), float(turned_scale), misfit, upright)
    late_s, late_misfit = _delay(effort, rows, slopes, inertial, gravity, friction)
    if late_s:
        # Where a joint sticks, friction turns around later than the velocity does: no clock is in
        # it. What the motion in one direction says then, has to say it as well.
        slides = np.where(np.abs(sign) > _ONE_WAY, effort, np.nan)
        late_s, late_misfit = _delay(slides, rows, slopes, inertial, gravity, friction)
    return EffortRelation(
        float(theta[0]), error, alone, free, as_it_is, parts[0], parts[1],
        unit, unit_scale, unit_misfit, late_s, late_misfit, zero,
    )  # fmt: skip


def _delay(
    tau: FloatArray, rows: IndexArray, slopes: Slopes, *columns: FloatArray
) -> tuple[float, float]:
    """
    Return by how much later efforts fit better [s], 0 if none does, and the misfit there.

    The columns are free, so that wrong masses are no delay. No effort comes before its cause.
    """
    found = _delay_within(_LONGEST_S, tau, rows, slopes, *columns)
    # The longer search is for what is at the end of the other: a joint that sticks where it turns
    # around may seem later at any length.
    if round(found[0] / slopes.period) < int(_LONGEST_S / slopes.period):
        return found
    return _delay_within(_LATEST_S, tau, rows, slopes, *columns)


def _delay_within(
    longest_s: float, tau: FloatArray, rows: IndexArray, slopes: Slopes, *columns: FloatArray
) -> tuple[float, float]:
    """Return the same of delays of so long at most."""
    most = int(longest_s / slopes.period)
    kept = _known_around(tau, most)[rows]
    if kept.sum() < FEWEST_ROWS:
        return 0.0, np.nan
    X, rows = np.column_stack(columns)[kept], rows[kept]
    U = _basis(X)
    misfits = []
    for k in range(most + 1):
        y = tau[rows + k]
        left = float(np.linalg.norm(y - U @ (U.T @ y)))
        misfits.append(left / max(float(np.linalg.norm(y - y.mean())), 1e-300))
    best = int(np.argmin(misfits))
    if best < 2 or misfits[best] > _BETTER * misfits[0]:
        return 0.0, np.nan
    return best * slopes.period, misfits[best]


def _basis(X: FloatArray) -> FloatArray:
    """Return orthonormal columns that span those of X, without what is rounding."""
    U, size, _ = np.linalg.svd(X / column_norms(X), full_matrices=False)
    return np.asarray(U[:, size > 1e-9 * size[0]])


def _known_around(x: FloatArray, most: int) -> BoolArray:
    """Return where x is known from ``most`` samples before to as many after, (N,)."""
    unknown = (~np.isfinite(x)).astype(np.int8)
    return np.asarray(maximum_filter1d(unknown, 2 * most + 1, mode='constant', cval=1) == 0)


def mean_over(x: FloatArray, half: int) -> FloatArray:
    """Return the mean over a window of 2 half steps, its ends by half, (N,); NaN at the ends."""
    result = np.full(len(x), np.nan)
    if len(x) > 2 * half:
        weights = np.full(2 * half + 1, 0.5 / half)
        weights[[0, -1]] *= 0.5
        result[half:-half] = np.convolve(x, weights, mode='valid')
    return result


def _error(X: FloatArray, residual: FloatArray, time: FloatArray) -> FloatArray:
    """Return the jackknife errors over clusters of a second, infinite where there are two."""
    groups = np.unique((time / _CLUSTER_S).astype(np.int64), return_inverse=True)[1]
    if groups.max(initial=0) < 2:
        return np.full(X.shape[1], np.inf)
    return jackknife_errors(X, residual, groups)
