# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What diagnostics show of the driver and its joints."""

from dataclasses import dataclass
from enum import Enum

from sosml_friction.actuators.bus.cycle import BusCounters
from sosml_friction.actuators.measurement import Measurement


class DriverState(Enum):
    """Where the driver is."""

    UNCONFIGURED = 'unconfigured'
    DISABLED = 'disabled'
    ENABLED = 'enabled'
    FAULT = 'fault'


@dataclass(kw_only=True)
class JointReport(Measurement):
    """
    Hold a joint's last measurement and what the driver makes of it.

    ``v``: the slope of its last positions [rad/s or m/s]; ``missed``: cycles without all replies,
    in total; ``problem``: what would fault it now, or ''; ``latency``: from the cycle's begin to
    its last answer's arrival [s], and ``usual_latency`` its median; ``tracking_error``: reference
    minus position [rad or m], NaN while it is not driven; ``timeouts``: how often the actuator's
    own watchdog tripped; ``restarts``: how often it was switched on anew.
    """

    name: str
    v: float
    flags: str
    missed: int
    problem: str
    warning: str
    latency: float
    usual_latency: float
    tracking_error: float
    timeouts: int
    restarts: int


@dataclass(frozen=True)
class DriverReport:
    """
    Hold what diagnostics show of the driver.

    ``reason``: why it is in FAULT; ``incomplete_cycles`` brought not all replies, ``late_cycles``
    brought one so late that it has no time.
    """

    state: DriverState
    reason: str
    trajectory_running: bool
    cycles: int
    incomplete_cycles: int
    late_cycles: int
    skew_ns: int
    bus: BusCounters
    bus_trouble: str
    joints: tuple[JointReport, ...]
