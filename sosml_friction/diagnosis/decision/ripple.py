# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A ripple of friction over position in what is left: teeth, or the torque constant's slots."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from sosml_friction.arrays import FloatArray


class Stretch(NamedTuple):
    """Hold what is left of one joint (N,), where it is (N,) and the sign of its motion (N,)."""

    left: FloatArray
    q: FloatArray
    sign: FloatArray


class Ripple(NamedTuple):
    """
    Hold the strongest ripple of one joint.

    ``frequency`` w [rad/rad or rad/m]; ``energy``: what s (A cos w q + B sin w q) explains;
    ``tried``: how many frequencies were.
    """

    frequency: float
    energy: float
    tried: int


def strongest_ripple(stretches: Sequence[Stretch], frequencies: FloatArray) -> Ripple:
    """
    Return the strongest ripple of friction in whitened rows.

    Of each w it is the energy |sum s r exp(i w q)|^2 / (sum s^2 / 2): over periods enough the two
    columns are orthogonal and of the same norm. What friction by speed leaves, the part of r along
    s, is taken off. Rows are white, so that columns that are not filtered like them explain less,
    and noise no more: of K frequencies with a probability of K exp(-x / 2) one has an energy of x.

    :param frequencies: of the lines that are tried, (K,) [rad/rad or rad/m].
    """
    energy = sum(float(x.sign @ x.sign) for x in stretches)
    if energy <= 0.0 or not len(frequencies):
        return Ripple(0.0, 0.0, 0)
    friction = sum(float(x.sign @ x.left) for x in stretches) / energy
    # One line after the other: all at once would be rows times lines of memory.
    sums = [
        sum(
            np.vdot(np.exp(1j * w * x.q), x.sign * (x.left - friction * x.sign)) for x in stretches
        )
        for w in frequencies.tolist()
    ]
    explained = 2.0 * np.abs(np.array(sums)) ** 2 / energy
    k = int(np.argmax(explained))
    return Ripple(float(frequencies[k]), float(explained[k]), len(frequencies))
