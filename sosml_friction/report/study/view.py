# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What tables and figures of the study have in common: what is shown, and in which words."""

from __future__ import annotations

import math
from collections.abc import Sequence

from sosml_friction.model.stribeck import Stribeck
from sosml_friction.report.common.drawing import style_of
from sosml_friction.report.common.labels import observer_label
from sosml_friction.study.curve_fit import fit_raw
from sosml_friction.study.metrics import SCORED_FROM_S
from sosml_friction.study.plant import SMOOTHING_VELOCITY
from sosml_friction.study.run import Study, rmse_mean
from sosml_friction.study.search import study_variants
from sosml_friction.study.task import Case

#: The cases whose estimates a friction law is fitted to, as in the paper's Figures 2 and 4.
FITTED: tuple[Case, ...] = (('slow', 'nominal'), ('reversal', 'mismatch'))
#: The two observers of the paper; its first-order one has a cutoff of at most 300 1/s.
_PAPER = ('first_order_capped', 'sosml')
_FEW = 3


def is_causal(name: str) -> bool:
    """Tell whether an observer of the study runs on line."""
    return study_variants()[name].observer.causal


def ranked(study: Study, case: Case, tuning: str = 'case') -> list[str]:
    """Return the observers of a case, that with the smallest RMSE of joint 1 first."""
    known = {
        row.observer: rmse_mean(row.condition, row.scores[0])
        for row in study.rows
        if (row.motion, row.condition, row.tuning) == (*case, tuning)
    }
    # One that is not a number comes last.
    return sorted(known, key=lambda name: (math.isnan(known[name]), known[name]))


def shown_observers(study: Study, case: Case) -> list[str]:
    """
    Return the few that a figure shows: the paper's two and the best causal one of another kind.

    The widest line is the first, so that it lies under the others.
    """
    chosen = [name for name in _PAPER if name in study.settings.observers]
    for name in ranked(study, case):
        kinds = {study_variants()[other].observer for other in chosen}
        observer = study_variants()[name].observer
        if len(chosen) < _FEW and observer not in kinds and observer.causal:
            chosen.append(name)
    return sorted(chosen, key=lambda name: -style_of(name, 0).width)


def fitted_laws(study: Study, case: Case, observers: Sequence[str]) -> dict[str, Stribeck]:
    """Return by observer the law through its estimates of joint 1, from 0.5 s on."""
    observation = study.observations[case]
    kept = observation.time > SCORED_FROM_S
    v = observation.velocity[kept, 0]
    return {
        name: fit_raw(v, study.estimate(study.row(case, name))[kept, 0], SMOOTHING_VELOCITY)
        for name in observers
    }


def case_text(case: Case) -> str:
    """Return a case as a person reads it."""
    return f'{case[0]}, {case[1]}'


def findings(study: Study) -> list[str]:
    """Return what the noisy cases say, a sentence each; joint 1, tuned per case."""
    sentences = []
    for case in study.observations:
        if case[1] != 'noise':
            continue
        values = {
            name: 1e3 * rmse_mean('noise', study.row(case, name).scores[0])
            for name in ranked(study, case)
        }
        causal = [name for name in values if is_causal(name)]
        offline = [name for name in values if not is_causal(name)]
        parts = []
        if causal:
            best = causal[0]
            parts.append(
                f'the best causal observer is {observer_label(best)} ({values[best]:.1f} mNm)'
            )
        if offline:
            parts.append(
                f'off line, {observer_label(offline[0])} leaves {values[offline[0]]:.1f} mNm'
            )
        for rival in ('first_order_capped', 'linear_second_order'):
            if rival in values and 'sosml' in values:
                ratio = values['sosml'] / values[rival]
                parts.append(f'SOSML has {ratio:.2f} times the RMSE of {observer_label(rival)}')
        sentences.append(f'{case[0].capitalize()} with noise: ' + '; '.join(parts) + '.')
    noisy = [case for case in study.observations if case[1] == 'noise']
    shared = {
        name: 1e3
        * math.hypot(*(rmse_mean('noise', study.row(c, name, 'shared').scores[0]) for c in noisy))
        for name in study.settings.observers
        if len(noisy) > 1 and is_causal(name)
    }
    if shared:
        best = min(shared, key=lambda name: shared[name])
        sentences.append(
            'With one gain set for both noisy motions the best causal observer is '
            f'{observer_label(best)}: root of the sum of squares {shared[best]:.0f} mNm.'
        )
    return sentences
