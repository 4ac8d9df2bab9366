# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the start-up of an RMD-X sees of its motor: it stands below the actuator, which has it."""

from __future__ import annotations

from abc import abstractmethod

from sosml_friction.actuators.actuator import Actuator
from sosml_friction.actuators.driver.start_up import Request
from sosml_friction.actuators.rmd_x import codec as rmd_x
from sosml_friction.actuators.rmd_x.configuration import RmdXConfiguration
from sosml_friction.actuators.rmd_x.protocol import Protocol


class RmdXMotor(Actuator):
    """
    Hold what the start-up finds out, and what it asks.

    ``protocol``: variant of the protocol, None before it is known; ``date``: the firmware's;
    ``blocks``: the model's name in parts; ``angle`` [rad]: of 0x92; ``counts_turns`` [rad]: 0x92
    minus the angle by counts, whole turns.
    """

    configuration: RmdXConfiguration
    protocol: Protocol | None
    date: int
    blocks: dict[int, str]
    angle: float
    counts_turns: float
    ask_angle: Request
    ask_status: Request
    ask_uptime: Request

    @abstractmethod
    def request(self, message: rmd_x.Request, patience_ns: int = 0) -> Request:
        """Return the frame that says ``message`` to this motor, and the key of its reply."""

    @abstractmethod
    def counted(self, counts: float) -> float:
        """Return the angle of an encoder's counts [rad]."""

    @abstractmethod
    def set_turn_offset(self, offset: float) -> None:
        """Take the encoder to have lost this angle [rad]."""

    @abstractmethod
    def flags(self) -> str:
        """Return the motor's error bits as words."""
