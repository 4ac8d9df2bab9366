# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the driver is told about a joint with an RMD-X."""

import math
from dataclasses import dataclass

from sosml_friction.actuators.joint_configuration import HostLoop, JointConfiguration
from sosml_friction.actuators.parameter import parameter
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.robot import JointLimits

TORQUE_MODE, SPEED_MODE, POSITION_MODE = MODES = ('torque', 'speed', 'position')
NO_TURN, OUTPUT_TURN, MOTOR_TURN = LOST_TURNS = ('refuse', 'output', 'motor')
SHUT_DOWN_AT_END, STOP_AT_END = AT_END = ('shutdown', 'stop')


@dataclass(frozen=True)
class RmdXConfiguration(JointConfiguration):
    """
    Describe a joint with an RMD-X; ``can_id`` is the motor's id.

    ``torque_constant`` is at the output [Nm/A]. Gains are needed in mode torque only,
    ``position_gain`` in mode speed, ``gear_ratio`` where lost turns of the motor are corrected.

    :raises ConfigurationError: if a value does not fit.
    """

    driver = 'rmd_x'

    can_id: int = parameter('id of the motor, 1 to 32 (rmd_x: required)', 0, mount=True)
    current_limit: float = parameter(
        'most current to command (rmd_x: required)', math.nan, unit='A', above=0.0,
        conditional=True,
    )  # fmt: skip
    current_rate_limit: float = parameter(
        'fastest change of the commanded current (rmd_x: required)', math.nan, unit='A/s',
        above=0.0, conditional=True,
    )  # fmt: skip
    kp: float = parameter(
        'proportional gain on the host (rmd_x: required)', math.nan, unit='Nm/rad or N/m',
        above=0.0, conditional=True,
    )  # fmt: skip
    kd: float = parameter(
        'derivative gain on the host (rmd_x: required)', math.nan, unit='Nm s/rad or N s/m',
        least=0.0, conditional=True,
    )  # fmt: skip
    mode: str = parameter(
        "what executes a trajectory (rmd_x): torque by the host's loop, or the motor's own speed "
        'or position loop',
        TORQUE_MODE,
        choices=MODES,
    )
    position_gain: float = parameter(
        'speed per position error in mode speed (required there)', math.nan, unit='1/s',
        above=0.0, conditional=True,
    )  # fmt: skip
    counts_per_turn: int = parameter(
        'encoder counts per turn of the output (rmd_x): measure by 0x60; 0: by 0x92, 0.01 degree',
        0, range=(0, 2**30), least=0.0,
    )  # fmt: skip
    lost_turns: str = parameter(
        'how a position outside the limits may be corrected at the start (rmd_x): by no turn, by '
        'turns of the output or of the motor',
        NO_TURN,
        choices=LOST_TURNS,
    )
    gear_ratio: float = parameter(
        'turns of the motor per turn of the output (required for lost_turns: motor)', math.nan,
        above=0.0, conditional=True,
    )  # fmt: skip
    brake: bool = parameter('it has a brake, opened by ~/enable, closed at the end', False)
    motor_watchdog_ms: int = parameter(
        "time of the motor's own watchdog (0xB3), written to its ROM unless it trips in time "
        'already; 0: left as it is',
        0, unit='ms', range=(0, 10000), least=0.0,
    )  # fmt: skip
    at_end: str = parameter(
        'after zero current: shutdown (0x80, free) or stop (0x81, the motor holds)',
        SHUT_DOWN_AT_END,
        choices=AT_END,
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 1 <= self.can_id <= 32:
            raise ConfigurationError(
                f"{self.name}.can_id is {self.can_id}: give the motor's id, 1 to 32"
            )

    def check_drive(self) -> None:
        self.require('current_limit', 'current_rate_limit')
        if self.mode == TORQUE_MODE:
            self.require('kp', 'kd')
        if self.mode == SPEED_MODE:
            self.require('position_gain')
        if self.lost_turns == MOTOR_TURN:
            self.require('gear_ratio')

    def loop(self, limits: JointLimits) -> HostLoop | str:
        """Return the loop of mode torque; the lower of effort and current limit counts."""
        if self.mode != TORQUE_MODE:
            return f"{self.name} is in mode {self.mode}, the motor's own loop"
        limit = min(self.current_limit * self.torque_constant, limits.effort)
        return HostLoop(self.kp, self.kd, limit, self.current_rate_limit * self.torque_constant)
