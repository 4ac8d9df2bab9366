# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Counters that begin anew where their register is full, as micros() of 32 bits every 71 min."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

#: What the register of a clock holds: microseconds or milliseconds in 32 bits.
_REGISTER = 2**32


def without_overflow(values: NDArray[Any]) -> NDArray[Any]:
    """
    Return a counter (N,) that goes on where it began anew, anything else as it is.

    Whole numbers below 2^32 that rise but for steps back are such if each of those, 2^32 added,
    is above 0 and no longer than the longest step that does not go back.
    """
    if values.dtype.kind not in 'iu' or not len(values):
        return values
    if values.min() < 0 or values.max() >= _REGISTER:
        return values
    # A difference of unsigned numbers is never below 0.
    counts = values.astype(np.int64)
    steps = np.diff(counts)
    back = steps < 0
    if not back.any() or back.all():
        return values
    anew = steps[back] + _REGISTER
    if anew.min() <= 0 or anew.max() > steps[~back].max():
        return values
    return np.asarray(counts + _REGISTER * np.append(0, np.cumsum(back)))
