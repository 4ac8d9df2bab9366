# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One emulated actuator: frames in, frames and torque out."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from sosml_friction.actuators.frame import Frame

# The time constant of the inner current loops [s]: field-oriented control of some 800 Hz. A lag
# of d between current and its report shows as viscous friction of d times the slope of gravity.
CURRENT_LOOP = 2e-4


class EmulatedActuator(ABC):
    """
    Answer frames and drive one joint of the emulated plant.

    x = direction * (q - zero_offset) is the actuator's own position, direction * torque_constant *
    current the effort on the joint. The current follows its command with a first-order lag,
    CURRENT_LOOP.

    :param seed: of this actuator's own noise, so that one actuator's traffic does not change
        another's.
    """

    def __init__(
        self,
        name: str,
        torque_constant: float,
        direction: int,
        zero_offset: float,
        current_limit: float,
        seed: np.random.SeedSequence,
    ) -> None:
        self.name = name
        self.torque_constant = torque_constant
        self.direction = direction
        self.zero_offset = zero_offset
        self.current_limit = current_limit
        self.current = 0.0
        self.frames = 0
        self.undecodable = 0
        self.watchdog_trips = 0
        self._rng = np.random.default_rng(seed)
        self._commanded = 0.0

    @property
    @abstractmethod
    def request_id(self) -> int:
        """Return the identifier it listens to."""

    @property
    def commanded_current(self) -> float:
        """Return the current its loop is told to give [A], after its own limit."""
        return self._commanded

    @property
    def effort(self) -> float:
        """Return the effort on the joint [Nm or N]."""
        return self.direction * self.torque_constant * self.current

    @abstractmethod
    def handle(self, frame: Frame, t_ns: int, q: float, v: float) -> Frame | None:
        """
        Take a frame that arrived at ``t_ns`` and return the reply, or None.

        :param q: the joint's position at that time [rad or m].
        :param v: its velocity.
        """

    @abstractmethod
    def control(self, t_ns: int, q: float, v: float) -> None:
        """Run the inner loop that is due on the grid of time at ``t_ns``, with the joint at q."""

    def advance(self, share: float) -> None:
        """Let the current go ``share`` = 1 - exp(-h / CURRENT_LOOP) of the way to its command."""
        self.current += share * (self._commanded - self.current)

    def _position(self, q: float) -> float:
        return self.direction * (q - self.zero_offset)

    def _normal(self, sigma: float) -> float:
        return sigma * float(self._rng.standard_normal()) if sigma > 0.0 else 0.0

    def _clamped(self, current: float) -> float:
        return min(max(current, -self.current_limit), self.current_limit)
