# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One type of actuator as the driver sees it, and all types there are."""

from __future__ import annotations

import inspect
import math
from abc import ABC, abstractmethod
from collections.abc import Hashable
from typing import ClassVar

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.bus.inquiry import FoundActuator, Inquiry
from sosml_friction.actuators.driver.start_up import Request, Step
from sosml_friction.actuators.emulator.emulated_actuator import EmulatedActuator
from sosml_friction.actuators.joint_configuration import JointConfiguration
from sosml_friction.actuators.measurement import Measurement, Setpoint
from sosml_friction.actuators.plausibility import Plausibility
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.robot import JointLimits
from sosml_friction.registry import Registry

# A joint that comes back from a restart may be this far from where it was [rad or m].
RESTART_DISTANCE = 0.3
# Noise of a position, as a share of the tracking limit.
STEP_SHARE = 0.1


class Actuator(ABC):
    """
    Turn commands for one joint into requests, and replies into a :class:`Measurement`.

    A subclass is a type of actuator: it states its ``configuration_type``, whose ``driver`` is its
    name in parameter files, and its ``emulated_type``, and is thereby known to driver, emulator,
    nodes and ``sosml can``. A file in this folder, or a folder with a file ``actuator.py``, is
    found without being named anywhere; a class elsewhere once it is defined.

    No input or output: the bus cycle sends and receives. Limits are applied here, the last place
    before the wire. ``timeouts`` counts how often the actuator said that it got no command for
    the time of its own watchdog, ``restarts`` how often it was switched on anew.

    :param rate: of the cycle [Hz]; ``stop_deceleration`` [rad/s^2 or m/s^2].
    :param margin: how far outside its limits the joint may be [rad or m].
    :raises TypeError: for a class that does not say what it must.
    :raises ConfigurationError: for one that takes another's name.
    """

    configuration_type: ClassVar[type[JointConfiguration]]
    emulated_type: ClassVar[type[EmulatedActuator]]
    #: Every type of actuator by its driver's name.
    registry: ClassVar[Registry[Actuator]] = Registry(
        'driver', 'sosml_friction.actuators', file='actuator'
    )

    def __init_subclass__(cls, **kwargs: object) -> None:
        super().__init_subclass__(**kwargs)
        if inspect.isabstract(cls):
            return
        for said in ('configuration_type', 'emulated_type'):
            if not hasattr(cls, said):
                raise TypeError(f'actuator {cls.__name__} does not state its {said}')
        # One that only refines another type is no type of its own.
        if 'configuration_type' not in vars(cls):
            return
        cls.registry.add(cls, cls.configuration_type.driver)

    @staticmethod
    def kind(driver: object, key: str = 'driver') -> type[Actuator]:
        """
        Return the type called ``driver``; the parameter ``key`` names it.

        :raises ConfigurationError: if there is none, with those there are.
        """
        kinds = Actuator.registry
        if not isinstance(driver, str) or driver not in kinds:
            raise ConfigurationError(f'{key} is {driver!r}: use one of {", ".join(kinds)}')
        return kinds[driver]

    def __init__(
        self,
        configuration: JointConfiguration,
        limits: JointLimits,
        rate: float,
        *,
        margin: float = 0.0,
        stop_deceleration: float = math.inf,
    ) -> None:
        self.configuration = configuration
        self.name = configuration.name
        self.limits = limits
        self.rate = rate
        self.margin = margin
        self.stop_deceleration = stop_deceleration
        self.measurement = Measurement()
        self.timeouts = 0
        self.restarts = 0
        self._plausibility = self.plausibility()

    # ---- on the bus

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

        ``read_only`` writes nothing, whatever the configuration asks for. To judge the actuator's
        own ``watchdog`` as well takes a second.
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
        """Return the requests that end the drive, as the configuration says."""

    @abstractmethod
    def key(self, frame: Frame) -> Hashable:
        """
        Return the key of the request that ``frame``, from :attr:`reply_id`, answers.

        :raises CanProtocolError: if it is none of its replies.
        """

    @abstractmethod
    def accept(self, frame: Frame, stamp_ns: int) -> None:
        """
        Take a reply to what was asked at ``stamp_ns`` [ns] into :attr:`measurement`.

        :raises CanProtocolError: if it cannot be decoded.
        """

    def unsolicited(self, frame: Frame) -> bool:
        """Take a frame the actuator sends by itself; return whether it is one."""
        return False

    def is_echo(self, request: Request, frame: Frame) -> bool:
        """Tell whether ``frame`` is not the reply to ``request`` but its echo; then count it."""
        return False

    def overdue(self, key: Hashable) -> None:
        """Take note that a reply did not come within its request's patience; here, nothing."""
        return

    @classmethod
    def speaks_unasked(cls, frame: Frame) -> bool:
        """Tell whether ``frame`` may be one that an actuator sends by itself."""
        return False

    @classmethod
    def scan(cls, inquiry: Inquiry) -> list[FoundActuator]:
        """
        Ask, on a bus where nobody drives, who of this type is there; command none.

        By default nobody is asked: a type may have no question that changes nothing.
        """
        return []

    # ---- what it says of itself

    @abstractmethod
    def flags(self) -> str:
        """Return the actuator's status bits as words, 'none' if none is set."""

    @abstractmethod
    def error(self) -> str:
        """Return what is wrong with the actuator by its own account, '' if nothing."""

    def waiting(self) -> str:
        """Return what the joint must wait for before it may move, '' if for nothing."""
        return ''

    def warning(self) -> str:
        """Return what its user should know although it works, '' if nothing."""
        return ''

    def silence(self) -> str:
        """Return the sentence for an actuator that does not answer."""
        return (
            f'joint {self.name}: no answer from {self.reply_id:#05x}: check its power, the '
            'wiring, the bit rate and its identifier'
        )

    # ---- what is judged of it, whatever its type

    def fault(self) -> str:
        """Return its own error, or an excess of temperature, as a sentence; '' if neither."""
        temperature, limit = self.measurement.temperature, self.configuration.temperature_limit
        if error := self.error():
            return error
        if temperature > limit:
            return f'joint {self.name}: {temperature:.0f} degC is above {limit:g}'
        return ''

    def plausibility(self) -> Plausibility:
        """Return what it may measure: by default the current of the joint's greatest effort."""
        return Plausibility(
            self.limits.effort / self.configuration.torque_constant,
            self.limits.velocity,
            STEP_SHARE * self.configuration.tracking_limit,
        )

    def doubt(self, v: float = math.nan, step: float = 0.0, seconds: float = 0.0) -> str:
        """Return why its measurement cannot be true; see :meth:`Plausibility.doubt`."""
        doubt = self._plausibility.doubt(self.measurement, v, step, seconds)
        return f'joint {self.name} {doubt}' if doubt else ''

    def restart_distance(self) -> float:
        """Return how far from where it was it may come back from a restart [rad or m]."""
        return RESTART_DISTANCE

    def out_of_band(self) -> str:
        """Return by how much the joint is outside its limits plus margin, '' if inside."""
        q, limits = self.measurement.q, self.limits
        # Written so that NaN is outside.
        if limits.lower - self.margin <= q <= limits.upper + self.margin:
            return ''
        excess = max(limits.lower - q, q - limits.upper)
        return (
            f'joint {self.name} is at {q:.4f}, {excess:.4f} outside its limits '
            f'{limits.lower:g} to {limits.upper:g}: move it back, or correct {self.name}.'
            'zero_offset'
        )
