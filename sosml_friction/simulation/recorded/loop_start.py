# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""When a recorded trajectory began: where the controller's law makes the recorded effort of it."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import DataError
from sosml_friction.motion.reference import BLEND, blend
from sosml_friction.motion.reference_motion import ReferenceMotion
from sosml_friction.motion.velocity import WindowedSlope
from sosml_friction.simulation.recorded.law_check import LawCheck
from sosml_friction.simulation.recorded.recorded_loop import RecordedLoop

#: Times before and after the message of the trajectory between which its beginning is searched,
#: and the step of the coarse search [s]. Chosen, no measurement.
_BEFORE_S, _AFTER_S, _STEP_S = 0.06, 0.5, 4e-3
#: Length of the motion that the search compares [s]. Chosen, no measurement.
_LOOK_S = 20.0
#: Interval at which the driver's model is evaluated; it is interpolated linearly between [s].
#: Chosen, no measurement.
_TABLE_S = 1e-3
#: A recording of fewer samples says nothing of it.
_FEWEST = 20
#: Rounds in which the place is found where the joints were held.
_ROUNDS = 3


@dataclass(frozen=True)
class LoopReference:
    """
    Hold the reference at each of the N samples of a recording, joints in the robot's order.

    ``start`` [s]: of the trajectory, after the first sample; the time that a sample takes from
    the beginning of its cycle is in it. ``q``, ``v`` (N, n) and ``ahead`` (N, n) [Nm or N]: the
    effort that is fed forward. ``left`` [%]: by joint, the share of the feedback effort that the
    law does not explain, 100 mean |recorded - law| / mean |recorded - ahead|.
    """

    start: float
    q: FloatArray
    v: FloatArray
    ahead: FloatArray
    left: Mapping[str, float]


def find_reference(log: JointLog, loop: RecordedLoop) -> LoopReference:
    """
    Return the reference of a recording.

    The command of a cycle is made of its own reference and of the sample before,

        u_k = ahead(t_k) + kp (q_r(t_k) - q_{k-1}) + kd (v_r(t_k) - v_{k-1}),

    and sample k + 1 reports it. The start of the trajectory is where the mean of |report - u| is
    least; at 1 rad/s and 250 Nm/rad a millisecond is 0.25 Nm. The position at which the joint was
    held before is fitted with it by least squares: its part of u is kp times the blend.

    :param log: all joints of the loop's robot, in its order.
    :raises DataError: if the law does not make the recorded effort, with the reason.
    """
    law = _Law(log, loop)
    start, offset = law.search()
    hold = np.array(law.here)
    hold[law.joints] = law.motion.first[law.joints] + offset
    time = log.time
    blending = slice(0, int(np.searchsorted(time, start + BLEND)) + 1)
    for _ in range(_ROUNDS):
        # What is fed forward depends on it too, a little.
        t = time[blending] - start
        reference, speed, bend = law.motion.at(t, hold)
        left = law.left(blending, reference, speed, law.fed(reference, speed, bend))
        hold[law.joints] += law.shift(t, left)
    reference, speed, bend = law.motion.at(time - start, hold)
    ahead = law.fed(reference, speed, bend)
    left = law.left(slice(None), reference, speed, ahead)
    size = np.nanmean(np.abs(law.tau - np.nanmedian(law.tau, axis=0)), axis=0)
    made = np.nanmean(np.abs(law.tau - ahead[:, law.joints]), axis=0)
    checks = [
        LawCheck(name, left[:, i], float(made[i]), float(size[i]), time[2:])
        for i, name in enumerate(loop.gains)
    ]
    for check, joint in zip(checks, law.joints, strict=True):
        if not check.holds:
            raise DataError(check.objection(loop.robot.effort_units[joint]))
    by_joint = {check.joint: check.share for check in checks}
    return LoopReference(start, reference, speed, ahead, by_joint)


class _Law:
    """Hold a recording under its controller; joints are those that it drives, in their order."""

    def __init__(self, log: JointLog, loop: RecordedLoop) -> None:
        robot = self._robot = loop.robot
        known = np.isfinite(log.q)
        if not known.any(axis=0).all():
            raise DataError('the position of a joint is not known')
        self.here = np.array([x[k][0] for x, k in zip(log.q.T, known.T, strict=True)])
        self.motion = ReferenceMotion(loop.wanted, self.here)
        self.joints = [robot.names.index(name) for name in loop.gains]
        gains = list(loop.gains.values())
        self._kp, self._kd, self._limit = (
            np.array([getattr(g, key) for g in gains]) for key in ('kp', 'kd', 'limit')
        )
        self._time, self._sent = log.time, loop.sent
        self.tau, self._q = log.tau[:, self.joints], log.q[:, self.joints]
        if not np.isfinite(self.tau).any(axis=0).all():
            raise DataError('the effort of a joint under the controller is not known')
        self._v = np.column_stack(
            [
                driver_velocity(log.t_ns, x, g.rate, g.velocity_window)
                for x, g in zip(self._q.T, gains, strict=True)
            ]
        )

    def fed(self, *reference: FloatArray) -> FloatArray:
        """Return what is fed forward (K, n) at position, velocity and acceleration (K, n) each."""
        return np.array([self._robot.inverse_dynamics(*x) for x in zip(*reference, strict=True)])

    def left(self, rows: slice, q_r: FloatArray, v_r: FloatArray, ahead: FloatArray) -> FloatArray:
        """Return report less law of the commands in ``rows`` but the first and the last."""
        j, now, before = self.joints, slice(1, -1), slice(None, -2)
        u = ahead[now, j] + self._kp * (q_r[now, j] - self._q[rows][before])
        u = u + self._kd * (v_r[now, j] - self._v[rows][before])
        return np.asarray(self.tau[rows][2:] - np.clip(u, -self._limit, self._limit))

    def _weight(self, t: FloatArray) -> FloatArray:
        """Return what those commands change by with the place where a joint was held."""
        share, rate, _ = blend(t[1:-1, None])
        return np.asarray(share * self._kp + rate * self._kd)

    def shift(self, t: FloatArray, left: FloatArray) -> FloatArray:
        """Return by how much that place should change so that least is left."""
        weight = np.where(np.isfinite(left), self._weight(t), 0.0)
        explained = np.sum(weight * np.nan_to_num(left), axis=0)
        return np.asarray(explained / np.maximum(np.sum(weight**2, axis=0), 1e-300))

    def search(self) -> tuple[float, FloatArray]:
        """Return when the trajectory begins [s], and how far off its start joints are held."""
        end = self._sent + _AFTER_S + min(self.motion.duration, _LOOK_S)
        few = slice(0, int(np.searchsorted(self._time, end)) + 1)
        if few.stop < _FEWEST:
            raise DataError('the recording ends before its trajectory has begun')
        table = np.arange(0.0, end - self._sent + _AFTER_S, _TABLE_S)
        made = self.fed(*self.motion.at(table, self.motion.first))

        def held(start: float) -> tuple[FloatArray, float]:
            t = self._time[few] - start
            reference, speed, _ = self.motion.at(t, self.motion.first)
            ahead = np.column_stack([np.interp(t, table, x) for x in made.T])
            left = self.left(few, reference, speed, ahead)
            offset = self.shift(t, left)
            return offset, float(np.nanmean(np.abs(left - self._weight(t) * offset)))

        grid = np.arange(self._sent - _BEFORE_S, self._sent + _AFTER_S, _STEP_S)
        best = int(np.argmin([held(start)[1] for start in grid]))
        near = (grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)])
        found = minimize_scalar(
            lambda x: held(x)[1], bounds=near, method='bounded', options={'xatol': 1e-5}
        )
        return float(found.x), held(float(found.x))[0]


def driver_velocity(t_ns: IndexArray, q: FloatArray, rate: float, window: int) -> FloatArray:
    """Return the velocity (N,) that the driver used: the last one known, 0 before the first."""
    slope = WindowedSlope(window, velocity_gap_ns(rate, window))
    result = np.zeros(len(q))
    last = 0.0
    for k, (stamp, position) in enumerate(zip(t_ns.tolist(), q.tolist(), strict=True)):
        v = slope.update(stamp, position)
        last = v if np.isfinite(v) else last
        result[k] = last
    return result


def velocity_gap_ns(rate: float, window: int) -> int:
    """Return after which pause the driver's window begins anew [ns]."""
    return int(window * round(1e9 / rate))
