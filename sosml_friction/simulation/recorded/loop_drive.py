# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Controllers in the loop of a simulation: each command holds until the next."""

from abc import abstractmethod

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.simulation.forward_drive import Drive
from sosml_friction.simulation.forward_model import ForwardModel


class LoopDrive(Drive):
    """
    Drive one window by commands that are made while it is simulated.

    What is asked for is what the actuators report: the torque is that of the model's terms. Where
    the model reports effort early (a negative delay), the torque is late by it.
    """

    def __init__(self, model: ForwardModel, period: float) -> None:
        self._model, self._period = model, period
        # Joints that are late alike are one group: how late, which, and the command that acts.
        late = np.maximum(0.0, -model.delay) / period
        self._groups = [(each, np.flatnonzero(late == each)) for each in np.unique(late)]
        self._now = [0] * len(self._groups)
        self._k = 0
        #: Efforts that were commanded up to now, (n,) each, and from which time on [samples].
        self.commands: list[FloatArray] = []
        self.times: list[float] = []
        self._torques: list[FloatArray] = []

    @abstractmethod
    def begin(self, k: int, q: FloatArray) -> None:
        """Make the commands of sample ``k``; an override does so after this."""
        self._k = k

    def ask(self, time: float, effort: FloatArray) -> None:
        """Ask for an effort (n,) [Nm or N] from a time on [samples], times in order."""
        self.times.append(time)
        self.commands.append(effort)
        self._torques.append(self._model.torque(effort))

    def torque(self, begin: float, end: float) -> tuple[FloatArray, FloatArray]:
        """Return the mean torque (1, n) twice: each command acts from its own time on."""
        mean = np.zeros_like(self._torques[0])
        for group, (late, joints) in enumerate(self._groups):
            at, last, now = self._k + begin - late, self._k + end - late, self._now[group]
            while now + 1 < len(self.times) and self.times[now + 1] < last:
                change = max(at, self.times[now + 1])
                mean[joints] += (change - at) * self._torques[now][joints]
                at, now = change, now + 1
            mean[joints] += (last - at) * self._torques[now][joints]
            self._now[group] = now
        mean = mean[None] / (end - begin)
        return mean, mean
