# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Short bursts in what is left: noise is there all the time, what comes now and then is none."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.regression.chance import FEWEST
from sosml_friction.regression.column_norms import ROUNDING
from sosml_friction.regression.contacts import usual
from sosml_friction.regression.kernels import runs
from sosml_friction.regression.noise_model import ORDER
from sosml_friction.regression.whitened import WhitenedRegression

#: A whitened row beyond this many usual ones is part of a burst: of Gaussian noise one of 1.7
#: million is.
_BEYOND = 5.0
#: Usual is what rows of about the same speed are, as late stamps make noise that grows with it: so
#: many groups at most, each of enough rows for its usual size. Chosen, no measurement.
_SPEEDS = 8
#: Share of the energy that is left which bursts hold where nothing acts: five times the largest
#: of 90 recordings, 0.024 (``python -m validation.leftovers --seed 20261283 --recordings 30``).
BURST_SHARE = 0.12


@dataclass(frozen=True)
class Bursts:
    """Hold how many bursts a joint has, their energy, its floor, and when the largest is [s]."""

    count: int
    energy: float
    floor: float
    at_s: float


def bursts(
    laboratory: WhitenedRegression, left: FloatArray, far: BoolArray, joints: Sequence[int]
) -> list[tuple[int, Bursts]]:
    """
    Return the bursts of each joint that has some: teeth that change flanks, touches, wrong values.

    A model of noise has them in its variance, which hides that they are short.

    :param left: whitened rows (rows, n) that causes and curves leave; ``far``: where joints slide.
    """
    if laboratory.contacts.impacts:
        # These have a name.
        return []
    reach = laboratory.signals[0].band.reach + ORDER
    # A joint that sticks lets go with a jerk, which shakes the others and the low-pass spreads.
    beside = maximum_filter1d(~far[:, joints].all(axis=1), 2 * reach + 1)
    # Noise is smaller where a rest has taken a part of it.
    standstill = laboratory.whitening.standstill
    rests = np.zeros_like(far) if standstill is None else standstill.reached()
    when = np.concatenate([s.band.at_rows(s.time)[ORDER:] for s in laboratory.signals])
    speed = np.abs(np.concatenate([s.band.at_rows(s.v)[ORDER:] for s in laboratory.signals]))
    found = []
    for i in joints:
        own = np.where(beside | rests[:, i], 0.0, left[:, i])
        rows = np.flatnonzero(np.abs(own) > ROUNDING)
        # Of a few moments one is as good as any: so many that the low-pass tells apart.
        fewest = FEWEST * (2 * reach + 1)
        if len(rows) < fewest:
            continue
        over = np.zeros(len(own), dtype=np.bool_)
        by_speed = rows[np.argsort(speed[rows, i])]
        for alike in np.array_split(by_speed, min(_SPEEDS, len(rows) // fewest)):
            sizes = np.abs(own[alike])
            over[alike] = sizes > _BEYOND * usual(sizes)
        if not over.any():
            continue
        # In whitened rows each change is there for as many as the filter has.
        count = len(runs(maximum_filter1d(over, 2 * ORDER + 1)))
        energy, floor = float(np.sum(own[over] ** 2)), BURST_SHARE * float(own @ own)
        found.append((i, Bursts(count, energy, floor, float(when[int(np.argmax(np.abs(own)))]))))
    return found
