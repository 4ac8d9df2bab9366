# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A ripple of friction over position in what is left: teeth, or the torque constant's slots."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.cogging import lines

#: Lines that are computed at a time, which bounds memory.
_AT_ONCE = 16


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


def strongest_ripple(stretches: Sequence[Stretch], highest: float) -> Ripple:
    """
    Return the strongest ripple of friction in whitened rows, three periods or more in the range.

    Of each w it is the energy |sum s r exp(i w q)|^2 / (sum s^2 / 2): over periods enough the two
    columns are orthogonal and of the same norm. What friction by speed leaves, the part of r along
    s, is taken off. Rows are white, so that columns that are not filtered like them explain less,
    and noise no more: with a probability of count exp(-x / 2) it has one of energy x.

    :param highest: frequency up to which lines are tried [rad/rad or rad/m].
    """
    span = max((float(np.ptp(x.q)) for x in stretches if len(x.q)), default=0.0)
    energy = sum(float(x.sign @ x.sign) for x in stretches)
    if span <= 0.0 or energy <= 0.0:
        return Ripple(0.0, 0.0, 0)
    # A quarter of a period over the range: between two lines one of noise is seen by 0.8.
    first, step = 6.0 * np.pi / span, 0.5 * np.pi / span
    count = int((highest - first) / step) + 1
    if count < 1:
        return Ripple(0.0, 0.0, 0)
    friction = sum(float(x.sign @ x.left) for x in stretches) / energy
    sums = np.zeros((count, 2))
    for x in stretches:
        weight = x.sign * (x.left - friction * x.sign)
        place = np.ascontiguousarray(x.q)
        for begin in range(0, count, _AT_ONCE):
            some = min(_AT_ONCE, count - begin)
            columns = lines(place, first + begin * step, step, some)
            sums[begin : begin + some] += np.tensordot(weight, columns, 1)
    explained = 2.0 * np.sum(sums**2, axis=1) / energy
    k = int(np.argmax(explained))
    return Ripple(first + k * step, float(explained[k]), count)
