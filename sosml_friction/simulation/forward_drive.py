# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Which torque acts on a simulated arm."""

from abc import ABC, abstractmethod

from sosml_friction.arrays import FloatArray


class Drive(ABC):
    """Say which torque acts."""

    @abstractmethod
    def begin(self, k: int, q: FloatArray) -> None:
        """Begin sample ``k`` with the encoders at ``q`` (W, n)."""

    @abstractmethod
    def torque(self, begin: float, end: float) -> tuple[FloatArray, FloatArray]:
        """Return torque (W, n) at both ends of a part of a sample, ``begin`` to ``end`` [0..1]."""


class RecordedDrive(Drive):
    """Drive by reported ``torque`` (W, S, n), its delay undone, on lines between samples."""

    def __init__(self, torque: FloatArray) -> None:
        self._torque = torque
        self._now = self._next = torque[:, 0]

    def begin(self, k: int, q: FloatArray) -> None:
        """Look up the sample and the next one."""
        last = self._torque.shape[1] - 1
        self._now = self._torque[:, min(k, last)]
        self._next = self._torque[:, min(k + 1, last)]

    def torque(self, begin: float, end: float) -> tuple[FloatArray, FloatArray]:
        """Return the torque between the two samples."""
        rise = self._next - self._now
        return self._now + begin * rise, self._now + end * rise
