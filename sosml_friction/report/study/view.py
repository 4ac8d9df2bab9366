# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the tables, figures and sentences of a study show."""

from sosml_friction.report.common.drawing import style_of
from sosml_friction.report.common.labels import observer_label
from sosml_friction.study.outcome import is_causal, ranked, shared_errors
from sosml_friction.study.run import Study, rmse_mean
from sosml_friction.study.search import study_variants
from sosml_friction.study.task import Case

#: The two observers of the paper; its first-order one has a cutoff of at most 300 1/s.
_PAPER = ('first_order_capped', 'sosml')
_FEW = 3


def shown_observers(study: Study, case: Case) -> list[str]:
    """
    Return the few that a figure shows: the paper's two and the best causal one of another kind.

    The widest line is the first, so that it lies under the others. None of a case not run.
    """
    if case not in study.observations:
        return []
    chosen = [name for name in _PAPER if name in study.settings.observers]
    for name in ranked(study, case):
        kinds = {study_variants()[other].observer for other in chosen}
        observer = study_variants()[name].observer
        if len(chosen) < _FEW and observer not in kinds and observer.causal:
            chosen.append(name)
    return sorted(chosen, key=lambda name: -style_of(name, 0).width)


def case_text(case: Case) -> str:
    """Return a case as a person reads it."""
    return f'{case[0]}, {case[1]}'


def findings(study: Study) -> list[str]:
    """Return what the noisy cases say, a sentence each; joint 1, tuned per case."""
    sentences = []
    for case in study.observations:
        if case[1] != 'noise':
            continue
        errors = {
            name: 1e3 * rmse_mean('noise', study.row(case, name).scores[0])
            for name in ranked(study, case)
        }
        causal = next((name for name in errors if is_causal(name)), None)
        offline = next((name for name in errors if not is_causal(name)), None)
        parts = []
        if causal is not None:
            best = observer_label(causal)
            parts.append(f'the best causal observer is {best} ({errors[causal]:.1f} mNm)')
        if offline is not None:
            parts.append(f'off line, {observer_label(offline)} leaves {errors[offline]:.1f} mNm')
        for rival in ('first_order_capped', 'linear_second_order'):
            if rival in errors and 'sosml' in errors:
                ratio = errors['sosml'] / errors[rival]
                parts.append(f'SOSML has {ratio:.2f} times the RMSE of {observer_label(rival)}')
        sentences.append(f'{case[0].capitalize()} with noise: ' + '; '.join(parts) + '.')
    shared = shared_errors(study)
    if shared:
        name = min(shared, key=lambda name: shared[name])
        sentences.append(
            'With one gain set for both noisy motions the best causal observer is '
            f'{observer_label(name)}: root of the sum of squares {1e3 * shared[name]:.0f} mNm.'
        )
    return sentences
