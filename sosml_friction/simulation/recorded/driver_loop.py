# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A recording of the project's own driver, simulated under the driver's controller."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from sosml_friction.bags.even_stretches import even_stretches, on_lines
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.simulation.forward_model import ForwardModel
from sosml_friction.simulation.forward_simulation import simulate
from sosml_friction.simulation.recorded.loop_start import LoopReference
from sosml_friction.simulation.recorded.pd_drive import PdDrive
from sosml_friction.simulation.recorded.recorded_loop import RecordedLoop
from sosml_friction.simulation.recorded.recorded_run import (
    RecordedRun,
    begins_every,
    refuse_runaway,
)
from sosml_friction.simulation.recorded.stretch import Stretch, measured_start, smooth_velocity

#: Hole that divides a recording [s]: the driver counts one of its own as a fault.
_LONGEST_S = 0.1


def bridged(log: JointLog) -> JointLog:
    """
    Return the log with its short holes filled, along lines at its usual step.

    In a short hole the driver kept running: its cycle was late, or the recorder lost a message. A
    hole of more than 0.1 s stays: the driver would have ended the motion in it.
    """
    time = log.time
    steps = np.diff(time)
    usual = float(np.median(steps))
    if not usual > 0.0:
        return log
    added = [
        np.linspace(time[k], time[k + 1], max(2, round(steps[k] / usual)) + 1)[1:-1]
        for k in np.flatnonzero((steps > 2.0 * usual) & (steps <= _LONGEST_S))
    ]
    if not added:
        return log
    t = np.sort(np.concatenate([time, *added]))
    t_ns = log.t_ns[0] + np.rint(t * 1e9).astype(np.int64)

    return log.mapped(partial(on_lines, t, time), t_ns=t_ns)


def simulate_driver_loop(
    forward: ForwardModel,
    log: JointLog,
    stretches: Sequence[Stretch],
    loop: RecordedLoop,
    reference: LoopReference,
    followed: list[int],
    told: Callable[[float], None],
) -> RecordedRun:
    """
    Simulate every stretch of a recording from its measured beginning to its end.

    A stretch begins where the measured velocity is known, and with what the controller saw before.
    The run is at the recorded stamps; a joint that moves as recorded is NaN in it.

    :param reference: at the samples of the log, joints in the model's order.
    :param followed: joints that move as recorded.
    :raises DataError: if the simulation runs away.
    """
    names = forward.robot.names
    gains = {i: loop.gains[name] for i, name in enumerate(names) if i not in followed}
    known = np.isfinite(log.q).all(axis=1) & np.append(True, np.diff(log.t_ns) > 0)
    runs: list[RecordedRun] = []
    spans = np.array([part.t_ns[[0, -1]] - log.t_ns[0] for part in even_stretches(bridged(log))])
    for s in stretches:
        # A stretch takes its samples for as far apart as those of the first.
        own_span = int(np.argmin(np.abs(1e-9 * spans[:, 0] - s.time[0])))
        end = 1e-9 * float(spans[own_span, 1])
        at, period = s.band.half, (end - float(s.time[0])) / (len(s.q) - 1)
        begin_s = float(s.time[0]) + at * period
        rows = np.flatnonzero(known & (log.time >= s.time[0] - 1e-9) & (log.time <= end + 1e-9))
        samples = len(s.q) - at
        start = measured_start(s, np.array([at], dtype=np.int64))
        tau = np.nan_to_num(log.tau[rows])
        own = replace(
            reference, q=reference.q[rows], v=reference.v[rows], ahead=reference.ahead[rows]
        )
        times = (log.time[rows] - begin_s) / period
        drive = PdDrive(forward, period, gains, log.t_ns[rows], times, own, log.q[rows], tau)

        def step(k: int, begin: float = begin_s, period: float = period) -> None:
            if k % 500 == 0:
                told((begin + k * period) / float(log.time[-1]))

        effort = np.quantile(np.abs(s.tau), 0.99, axis=0)
        run = simulate(forward, start, drive, period, samples, effort, step, followed)
        refuse_runaway(run.q, 'the closed loop')
        drive.begin(samples - 1, run.q[:, -1])
        grid = np.arange(samples, dtype=np.float64) * period
        cycles = slice(drive.first, drive.first + len(drive.reported()))
        when = np.clip(times[cycles] * period, 0.0, grid[-1])
        even = np.arange(-at, len(s.q) - at, dtype=np.float64) * period
        simulated = (
            CubicHermiteSpline(grid, run.q[0], run.v[0])(when),
            on_lines(when, grid, run.v[0]),
            drive.reported(),
        )
        for x in simulated:
            x[:, followed] = np.nan
        v = on_lines(when, even, smooth_velocity(s))
        measured = (log.q[rows][cycles], v, log.tau[rows][cycles])
        begins = begins_every(len(when), len(when))
        runs.append(RecordedRun(log.time[rows][cycles], measured, simulated, begins))
    return RecordedRun.joined(runs)
