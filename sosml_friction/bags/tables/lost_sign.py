# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Numbers below 0 that a register holds as large ones, written without their sign."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

#: What the bit of the sign counts: of loads and speeds of servos of Dynamixel and Feetech, which
#: have it beside the size, and of integers of 16 and 32 bits.
_SIGNS = (2.0**10, 2.0**15, 2.0**31)
#: A sign that is lost makes a jump of half of the register at every change of direction; as many
#: are no chance, and of those one in ten may be left. Chosen, no measurement.
_FEWEST, _LEFT = 3, 0.1


def with_sign(values: NDArray[Any]) -> NDArray[Any] | None:
    """
    Return a velocity or an effort with the signs that it lost, None where it lost none.

    Whole numbers, none below 0, are such if they jump to and fro across the bit of a sign, and do
    not when that is read: as the complement of two, or as a sign beside the size.
    """
    known = values[np.isfinite(values)]
    if len(known) < 2 or known.min() < 0 or (known != np.rint(known)).any():
        return None
    sign = next((s for s in _SIGNS if s <= known.max() < 2.0 * s), np.inf)
    if len(np.unique(known[known >= sign])) < 2:
        # One number alone stands for a missing value.
        return None
    before = _jumps(known, sign)
    forms = [np.where(values >= sign, sign - values, values)]
    if sign > _SIGNS[0]:
        forms.append(np.where(values >= sign, values - 2.0 * sign, values))
    best = min(forms, key=lambda own: float(np.nansum(np.abs(np.diff(own)))))
    is_found = before >= _FEWEST and _jumps(best[np.isfinite(best)], sign) <= _LEFT * before
    return best if is_found else None


def _jumps(values: NDArray[Any], sign: float) -> int:
    return int((np.abs(np.diff(values.astype(np.float64))) > 0.5 * sign).sum())
