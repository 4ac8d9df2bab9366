# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One unit of work of the study: tune an observer, then score it on other seeds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.observers.search_space import Gains
from sosml_friction.study.condition import Observation
from sosml_friction.study.metrics import SCORED_FROM_S, Score, score
from sosml_friction.study.search import StudyVariant
from sosml_friction.study.tuning import minimise

#: A motion and a condition.
Case = tuple[str, str]
#: By how much the Pareto front varies the bandwidth of an observer.
SWEEP = np.geomspace(0.2, 5.0, 13)
#: How many observations of a case the Pareto front uses.
_SWEEP_SEEDS = 5


@dataclass(frozen=True)
class StudyTask:
    """
    Say what to tune and to score.

    :param tuned_on: groups of observations; the sum over groups of the mean square error over a
        group is minimised, for each joint.
    :param position_noise: what observers that ask for it are told [rad].
    :param swept_on: the case in which the Pareto front is made, if any.
    """

    variant: StudyVariant
    tuned_on: Sequence[Sequence[Observation]]
    scored_on: Mapping[Case, Sequence[Observation]]
    evaluations: int
    position_noise: float
    swept_on: Case | None = None


@dataclass(frozen=True)
class SweepPoint:
    """Hold noise [Nm] and settle time [s] of joint 1 at ``factor`` times the tuned bandwidth."""

    factor: float
    noise_std: float
    settle_s: float


@dataclass(frozen=True)
class TaskResult:
    """Hold the gains found, and per case the scores of each joint."""

    gains: Gains
    scores: dict[Case, list[Score]]
    sweep: list[SweepPoint] = field(default_factory=list)


def run_task(task: StudyTask) -> TaskResult:
    """Tune with exactly the evaluations of the task, and score."""
    observer, space = task.variant
    n = task.tuned_on[0][0].friction.shape[1]

    def objective(points: FloatArray) -> FloatArray:
        gains = task.variant.gains(points, task.position_noise)
        total = np.zeros(n)
        # Gains far off may overflow: what comes out is not finite, and not chosen.
        with np.errstate(over='ignore', invalid='ignore'):
            for group in task.tuned_on:
                for observation in group:
                    estimate = observation.estimate(observer(gains))
                    error = (estimate - observation.friction)[observation.time > SCORED_FROM_S]
                    total += np.mean(error**2, axis=0) / len(group)
        return total

    def scores_of(gains: Gains, case: Case, observations: Sequence[Observation]) -> list[Score]:
        estimates = [observation.estimate(observer(gains)) for observation in observations]
        return [score(observations, estimates, joint, case[1] == 'noise') for joint in range(n)]

    points, _ = minimise(objective, n, len(space.ranges), task.evaluations)
    gains = task.variant.gains(points, task.position_noise)
    # Gains tuned for another case, or swept, may be far off as well.
    with np.errstate(over='ignore', invalid='ignore'):
        scores = {case: scores_of(gains, case, seen) for case, seen in task.scored_on.items()}
        sweep = []
        if task.swept_on is not None:
            seen = task.scored_on[task.swept_on][:_SWEEP_SEEDS]
            for factor in SWEEP.tolist():
                swept = scores_of(space.faster(gains, factor), task.swept_on, seen)
                sweep.append(SweepPoint(factor, swept[0].noise_std, swept[0].settle_s))
    return TaskResult(gains, scores, sweep)
