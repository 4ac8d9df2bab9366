# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the driver is told about all joints, read from ROS parameters or their YAML file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass
from pathlib import Path
from typing import Any

from sosml_friction.actuators.actuator import Actuator
from sosml_friction.actuators.joint_configuration import HostLoop, JointConfiguration
from sosml_friction.actuators.parameter import check_parameters, parameter, parameters_of
from sosml_friction.bags.controllers import ACTUATOR, PD
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.robot import JointLimits
from sosml_friction.motion.parameter_file import node_parameters


@dataclass(frozen=True)
class DriverConfiguration:
    """
    Describe the driver as a whole; each joint has the configuration of its type of actuator.

    A program that has said :meth:`JointDriver.heartbeat` once and is then silent for
    ``host_timeout`` is a fault. Between the URDF's limits and ``limit_margin`` beyond, the soft
    stop lets the torque outward fade.

    :raises ConfigurationError: if values do not fit.
    """

    joints: tuple[JointConfiguration, ...]
    bitrate: int = parameter(
        'the bit rate', 1_000_000, unit='bit/s', range=(10_000, 1_000_000), key='can_bitrate'
    )
    rate: float = parameter('cycles per second', 500.0, unit='Hz', range=(10.0, 1000.0), above=0.0)
    velocity_window: int = parameter(
        'positions whose least-squares slope is the velocity; it lags by (N - 1) / 2 periods',
        11,
        range=(2, 101),
    )
    reply_timeout: float = parameter(
        'how long a cycle waits for replies before the next one begins',
        0.02,
        unit='s',
        range=(0.0005, 1.0),
        above=0.0,
    )
    missed_limit: int = parameter(
        'periods without an answer of an actuator that are a fault',
        40,
        unit='periods',
        range=(1, 1000),
        above=0.0,
    )
    start_tolerance: float = parameter(
        'how far from the present position a trajectory may start',
        0.05,
        unit='rad or m',
        range=(0.0, 1.0),
    )
    limit_margin: float = parameter(
        "how far outside the URDF's limits a joint may be before it is a fault; on the way there "
        'the torque outward fades',
        0.1,
        unit='rad or m',
        range=(0.0, 1.0),
    )
    stop_deceleration: float = parameter(
        'deceleration of a stop, and of the catch when a moving joint is enabled',
        5.0,
        unit='rad/s^2 or m/s^2',
        range=(0.01, 1000.0),
        above=0.0,
    )
    host_timeout: float = parameter(
        'time that callbacks of this node may hang; longer ends in zero torque',
        1.0,
        unit='s',
        range=(0.2, 10.0),
        above=0.0,
    )

    def __post_init__(self) -> None:
        check_parameters(self)
        if not self.joints:
            raise ConfigurationError('the driver has no joints: name them in its parameter joints')
        if len(set(self.names)) != len(self.names):
            raise ConfigurationError(f'joints names one twice: {", ".join(self.names)}')
        if self.reply_timeout > self.missed_limit / self.rate:
            raise ConfigurationError(
                f'reply_timeout is {self.reply_timeout:g} s, missed_limit is {self.missed_limit} '
                f'periods of {1e3 / self.rate:g} ms: a single wait would already be the fault: '
                'raise missed_limit or lower reply_timeout'
            )
        for joint in self.joints:
            joint.check_drive()

    @property
    def names(self) -> tuple[str, ...]:
        """Return the joints in order."""
        return tuple(joint.name for joint in self.joints)

    @property
    def period_ns(self) -> int:
        """Return the cycle's period [ns]."""
        return round(1e9 / self.rate)

    @property
    def silence_ns(self) -> int:
        """Return how long an actuator may be silent: missed_limit periods [ns]."""
        return self.missed_limit * self.period_ns

    @classmethod
    def from_parameters(cls, values: Mapping[str, Any]) -> DriverConfiguration:
        """
        Build it from flat parameters, ``shoulder.can_id`` and the like.

        :raises ConfigurationError: if one is missing, unknown to its actuator or does not fit.
        """
        own = {
            place.name: values[key] for key, (place, _) in parameters_of(cls).items()
            if key in values
        }  # fmt: skip
        return cls(joints=joints_from_parameters(values), **own)


def joints_from_parameters(values: Mapping[str, Any]) -> tuple[JointConfiguration, ...]:
    """
    Build the joints from flat parameters, ``shoulder.can_id`` and the like.

    The values that drive a joint may be missing where it is only mounted, as in the emulator.

    :raises ConfigurationError: if one is missing, unknown to its actuator or does not fit.
    """
    names = _required(values, 'joints')
    if not isinstance(names, list | tuple) or not all(isinstance(name, str) for name in names):
        raise ConfigurationError(f'joints is {names!r}: give a list, as [shoulder, elbow]')
    return tuple(_joint(values, name) for name in names)


def _joint(values: Mapping[str, Any], name: str) -> JointConfiguration:
    driver = _required(values, f'{name}.driver')
    kind = Actuator.kind(driver, f'{name}.driver').configuration_type
    parameters = parameters_of(kind)
    given = {
        key.removeprefix(f'{name}.'): value
        for key, value in values.items()
        if key.startswith(f'{name}.') and value is not None
    }
    del given['driver']
    for key in given:
        if key not in parameters:
            raise ConfigurationError(
                f'{name}.{key} is no parameter of driver {driver}: it has {", ".join(parameters)}'
            )
    for key, (place, _) in parameters.items():
        if place.default is MISSING and key not in given:
            _required(values, f'{name}.{key}')
    return kind(name=name, **given)


def _required(values: Mapping[str, Any], key: str) -> Any:
    if values.get(key) is None:
        raise ConfigurationError(f'parameter {key} is not set')
    return values[key]


def read_parameters(path: str | Path, node: str) -> dict[str, Any]:
    """
    Read the parameters of ``node``, flat, those for any node included, from a ROS file.

    :raises ConfigurationError: if the file cannot be read or has nothing for ``node``.
    """
    result = node_parameters(Path(path), node)
    if not result:
        raise ConfigurationError(f'parameter file {path} has nothing for {node}')
    return result


def controller_entries(
    configuration: DriverConfiguration, limits: Sequence[JointLimits]
) -> dict[str, dict[str, Any]]:
    """Return an entry for each joint, as :mod:`sosml_friction.bags.controllers` describes it."""
    entries: dict[str, dict[str, Any]] = {}
    for joint, limit in zip(configuration.joints, limits, strict=True):
        loop = joint.loop(limit)
        if not isinstance(loop, HostLoop):
            entries[joint.name] = {'kind': ACTUATOR, 'reason': loop}
            continue
        entries[joint.name] = {
            'kind': PD,
            **loop._asdict(),
            'rate': configuration.rate,
            'velocity_window': configuration.velocity_window,
        }
    return entries
