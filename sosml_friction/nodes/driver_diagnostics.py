# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What ``/diagnostics`` shows of the driver: its cycle, its bus and each joint."""

import math
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus

from sosml_friction.actuators.driver.configuration import DriverConfiguration
from sosml_friction.actuators.driver.cycle_thread import CycleThread
from sosml_friction.actuators.driver.report import DriverReport, JointReport
from sosml_friction.actuators.driver.sample_relay import SampleRelay
from sosml_friction.motion.velocity import lag
from sosml_friction.nodes.diagnostics import ERROR, OK, WARN, make_status

_BUS = {
    'frames sent': 'sent',
    'frames received': 'received',
    'replies missed': 'missed',
    'frames stale': 'stale',
    'frames unsolicited': 'unsolicited',
    'requests echoed': 'echoes',
    'frames foreign': 'foreign',
    'commands by another program': 'intruders',
    'frames undecodable': 'undecodable',
    'frames not sent': 'not_sent',
    'error frames': 'error_frames',
    'last error frame': '',
    'bus failures': 'failures',
    'bus opened again': 'reopened',
}


def cycle_values(
    report: DriverReport,
    configuration: DriverConfiguration,
    refused: str,
    thread: CycleThread | None,
    relay: SampleRelay | None,
) -> dict[str, Any]:
    """Return what is shown of the cycle; ``refused``: why the last trajectory was, or ''."""
    return {
        'state': report.state.value,
        'fault': report.reason,
        'trajectory running': report.trajectory_running,
        'refused trajectory': refused,
        'cycles': report.cycles,
        'incomplete cycles': report.incomplete_cycles,
        'late cycles': report.late_cycles,
        'cycle overruns': thread.overruns if thread else 0,
        'cycle overruns by lateness': thread.late.text() if thread else 'none',
        'greatest lateness [ms]': thread.late.greatest_ns * 1e-6 if thread else 0.0,
        'cycles skipped': thread.skipped if thread else 0,
        'cycles begun late by': thread.begun.text() if thread else 'none',
        'greatest late begin [ms]': thread.begun.greatest_ns * 1e-6 if thread else 0.0,
        'samples not published': relay.dropped if relay else 0,
        'position skew [ms]': report.skew_ns * 1e-6,
        'velocity lag [ms]': 1e3 * lag(configuration.velocity_window, 1.0 / configuration.rate),
        'velocity window [samples]': configuration.velocity_window,
    }


def bus_values(report: DriverReport, load: str) -> dict[str, Any]:
    """Return what is shown of the bus, with its ``load`` as a sentence."""
    values = {
        label: getattr(report.bus, name) if name else report.bus_trouble
        for label, name in _BUS.items()
    }
    return {**values, 'load': load}


def joint_status(node: str, joint: JointReport, channel: str) -> DiagnosticStatus:
    """Return what is shown of one joint."""
    values = {
        'position': joint.q,
        'velocity': joint.v,
        'effort': joint.tau if math.isfinite(joint.tau) else 'not measured',
        'current [A]': joint.current,
        'speed by the actuator': joint.speed,
        'position raw [counts]': joint.position_raw,
        'latency [ms]': joint.latency * 1e3,
        'usual latency [ms]': joint.usual_latency * 1e3,
        'tracking error': joint.tracking_error,
        'temperature [degC]': joint.temperature,
        'voltage [V]': joint.voltage,
        'flags': joint.flags,
        'firmware': joint.firmware or 'not told',
        'model': joint.model or 'not told',
        'uptime [s]': joint.uptime,
        'replies missed': joint.missed,
        'watchdog of the motor tripped': joint.timeouts,
        'restarts': joint.restarts,
    }
    level = ERROR if joint.problem else WARN if joint.warning else OK
    text = joint.problem or joint.warning or 'no fault'
    return make_status(f'{node}: {joint.name}', level, text, values, channel)
