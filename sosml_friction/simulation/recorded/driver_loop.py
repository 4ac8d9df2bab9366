# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A recording of the project's own driver, simulated under the driver's controller."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from sosml_friction.bags.even_stretches import even_stretches
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.regression.signals import Signals
from sosml_friction.simulation.forward_model import ForwardModel
from sosml_friction.simulation.forward_simulation import simulate
from sosml_friction.simulation.recorded.loop_start import LoopReference
from sosml_friction.simulation.recorded.pd_drive import PdDrive
from sosml_friction.simulation.recorded.recorded_loop import RecordedLoop
from sosml_friction.simulation.recorded.resimulation import measured_start

FloatArray = NDArray[np.float64]

#: A hole of more than this parts a recording [s]: the driver takes one of its own for a fault.
_LONGEST_S = 0.1


@dataclass(frozen=True)
class DriverLoopRun:
    """
    Hold a simulation at the recorded stamps, stretch after stretch, N samples of n joints.

    ``time`` (N,) [s] since the first sample of the log; ``measured`` and ``simulated``: position,
    velocity and effort, simulated NaN of a joint that moves as recorded; ``begins`` (N,): where a
    stretch begins; ``finite``: whether all of it stayed where a robot can be.
    """

    time: FloatArray
    measured: Mapping[str, FloatArray]
    simulated: Mapping[str, FloatArray]
    begins: NDArray[np.bool_]
    finite: bool


def bridged(log: JointLog) -> JointLog:
    """
    Return the log with its short holes filled, along lines at its usual step.

    The driver goes on in a hole: its cycle was late, or the recorder lost a message. One of more
    than 0.1 s, in which the driver would have ended the motion, is left.
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

    def filled(x: FloatArray) -> FloatArray:
        return np.column_stack([np.interp(t, time, y) for y in x.T])

    temperature = None if log.temperature is None else filled(log.temperature)
    return JointLog(
        log.names, t_ns, filled(log.q), filled(log.v), filled(log.tau), temperature, log.tags
    )


def simulate_driver_loop(
    forward: ForwardModel,
    log: JointLog,
    signals: list[Signals],
    loop: RecordedLoop,
    reference: LoopReference,
    followed: list[int],
    told: Callable[[float], None],
) -> DriverLoopRun:
    """
    Simulate every stretch of a recording from its measured beginning to its end.

    A stretch begins where the measured velocity is known, and with what the controller saw before.

    :param signals: of the :func:`bridged` log.
    :param reference: at the samples of the log, joints in the model's order.
    :param followed: joints that move as recorded.
    :param told: called with the share that is done, 0..1.
    """
    names = signals[0].robot.names
    gains = {i: loop.gains[name] for i, name in enumerate(names) if i not in followed}
    known = np.isfinite(log.q).all(axis=1) & np.append(True, np.diff(log.t_ns) > 0)
    parts: dict[str, list[FloatArray]] = {}
    begins: list[NDArray[np.bool_]] = []
    finite = True
    spans = np.array([part.t_ns[[0, -1]] - log.t_ns[0] for part in even_stretches(bridged(log))])
    for s in signals:
        # Signals take the samples of all stretches for as far apart as those of the first.
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
        if not np.isfinite(run.q).all():
            finite = False
            break
        drive.begin(samples - 1, run.q[:, -1])
        grid = np.arange(samples, dtype=np.float64) * period
        cycles = slice(drive.first, drive.first + len(drive.reported()))
        when = np.clip(times[cycles] * period, 0.0, grid[-1])
        q = CubicHermiteSpline(grid, run.q[0], run.v[0])
        smooth_v = s.v.copy()
        smooth_v[: s.band.half] = smooth_v[len(s.v) - s.band.half :] = np.nan
        even = (np.arange(len(s.q)) - at) * period
        whole = {
            'time': log.time[rows][cycles],
            'q': log.q[rows][cycles],
            'v': np.column_stack([np.interp(when, even, x) for x in smooth_v.T]),
            'tau': log.tau[rows][cycles],
            'q_s': q(when),
            'v_s': np.column_stack([np.interp(when, grid, x) for x in run.v[0].T]),
            'tau_s': drive.reported(),
        }
        for key in ('q_s', 'v_s', 'tau_s'):
            whole[key][:, followed] = np.nan
        for key, x in whole.items():
            parts.setdefault(key, []).append(x)
        begin = np.zeros(len(when), dtype=np.bool_)
        begin[:1] = True
        begins.append(begin)
    if not finite:
        empty = np.zeros((0, len(names)))
        nothing = dict.fromkeys(('position', 'velocity', 'effort'), empty)
        return DriverLoopRun(np.zeros(0), nothing, nothing, np.zeros(0, np.bool_), False)
    x = {key: np.concatenate(value) for key, value in parts.items()}
    return DriverLoopRun(
        x['time'],
        {'position': x['q'], 'velocity': x['v'], 'effort': x['tau']},
        {'position': x['q_s'], 'velocity': x['v_s'], 'effort': x['tau_s']},
        np.concatenate(begins),
        True,
    )
