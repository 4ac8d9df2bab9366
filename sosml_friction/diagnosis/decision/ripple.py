# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A ripple over position in what is left: of friction, as of teeth, or of the torque constant."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from sosml_friction.arrays import FloatArray


class Stretch(NamedTuple):
    """
    Hold what is left of one joint (N,), where it is (N,) and what ripples (N,).

    ``weight``: the sign of motion for a ripple of friction, the torque for one of its constant.
    """

    left: FloatArray
    q: FloatArray
    weight: FloatArray


class Ripple(NamedTuple):
    """
    Hold the strongest ripple of one joint.

    ``frequency`` w [rad/rad or rad/m]; ``energy``: what x (A cos w q + B sin w q)
    explains, with the weight x;
    ``tried``: how many frequencies were.
    """

    frequency: float
    energy: float
    tried: int


def strongest_ripple(stretches: Sequence[Stretch], frequencies: FloatArray) -> Ripple:
    """
    Return the strongest ripple in whitened rows.

    Of each w it is the energy |sum x r exp(i w q)|^2 / (sum x^2 / 2), with the weight x: over
    periods enough the two columns are orthogonal and of the same norm. What friction by speed or
    a wrong torque constant leaves, the part of r along x, is taken off. Rows are white, so that
    columns that are not filtered like them explain less, and noise no more: of K frequencies with
    a probability of K exp(-e / 2) one has an energy of e.

    :param frequencies: of the lines that are tried, (K,) [rad/rad or rad/m].
    """
    energy = sum(float(x.weight @ x.weight) for x in stretches)
    if energy <= 0.0 or not len(frequencies):
        return Ripple(0.0, 0.0, 0)
    steady = sum(float(x.weight @ x.left) for x in stretches) / energy
    # One line after the other: all at once would be rows times lines of memory.
    loose = [x.weight * (x.left - steady * x.weight) for x in stretches]
    sums = [
        sum(np.vdot(np.exp(1j * w * x.q), part) for x, part in zip(stretches, loose, strict=True))
        for w in frequencies.tolist()
    ]
    explained = 2.0 * np.abs(np.array(sums)) ** 2 / energy
    k = int(np.argmax(explained))
    return Ripple(float(frequencies[k]), float(explained[k]), len(frequencies))
