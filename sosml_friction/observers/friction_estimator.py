# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""From stamped joint states to friction: one path for on-line, replayed and batch use."""

from collections.abc import Sequence

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.robot import Robot
from sosml_friction.observers.momentum_sampler import Interval, MomentumSampler, stack
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
        zero = np.zeros(robot.n)
        still = stack([Interval(1e-3, zero, zero, zero, np.eye(robot.n))])
        for observer in observers:
            # Compile now: at the first sample it would stall the node.
            observer.start(zero)
            observer.run(still)

    def update(
        self, t_ns: int, q: FloatArray, v: FloatArray, tau: FloatArray
    ) -> dict[str, FloatArray] | None:
        """
        Take one sample and return tau_f of each observer, (n,) [Nm or N].

        The sample is that of :meth:`take`.

        :return: None for a repeated stamp; NaN where there is no estimate yet.
        :raises ConfigurationError: if an observer is a smoother.
        """
        offline = [name for name, observer in self.observers.items() if not observer.causal]
        if offline:
            raise ConfigurationError(
                f'observer {", ".join(offline)} needs the whole recording: use batch'
            )
        taken = self.take(t_ns, q, v, tau)
        if taken is None:
            return None
        if not isinstance(taken, Interval):
            for observer in self.observers.values():
                if taken.p is not None:
                    observer.start(taken.p)
            return {name: np.full(self.robot.n, np.nan) for name in self.observers}
        samples = stack([taken])
        return {name: -observer.run(samples)[0] for name, observer in self.observers.items()}

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
        return result
