# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the driver is told about the joints, read from ROS parameters or their YAML file."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields
from pathlib import Path
from typing import Any

import yaml

from sosml_friction.exceptions import ConfigurationError

RMD_X = 'rmd_x'
SERVO_DBC = 'servo_dbc'
DRIVERS = (RMD_X, SERVO_DBC)

TORQUE_MODE = 'torque'
SPEED_MODE = 'speed'
POSITION_MODE = 'position'
MODES = (TORQUE_MODE, SPEED_MODE, POSITION_MODE)

NO_TURN = 'refuse'
OUTPUT_TURN = 'output'
MOTOR_TURN = 'motor'
LOST_TURNS = (NO_TURN, OUTPUT_TURN, MOTOR_TURN)

SHUT_DOWN_AT_END = 'shutdown'
STOP_AT_END = 'stop'
AT_END = (SHUT_DOWN_AT_END, STOP_AT_END)


@dataclass(frozen=True)
class ActuatorMount:
    """
    Say which actuator a joint has and how it is mounted.

    With i its current and x its position, both in its own direction: tau = direction *
    torque_constant * i [Nm or N] and q = direction * x + zero_offset [rad or m].
    ``torque_constant`` is at the output [Nm/A]; ``can_id`` of an RMD-X; ``dbc`` of a servo bridge
    and ``dbc_map``, its own names as ``ours=theirs`` (``servo_state=STATE_1``,
    ``servo_state.position=Pos``).

    :raises ConfigurationError: if a value is missing or does not fit.
    """

    name: str
    driver: str
    direction: int
    zero_offset: float
    torque_constant: float
    can_id: int = 0
    dbc: str = ''
    dbc_map: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        _check_types(self, f'{self.name}.')
        if self.driver not in DRIVERS:
            raise ConfigurationError(
                f'{self.name}.driver is {self.driver!r}: use one of {", ".join(DRIVERS)}'
            )
        if self.direction not in (-1, 1):
            raise ConfigurationError(
                f'{self.name}.direction is {self.direction}: give 1 where the actuator turns the '
                'way of the URDF, -1 where it turns against it'
            )
        if self.driver == RMD_X and not 1 <= self.can_id <= 32:
            raise ConfigurationError(
                f"{self.name}.can_id is {self.can_id}: give the motor's id, 1 to 32"
            )
        object.__setattr__(self, 'dbc_map', tuple(self.dbc_map))
        self._require('zero_offset', -math.inf)
        self._require('torque_constant', 0.0)

    def _require(self, key: str, above: float) -> None:
        value = getattr(self, key)
        if not math.isfinite(value):
            raise ConfigurationError(
                f'{self.name}.{key} is {value}: driver {self.driver} needs a number'
            )
        if not value > above:
            raise ConfigurationError(f'{self.name}.{key} is {value:g}: it must be above {above:g}')


@dataclass(frozen=True)
class JointConfiguration(ActuatorMount):
    """
    Describe one joint's actuator and how it is driven.

    ``current_limit`` [A], ``current_rate_limit`` [A/s], ``kp`` [Nm/rad or N/m] and ``kd`` [Nm
    s/rad or N s/m] are for an RMD-X, which must have them (the gains in mode torque only);
    ``temperature_limit`` [degC]; ``tracking_limit`` [rad or m]: a joint further than this from
    its reference is a fault.

    For an RMD-X: ``mode``, which of its loops executes a trajectory: torque (the loop on the
    host), speed (then ``position_gain`` [1/s]) or position. ``counts_per_turn``: encoder counts
    per turn of the output, to measure by 0x60; 0 measures by 0x92, in 0.01 degree.
    ``lost_turns``: by which turns a position outside the limits may be corrected at the start,
    none (refuse), of the output or of the motor (then ``gear_ratio``). ``brake``: it has one.
    ``motor_watchdog_ms``: time of the motor's own watchdog, written to its ROM where it does not
    trip in time; 0 leaves it as it is. ``at_end``: 0x80, output off, or 0x81, the motor holds.

    :raises ConfigurationError: if a value is missing or does not fit.
    """

    current_limit: float = math.nan
    current_rate_limit: float = math.nan
    kp: float = math.nan
    kd: float = math.nan
    temperature_limit: float = 75.0
    tracking_limit: float = 0.2
    mode: str = TORQUE_MODE
    position_gain: float = math.nan
    gear_ratio: float = math.nan
    lost_turns: str = NO_TURN
    counts_per_turn: int = 0
    brake: bool = False
    motor_watchdog_ms: int = 0
    at_end: str = SHUT_DOWN_AT_END

    def __post_init__(self) -> None:
        super().__post_init__()
        self._require('temperature_limit', 0.0)
        self._require('tracking_limit', 0.0)
        for key, words in (('mode', MODES), ('lost_turns', LOST_TURNS), ('at_end', AT_END)):
            if getattr(self, key) not in words:
                raise ConfigurationError(
                    f'{self.name}.{key} is {getattr(self, key)!r}: use one of {", ".join(words)}'
                )
        for key in ('counts_per_turn', 'motor_watchdog_ms'):
            if getattr(self, key) < 0:
                raise ConfigurationError(
                    f'{self.name}.{key} is {getattr(self, key)}: give a number, or 0 for none'
                )
        if self.driver != RMD_X:
            if self.mode == SPEED_MODE:
                raise ConfigurationError(
                    f'{self.name}.mode is speed: driver {self.driver} takes positions'
                )
            return
        for key in ('current_limit', 'current_rate_limit'):
            self._require(key, 0.0)
        if self.mode == TORQUE_MODE:
            self._require('kp', 0.0)
            self._require('kd', -1e-300)
        if self.mode == SPEED_MODE:
            self._require('position_gain', 0.0)
        if self.lost_turns == MOTOR_TURN:
            self._require('gear_ratio', 0.0)


@dataclass(frozen=True)
class DriverConfiguration:
    """
    Describe the driver as a whole.

    ``rate`` of the cycle [Hz]; ``bitrate`` [bit/s]; ``velocity_window`` samples of the slope;
    ``reply_timeout`` [s]: how long a cycle waits for replies; ``missed_limit``: an actuator that
    has not answered for so many periods is a fault;
    ``start_tolerance`` [rad or m]: how far from the present position a trajectory may start;
    ``stop_deceleration`` [rad/s^2 or m/s^2] of a stop and of the catch at :meth:`enable`;
    ``limit_margin`` [rad or m]: how far outside the URDF's limits a joint may be: there the soft
    stop lets the torque outward fade; ``host_timeout`` [s]: a program that has said
    :meth:`JointDriver.heartbeat` once and is then silent for so long is a fault.
    """

    joints: tuple[JointConfiguration, ...]
    rate: float = 500.0
    bitrate: int = 1_000_000
    velocity_window: int = 11
    reply_timeout: float = 0.02
    missed_limit: int = 40
    start_tolerance: float = 0.05
    limit_margin: float = 0.1
    stop_deceleration: float = 5.0
    host_timeout: float = 1.0

    def __post_init__(self) -> None:
        _check_types(self)
        if not self.joints:
            raise ConfigurationError('the driver has no joints: name them in its parameter joints')
        names = [joint.name for joint in self.joints]
        if len(set(names)) != len(names):
            raise ConfigurationError(f'joints names one twice: {", ".join(names)}')
        if not (math.isfinite(self.rate) and self.rate > 0.0):
            raise ConfigurationError(f'rate is {self.rate}: give the cycles per second')
        for key in ('stop_deceleration', 'reply_timeout', 'missed_limit', 'host_timeout'):
            value = getattr(self, key)
            if not (math.isfinite(value) and value > 0.0):
                raise ConfigurationError(f'{key} is {value}: give a positive number')
        if self.reply_timeout > self.missed_limit / self.rate:
            raise ConfigurationError(
                f'reply_timeout is {self.reply_timeout:g} s, missed_limit is {self.missed_limit} '
                f'periods of {1e3 / self.rate:g} ms: a single wait would already be the fault: '
                'raise missed_limit or lower reply_timeout'
            )
        used = [joint.can_id for joint in self.joints if joint.driver == RMD_X]
        if len(set(used)) != len(used):
            raise ConfigurationError(
                f'two motors share a can_id ({", ".join(map(str, used))}): give each its own'
            )

    @property
    def names(self) -> tuple[str, ...]:
        """Return the joints in order."""
        return tuple(joint.name for joint in self.joints)

    @property
    def period_ns(self) -> int:
        """Return the cycle's period [ns]."""
        return round(1e9 / self.rate)

    @classmethod
    def from_parameters(cls, values: Mapping[str, Any], dbc: str | Path) -> DriverConfiguration:
        """
        Build it from flat parameters, ``shoulder.can_id`` and the like.

        :param dbc: the DBC of a servo joint whose ``dbc`` is empty.
        :raises ConfigurationError: if one is missing or does not fit.
        """
        joints = tuple(
            JointConfiguration(**joint_values(values, name, JointConfiguration, dbc))
            for name in _joint_names(values)
        )
        scalars = {
            field: values[parameter]
            for parameter, field in _SCALARS.items()
            if parameter in values
        }
        return cls(joints=joints, **scalars)


_SCALARS = {
    'rate': 'rate',
    'can_bitrate': 'bitrate',
    'velocity_window': 'velocity_window',
    'reply_timeout': 'reply_timeout',
    'missed_limit': 'missed_limit',
    'start_tolerance': 'start_tolerance',
    'limit_margin': 'limit_margin',
    'stop_deceleration': 'stop_deceleration',
    'host_timeout': 'host_timeout',
}


def required(values: Mapping[str, Any], key: str) -> Any:
    """
    Return ``values[key]``.

    :raises ConfigurationError: if it is not there.
    """
    if values.get(key) is None:
        raise ConfigurationError(f'parameter {key} is not set')
    return values[key]


# A YAML file read without ROS may hold anything.
_KINDS: dict[str, tuple[tuple[type, ...], str]] = {
    'float': ((float, int), 'a number'),
    'int': ((int,), 'a whole number'),
    'bool': ((bool,), 'true or false'),
    'str': ((str,), 'a word'),
    'tuple[str, ...]': ((list, tuple), 'a list of words'),
}


def _check_types(own: ActuatorMount | DriverConfiguration, prefix: str = '') -> None:
    names = {field: parameter for parameter, field in _SCALARS.items()}
    for field in fields(own):
        kinds, words = _KINDS.get(str(field.type), ((object,), ''))
        value = getattr(own, field.name)
        # To Python a bool is a whole number, to a reader it is not.
        mistaken = isinstance(value, bool) and bool not in kinds and object not in kinds
        if mistaken or not isinstance(value, kinds):
            name = names.get(field.name, field.name)
            raise ConfigurationError(f'{prefix}{name} is {value!r}: it must be {words}')


def _joint_names(values: Mapping[str, Any]) -> list[str]:
    names = required(values, 'joints')
    if not isinstance(names, list | tuple) or not all(isinstance(name, str) for name in names):
        raise ConfigurationError(f'joints is {names!r}: give a list, as [shoulder, elbow]')
    return list(names)


def joint_values(
    values: Mapping[str, Any], joint: str, kind: type[ActuatorMount], dbc: str | Path
) -> dict[str, Any]:
    """
    Return the fields of ``kind`` that flat parameters give for ``joint``.

    :param dbc: the DBC where the joint names none.
    :raises ConfigurationError: if one that has no default is missing.
    """
    given: dict[str, Any] = {'name': joint}
    for field in fields(kind):
        key = f'{joint}.{field.name}'
        if values.get(key) is not None:
            given[field.name] = values[key]
        elif field.name != 'name' and field.default is MISSING:
            required(values, key)
    given['dbc'] = str(given.get('dbc') or dbc)
    return given


def mounts_from_parameters(
    values: Mapping[str, Any], dbc: str | Path
) -> tuple[ActuatorMount, ...]:
    """
    Build the mounts from flat parameters, ``shoulder.can_id`` and the like.

    :raises ConfigurationError: if one is missing or does not fit.
    """
    return tuple(
        ActuatorMount(**joint_values(values, name, ActuatorMount, dbc))
        for name in _joint_names(values)
    )


def read_parameters(path: str | Path, node: str) -> dict[str, Any]:
    """
    Read the parameters of ``node`` from a ROS parameter file, flat, those for any node included.

    :raises ConfigurationError: if the file cannot be read or has nothing for ``node``.
    """
    try:
        document = yaml.safe_load(Path(path).read_text(encoding='utf-8'))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        reason = ' '.join(str(error).split())
        raise ConfigurationError(f'parameter file {path} cannot be read: {reason}') from error
    result: dict[str, Any] = {}
    for key in ('/**', f'/**/{node}', node):
        section = document.get(key) if isinstance(document, dict) else None
        if isinstance(section, dict):
            _flatten('', section.get('ros__parameters') or {}, result)
    if not result:
        raise ConfigurationError(f'parameter file {path} has nothing for {node}')
    return result


def _flatten(prefix: str, values: Mapping[str, Any], result: dict[str, Any]) -> None:
    for key, value in values.items():
        if isinstance(value, dict):
            _flatten(f'{prefix}{key}.', value, result)
        else:
            result[f'{prefix}{key}'] = value
