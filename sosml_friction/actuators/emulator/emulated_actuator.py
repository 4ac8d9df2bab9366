# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One emulated actuator: frames in, frames and torque out."""

import functools
import math
import operator
from abc import ABC, abstractmethod
from typing import Any, ClassVar

import numpy as np

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.emulator.fault import Fault
from sosml_friction.actuators.joint_configuration import JointConfiguration

# The time constant of the inner current loops [s]: field-oriented control of some 800 Hz. A lag
# of d between current and its report shows as viscous friction of d times the slope of gravity.
CURRENT_LOOP = 2e-4


class EmulatedActuator(ABC):
    """
    Answer frames and drive one joint of the emulated plant.

    x = direction * (q - zero_offset) is the actuator's own position, direction * torque_constant *
    current the effort on the joint. The current follows its command with a first-order lag,
    CURRENT_LOOP.

    ``options_type`` is a dataclass of :func:`~sosml_friction.actuators.parameter.parameter`: how
    good hardware of this type is, each with a default. Its fields are parameters of the emulator.

    :param mount: of the joint; only what says how the actuator is mounted counts.
    :param seed: of its own noise, so that one actuator's traffic does not change another's.
    """

    options_type: ClassVar[type]

    def __init__(
        self,
        mount: JointConfiguration,
        options: Any,
        seed: np.random.SeedSequence,
        *,
        current_limit: float = math.inf,
    ) -> None:
        self.name = mount.name
        self.direction = mount.direction
        self.zero_offset = mount.zero_offset
        self.torque_constant = mount.torque_constant
        self.current_limit = current_limit
        self.current = 0.0
        self.frames = 0
        self.undecodable = 0
        self.watchdog_trips = 0
        # Of its own clock before emulated time: where that stood still, the motor's did not.
        self.clock_ahead_ns = 0
        self._rng = np.random.default_rng(seed)
        self._commanded = 0.0
        self._faults: tuple[Fault, ...] = ()
        self._stuck_at: float | None = None
        self._dark_until_ns = 0
        self._unsolicited: list[Frame] = []

    @property
    @abstractmethod
    def request_id(self) -> int:
        """Return the identifier it listens to."""

    def counters(self) -> dict[str, int]:
        """Return what has happened to it, by name, as diagnostics show it."""
        return {
            'frames': self.frames,
            'frames undecodable': self.undecodable,
            'watchdog trips': self.watchdog_trips,
        }

    @property
    def commanded_current(self) -> float:
        """Return the current its loop is told to give [A], after its own limit."""
        return self._commanded

    @property
    def effort(self) -> float:
        """Return the effort on the joint [Nm or N]."""
        return self.direction * self.torque_constant * self.current

    def take(self, frame: Frame, t_ns: int, q: float, v: float) -> Frame | None:
        """Hear a frame, or not, by the faults it has; see :meth:`handle`."""
        if t_ns < self._dark_until_ns or self.has_fault('silent'):
            return None
        q, v = self._sensed(q, v)
        return self.handle(frame, t_ns, q, v)

    def run(self, t_ns: int, q: float, v: float) -> None:
        """Run what is due at ``t_ns``, unless it is dark; see :meth:`control`."""
        if t_ns >= self._dark_until_ns:
            q, v = self._sensed(q, v)
            self.control(t_ns, q, v)

    def take_unsolicited(self) -> list[Frame]:
        """Return the frames it has sent by itself since the last call, unless it is cut off."""
        frames, self._unsolicited = self._unsolicited, []
        return [] if self.has_fault('silent') else frames

    def reply_delay_ns(self, frame: Frame) -> int:
        """Return how much longer than others the answer to ``frame`` takes [ns]."""
        return 0

    def has_fault(self, name: str) -> bool:
        """Tell whether it has the fault called ``name``."""
        return any(fault.name == name for fault in self._faults)

    def set_faults(self, faults: tuple[Fault, ...], q: float) -> None:
        """Have these faults and no others; a stuck encoder stays at the true position ``q``."""
        self._faults = faults
        if not self.has_fault('stuck_encoder'):
            self._stuck_at = None
        elif self._stuck_at is None:
            self._stuck_at = q

    def happen(self, fault: Fault, t_ns: int) -> None:
        """Let an event, or the beginning of a fault, happen at ``t_ns``."""
        if fault.name in ('reboot', 'power_cycle'):
            self._dark_until_ns = t_ns + round(fault.number('seconds') * 1e9)
            self._unsolicited.clear()
            self.restart(self._dark_until_ns)
        elif fault.name == 'watchdog':
            self.trip(t_ns)

    def _fault_bits(self) -> int:
        own = (int(f.number('bits')) for f in self._faults if f.name == 'error_bits')
        return functools.reduce(operator.or_, own, 0)

    def _sensed(self, q: float, v: float) -> tuple[float, float]:
        return (q, v) if self._stuck_at is None else (self._stuck_at, 0.0)

    @abstractmethod
    def restart(self, t_ns: int) -> None:
        """Be as after power-on, which is complete at ``t_ns``: output off."""

    @abstractmethod
    def trip(self, t_ns: int) -> None:
        """Do what it does when it has heard nothing for too long: output off."""

    @abstractmethod
    def handle(self, frame: Frame, t_ns: int, q: float, v: float) -> Frame | None:
        """Take a frame that arrived at ``t_ns``; return the reply, or None."""

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

    def _encoder_noise_of(self, sigma: float) -> float:
        return 0.0 if self._stuck_at is not None else self._normal(sigma)

    def _clamped(self, current: float) -> float:
        return min(max(current, -self.current_limit), self.current_limit)
