# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One actuator as the driver sees it: what it asks, what it expects, what it measured."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Hashable
from dataclasses import dataclass
from typing import NamedTuple

from sosml_friction.actuators.configuration import JointConfiguration
from sosml_friction.actuators.frame import Frame
from sosml_friction.model.robot import JointLimits


class Request(NamedTuple):
    """A frame to send and the key of the one reply it must bring."""

    frame: Frame
    key: Hashable


@dataclass
class Measurement:
    """
    Hold the last that is known of a joint; NaN is not known.

    ``q`` [rad or m], ``tau`` [Nm or N] by the measured current, ``temperature`` [degC],
    ``voltage`` [V], ``current`` [A] in the actuator's own direction; ``stamp_ns``: when ``q`` was
    received.
    """

    q: float = math.nan
    tau: float = math.nan
    current: float = math.nan
    temperature: float = math.nan
    voltage: float = math.nan
    stamp_ns: int = 0
    firmware: str = ''


class Actuator(ABC):
    """
    Turn commands for one joint into requests, and replies into a :class:`Measurement`.

    No input or output: the bus cycle sends and receives. Limits are applied here, the last place
    before the wire.
    """

    def __init__(self, configuration: JointConfiguration, limits: JointLimits) -> None:
        self.configuration = configuration
        self.limits = limits
        self.measurement = Measurement()

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
    def frames_per_cycle(self) -> float:
        """Return how many frames it puts on the bus in one cycle, both ways, on average."""

    @abstractmethod
    def probe(self) -> list[Request]:
        """Return the questions of the start-up, which change nothing and move nothing."""

    @abstractmethod
    def command(self, effort: float, position: float, now_ns: int) -> list[Request]:
        """
        Return the cycle's requests while the joint is driven.

        :param effort: what a torque actuator is to give [Nm or N].
        :param position: what a position actuator is to hold [rad or m].
        :raises CanProtocolError: if the value it uses is not finite.
        """

    @abstractmethod
    def release(self, now_ns: int) -> list[Request]:
        """Return the cycle's requests while the joint is free: measured, without torque."""

    @abstractmethod
    def shut_down(self) -> list[Request]:
        """Return the requests that switch the output off for good."""

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

    @abstractmethod
    def flags(self) -> str:
        """Return the actuator's status bits as words, 'none' if none is set."""

    @abstractmethod
    def fault(self) -> str:
        """Return what is wrong with the actuator by its own account, '' if nothing."""

    def silence(self) -> str:
        """Return the sentence for an actuator that does not answer."""
        return (
            f'joint {self.name}: no answer from {self.reply_id:#05x}: check its power, the '
            'wiring, the bit rate and its identifier'
        )
