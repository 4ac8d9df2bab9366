# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One actuator as the driver sees it: what it asks, what it expects, what it measured."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Hashable
from dataclasses import dataclass
from typing import NamedTuple

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.driver.configuration import JointConfiguration
from sosml_friction.actuators.driver.start_up import Request, Step
from sosml_friction.model.robot import JointLimits


class Setpoint(NamedTuple):
    """
    Say what a joint is to do in this cycle.

    ``effort`` [Nm or N] is for an actuator that takes torque; ``position`` [rad or m] and
    ``velocity`` [rad/s or m/s] are the reference, for one that takes those.
    """

    effort: float
    position: float
    velocity: float


@dataclass
class Measurement:
    """
    Hold the last that is known of a joint; NaN is not known.

    ``q`` [rad or m], ``tau`` [Nm or N] by the measured current, ``temperature`` [degC],
    ``voltage`` [V], ``current`` [A] in the actuator's own direction; ``stamp_ns``: when ``q`` was
    received. Raw: ``position_raw`` as the actuator counts it, ``speed`` [rad/s or m/s] as it
    reports it, in the joint's direction. ``uptime`` [s].
    """

    q: float = math.nan
    tau: float = math.nan
    current: float = math.nan
    temperature: float = math.nan
    voltage: float = math.nan
    stamp_ns: int = 0
    firmware: str = ''
    model: str = ''
    position_raw: float = math.nan
    speed: float = math.nan
    uptime: float = math.nan


class Actuator(ABC):
    """
    Turn commands for one joint into requests, and replies into a :class:`Measurement`.

    No input or output: the bus cycle sends and receives. Limits are applied here, the last place
    before the wire. ``timeouts`` counts how often the actuator said that it got no command for
    the time of its own watchdog, ``restarts`` how often it was switched on anew.
    """

    def __init__(self, configuration: JointConfiguration, limits: JointLimits) -> None:
        self.configuration = configuration
        self.limits = limits
        self.measurement = Measurement()
        self.timeouts = 0
        self.restarts = 0
        self.overdue_replies = 0

    @property
    def name(self) -> str:
        """Return the joint's name."""
        return self.configuration.name

    @property
    @abstractmethod
    def reply_id(self) -> int:
        """Return the identifier its replies come from."""

    @property
    @abstractmethod
    def request_ids(self) -> frozenset[int]:
        """Return the identifiers by which it can be commanded."""

    @property
    @abstractmethod
    def frames_per_cycle(self) -> float:
        """Return how many frames it puts on the bus in one cycle, both ways, on average."""

    @abstractmethod
    def start_up(self, *, read_only: bool, watchdog: bool = True) -> list[Step]:
        """
        Return the steps that tell whether the joint may be enabled; nothing here moves it.

        :param read_only: write nothing, whatever the configuration asks for.
        :param watchdog: judge the actuator's own watchdog as well, which takes a second.
        """

    @abstractmethod
    def probe(self) -> list[Request]:
        """Return one question that changes nothing, to find out whether anybody answers."""

    @abstractmethod
    def command(self, setpoint: Setpoint, now_ns: int) -> list[Request]:
        """
        Return the cycle's requests while the joint is driven.

        :raises CanProtocolError: if the value it uses is not finite.
        """

    @abstractmethod
    def observe(self, now_ns: int) -> list[Request]:
        """Return the cycle's requests that measure and leave the last command as it is."""

    @abstractmethod
    def release(self, now_ns: int) -> list[Request]:
        """Return the cycle's requests while the joint is free: measured, without torque."""

    @abstractmethod
    def shut_down(self) -> list[Request]:
        """Return the requests that end the drive, as the configuration's ``at_end`` says."""

    @abstractmethod
    def key(self, frame: Frame) -> Hashable:
        """
        Return the key of the request that ``frame``, from :attr:`reply_id`, answers.

        :raises CanProtocolError: if it is none of its replies.
        """

    @abstractmethod
    def accept(self, frame: Frame, stamp_ns: int) -> None:
        """
        Take a reply into :attr:`measurement`.

        :param stamp_ns: when it was received [ns].
        :raises CanProtocolError: if it cannot be decoded.
        """

    def unsolicited(self, frame: Frame) -> bool:
        """Take a frame the actuator sends by itself; return whether it is one."""
        return False

    def is_echo(self, request: Request, frame: Frame) -> bool:
        """Tell whether ``frame`` is not the reply to ``request`` but its echo; then count it."""
        return False

    def overdue(self, key: Hashable) -> None:
        """Take note that a reply did not come within its request's patience."""
        self.overdue_replies += 1

    def waiting(self) -> str:
        """Return what the joint must wait for before it may move, '' if for nothing."""
        return ''

    @abstractmethod
    def flags(self) -> str:
        """Return the actuator's status bits as words, 'none' if none is set."""

    @abstractmethod
    def fault(self) -> str:
        """Return what is wrong with the actuator by its own account, '' if nothing."""

    def doubt(self) -> str:
        """Return why its position cannot be true if that lasts, '' if nothing speaks against."""
        return ''

    def warning(self) -> str:
        """Return what its user should know although it works, '' if nothing."""
        return ''

    def out_of_band(self, margin: float) -> str:
        """Return by how much the joint is outside its limits plus ``margin``, '' if inside."""
        q, limits = self.measurement.q, self.limits
        # Written so that NaN is outside.
        if limits.lower - margin <= q <= limits.upper + margin:
            return ''
        excess = max(limits.lower - q, q - limits.upper)
        return (
            f'joint {self.name} is at {q:.4f}, {excess:.4f} outside its limits '
            f'{limits.lower:g} to {limits.upper:g}: move it back, or correct {self.name}.'
            'zero_offset'
        )

    def silence(self) -> str:
        """Return the sentence for an actuator that does not answer."""
        return (
            f'joint {self.name}: no answer from {self.reply_id:#05x}: check its power, the '
            'wiring, the bit rate and its identifier'
        )
