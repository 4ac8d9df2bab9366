# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What an actuator is told and what it tells, in units of the joint."""

import math
from dataclasses import dataclass
from typing import NamedTuple


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
    asked for; ``received_ns``: when the last answer of a cycle came. Raw: ``position_raw`` as the
    actuator counts it, ``speed`` [rad/s or m/s] as it reports it, in the joint's direction.
    ``uptime`` [s].
    """

    q: float = math.nan
    tau: float = math.nan
    current: float = math.nan
    temperature: float = math.nan
    voltage: float = math.nan
    stamp_ns: int = 0
    received_ns: int = 0
    firmware: str = ''
    model: str = ''
    position_raw: float = math.nan
    speed: float = math.nan
    uptime: float = math.nan
