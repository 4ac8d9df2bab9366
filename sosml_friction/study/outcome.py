# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a study says: which observers are best, and the laws that their estimates follow."""

import math
from collections.abc import Sequence

from sosml_friction.model.laws import FrictionLaw
from sosml_friction.study.curve_fit import fit_raw
from sosml_friction.study.metrics import SCORED_FROM_S
from sosml_friction.study.plant import SMOOTHING_VELOCITY
from sosml_friction.study.run import Study, rmse_mean
from sosml_friction.study.search import study_variants
from sosml_friction.study.task import Case

#: The cases whose estimates a friction law is fitted to, as in the paper's Figures 2 and 4.
FITTED: tuple[Case, ...] = (('slow', 'nominal'), ('reversal', 'mismatch'))


def is_causal(name: str) -> bool:
    """Tell whether an observer of the study runs on line."""
    return study_variants()[name].observer.causal


def ranked(study: Study, case: Case) -> list[str]:
    """Return the observers of a case, that with the smallest RMSE of joint 1 first."""
    known = {
        row.observer: rmse_mean(row.condition, row.scores[0])
        for row in study.rows
        if (row.motion, row.condition, row.tuning) == (*case, 'case')
    }
    # One that is not a number comes last.
    return sorted(known, key=lambda name: (math.isnan(known[name]), known[name]))


def fitted_laws(study: Study, case: Case, observers: Sequence[str]) -> dict[str, FrictionLaw]:
    """Return by observer the law through its estimates of joint 1, from 0.5 s on."""
    observation = study.observations[case]
    kept = observation.time > SCORED_FROM_S
    v = observation.velocity[kept, 0]
    return {
        name: fit_raw(v, study.estimate(study.row(case, name))[kept, 0], SMOOTHING_VELOCITY)
        for name in observers
    }


def shared_errors(study: Study) -> dict[str, float]:
    """
    Return the error of each causal observer with one gain set for all noisy motions [Nm].

    The root of the sum of squares over the motions, joint 1; empty with fewer than two motions.
    """
    noisy = [case for case in study.observations if case[1] == 'noise']
    return {
        name: math.hypot(
            *(rmse_mean('noise', study.row(c, name, 'shared').scores[0]) for c in noisy)
        )
        for name in study.settings.observers
        if len(noisy) > 1 and is_causal(name)
    }
