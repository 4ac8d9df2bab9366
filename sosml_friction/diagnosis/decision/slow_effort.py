# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How much of what is left is slower than noise: something acts that lasts."""

from collections.abc import Sequence

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.diagnosis.decision.leftover import REST, SLOW, Leftover, share_beside
from sosml_friction.diagnosis.decision.tone import gain
from sosml_friction.regression.whitened import WhitenedRegression

#: The slowest part of the band, as a share of it.
_SLOW = 0.1
#: Largest share of the power of noise that is in there. White noise has a tenth; noise behind
#: a low-pass of first order at that frequency, of a drive that smooths its effort, has
#: atan(1) / atan(10) = 0.53.
_SHARE = 0.5


def slow_power(
    laboratory: WhitenedRegression, left: FloatArray, joint: int
) -> tuple[float, float]:
    """
    Return the mean squares of what is left of a joint, slower than a tenth of the band and in all.

    In effort, (Nm or N)^2 to a factor: a model of the noise takes what is slow for a part of it,
    and whitens it.

    :param left: whitened rows (rows, n).
    """
    noise = laboratory.noise[joint]
    slow = every = 0.0
    for signals, part in zip(laboratory.signals, laboratory.split(left), strict=True):
        band = signals.band
        hertz = np.fft.rfftfreq(len(part), band.output_step).astype(np.float64)
        inside = hertz < band.cutoff
        power = np.abs(np.fft.rfft(part[:, joint]))[inside] ** 2 / len(part)
        power /= gain(noise, band.output_step, hertz[inside])
        slow += float(power[hertz[inside] < _SLOW * band.cutoff].sum())
        every += float(power.sum())
    return slow, every


def slow_effort(
    laboratory: WhitenedRegression, left: Sequence[FloatArray], joint: int
) -> Leftover | None:
    """
    Return what is left of a joint that is too slow for noise, None if most of it is not.

    :param left: whitened rows (rows, n) without the causes, and with them.
    """
    (_, before), (slow, every) = (slow_power(laboratory, own, joint) for own in left)
    if slow <= _SHARE * every:
        return None
    share = share_beside(slow, max(before - every, 0.0))
    # As the other leftovers have it, whitened.
    energy = float(np.sum(left[1][:, joint] ** 2))
    return Leftover(SLOW, joint, slow / every * energy, _SHARE * energy, share, REST)
