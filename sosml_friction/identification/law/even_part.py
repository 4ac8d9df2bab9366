# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The part of a fitted friction that is the same in both directions."""

import numpy as np
from scipy.stats import f as f_distribution

from sosml_friction.arrays import FloatArray
from sosml_friction.identification.law.jackknife import jackknife_covariance
from sosml_friction.identification.law.law_checks import LawCheck, odd_even_check
from sosml_friction.identification.law.law_problem import LawProblem, LawSolution
from sosml_friction.model.terms.kinds.fading_term import fade
from sosml_friction.regression.column_norms import column_norms


def even_part(
    problem: LawProblem,
    solution: LawSolution,
    nonlinear: tuple[str, ...],
    speeds: FloatArray,
    effort_unit: str,
) -> LawCheck:
    """
    Tell whether the even part of friction changes with speed.

    :param nonlinear: which parameters were found beside v_s.
    :param speeds: slowest and fastest of the data (2,) [rad/s or m/s].
    """
    form = problem.form
    p = dict(zip(problem.names(solution.v_s), solution.theta.tolist(), strict=True))
    if form.symmetric:
        names, X = problem.jacobian(solution, nonlinear)
        even = [problem.speed]
        if solution.v_s is not None:
            even.append(fade(problem.speed, solution.v_s, solution.alpha))
        X = np.column_stack([X, *(problem.made(column) for column in even)])
        norms = column_norms(X)
        w = solution.weights
        root = np.sqrt(w)
        theta = np.linalg.lstsq(X / norms * root[:, None], solution.residual * root, rcond=1e-10)[
            0
        ]
        rest = solution.residual - X / norms @ theta
        spread = jackknife_covariance(X / norms, rest, problem.groups, w)
        own = np.arange(X.shape[1] - len(even), X.shape[1])
        found = theta[own] / norms[own]
        C = spread[np.ix_(own, own)] / np.outer(norms[own], norms[own])
        bias = p['bias'] + float((theta / norms)[names.index('bias')])
    else:
        of = ['viscous_asymmetry', *(['stribeck_asymmetry'] if solution.v_s else [])]
        full = problem.covariance(solution, nonlinear)
        found = np.array([p[name] for name in of])
        C = np.array([[full[a, b] for b in of] for a in of])
        bias = p['bias']
    shapes = [speeds]
    if solution.v_s is not None:
        shapes.append(fade(speeds, solution.v_s, solution.alpha))
    even_at = np.array(shapes).T @ found
    inverse = np.linalg.pinv(C, rcond=1e-10)
    statistic = float(found @ inverse @ found) / len(found)
    freedom = max(problem.count - len(solution.theta) - 2, 1)
    chance = float(f_distribution.sf(statistic, len(found), freedom))
    peak: FloatArray | float = 0.0
    if solution.v_s is not None:
        peak = p['stribeck'] * fade(speeds, solution.v_s, solution.alpha)
    odd_at = p['coulomb'] + peak + p['viscous'] * speeds
    return odd_even_check(speeds, odd_at, bias + even_at, chance, effort_unit, not form.symmetric)
