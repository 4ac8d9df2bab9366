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
        self._late = max(0.0, -model.delay) / period
        self._k = 0
        self._now = 0
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
        at, last = self._k + begin - self._late, self._k + end - self._late
        length = last - at
        total = np.zeros_like(self._torques[0])
        while self._now + 1 < len(self.times) and self.times[self._now + 1] < last:
            change = max(at, self.times[self._now + 1])
            total += (change - at) * self._torques[self._now]
            at, self._now = change, self._now + 1
        mean = ((total + (last - at) * self._torques[self._now]) / length)[None]
        return mean, mean
