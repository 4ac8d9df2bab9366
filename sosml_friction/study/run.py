# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The paper's simulation study: motions x conditions x observers, every observer tuned equally well.

Each observer is tuned twice over. ``case``: for each motion and condition on its own, which shows
what it can do. ``shared``: one gain set for both motions with noise, the sum of their mean square
errors minimised, which shows what it does for a user who sets gains once. Every tuning takes the
same number of evaluations. Gains are tuned on the noise of other seeds than they are scored on;
without noise there is one signal, on which both happens.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.study.condition import CONDITIONS, Observation, encoder_noise, observe
from sosml_friction.study.metrics import SCORED_FROM_S, Score
from sosml_friction.study.motion import MOTIONS
from sosml_friction.study.parallel import available_cores, run_all, workers
from sosml_friction.study.plant import PLANT_STEP, simulate, study_robot
from sosml_friction.study.search import study_variants
from sosml_friction.study.task import Case, StudyTask, SweepPoint, run_task

#: The noise of tuning starts at this seed; that of scoring is 1, 2, ... and stays below.
FIRST_TUNING_SEED = 101
#: What observers are told of the noise where there is none, in that of the encoder: with none at
#: all their equations have no solution.
_WITHOUT_NOISE = 0.01
#: What a first look does with less, as settings.
QUICK: Mapping[str, Any] = {'evaluations': 24, 'seeds': 2, 'tuning_seeds': 1, 'plant_step': 200e-6}
#: Where the Pareto front of noise against settle time is made.
SWEPT = ('reversal', 'noise')


@dataclass(frozen=True)
class StudySettings:
    """
    Choose the extent of the study.

    :param observers: names of :func:`~sosml_friction.study.search.study_variants`.
    :param seeds: noise seeds 1..seeds are scored, 1 to 100.
    :param tuning_seeds: noise seeds 101.. are averaged in tuning, 1 to 100.
    :param evaluations: gain sets tried in each tuning, 4 to 100000.
    :param bits: resolution of the encoders, 8 to 24 bits per turn.
    :param plant_step: [s].
    :raises ConfigurationError: if a name is unknown or given twice, or a number is out of range.
    """

    motions: Sequence[str] = tuple(MOTIONS)
    conditions: Sequence[str] = CONDITIONS
    observers: Sequence[str] = field(default_factory=lambda: tuple(study_variants()))
    seeds: int = 5
    tuning_seeds: int = 2
    evaluations: int = 300
    bits: int = 16
    plant_step: float = PLANT_STEP

    def __post_init__(self) -> None:
        for what, chosen, known in (
            ('motion', self.motions, tuple(MOTIONS)),
            ('condition', self.conditions, CONDITIONS),
            ('observer', self.observers, tuple(study_variants())),
        ):
            unknown = [name for name in chosen if name not in known]
            if unknown:
                raise ConfigurationError(
                    f'{what} {unknown[0]!r} is not in the study: use {", ".join(known)}'
                )
            if not chosen or len(set(chosen)) != len(chosen):
                raise ConfigurationError(
                    f'the {what}s are {", ".join(chosen) or "none"}: give each one once, at least '
                    'one'
                )
        for what, number, low, high in (
            ('seeds', self.seeds, 1, FIRST_TUNING_SEED - 1),
            ('tuning seeds', self.tuning_seeds, 1, 100),
            ('evaluations', self.evaluations, 4, 100_000),
            ('bits', self.bits, 8, 24),
        ):
            if not low <= number <= high:
                raise ConfigurationError(f'the number of {what} is {number}: use {low} to {high}')

    @property
    def scoring(self) -> range:
        """Return the noise seeds that are scored."""
        return range(1, self.seeds + 1)

    @property
    def tuning(self) -> range:
        """Return the noise seeds of tuning, none of which is scored."""
        return range(FIRST_TUNING_SEED, FIRST_TUNING_SEED + self.tuning_seeds)


@dataclass(frozen=True)
class StudyRow:
    """
    Hold the scores of an observer in one case, one for each joint.

    ``tuning`` is ``case`` or ``shared``; ``gains`` has one value for each joint.
    """

    motion: str
    condition: str
    observer: str
    tuning: str
    gains: dict[str, list[float]]
    scores: list[Score]


@dataclass(frozen=True)
class Study:
    """
    Hold what the study found.

    :param rows: by motion, condition, tuning and observer, in the order of the settings.
    :param observations: the first that was scored in each case.
    :param floors: per case the RMSE (n,) [Nm] of an ideal observer with the same model.
    :param sweeps: per observer the points of the Pareto front, slow to fast.
    """

    settings: StudySettings
    joints: tuple[str, ...]
    rows: list[StudyRow]
    observations: dict[Case, Observation]
    floors: dict[Case, FloatArray]
    sweeps: dict[str, list[SweepPoint]]

    def row(self, case: Case, observer: str, tuning: str = 'case') -> StudyRow:
        """Return one row."""
        wanted = (*case, observer, tuning)
        (row,) = [r for r in self.rows if (r.motion, r.condition, r.observer, r.tuning) == wanted]
        return row

    def estimate(self, row: StudyRow) -> FloatArray:
        """Return tau_f (N, n) [Nm] that a row's observer says of the observation of its case."""
        observer = study_variants()[row.observer].observer(row.gains)
        return self.observations[row.motion, row.condition].estimate(observer)


def rmse_mean(condition: str, score: Score) -> float:
    """Return the mean RMSE over the seeds; in ``mismatch``, where M is scaled, the rms of all."""
    if condition == 'mismatch':
        return float(np.sqrt(np.mean(score.rmse**2)))
    return float(np.mean(score.rmse))


def run_study(
    settings: StudySettings,
    processes: int | None = None,
    progress: Callable[[str, float], None] = lambda what, share: None,
) -> Study:
    """Run the study. The result does not depend on the number of processes."""
    count = available_cores() if processes is None else processes
    with workers(count) as pool:
        progress('simulating the motions', 0.0)
        prepared = run_all(pool, _prepare, [(name, settings) for name in settings.motions])
        tuned_on = {case: pair[0] for cases in prepared for case, pair in cases.items()}
        scored_on = {case: pair[1] for cases in prepared for case, pair in cases.items()}
        plan = _plan(settings, tuned_on, scored_on)
        known = list(study_variants())
        # The last observers are the slowest: they come first, so that none is left at the end.
        plan.sort(key=lambda planned: -known.index(planned[0]))
        results = run_all(
            pool,
            run_task,
            [task for _, _, task in plan],
            lambda done: progress(f'tuning and scoring, {done} of {len(plan)}', done / len(plan)),
        )
    rows, sweeps = [], {}
    for (name, tuning, _), result in zip(plan, results, strict=True):
        for (motion, condition), scores in result.scores.items():
            rows.append(StudyRow(motion, condition, name, tuning, result.gains, scores))
        if result.sweep:
            sweeps[name] = result.sweep
    rows.sort(
        key=lambda row: (
            settings.motions.index(row.motion),
            settings.conditions.index(row.condition),
            row.tuning,
            settings.observers.index(row.observer),
        )
    )
    return Study(
        settings,
        study_robot().names,
        rows,
        {case: observations[0] for case, observations in scored_on.items()},
        {case: _floor(observations) for case, observations in scored_on.items()},
        {name: sweeps[name] for name in settings.observers if name in sweeps},
    )


def _plan(
    settings: StudySettings,
    tuned_on: dict[Case, list[Observation]],
    scored_on: dict[Case, list[Observation]],
) -> list[tuple[str, str, StudyTask]]:
    """Return (observer, tuning, task) of everything there is to do."""
    noise = encoder_noise(settings.bits)
    plan = []
    noisy = [tuned_on[case] for case in tuned_on if case[1] == 'noise']
    for name in settings.observers:
        variant = study_variants()[name]
        for case, observations in tuned_on.items():
            task = StudyTask(
                variant,
                [observations],
                {case: scored_on[case]},
                settings.evaluations,
                noise if case[1] == 'noise' else _WITHOUT_NOISE * noise,
                case if case == SWEPT else None,
            )
            plan.append((name, 'case', task))
        if len(noisy) > 1:
            task = StudyTask(variant, noisy, scored_on, settings.evaluations, noise)
            plan.append((name, 'shared', task))
    return plan


def _prepare(
    task: tuple[str, StudySettings],
) -> dict[Case, tuple[list[Observation], list[Observation]]]:
    """Simulate a motion and return by case what is tuned and what is scored on."""
    name, settings = task
    motion, robot = MOTIONS[name], study_robot()
    run = simulate(robot, motion.reference, motion.duration, settings.plant_step)
    prepared = {}
    for condition in settings.conditions:
        tuned_on = observe(run, robot, condition, settings.bits, settings.tuning)
        scored_on = tuned_on
        if condition == 'noise':
            scored_on = observe(run, robot, condition, settings.bits, settings.scoring)
        prepared[name, condition] = tuned_on, scored_on
    return prepared


def _floor(observations: Sequence[Observation]) -> FloatArray:
    squares = [
        np.mean(observation.floor[observation.time > SCORED_FROM_S] ** 2, axis=0)
        for observation in observations
    ]
    return np.asarray(np.sqrt(np.mean(squares, axis=0)))
