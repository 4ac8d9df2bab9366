# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that goes up and down in time, in what a fit leaves."""

from collections.abc import Sequence

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.regression.chance import BEYOND_CHANCE, NEGLIGIBLE
from sosml_friction.regression.kernels import runs

#: Least distance of two times at which friction has a level of its own, in periods of the
#: low-pass's cut-off: twenty rows of the band, so that it is known to a quarter of the noise.
CYCLES = 10.0


def wandering_friction(
    residual: FloatArray, sign: FloatArray, told: FloatArray, counts: Sequence[int], most: int
) -> FloatArray:
    """
    Return what friction that goes up and down in time is of a residual (K,), zeros for none.

    Its level f_k is a mean of s times the residual over each stroke, of a long one over ``most``
    rows, and on the line in between. Friction that wanders is as high after a reversal as before:
    f_k f_k+1 > 0. Slow noise is as large as an effort: f_k f_k+1 < 0. Of white noise the sum of
    these products over all reversals is normal about 0, with the sum of their squares as its
    variance. One that is positive by more than chance is of friction, where it is more than half
    of what levels are: other things that are left come back at each reversal as well.

    :param sign: of friction (K,), as the band has it; ``told``: 1 for rows that say something.
    :param counts: rows of each stretch.
    """
    nothing, first = np.zeros(len(residual)), 0
    strokes: list[tuple[float, float, float, int]] = []
    for stretch, count in enumerate(counts):
        its = slice(first, first + count)
        for way in (1.0, -1.0):
            for begin, end in runs(way * sign[its] * told[its] > 0.5):
                rows = first + np.arange(begin, end)
                for part in np.array_split(rows, -(-len(rows) // most)):
                    s = sign[part]
                    level = float(s @ residual[part] / (s @ s))
                    strokes.append((float(part.mean()), level, way, stretch))
        first += count
    if not strokes:
        return nothing
    middles, levels, ways, of = np.array(sorted(strokes)).T
    across = (ways[1:] != ways[:-1]) & (of[1:] == of[:-1])
    both = (levels[1:] * levels[:-1])[across]
    if not both.sum() > BEYOND_CHANCE * np.sqrt(np.sum(both**2)):
        return nothing
    if not both.mean() > 0.5 * np.mean(levels**2):
        return nothing
    found = sign * np.interp(np.arange(len(residual)), middles, levels)
    share = float(np.sum(told * found**2)) / float(np.sum(told * residual**2))
    return found if share > NEGLIGIBLE else nothing
