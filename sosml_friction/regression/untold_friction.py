# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that a model does not tell, as part of the torque that sensors report."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import lsq_linear

from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import Signals

#: A joint moves where the state of its sign is beyond half, and goes both ways where the shorter
#: of the two is more than this share of both. Chosen, no measurement.
_MOVES, _LEAST = 0.5, 0.05


def with_untold_friction(
    stretches: Sequence[Signals], settings: DiagnosisSettings
) -> list[Signals]:
    """
    Return the stretches with the friction that they need where the model does not tell it.

    ``untold`` are C and B of C s + B q', by least squares beside a constant in the band, of the
    joints whose friction is not stated or is trusted less than the tolerance says. With what is
    stated, neither is less than nothing. 0 of others, and of a joint that goes one way only, whose
    Coulomb friction is a constant. What a report adds follows the whole torque: with a friction
    that is a guess, a coupling would be wrong by as much as it.
    """
    scales, n = stretches[0].scales, stretches[0].robot.n
    is_guess = settings.trust.get('friction', settings.tolerance) > settings.tolerance
    stated = np.isfinite(scales.coulomb) & np.isfinite(scales.viscous)
    silent = stretches[0].silent
    joints = [i for i in range(n) if (is_guess or not stated[i]) and i not in silent]
    if not joints:
        return list(stretches)
    untold = [(0.0, 0.0)] * n
    for i in joints:
        if not _goes_both_ways(stretches, i):
            continue
        rows = []
        for s in stretches:
            seen = [s.sign[:, i], s.v[:, i], np.ones(len(s.q)), s.unexplained[:, i]]
            rows.append(s.band.apply(np.column_stack(seen)))
        X = np.concatenate(rows)
        # What is stated may be too much, and no more than all of it.
        least = [-np.nan_to_num(scales.coulomb[i]), -np.nan_to_num(scales.viscous[i]), -np.inf]
        found = lsq_linear(X[:, :-1], X[:, -1], (least, np.inf))
        untold[i] = (float(found.x[0]), float(found.x[1]))
    return [replace(s, untold=tuple(untold), cache={}) for s in stretches]


def _goes_both_ways(stretches: Sequence[Signals], joint: int) -> bool:
    """Tell whether a joint goes each way for a part of the time that it moves."""
    ways = [
        sum(int(np.sum(side * s.sign[:, joint] > _MOVES)) for s in stretches) for side in (1, -1)
    ]
    return min(ways) > _LEAST * sum(ways)
