# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a candidate has to exceed to be named, and its floor from null simulations."""

from itertools import islice

import numpy as np

from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.diagnosis.decision.null_recordings import null_recordings
from sosml_friction.regression.evidence import CandidateColumns, Fit
from sosml_friction.regression.whitened import WhitenedRegression


def candidate_floor(
    laboratory: WhitenedRegression,
    fit: Fit,
    best: Finding,
    columns: CandidateColumns,
    generation: int,
) -> float:
    """
    Return the gain on data left out that a candidate has to exceed: the larger of two.

    ``floor (1 + ln g)``: what may choose among the g points of a grid has to explain more;
    ``floor_margin`` times its largest gain in null simulations.

    :param fit: of the causes that are accepted already, which the null simulations hold.
    :param columns: of the candidate over its grid.
    :param generation: how many causes are accepted, for the seed.
    """
    settings = laboratory.settings
    # What the candidate explains is not held for friction that turns around in another way.
    beside = fit.system.extended([best.columns])
    seed = [settings.seed, generation]
    nulls = null_recordings(laboratory, fit.system, fit.baseline.x, beside, seed)
    most = max(
        Fit.make(fit.system, y).score(columns).cv_gain for y in islice(nulls, settings.nulls)
    )
    choice = 1.0 + float(np.log(columns.C.shape[2]))
    return max(settings.floor * choice, settings.floor_margin * most)


def failed_gates(finding: Finding, known: bool = False) -> tuple[str, ...]:
    """
    Return what speaks against naming a finding.

    :param known: its effect is named in this joint already, and this is another harmonic: it has
        to gain over all folds, but one may lack the part of the turn that shows it.
    """
    s = finding.score
    failed = []
    if finding.objection:
        failed.append(finding.objection)
    if not s.cv_gain > finding.floor:
        failed.append(
            f'it removes {100 * s.cv_gain:.1f} % of what is unexplained on data left out, '
            f'within the floor of {100 * finding.floor:.1f} %'
        )
    if s.cv_gain < s.cv_se and not known:
        failed.append('the gain is within its standard error over the folds')
    return tuple(failed)
