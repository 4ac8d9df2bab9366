# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A recording simulated again from its beginning: in its own closed loop, or in windows."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.simulation.forward_model import ForwardModel
from sosml_friction.simulation.forward_simulation import simulate
from sosml_friction.simulation.recorded.cascade_drive import CascadeDrive
from sosml_friction.simulation.recorded.controlled_joint import ControlledJoint
from sosml_friction.simulation.recorded.driver_loop import bridged, simulate_driver_loop
from sosml_friction.simulation.recorded.law_check import LawCheck
from sosml_friction.simulation.recorded.loop_start import LoopReference, find_reference
from sosml_friction.simulation.recorded.recorded_loop import RecordedLoop, during
from sosml_friction.simulation.recorded.recorded_run import (
    QUANTITIES,
    RecordedRun,
    begins_every,
    refuse_runaway,
)
from sosml_friction.simulation.recorded.recorded_simulation import (
    CLOSED_LOOP,
    WINDOWS,
    RecordedSimulation,
    SimulationError,
    simulation_error,
)
from sosml_friction.simulation.recorded.stretch import (
    Prepare,
    Stretch,
    measured_start,
    simulate_windows,
    smooth_velocity,
    undriven,
)


class Step(Protocol):
    """Say what is being done now, and if that is known which share of it is done, 0..1."""

    def __call__(self, what: str, share: float | None = None) -> None:
        """Take note."""


#: Length of a window unless another is asked for [s]. Chosen, no measurement.
HORIZON_S = 0.5
#: Length of the beginning through which a parabola gives the initial velocity [s]. Chosen, no
#: measurement.
_START_S = 0.02
#: Most that the low-pass cuts off the ends of a stretch [s]. Chosen, no measurement.
_MARGIN_S = 0.4


def simulate_recording(
    log: JointLog,
    model: RobotModelFile,
    prepare: Prepare,
    controlled: Mapping[str, ControlledJoint] | None = None,
    horizon_s: float | None = None,
    step: Step = lambda what, share=None: None,
    loop: RecordedLoop | str = '',
) -> RecordedSimulation:
    """
    Simulate a recording from the model, and compare.

    In closed loop where every joint's controller and wanted position are known; else, or where a
    ``horizon_s`` is asked for, in windows.

    :param prepare: makes the simulated model and the stretches of a log.
    :param loop: the driver's own loop that it holds, or why it cannot be closed.
    :raises DataError: if no joint has effort, or no stretch is long enough.
    :raises ConfigurationError: if the model cannot be simulated, or the horizon is no time.
    """
    if horizon_s is not None and not 0.0 < horizon_s < np.inf:
        raise ConfigurationError(
            f'the horizon is {horizon_s:g} s: give the length of a window, such as 0.5'
        )
    names = model.joint_names
    log = log.select(names)
    log.require_effort()
    why_not = 'windows were asked for' if horizon_s is not None else ''
    reference: LoopReference | None = None
    if not why_not and isinstance(loop, RecordedLoop):
        step('looking for the beginning of the trajectory')
        sought = _reference(log, names, loop)
        if isinstance(sought, str):
            why_not = sought
        else:
            log, reference = sought
    step('preparing the recording')
    shortest = (horizon_s or HORIZON_S) + _MARGIN_S
    try:
        forward, stretches = prepare(log if reference is None else bridged(log), shortest)
    except DataError as error:
        raise DataError(
            f'no stretch of the recording is {shortest:g} s long without a hole in position or '
            'effort: give a shorter --horizon or record longer'
        ) from error
    prepared = _Prepared(forward, model, log, stretches, step)
    if reference is not None and isinstance(loop, RecordedLoop):
        return prepared.in_driver_loop(loop, reference)
    controlled = controlled or {}
    if not why_not:
        why_not = str(loop) or prepared.why_not(controlled)
    checks: list[LawCheck] = []
    if not why_not:
        step("checking the controller's law")
        checks = prepared.cascade_checks(controlled)
        units = dict(zip(names, forward.robot.effort_units, strict=True))
        why_not = '; '.join(x.objection(units[x.joint]) for x in checks if not x.holds)
    if why_not:
        return prepared.in_windows(horizon_s or HORIZON_S, why_not)
    return prepared.in_cascades(controlled, [check.remark() for check in checks])


def _reference(
    log: JointLog, names: Sequence[str], loop: RecordedLoop
) -> tuple[JointLog, LoopReference] | str:
    """Return what of a log was under the loop, and its reference by ``names``, or why not."""
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


@dataclass(frozen=True)
class _Prepared:
    """Hold a recording as it is to be simulated: the model's ``forward`` and its stretches."""

    forward: ForwardModel
    model: RobotModelFile
    log: JointLog
    stretches: Sequence[Stretch]
    step: Step

    def cascade_checks(self, controlled: Mapping[str, ControlledJoint]) -> list[LawCheck]:
        """Return what the cascades, fed with the recorded motion, leave of the recorded effort."""
        names, log = self.forward.robot.names, self.log
        period = float(np.median(np.diff(log.time)))
        # Before the first sample the motion is not known; the law knows it two samples later.
        rest = np.zeros(log.q.shape[1])
        drive = CascadeDrive(self.forward, controlled, log.q[0], rest, period)
        for k, q in enumerate(log.q):
            drive.begin(k, q[None])
        left = log.tau - np.array(drive.commands)
        left[:2] = np.nan
        size = np.nanmean(np.abs(log.tau), axis=0)
        return [
            LawCheck(name, left[:, i], float(size[i]), float(size[i]), log.time)
            for i, name in enumerate(names)
            if np.isfinite(left[:, i]).any()
        ]

    def why_not(self, controlled: Mapping[str, ControlledJoint]) -> str:
        """Return why the cascades of a recording cannot be simulated in closed loop, or ''."""
        names, stretches = self.forward.robot.names, self.stretches
        missing = [name for name in names if name not in controlled]
        if missing:
            return (
                'the closed loop needs the controller and the wanted position of each joint, and '
                f'the recording has none of {", ".join(missing)}'
            )
        if not all(np.isfinite(controlled[name].reference).all() for name in names):
            return 'the wanted position is not known at every sample'
        if len(stretches) != 1 or len(stretches[0].q) != len(self.log):
            return 'the recording has a hole, and a controller remembers what was before it'
        return ''

    def in_driver_loop(self, loop: RecordedLoop, reference: LoopReference) -> RecordedSimulation:
        names, unknown = self.forward.robot.names, undriven(self.stretches[0])
        led = [i for i, name in enumerate(names) if name in loop.followed or i in unknown]
        run = simulate_driver_loop(
            self.forward, self.log, self.stretches, loop, reference, led,
            lambda share: self.step('simulating the closed loop', share),
        )  # fmt: skip
        remarks = [
            f"{name}: the driver's law makes the recorded effort, but for {left:.1f} % of what "
            'its gains add to the feed-forward'
            for name, left in reference.left.items()
        ]
        remarks.append(
            f'the trajectory begins {1e3 * reference.start:.1f} ms after the first sample, found '
            'by that law'
        )
        remarks += [
            f'{names[i]} moves as recorded, because {loop.followed[names[i]]}; --horizon '
            f'{HORIZON_S:g} simulates it by its effort'
            for i in led
            if i not in unknown
        ]
        if len(self.stretches) > 1:
            remarks.append(
                f'the recording has holes: its {len(self.stretches)} stretches are simulated each '
                'from the measured state'
            )
        return self._result(run, run.measured[0][0], led, remarks)

    def in_cascades(
        self, controlled: Mapping[str, ControlledJoint], remarks: Sequence[str]
    ) -> RecordedSimulation:
        log, stretch = self.log, self.stretches[0]
        period, count = stretch.band.step, len(log)
        start = measured_start(stretch, np.zeros(1, dtype=np.int64))
        # The controller sees the first sample itself, and what is smoothed is wrong at the ends.
        first = max(5, round(_START_S / period))
        curve = np.polynomial.polynomial.polyfit(np.arange(first) * period, log.q[:first], 2)
        start.q[0], start.v[0], start.acceleration[0] = log.q[0], curve[1], 2.0 * curve[2]
        drive = CascadeDrive(self.forward, controlled, start.q[0], start.v[0], period)
        effort = np.nanquantile(np.abs(log.tau), 0.99, axis=0)

        def told(k: int) -> None:
            if k % 500 == 0:
                self.step('simulating the closed loop', k / count)

        found = simulate(self.forward, start, drive, period, count, effort, told)
        drive.begin(count - 1, found.q[:, -1])
        refuse_runaway(found.q, 'the closed loop')
        run = RecordedRun(
            log.time,
            (log.q, smooth_velocity(stretch), log.tau),
            (found.q[0], found.v[0], drive.reported()),
            begins_every(count, count),
        )
        return self._result(run, log.q[0], more=remarks)

    def in_windows(self, horizon_s: float, why_not: str) -> RecordedSimulation:
        runs: list[RecordedRun] = []
        origins: list[FloatArray] = []
        for s in self.stretches:
            edge, length = s.band.half, max(2, round(horizon_s / s.band.step))
            at = np.arange(edge, len(s.q) - edge - length, length)
            if not len(at):
                continue

            def told(k: int, length: int = length) -> None:
                if k % 20 == 0:
                    self.step('simulating windows', k / length)

            # The last sample of a window is the first of the next.
            found = simulate_windows(self.forward, s, at, length + 1, told)
            refuse_runaway(found.q, 'a window')
            rows = (at[:, None] + 1 + np.arange(length)).ravel()
            q, v = (x[:, 1:].reshape(len(rows), self.forward.n) for x in (found.q, found.v))
            tau, torque = (s.band.smooth(x, 1.0)[rows] for x in (s.tau, s.torque))
            runs.append(
                RecordedRun(
                    s.time[rows],
                    (s.q[rows], s.v[rows], tau),
                    (q, v, torque),
                    begins_every(length, len(rows)),
                )
            )
            origins.append(np.repeat(s.q[at], length, axis=0))
        if not runs:
            raise DataError(
                f'no stretch of the recording has a window of {horizon_s:g} s without a hole: '
                'give a shorter --horizon or record longer'
            )
        run = RecordedRun.joined(runs)
        origin = np.concatenate(origins)
        return self._result(run, origin, why_not=why_not, horizon_s=horizon_s)

    def _result(
        self,
        run: RecordedRun,
        origin: FloatArray,
        led: Sequence[int] | None = None,
        more: Sequence[str] = (),
        why_not: str = '',
        horizon_s: float | None = None,
    ) -> RecordedSimulation:
        """
        Return the run with its errors, by joint.

        :param origin: where a motion began, (n,) or (N, n): the position's error is relative to
            it.
        :param led: joints that follow the recording, None for those without effort.
        :param horizon_s: length of the windows, None in closed loop.
        """
        forward, first = self.forward, self.stretches[0]
        names, unknown = forward.robot.names, undriven(first)
        followed = tuple(names[i] for i in (unknown if led is None else led))
        errors: dict[str, dict[str, SimulationError]] = {}
        for i, (name, effort) in enumerate(zip(names, forward.robot.effort_units, strict=True)):
            length = 'rad' if effort == 'Nm' else 'm'
            units = (length, f'{length}/s', effort)
            origins: tuple[FloatArray | float, ...] = (origin[..., i], 0.0, 0.0)
            errors[name] = {
                what: SimulationError(np.nan, np.nan, np.nan, unit)
                if name in followed
                else simulation_error(measured[:, i], simulated[:, i], begin, unit)
                for what, measured, simulated, begin, unit in zip(
                    QUANTITIES, run.measured, run.simulated, origins, units, strict=True
                )
            }
        remarks = [
            f'{name} has no friction in the model and is simulated without'
            for name, joint in self.model.joints.items()
            if joint.friction is None and name not in followed
        ]
        remarks += [f'{names[i]} has no effort in the recording and follows it' for i in unknown]
        largest = np.max([np.abs(s.tau).max(axis=0) for s in self.stretches], axis=0)
        return RecordedSimulation(
            CLOSED_LOOP if horizon_s is None else WINDOWS, why_not, horizon_s, names,
            forward.robot.effort_units, run.time,
            dict(zip(QUANTITIES, run.measured, strict=True)),
            dict(zip(QUANTITIES, run.simulated, strict=True)),
            run.begins, errors, followed, forward.displacement,
            forward.steps(np.median(first.q, axis=0), largest, first.band.step),
            (*remarks, *more),
        )  # fmt: skip
