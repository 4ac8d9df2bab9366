# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A tone in what is left: a hum that follows time and not the motion."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter

from sosml_friction.arrays import FloatArray
from sosml_friction.regression.noise_model import NoiseModel
from sosml_friction.regression.rests import STILL

#: Fewest cycles in a stretch that make a tone: a slower one is a course of time, a free curve.
_CYCLES = 3
#: Frequencies whose median is the noise beside a tone: so many know it to 1 / (sqrt(201) ln 2) =
#: 10 %, the standard error of the median of exponentials.
_BESIDE = 201
#: The share of a tone that something over position has to be alike to be as good a reason. Along a
#: rich motion it is below 0.05; where a motor creeps past its own cogging (data of an ODrive) 0.82
#: and more.
_ALIKE = 0.25
#: Points between two lines of a periodogram, of all the time or way that there is: a tone between
#: two of them loses 1 - sinc(1 / 8)^2 = 5 % of its energy.
BETWEEN_LINES = 4
#: Most lines that are tried, of each joint: that many take 0.3 s.
_MOST_LINES = 500


@dataclass(frozen=True)
class Tone:
    """
    Hold the strongest tone of one joint.

    ``hertz``; ``share``: of the energy in the band that is left, in effort and not whitened, as
    the model of the noise takes a tone for a part of it; ``chance``: the probability that noise
    has one as much beyond its neighbours in frequency; ``energy``: whitened.
    """

    hertz: float
    share: float
    chance: float
    energy: float = 0.0

    def follows(self, q: FloatArray, step: float) -> bool:
        """
        Tell whether something periodic over position would be a reason as well.

        At constant speed v a tone of f is a line at w = 2 pi f / v over position, and where q is
        a sine one at 2 f is its square: the share of the tone, in the phase that has most of it,
        that 1, cos w q and sin w q explain.

        :param q: position (N, n) [rad or m], ``step`` [s] from row to row.
        """
        angle = 2.0 * np.pi * self.hertz * step * np.arange(len(q))
        turn = np.linalg.qr(_centred(np.column_stack([np.cos(angle), np.sin(angle)])))[0]
        for x in q.T:
            speed = np.abs(np.diff(x)) / step
            moving = speed[speed > STILL * speed.max()]
            if not len(moving):
                # A joint that stands makes no tone of a period over position.
                continue
            slow, fast = np.quantile(moving, (0.1, 0.9))
            low, high = 2.0 * np.pi * self.hertz / fast, 2.0 * np.pi * self.hertz / slow
            # Half of a line's width over the range apart.
            count = (high - low) * float(np.ptp(x)) / np.pi + 2.0
            w = np.linspace(low, high, int(min(count, _MOST_LINES)))
            # One line after the other: all at once would be rows times lines of memory.
            for line in w:
                path = np.linalg.qr(
                    _centred(np.column_stack([np.cos(line * x), np.sin(line * x)]))
                )[0]
                if np.linalg.norm(path.T @ turn, 2) ** 2 > _ALIKE:
                    return True
        return False


def _centred(x: FloatArray) -> FloatArray:
    """Return columns (N, k) without their means."""
    return x - x.mean(axis=0)


def strongest_tone(
    left: FloatArray, noise: NoiseModel, step: float, band: float, above: float = 0.0
) -> Tone:
    """
    Return the strongest tone of a whitened residual.

    Of white noise a periodogram P_k / <P> is exponentially distributed: the largest of K exceeds
    x with the probability K exp(-x). Of m rows that say something, a cosine and a sine of the
    frequency f explain 2 |sum y exp(-i 2 pi f t)|^2 / m by least squares. Of a tone in a few rows
    among zeros most is beside its own line.

    :param left: of one joint in one stretch (N,), 0 where it says nothing.
    :param step: from row to row [s].
    :param band: edge of the band [Hz]; ``above``: from where on.
    """
    count, told = len(left), np.count_nonzero(left)
    power = np.abs(np.fft.rfft(left)) ** 2
    hertz = np.fft.rfftfreq(count, step).astype(np.float64)
    inside = (np.arange(len(power)) >= _CYCLES) & (hertz < band) & (hertz > above)
    if not power[inside].any():
        return Tone(0.0, 0.0, 1.0)
    beside = median_filter(power, size=_BESIDE, mode='reflect') / np.log(2.0)
    beyond = np.where(inside, power / np.maximum(beside, np.finfo(float).tiny), 0.0)
    k = int(np.argmax(beyond))
    chance = min(1.0, float(inside.sum() * np.exp(-beyond[k])))
    between = np.arange(1 - BETWEEN_LINES, BETWEEN_LINES) / (BETWEEN_LINES * count * step)
    near = hertz[k] + between
    turns = np.exp(-2j * np.pi * step * np.outer(near, np.arange(count)))
    found = np.abs(turns @ left) ** 2
    best = int(np.argmax(found))
    energy = 2.0 / told * float(found[best])
    # Parseval: of a real signal each line stands for itself and its mirror.
    effort = power[inside] / gain(noise, step, hertz[inside])
    every = 2.0 / count * float(effort.sum())
    share = min(1.0, energy / float(gain(noise, step, near[[best]])[0]) / every)
    return Tone(float(near[best]), share, chance, energy)


def gain(noise: NoiseModel, step: float, hertz: FloatArray) -> FloatArray:
    """Return the power gain of the whitening at frequencies [Hz]."""
    lag = np.arange(len(noise.whitening))
    turns = np.exp(-2j * np.pi * step * np.outer(hertz, lag))
    return np.asarray(np.abs(turns @ noise.whitening) ** 2, dtype=np.float64)
