# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Which method tells friction best, from which trajectory: errors, coverage and flags over seeds.

The shoulder of the study's arm moves along the package's trajectories while the elbow is held, by
computed torque that knows no friction; its own friction is C 0.80, B 0.35, S 0.50, v_s 0.030 and
a bias of 0.10. It is seen by an encoder of 16 bit with noise of half a count, at 1 kHz, without a
velocity, and an effort with 50 mNm of white noise. Observers have the gains that ``sosml fit
--observers`` gives them, measured on noise of a seed that is not scored. Each cell is mean error
(standard deviation over seeds), then the share of seeds in which the 95 % interval has the truth,
all of those in which the parameter is not flagged as not identifiable; f: the share in which it is
flagged. Run with ``make identification``: 5 seeds, ten minutes on one core;
``SOSML_FRICTION_SEEDS=40`` for more of them.
"""

from __future__ import annotations

import os
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import DataError
from sosml_friction.identification.friction_fit import (
    WEAK_FORM,
    FitSettings,
    FrictionFit,
    JointFit,
    fit_friction,
)
from sosml_friction.identification.inverse_model import fit_inverse_model
from sosml_friction.identification.output_error.fits import first_guess
from sosml_friction.identification.output_error.windows import fit_windows
from sosml_friction.identification.several.bag_roles import BagRole
from sosml_friction.identification.several.consolidation import consolidate
from sosml_friction.identification.weak_form import WeakForm
from sosml_friction.model.laws import make_friction_law
from sosml_friction.model.parameter import NOT_IDENTIFIABLE, Parameter
from sosml_friction.model.robot import Robot
from sosml_friction.motion.trajectories import build_trajectory
from sosml_friction.observers.conditions import Conditions
from sosml_friction.observers.friction_estimator import FrictionEstimator
from sosml_friction.observers.log_conditions import measure_conditions
from sosml_friction.observers.recipe import gains_for_conditions
from sosml_friction.observers.registry import make_observer
from sosml_friction.report.common.labels import observer_label
from sosml_friction.report.common.table import terminal_table
from sosml_friction.study.condition import read_by_encoder
from sosml_friction.study.mismatched_robot import MismatchedRobot
from sosml_friction.study.motion import POSTURE, Reference
from sosml_friction.study.parallel import available_cores, run_all, workers
from sosml_friction.study.plant import (
    ARMATURE,
    JOINTS,
    SMOOTHING_VELOCITY,
    TRUTH,
    simulate,
    study_robot,
    study_urdf,
)

FloatArray = NDArray[np.float64]

SEEDS = int(os.environ.get('SOSML_FRICTION_SEEDS', '5'))
#: Noise of the seed that gains are measured on.
TUNING_SEED = 1001
BITS, TORQUE_NOISE, BIAS = 16, 0.05, 0.10
JOINT = 'shoulder'
KNOWN = {**TRUTH[0], 'bias': BIAS}
#: Parameter, its column and what errors are printed in.
COLUMNS = (
    ('coulomb', 'C', 'mNm', 1e3),
    ('viscous', 'B', 'mNm s', 1e3),
    ('stribeck', 'S', 'mNm', 1e3),
    ('stribeck_velocity', 'v_s', 'mrad/s', 1e3),
    ('bias', 'bias', 'mNm', 1e3),
)
#: What is recorded: the trajectory, its options, and its part in the paper's rule.
RECORDINGS: Mapping[str, tuple[str, dict[str, Any], str]] = {
    'T1': ('speed_ladder', {}, 'T1'),
    'T2': ('symmetric_reversals', {}, 'T2'),
    'T3': ('slow_ladder', {}, 'T3'),
    'multisine': ('multisine', {}, ''),
    'rich': ('rich', {'speeds': (0.03, 0.4), 'cycles': 4.0, 'period': 8.0}, ''),
}
#: Change of the elbow's friction at a reversal [Nm]: held, it shows none.
ELBOW_JUMP = 1.1
#: What is fitted together.
TOGETHER = 'T1+T2+T3'
OBSERVERS = ('first_order', 'sosml', 'kalman', 'kalman_stribeck', 'smoother')
#: Forward simulation takes as long as all others together: on these only.
OUTPUT_ERROR_ON = ('T1',)
#: The plant is integrated at a quarter of the sampling interval: v0 asks for less than 1.6 ms.
_PLANT_STEP = 250e-6
#: Errors of the model in the mismatch run: factor on M, offsets of gravity [Nm].
_WRONG = (1.1, (0.1, 0.05))
_MISMATCH_SEEDS = 3


@dataclass(frozen=True)
class Entry:
    """Hold one fit: parameters by name, and what it took [s]."""

    parameters: Mapping[str, Parameter] | None
    seconds: float


@dataclass(frozen=True)
class Seen:
    """Hold what observers make of a recording, the regression of the weak form, and time [s]."""

    log: JointLog
    estimates: Mapping[str, FloatArray]
    seconds: Mapping[str, float]
    form: WeakForm


#: By (data, method), one entry.
Run = dict[tuple[str, str], Entry]


def truth(name: str) -> JointLog:
    """Return the exact signals of a recording."""
    kind, options, _ = RECORDINGS[name]
    at = dict(zip(JOINTS, POSTURE.tolist(), strict=True))
    trajectory = build_trajectory(kind, at, at, {**options, 'scale': (1.0, 0.0)})
    splines = [trajectory.spline().derivative(k) if k else trajectory.spline() for k in range(3)]

    def reference(t: float) -> Reference:
        return Reference(*(spline(min(t, trajectory.duration)) for spline in splines))

    laws = [
        make_friction_law('stribeck', {**own, 'bias': BIAS if i == 0 else 0.0}, SMOOTHING_VELOCITY)
        for i, own in enumerate(TRUTH)
    ]
    return simulate(study_robot(), reference, trajectory.duration, _PLANT_STEP, laws).log


def measured(exact: JointLog, seed: int) -> JointLog:
    """Return what is measured of exact signals; the elbow, which is held, reports no effort."""
    log = read_by_encoder(exact, BITS, seed)
    noise = np.random.default_rng([seed, 1]).normal(0.0, TORQUE_NOISE, log.tau.shape)
    return replace(log, tau=log.tau + noise * [1.0, np.nan])


def gains(exact: JointLog) -> dict[str, dict[str, list[float]]]:
    """Return gains by what is measured in a recording; of the elbow, which is held, stated."""
    log = read_by_encoder(exact, BITS, TUNING_SEED)
    noise = np.random.default_rng([TUNING_SEED, 1]).normal(0.0, TORQUE_NOISE, log.tau.shape)
    robot = study_robot()
    found = measure_conditions(replace(log, tau=log.tau + noise), robot)
    conditions = Conditions.of(
        robot,
        found.posture,
        found.position_noise.tolist(),
        found.velocity_noise.tolist(),
        [float(found.friction_jump[0]), ELBOW_JUMP],
        [float(found.reversal_time[0])] * 2,
        [float(found.top_speed[0])] * 2,
    )
    recipe = gains_for_conditions(conditions)
    return {name: recipe[name] for name in OBSERVERS}


def wrong_robot() -> Robot:
    """Return a model with 10 % more inertia and 0.1 Nm more gravity than the arm."""
    return MismatchedRobot(study_urdf(), JOINTS, ARMATURE, *_WRONG)


@contextmanager
def timed() -> Iterator[Callable[[], float]]:
    """Yield a clock of this process's own time, which neighbours do not slow."""
    begin = time.process_time()
    yield lambda: time.process_time() - begin


def seen(log: JointLog, robot: Robot, own_gains: Mapping[str, Mapping[str, list[float]]]) -> Seen:
    """Run the observers over a recording, and make the regression of the weak form."""
    # Made before the clock starts: it compiles.
    observers = [make_observer(name, own) for name, own in own_gains.items()]
    estimator = FrictionEstimator(robot, observers, 'start', 'position_difference')
    with timed() as spent:
        stretches = estimator.stretches(log)
        shared = spent()
    estimates, seconds = {}, {}
    for name, observer in estimator.observers.items():
        with timed() as spent:
            tau_f = np.full((len(log), robot.n), np.nan)
            for stretch in stretches:
                observer.start(stretch.p_start)
                tau_f[stretch.rows] = -observer.run(stretch.samples)
            estimates[name], seconds[name] = tau_f, shared + spent()
    with timed() as spent:
        form = WeakForm(log, robot, 'start')
        seconds[WEAK_FORM] = spent()
    return Seen(log, estimates, seconds, form)


def fits_of(
    found: Seen, robot: Robot, own_gains: Mapping[str, Mapping[str, list[float]]]
) -> dict[str, tuple[FrictionFit, float]]:
    """Return fits of a recording by method, with the time of each, observer included."""
    fits: dict[str, tuple[FrictionFit, float]] = {}
    for name, tau_f in found.estimates.items():
        observer = make_observer(name, own_gains[name])
        for method in ('segments', 'samples') if name == 'sosml' else ('segments',):
            with timed() as spent:
                settings = FitSettings(method=method)
                fit = fit_friction(
                    found.log,
                    {name: tau_f},
                    robot,
                    {name: observer},
                    settings,
                    require=False,
                )
                label = f'{method}, {observer_label(name)}'
                fits[label] = fit, found.seconds[name] + spent()
    for label, v0 in (('weak form', None), ('weak form, v0 known', SMOOTHING_VELOCITY)):
        with timed() as spent:
            fit = weak_fit(found.form, v0)
            fits[label] = fit, found.seconds[WEAK_FORM] + spent()
    return fits


def weak_fit(form: WeakForm, v0: float | None) -> FrictionFit:
    """Return the joint's fit by the weak form alone, the width of the sign found or known."""
    i = JOINTS.index(JOINT)
    try:
        rows, weak = form.rows(i, v0), form.fit(i, v0)
    except DataError as error:
        return FrictionFit({}, {}, {JOINT: str(error)})
    own = JointFit(WEAK_FORM, 'weak', 'Nm', weak.fit, (), np.zeros(0))
    return FrictionFit({JOINT: {WEAK_FORM: own}}, {}, {}, {JOINT: {WEAK_FORM: rows}})


def inverse_entry(log: JointLog, robot: Robot) -> Entry:
    """Return the fit of the inverse model, which has no Stribeck term; its filter at 20 Hz."""
    with timed() as spent:
        fits = fit_inverse_model(log, robot, cutoff=20.0).joints.get(JOINT)
        return Entry(fits['symmetric'].parameters if fits else None, spent())


def output_error_entry(log: JointLog, robot: Robot, first: FrictionFit) -> Entry:
    """Return the fit of a simulation that the measured effort drives, from another fit."""
    known = list(first.joints.get(JOINT, {}).values())
    with timed() as spent:
        try:
            start = first_guess(robot, JOINTS.index(JOINT), known[0].fit.parameters)
            found = fit_windows(log, robot, JOINTS.index(JOINT), start, SMOOTHING_VELOCITY)
        except (DataError, IndexError):
            return Entry(None, spent())
        return Entry(found.parameters, spent())


def entry_of(fit: FrictionFit, seconds: float) -> Entry:
    """Return the only fit of the joint."""
    fits = list(fit.joints.get(JOINT, {}).values())
    return Entry(fits[0].fit.parameters if fits else None, seconds)


def together(parts: Mapping[str, tuple[FrictionFit, float]]) -> Entry:
    """Return what recordings say together, by the way that ``sosml fit`` prefers."""
    observer = next((o for fit, _ in parts.values() for o in fit.rows.get(JOINT, {})), '')
    roles = {name: BagRole(RECORDINGS[name][2], 'stated', 'stated') for name in parts}
    with timed() as spent:
        try:
            found = consolidate(
                JOINT, observer, 'Nm', {name: fit for name, (fit, _) in parts.items()}, roles
            )
            parameters = dict(found.parameters) or None
        except DataError:
            parameters = None
        return Entry(parameters, spent() + sum(seconds for _, seconds in parts.values()))


def run_seed(task: tuple[int, Mapping[str, tuple[JointLog, Any]], bool]) -> Run:
    """Return every fit of one seed of noise; with a wrong model, of the three ladders only."""
    seed, recordings, wrong = task
    robot = wrong_robot() if wrong else study_robot()
    made = {
        name: seen(measured(exact, 100 * seed + k), robot, own_gains)
        for k, (name, (exact, own_gains)) in enumerate(recordings.items())
    }
    return fit_all(made, robot, {name: own for name, (_, own) in recordings.items()})


def fit_all(made: Mapping[str, Seen], robot: Robot, own_gains: Mapping[str, Any]) -> Run:
    """Return every fit of what was seen of the recordings, alone and together."""
    run: Run = {}
    parts: dict[str, dict[str, tuple[FrictionFit, float]]] = defaultdict(dict)
    for name, found in made.items():
        fits = fits_of(found, robot, own_gains[name])
        for method, (fit, seconds) in fits.items():
            run[name, method] = entry_of(fit, seconds)
            if name in TOGETHER.split('+'):
                parts[method][name] = fit, seconds
        run[name, 'inverse model'] = inverse_entry(found.log, robot)
        first = fits['segments, SOSML'][0]
        if name in OUTPUT_ERROR_ON:
            run[name, 'output error, v0 known'] = output_error_entry(found.log, robot, first)
    for method, its_parts in parts.items():
        run[TOGETHER, method] = together(its_parts)
    return run


def cell(parameters: Sequence[Parameter | None], name: str, scale: float) -> str:
    """Return mean error (sd), coverage and share flagged of one parameter over seeds."""
    if all(p is None for p in parameters):
        return '-'
    flagged = [p is None or NOT_IDENTIFIABLE in p.flags or not np.isfinite(p.value)
               for p in parameters]  # fmt: skip
    told = [p for p, flag in zip(parameters, flagged, strict=True) if p is not None and not flag]
    share = f'f{100 * np.mean(flagged):.0f}' if any(flagged) else ''
    if not told:
        return share
    errors = scale * (np.array([p.value for p in told]) - KNOWN[name])
    inside = [p.interval is not None and p.interval[0] <= KNOWN[name] <= p.interval[1]
              for p in told]  # fmt: skip
    spread = f' ({np.std(errors, ddof=1):.2g})' if len(told) > 1 else ''
    return f'{np.mean(errors):+.2g}{spread} {100 * np.mean(inside):.0f}% {share}'.strip()


def print_table(title: str, runs: Sequence[Run], data: str) -> None:
    """Print the methods on one set of data."""
    methods = list(dict.fromkeys(method for run in runs for d, method in run if d == data))
    seconds = {m: float(np.median([run[data, m].seconds for run in runs])) for m in methods}
    fastest = min(seconds.values())
    columns = {title: 'w', **{f'{c} [{unit}]': 'w' for _, c, unit, _ in COLUMNS}, 'time': 'n w'}
    rows = []
    for method in methods:
        entries = [run[data, method].parameters or {} for run in runs]
        cells = [
            cell([parameters.get(name) for parameters in entries], name, scale)
            for name, _, _, scale in COLUMNS
        ]
        rows.append([method, *cells, f'{seconds[method] / fastest:.3g}'])
    Console(width=140, highlight=False).print(terminal_table(columns, rows))


def print_mismatch(right: Sequence[Run], wrong: Sequence[Run]) -> None:
    """Print by how much each estimate moves when the model is wrong, on the same noise."""
    columns = {f'{TOGETHER}, M +10 %, g +0.1 Nm: change': 'w'}
    columns |= {f'{column} [{unit}]': 'w' for _, column, unit, _ in COLUMNS}
    rows = []
    methods = [method for data, method in right[0] if data == TOGETHER]
    for method in methods:
        cells = []
        for name, _, _, scale in COLUMNS:
            changes = [
                scale * (b.value - a.value)
                for one, other in zip(right, wrong, strict=False)
                if (a := (one[TOGETHER, method].parameters or {}).get(name)) is not None
                and (b := (other[TOGETHER, method].parameters or {}).get(name)) is not None
                and np.isfinite(a.value)
                and np.isfinite(b.value)
            ]
            sd = f' ({np.std(changes, ddof=1):.2g})' if len(changes) > 1 else ''
            cells.append(f'{np.mean(changes):+.2g}{sd}' if changes else '-')
        rows.append([method, *cells])
    Console(width=140, highlight=False).print(terminal_table(columns, rows))


def main() -> None:
    """Print a table for each set of data, and what a wrong model changes."""
    with workers(available_cores()) as pool:
        exact = dict(zip(RECORDINGS, run_all(pool, truth, list(RECORDINGS)), strict=True))
        made = run_all(pool, gains, list(exact.values()))
        recordings = {name: (exact[name], g) for name, g in zip(exact, made, strict=True)}
        ladders = {name: recordings[name] for name in TOGETHER.split('+')}
        few = min(SEEDS, _MISMATCH_SEEDS)
        tasks = [(seed, recordings, False) for seed in range(1, SEEDS + 1)]
        tasks += [(seed, ladders, True) for seed in range(1, few + 1)]
        runs = run_all(pool, run_seed, tasks)
    print(
        f'{SEEDS} seeds, {BITS} bit, {1e3 * TORQUE_NOISE:.0f} mNm: mean error (sd) coverage of '
        '95 % intervals; f: flagged [%]; time: of the fastest, observer included'
    )
    for data in (*RECORDINGS, TOGETHER):
        seconds = sum(exact[name].time[-1] for name in data.split('+'))
        print_table(f'{data}, {seconds:.0f} s', runs[:SEEDS], data)
    print(f'The model is wrong: {few} seeds, mean change (sd)')
    print_mismatch(runs[:few], runs[SEEDS:])


if __name__ == '__main__':
    main()
