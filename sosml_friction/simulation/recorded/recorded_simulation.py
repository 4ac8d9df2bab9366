# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A whole recording simulated again from a model folder: what the model gets wrong, by joint."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.diagnosis.model_effects import known_effects, model_friction, with_known
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import Signals, prepare
from sosml_friction.simulation.forward_model import ForwardModel
from sosml_friction.simulation.forward_simulation import simulate
from sosml_friction.simulation.recorded.cascade_drive import CascadeDrive
from sosml_friction.simulation.recorded.controlled_joint import ControlledJoint
from sosml_friction.simulation.recorded.driver_loop import bridged, simulate_driver_loop
from sosml_friction.simulation.recorded.loop_start import LoopReference, find_reference
from sosml_friction.simulation.recorded.recorded_loop import RecordedLoop, during
from sosml_friction.simulation.recorded.resimulation import (
    measured_start,
    simulate_windows,
    undriven,
)

FloatArray = NDArray[np.float64]


class Step(Protocol):
    """Say what is being done now, and if that is known which share of it is done, 0..1."""

    def __call__(self, what: str, share: float | None = None) -> None:
        """Take note."""


CLOSED_LOOP, WINDOWS = 'closed_loop', 'windows'
#: A window lasts so long unless another length is asked for [s].
HORIZON_S = 0.5
#: A parabola through so much of the beginning says how fast a recording starts [s].
_START_S = 0.02
#: Smoothing takes at most so much off a stretch [s].
_MARGIN_S = 0.4
_QUANTITIES = ('position', 'velocity', 'effort')


@dataclass(frozen=True)
class SimulationError:
    """
    Hold how far a simulated quantity of a joint is from the measured one.

    ``rms`` and ``largest`` in its unit; ``relative`` [%]: 100 |simulated - measured| / |measured|;
    of a position, as a share of the way from where the window or the recording began.
    """

    rms: float
    largest: float
    relative: float
    unit: str


@dataclass(frozen=True)
class RecordedSimulation:
    """
    Hold a recording and its simulation, at the samples that were simulated.

    ``mode``: ``closed_loop``, the recorded controllers follow what was wanted; or
    ``windows``, driven by the measured effort and begun anew from the measured state every
    ``horizon_s``; ``why_not``: why it is not the former. ``measured`` and ``simulated``: position,
    velocity and effort (N, n); in windows the effort is the one that the model needs for the
    measured motion, both low-passed. ``begins`` (N,): where a window begins. ``followed``: joints
    without effort, or in closed loop without a controller that is known, which follow the
    recording. ``displacement`` (n,): over which friction turns
    around; ``steps``: of the integration in a sample. ``remarks``: sentences.
    """

    mode: str
    why_not: str
    horizon_s: float | None
    names: tuple[str, ...]
    units: tuple[str, ...]
    time: FloatArray
    measured: Mapping[str, FloatArray]
    simulated: Mapping[str, FloatArray]
    begins: NDArray[np.bool_]
    errors: Mapping[str, Mapping[str, SimulationError]]
    followed: tuple[str, ...]
    displacement: FloatArray
    steps: int
    remarks: tuple[str, ...]


def simulate_recording(
    log: JointLog,
    model: RobotModelFile,
    controlled: Mapping[str, ControlledJoint] | None = None,
    horizon_s: float | None = None,
    step: Step = lambda what, share=None: None,
    loop: RecordedLoop | str = '',
) -> RecordedSimulation:
    """
    Simulate a recording from the model, and compare.

    In closed loop where every joint's controller and wanted position are known; else, or where a
    ``horizon_s`` is asked for, in windows.

    :param controlled: cascades of loops that the recording holds, by joint.
    :param loop: the driver's own loop that it holds, or why it cannot be closed.
    :raises DataError: if no joint has effort, or no stretch is long enough.
    :raises ConfigurationError: if the model cannot be simulated, or the horizon is no time.
    """
    if horizon_s is not None and not 0.0 < horizon_s < np.inf:
        raise ConfigurationError(
            f'the horizon is {horizon_s:g} s: give the length of a window, such as 0.5'
        )
    robot = model.make_robot()
    log = log.select(robot.names)
    log.require_effort()
    why_not = 'windows were asked for' if horizon_s is not None else ''
    reference: LoopReference | None = None
    if not why_not and isinstance(loop, RecordedLoop):
        step('looking for the beginning of the trajectory')
        sought = _reference(log, robot.names, loop)
        if isinstance(sought, str):
            why_not = sought
        else:
            log, reference = sought
    step('preparing the recording')
    shortest = (horizon_s or HORIZON_S) + _MARGIN_S
    whole = log if reference is None else bridged(log)
    try:
        prepared = prepare([whole], model, robot, DiagnosisSettings(), shortest_s=shortest)
    except DataError as error:
        raise DataError(
            f'no stretch of the recording is {shortest:g} s long without a hole in position or '
            'effort: give a shorter --horizon or record longer'
        ) from error
    signals = with_known(prepared, model)
    displacement = signals[0].scales.displacement
    terms = [found.term(robot) for found in known_effects(model)]
    forward = ForwardModel(robot, model_friction(model), displacement, terms)
    if reference is not None and isinstance(loop, RecordedLoop):
        return _in_driver_loop(forward, model, log, signals, loop, reference, step)
    if not why_not:
        why_not = str(loop) or _why_not(log, robot.names, controlled or {}, signals)
    if why_not:
        return _in_windows(forward, model, signals, horizon_s or HORIZON_S, why_not, step)
    assert controlled is not None
    return _in_closed_loop(forward, model, log, signals[0], controlled, step)


def _why_not(
    log: JointLog,
    names: tuple[str, ...],
    controlled: Mapping[str, ControlledJoint],
    signals: list[Signals],
) -> str:
    """Return why the cascades of a recording cannot be simulated in closed loop, or ''."""
    missing = [name for name in names if name not in controlled]
    if missing:
        return (
            f'the closed loop needs the controller and the wanted position of each joint, and the '
            f'recording has none of {", ".join(missing)}'
        )
    if not all(np.isfinite(controlled[name].reference).all() for name in names):
        return 'the wanted position is not known at every sample'
    if len(signals) != 1 or len(signals[0].q) != len(log):
        return 'the recording has a hole, and a controller remembers what was before it'
    return ''


def _reference(
    log: JointLog, names: tuple[str, ...], loop: RecordedLoop
) -> tuple[JointLog, LoopReference] | str:
    """
    Return the part of a log that was under the loop, and its reference, or why it is not known.

    Joints are in the order of ``names``.
    """
    if set(names) != set(loop.robot.names):
        return "the model's joints are not the driver's"
    if not any(name in loop.gains for name in names):
        return 'no joint is under the controller of the driver'
    try:
        part, own = during(log, loop)
        found = find_reference(part.select(loop.robot.names), own)
    except DataError as error:
        return str(error)
    order = [loop.robot.names.index(name) for name in names]
    q, v, ahead = found.q[:, order], found.v[:, order], found.ahead[:, order]
    return part, replace(found, q=q, v=v, ahead=ahead)


def _in_driver_loop(
    forward: ForwardModel,
    model: RobotModelFile,
    log: JointLog,
    signals: list[Signals],
    loop: RecordedLoop,
    reference: LoopReference,
    step: Step,
) -> RecordedSimulation:
    names = signals[0].robot.names
    followed = [
        i for i in range(len(names)) if names[i] in loop.followed or i in undriven(signals[0])
    ]
    run = simulate_driver_loop(
        forward, log, signals, loop, reference, followed,
        lambda share: step('simulating the closed loop', share),
    )  # fmt: skip
    _refuse_runaway(run.finite, 'the closed loop')
    remarks = [
        f"{name}: the driver's law makes the recorded effort, but for {left:.1f} % of what its "
        'gains add to the feed-forward'
        for name, left in reference.left.items()
    ]
    remarks.append(
        f'the trajectory begins {1e3 * reference.start:.1f} ms after the first sample, found by '
        'that law'
    )
    remarks += [
        f'{names[i]} moves as recorded, because {loop.followed[names[i]]}; --horizon '
        f'{HORIZON_S:g} simulates it by its effort'
        for i in followed
        if names[i] in loop.followed and i not in undriven(signals[0])
    ]
    if len(signals) > 1:
        remarks.append(
            f'the recording has holes: its {len(signals)} stretches are simulated each from the '
            'measured state'
        )
    return _result(
        CLOSED_LOOP, '', None, forward, model, signals, run.time, run.measured, run.simulated,
        run.begins, run.measured['position'][0], followed, remarks,
    )  # fmt: skip


def _in_closed_loop(
    forward: ForwardModel,
    model: RobotModelFile,
    log: JointLog,
    signals: Signals,
    controlled: Mapping[str, ControlledJoint],
    step: Step,
) -> RecordedSimulation:
    names, period = signals.robot.names, signals.band.step
    count = len(log)
    at = np.zeros(1, dtype=np.int64)
    start = measured_start(signals, at)
    # The controller sees the first sample itself, and what is smoothed is wrong at the ends.
    first = max(5, round(_START_S / period))
    curve = np.polynomial.polynomial.polyfit(np.arange(first) * period, log.q[:first], 2)
    start.q[0], start.v[0], start.acceleration[0] = log.q[0], curve[1], 2.0 * curve[2]
    reference = np.column_stack([controlled[name].reference for name in names])
    drive = CascadeDrive(forward, names, controlled, reference, start.q[0], start.v[0], period)
    effort = np.nanquantile(np.abs(log.tau), 0.99, axis=0)

    def told(k: int) -> None:
        if k % 500 == 0:
            step('simulating the closed loop', k / count)

    run = simulate(forward, start, drive, period, count, effort, told)
    drive.begin(count - 1, run.q[:, -1])
    _refuse_runaway(np.isfinite(run.q).all(), 'the closed loop')
    q = run.q[0]
    simulated = {'position': q, 'velocity': run.v[0], 'effort': drive.reported()}
    # A smoothed velocity is wrong at the ends.
    velocity = signals.v.copy()
    velocity[: signals.band.half] = velocity[count - signals.band.half :] = np.nan
    measured = {'position': log.q, 'velocity': velocity, 'effort': log.tau}
    begins = np.zeros(count, dtype=np.bool_)
    begins[0] = True
    return _result(
        CLOSED_LOOP, '', None, forward, model, [signals], log.time, measured, simulated, begins,
        log.q[0],
    )  # fmt: skip


def _in_windows(
    forward: ForwardModel,
    model: RobotModelFile,
    signals: list[Signals],
    horizon_s: float,
    why_not: str,
    step: Step,
) -> RecordedSimulation:
    parts: dict[str, list[FloatArray]] = {}
    begins: list[NDArray[np.bool_]] = []
    for s in signals:
        period, edge = s.band.step, s.band.half
        length = max(2, round(horizon_s / period))
        at = np.arange(edge, len(s.q) - edge - length, length)
        if not len(at):
            continue

        def told(k: int, length: int = length) -> None:
            if k % 20 == 0:
                step('simulating windows', k / length)

        # The last sample of a window is the first of the next.
        run = simulate_windows(forward, s, at, length + 1, told)
        rows = (at[:, None] + 1 + np.arange(length)).ravel()
        _refuse_runaway(np.isfinite(run.q).all(), 'a window')
        flat = (len(rows), forward.n)
        whole = {
            'time': s.time[rows],
            'q': s.q[rows], 'v': s.v[rows], 'tau': s.band.smooth(s.tau, 1.0)[rows],
            'q_s': run.q[:, 1:].reshape(flat), 'v_s': run.v[:, 1:].reshape(flat),
            'tau_s': s.band.smooth(s.torque, 1.0)[rows],
            'from': np.repeat(s.q[at], length, axis=0),
        }  # fmt: skip
        for key, x in whole.items():
            parts.setdefault(key, []).append(x)
        begin = np.zeros(len(rows), dtype=np.bool_)
        begin[::length] = True
        begins.append(begin)
    if not begins:
        raise DataError(
            f'no stretch of the recording has a window of {horizon_s:g} s without a hole: give a '
            'shorter --horizon or record longer'
        )
    x = {key: np.concatenate(value) for key, value in parts.items()}
    measured = {'position': x['q'], 'velocity': x['v'], 'effort': x['tau']}
    simulated = {'position': x['q_s'], 'velocity': x['v_s'], 'effort': x['tau_s']}
    return _result(
        WINDOWS, why_not, horizon_s, forward, model, signals, x['time'], measured, simulated,
        np.concatenate(begins), x['from'],
    )  # fmt: skip


def _refuse_runaway(finite: bool | np.bool_, what: str) -> None:
    if not finite:
        raise DataError(
            f'the simulation of {what} runs away: the model is unstable, or the effort in the '
            'recording has another sign or unit than the model'
        )


def _result(
    mode: str,
    why_not: str,
    horizon_s: float | None,
    forward: ForwardModel,
    model: RobotModelFile,
    signals: list[Signals],
    time: FloatArray,
    measured: Mapping[str, FloatArray],
    simulated: Mapping[str, FloatArray],
    begins: NDArray[np.bool_],
    origin: FloatArray | float = 0.0,
    led: Sequence[int] | None = None,
    more: Sequence[str] = (),
) -> RecordedSimulation:
    robot = signals[0].robot
    unknown = undriven(signals[0])
    followed = tuple(robot.names[i] for i in (unknown if led is None else led))
    errors: dict[str, dict[str, SimulationError]] = {}
    for i, name in enumerate(robot.names):
        effort = robot.effort_units[i]
        length = 'rad' if effort == 'Nm' else 'm'
        units = dict(zip(_QUANTITIES, (length, f'{length}/s', effort), strict=True))
        errors[name] = {}
        for what in _QUANTITIES:
            if name in followed:
                errors[name][what] = SimulationError(np.nan, np.nan, np.nan, units[what])
                continue
            m, difference = measured[what], simulated[what] - measured[what]
            if what == 'position':
                m = m - origin
            known = np.isfinite(difference[:, i])
            size = float(np.linalg.norm(m[known, i]))
            error = difference[known, i]
            errors[name][what] = SimulationError(
                float(np.sqrt(np.mean(error**2))) if known.any() else np.nan,
                float(np.abs(error).max(initial=0.0)),
                100.0 * float(np.linalg.norm(error)) / size if size > 0.0 else np.nan,
                units[what],
            )
    remarks = [
        f'{name} has no friction in the model and is simulated without'
        for name, joint in model.joints.items()
        if joint.friction is None and name not in followed
    ]
    remarks += [f'{robot.names[i]} has no effort in the recording and follows it' for i in unknown]
    remarks += more
    effort = np.max([np.abs(s.tau).max(axis=0) for s in signals], axis=0)
    return RecordedSimulation(
        mode, why_not, horizon_s, robot.names, robot.effort_units, time, measured, simulated,
        begins, errors, followed, forward.displacement,
        forward.steps(np.median(signals[0].q, axis=0), effort, signals[0].band.step),
        tuple(remarks),
    )  # fmt: skip
