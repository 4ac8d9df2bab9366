# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What curves of two quantities, and of time back and forth, explain of what is left then."""

from collections.abc import Sequence

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.diagnosis.decision.leftover import (
    AT_ONCE,
    FRICTION_BY,
    REST,
    Leftover,
    curve_floor,
    share_beside,
)
from sosml_friction.diagnosis.decision.slow_noise import noise_where
from sosml_friction.regression.curves.axes import BACK_AND_FORTH
from sosml_friction.regression.curves.pairs import Pairs
from sosml_friction.regression.curves.wandering import Wandering
from sosml_friction.regression.evidence import Fit
from sosml_friction.regression.evidence_curves import SMOOTH, fit_curves
from sosml_friction.regression.whitened import WhitenedRegression


def further_curves(
    laboratory: WhitenedRegression,
    fit: Fit,
    left: FloatArray,
    far: BoolArray,
    joints: Sequence[int],
    named: FloatArray,
) -> list[Leftover]:
    """
    Return what further curves explain beside the nominal.

    They come after the curves of one quantity, so that what these explain has one name.

    :param left: whitened rows (rows, n) that all those have left; ``far``: where they were sought.
    :param named: energy that the causes of each joint explain (n,).
    """
    rows = laboratory.known * far.mean(axis=0)
    target = Fit.make(fit.system, left)
    pairs, wandering = Pairs(laboratory.signals), Wandering(laboratory.signals)
    found = []
    # Joint by joint: the curves of all together would be the largest array of a diagnosis.
    for i in joints:
        both = pairs.axes(i)
        floor = curve_floor(float(rows[i]), (len(both) + 1) * len(joints))
        for curve, axes, smooth in ((pairs, both, 0.0), (wandering, [()], SMOOTH)):
            if not axes:
                # A joint that stands alone has time, and nothing else.
                continue
            whole = laboratory.of_curve(curve, i)
            parts = np.split(whole, len(axes), axis=1)
            result = fit_curves(target, [(i, part) for part in parts], far, smooth)
            for of, part, energy in zip(axes, parts, result.energy.tolist(), strict=True):
                least = floor * noise_where(part, result.left[:, i])
                share = share_beside(energy, float(named[i]))
                name = f'{" and ".join(of)}{AT_ONCE}' if of else f'{FRICTION_BY}{BACK_AND_FORTH}'
                found.append(Leftover(name, i, energy, least, share, REST))
    return found
