# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Where a ripple of the torque constant is a better reason than a cause that repeats."""

import numpy as np

from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.regression.curves.torque_ripple import TorqueRipple
from sosml_friction.regression.evidence import Fit
from sosml_friction.regression.inner_search import refine
from sosml_friction.regression.rival import VERY_STRONG
from sosml_friction.regression.whitened import WhitenedRegression


def torque_ripple_in_place(
    laboratory: WhitenedRegression, fit: Fit, best: Finding, choice: float
) -> str:
    """
    Return the ripple of the torque constant that is there instead of a cause, '' for none.

    Where the torque keeps its size, as of one direction at one speed, such a ripple is cogging:
    it is told where its evidence is very strongly the larger.

    :param fit: without the cause.
    :param choice: price of the choice among all candidates, 2 ln K.
    """
    first, i, curve = laboratory.signals[0], best.joint, TorqueRipple()
    if not best.effect.repeats or not (grid := curve.grid(first, i)):
        return ''
    s = fit.score(laboratory.on_grid(curve, i, grid).beside(fit.system))
    _, inner, s, _ = refine(laboratory, fit, curve, i, grid[s.best])
    if curve.implausible(Fitted(first, i, inner, s.amplitude, s.error)):
        return ''
    # The price of two sizes and a frequency, the best of many.
    price = 3.0 * float(np.log(laboratory.known[i])) + 2.0 * float(np.log(len(grid))) + choice
    if s.gain - price <= best.delta_bic + VERY_STRONG:
        return ''
    period = 2.0 * np.pi / float(inner['frequency'])
    unit = first.length_unit(i)
    return f'a ripple of its torque constant over position (period {period:.3g} {unit})'
