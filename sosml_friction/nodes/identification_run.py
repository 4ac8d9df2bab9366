# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One run of identifier_node: its folder, its bag and how far it is."""

import math
import struct
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from rclpy.task import Future
from sensor_msgs.msg import JointState

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.recorder import BagRecorder
from sosml_friction.model.robot import Robot
from sosml_friction.motion.trajectory import Trajectory

#: Time that is recorded after the end of the trajectory [s]. Chosen, no measurement.
SETTLE_S = 0.5
#: By when the driver has the trajectory [ns]: DDS looks every 3 s for what was lost. Chosen.
UNHEARD_NS = 10 * 10**9
#: So long is braked at least and at most [s], and the run's accelerations are looked for at so
#: many instants. Chosen.
_BRAKE_S, _LONGEST_S = 0.1, 1.0
_LOOKS = 2000
#: Between two instants at which the motion may have begun [s]: no joint goes far in it.
_LOOK_S = 0.02


@dataclass
class IdentificationRun:
    """
    Hold a run.

    ``reset`` will be the observers' answer to their reset. ``pending`` holds what came before the
    beginning was known, ``unknown_ns`` the stamps at which no joint's friction was known.
    ``begin_ns`` is the stamp of the first sample of the bag, ``sent_ns`` that of the sample after
    which the trajectory was sent, ``heard_ns`` by when the driver had it at the latest, which
    ``is_heard`` says: the motion began between the two. DDS may take seconds for it, as it asks
    only so often whether something was lost or has come. ``past_end``: topics that are past the
    end; ``off_since``: by when the motion may have begun, the stamp since which the robot is off
    that, infinite where it was for a second.
    """

    folder: Path
    trajectory: Trajectory
    recorder: BagRecorder
    reset: Future
    pending: list[tuple[str, bytes, int]] = field(default_factory=list)
    unknown_ns: list[int] = field(default_factory=list)
    begin_ns: int = 0
    sent_ns: int = 0
    heard_ns: int = 0
    is_heard: bool = False
    past_end: set[str] = field(default_factory=set)
    off_since: FloatArray | None = None

    @property
    def end_ns(self) -> int:
        """Return the stamp of the end of the recording."""
        return self.heard_ns + round((self.trajectory.duration + SETTLE_S) * 1e9)

    def elapsed(self, t_ns: int) -> float:
        """Return how long the trajectory has run at a stamp at the least [s]."""
        return (t_ns - self.heard_ns) * 1e-9

    def brake(self, state: JointState, robot: Robot) -> Trajectory:
        """
        Return a trajectory from a state to rest, as fast as the run itself accelerates.

        It begins with where the robot is: without a point at time 0, some drivers begin where
        they held last. A velocity that is not measured is that of the run.
        """
        spline = self.trajectory.spline()
        measured = np.full((2, len(robot.names)), np.nan)
        for row, values in zip(measured, (state.position, state.velocity), strict=True):
            by_name = dict(zip(state.name, values, strict=False))
            row[:] = [by_name.get(name, np.nan) for name in robot.names]
        duration = self.trajectory.duration
        stamp = state.header.stamp
        at = min(max(self.elapsed(stamp.sec * 10**9 + stamp.nanosec), 0.0), duration)
        q, v = np.where(np.isfinite(measured), measured, [spline(at, 0), spline(at, 1)])
        looks = np.linspace(0.0, duration, _LOOKS)
        fastest, most = (np.abs(spline(looks, k)).max(axis=0) for k in (1, 2))
        most = np.maximum(most, fastest / _LONGEST_S)
        # A joint that does not take part is at rest.
        moves = most > 0.0
        needed = float(np.max(np.abs(v[moves]) / most[moves], initial=0.0))
        time = min(max(_BRAKE_S, needed), _LONGEST_S)
        end = q + 0.5 * time * v
        for i, limit in enumerate(robot.limits):
            # The same place twice is that of a joint without limits.
            if limit.upper > limit.lower:
                end[i] = min(max(end[i], min(q[i], limit.lower)), max(q[i], limit.upper))
        return Trajectory(
            robot.names, np.array([0.0, time]), np.array([q, end]), np.array([v, 0.0 * v])
        )

    def progress(self, t_ns: int) -> float:
        """Return the share of the trajectory that has surely run at a stamp, 0 to 1."""
        # Until it is heard, the beginning moves on with the samples, and the share would go back.
        share = self.elapsed(t_ns) / self.trajectory.duration if self.is_heard else 0.0
        return min(1.0, max(0.0, share))

    def hear(self, t_ns: int, now_ns: int, has_it: bool) -> None:
        """
        Look, at a sample of stamp ``t_ns``, whether the driver is known to have the trajectory.

        A machine that is late comes to its samples late: none of those so far may be of the
        motion. Whoever else listens may be stuck, and nobody waits for it any longer than a while:
        whether the robot moves is seen without it. ``now_ns`` may be of another clock.
        """
        late_ns = now_ns - t_ns
        self.heard_ns = now_ns if 0 < late_ns < UNHEARD_NS else t_ns
        self.is_heard = has_it or self.heard_ns - self.sent_ns > UNHEARD_NS

    def off_track(self, state: JointState, tolerance: float) -> tuple[str, float] | None:
        """
        Return the joint that has been off its trajectory for a second, and how far [rad or m].

        By the samples' time: where the machine stands still the last one only stays the last.
        """
        now = self.elapsed(state.header.stamp.sec * 10**9 + state.header.stamp.nanosec)
        unsure = (self.heard_ns - self.sent_ns) * 1e-9
        earlier = np.linspace(0.0, unsure, 1 + math.ceil(unsure / _LOOK_S))
        wanted = self.trajectory.spline()(np.clip(now + earlier, 0.0, self.trajectory.duration))
        known = dict(zip(state.name, state.position, strict=False))
        position = np.array([known.get(name, np.nan) for name in self.trajectory.names])
        errors = np.nan_to_num(np.abs(position - wanted))
        off = (errors > tolerance).any(axis=1)
        if self.off_since is None:
            self.off_since = np.full(len(earlier), np.nan)
        since = self.off_since
        is_out = np.isinf(since)
        since[~is_out & ~off] = np.nan
        since[off & np.isnan(since)] = now
        since[now - since > 1.0] = -np.inf
        if not np.isinf(since).all():
            return None
        best = errors[int(np.argmin(errors.max(axis=1)))]
        worst = int(np.argmax(best))
        return self.trajectory.names[worst], float(best[worst])


def stamp_ns(data: bytes) -> int:
    """Read the stamp of a serialised message that begins with a header, without decoding it."""
    seconds, nanoseconds = struct.unpack_from('<iI' if data[1] & 1 else '>iI', data, 4)
    return int(seconds) * 1_000_000_000 + int(nanoseconds)
