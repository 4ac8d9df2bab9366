# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a study says: which observers are best, and the laws that their estimates follow."""

import math
from collections.abc import Sequence

import numpy as np
from scipy.optimize import lsq_linear, minimize_scalar

from sosml_friction.arrays import FloatArray
from sosml_friction.model.laws import FrictionLaw, make_friction_law
from sosml_friction.model.smooth_sign import smooth_sign
from sosml_friction.model.terms.kinds.fading_term import fade
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


#: Where v_s is searched [rad/s].
_LOWEST, _HIGHEST = 1e-3, 1.0


def fit_raw(v: FloatArray, tau_f: FloatArray, smoothing_velocity: float) -> FrictionLaw:
    """
    Fit tau_f = s(v) (C + S exp(-|v| / v_s)) + B v + bias by least squares, C, B, S >= 0.

    As in the paper every sample counts, lag and all: this shows what an observer does to the
    friction map. To identify friction, use
    :mod:`~sosml_friction.identification.law.law_search`, which allows for the lag. For a given v_s
    the law is linear; v_s is searched from 0.001 to 1 rad/s.

    :param v: true velocity (N,) [rad/s].
    :param tau_f: what the observer says (N,) [Nm].
    :param smoothing_velocity: v0 of the law [rad/s], known.
    """
    lowest = [0.0, 0.0, 0.0, -np.inf]
    sign = smooth_sign(v, smoothing_velocity)

    def solve(v_s: float) -> tuple[float, FloatArray]:
        X = np.column_stack([sign, v, sign * fade(v, v_s, 1.0), np.ones_like(v)])
        # The bounds need only the triangle, as the samples are many and the columns few.
        Q, R = np.linalg.qr(X)
        found = lsq_linear(R, Q.T @ tau_f, bounds=(lowest, np.inf), method='bvls')
        return float(np.sum((tau_f - X @ found.x) ** 2)), found.x

    grid = np.geomspace(_LOWEST, _HIGHEST, 40)
    best = int(np.argmin([solve(v_s)[0] for v_s in grid]))
    around = np.log(grid[[max(best - 1, 0), min(best + 1, len(grid) - 1)]])
    refined = minimize_scalar(
        lambda u: solve(float(np.exp(u)))[0],
        bounds=tuple(around),
        method='bounded',
        options={'xatol': 1e-8},
    )
    v_s = float(np.exp(refined.x))
    C, B, S, bias = (float(x) for x in solve(v_s)[1])
    return make_friction_law(
        'stribeck',
        {'coulomb': C, 'viscous': B, 'stribeck': S, 'stribeck_velocity': v_s, 'bias': bias},
        smoothing_velocity,
    )
