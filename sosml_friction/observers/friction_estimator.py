# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""From stamped joint states to friction: one path for on-line, replayed and batch use."""

from collections.abc import Sequence

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.robot import Robot
from sosml_friction.observers.advance import INTERVAL, REPEATED, START
from sosml_friction.observers.momentum_sampler import MomentumSampler
from sosml_friction.observers.momentum_samples import MomentumSamples
from sosml_friction.observers.observer import Observer


class FrictionEstimator(MomentumSampler):
    """
    Run momentum observers on samples (t, q, v, tau) and return tau_f = -tau_e.

    At the start of a stretch (see the base) the observers start and their estimate is NaN, not yet
    known; for a repeated stamp :meth:`update` returns None. A joint whose effort is missing is NaN
    and starts again, the others go on.

    :param robot: rigid-body terms; its joints are the columns of q, v and tau.
    :param observers: what to run, each for all joints; names must differ.
    :param effort_hold: it and what follows is of
        :class:`~sosml_friction.observers.momentum_sampler.MomentumSampler`.
    :raises ConfigurationError: if an option is unknown or an observer has another number of
        joints.
    """

    def __init__(
        self,
        robot: Robot,
        observers: Sequence[Observer],
        effort_hold: Sequence[str] | str = 'start',
        velocity_source: str = 'message',
        maximum_gap_s: float = 0.05,
    ) -> None:
        super().__init__(robot, effort_hold, velocity_source, maximum_gap_s)
        names = [observer.identifier for observer in observers]
        if len(set(names)) != len(names) or not names:
            raise ConfigurationError(
                f'the observers are {names}: give each one once, at least one'
            )
        for observer in observers:
            if observer.n != robot.n:
                raise ConfigurationError(
                    f'observer {observer.identifier} has gains for {observer.n} joints where the '
                    f'robot has {robot.n} ({", ".join(robot.names)})'
                )
        self.observers = {observer.identifier: observer for observer in observers}
        # Compile now: at the first sample it would stall the node.
        zero = np.zeros(robot.n)
        self._begin_to_take()
        row = np.zeros((1, robot.n))
        still = MomentumSamples(np.full(1, 1e-3), row, row, row, np.eye(robot.n)[np.newaxis])
        for observer in observers:
            observer.start(zero)
            observer.run(still)

    def update(
        self, t_ns: int, q: FloatArray, v: FloatArray, tau: FloatArray
    ) -> dict[str, FloatArray] | None:
        """
        Take one sample and return tau_f of each observer, (n,) [Nm or N].

        :param t_ns: stamp of measurement [ns].
        :param q: position (n,) [rad or m].
        :param v: velocity (n,) [rad/s or m/s]; unused with ``position_difference``.
        :param tau: actuator effort at the joint (n,) [Nm or N], NaN where not known.
        :return: None for a repeated stamp; NaN where there is no estimate yet.
        :raises ConfigurationError: if an observer is a smoother.
        """
        outcome, interval = self._take(t_ns, q, v, tau)
        if outcome == INTERVAL:
            found = {}
            for name, observer in self.observers.items():
                found[name] = -observer.run(interval)[0]
            return found
        # An interval follows a start.
        for observer in self.observers.values():
            if not observer.causal:
                raise ConfigurationError(
                    f'observer {observer.identifier} needs the whole recording: use batch'
                )
        if outcome == REPEATED:
            return None
        if outcome == START:
            for observer in self.observers.values():
                observer.start(interval.p[0])
        return {name: np.full(self.robot.n, np.nan) for name in self.observers}

    def batch(self, log: JointLog) -> dict[str, FloatArray]:
        """
        Return tau_f of each observer over a recording, (N, n), the same numbers as on line.

        Starts afresh. A repeated stamp gets NaN.

        :raises DataError: if a joint of the robot is not in the log.
        """
        stretches = self.stretches(log)
        result = {}
        for name, observer in self.observers.items():
            tau_f = np.full((len(log), self.robot.n), np.nan)
            for stretch in stretches:
                observer.start(stretch.p_start)
                tau_f[stretch.rows] = -observer.run(stretch.samples)
            result[name] = tau_f
        # What comes next on line is no continuation.
        self.reset()
        return result
