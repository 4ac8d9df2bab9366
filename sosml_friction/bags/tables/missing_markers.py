# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Numbers that stand for a value that is missing, such as -9999."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

#: A number of so many nines is written for what is missing.
_NINES = 3
#: No joint has a value of this size, in whatever unit.
_HUGE = 1e9
#: Bits of the least integer whose limits are written for what is missing; those of a shorter one
#: are usual counts.
_BITS = 15
#: What is told by its distance alone, or may jump as an effort does, is away from all other values
#: by so many of their ranges. Chosen, no measurement.
_RANGES = 10.0
#: A range needs so many values that differ. Chosen, no measurement.
_VALUES = 10


def missing_markers(values: NDArray[Any], quantity: str) -> list[float]:
    """
    Return the numbers in a series that stand for missing values; most often there are none.

    Position and velocity go through all values between two of theirs. One that is away from all
    others by their whole range, with nothing between, is no motion: it stands for what is missing
    if it is a number that is written for that, of nines, a limit of integers, or huge. A position
    that goes at once to one place more often than once, away by ten ranges, is missing whatever
    the number is, such as 0. An effort may jump, and stay at its limit: there it takes both, such
    a number, repeated, and ten ranges.

    :param values: (N,), in the unit of the file.
    :param quantity: ``position``, ``velocity``; others are taken as an effort.
    """
    values = values.astype(np.float64)  # the distance of two integers may be none
    known = values[np.isfinite(values)]
    distinct, counts = np.unique(known, return_counts=True)
    share = dict(zip(distinct.tolist(), (counts / max(len(known), 1)).tolist(), strict=True))
    ends = [*distinct[:2].tolist(), *distinct[-2:].tolist()]
    written = [x for x in dict.fromkeys(ends) if _is_written(x) and share[x] < 0.5]
    rest = distinct[~np.isin(distinct, written)]
    moves = quantity in ('position', 'velocity')
    found = [
        x
        for x in written
        if len(rest)
        and _away(x, rest) > (1.0 if moves else _RANGES) * float(np.ptp(rest))
        and (moves or (len(rest) >= _VALUES and share[x] * len(known) > 1.5))
    ]
    if found or quantity != 'position' or len(distinct) <= _VALUES:
        return found
    for x, rest in ((ends[0], distinct[1:]), (ends[-1], distinct[:-1])):
        visits = int(np.sum(np.diff((values == x).astype(int)) == 1))
        if share[x] < 0.5 and visits > 1 and _away(x, rest) > _RANGES * float(np.ptp(rest)):
            return [x]
    return []


def _is_written(value: float) -> bool:
    """Tell whether a number is one that is written for a missing value."""
    size = abs(value)
    digits = f'{size:.10g}'.replace('.', '')
    is_nines = len(digits) >= _NINES and set(digits) == {'9'} and size > 99.0
    is_limit = size >= 2**_BITS - 1 and any(np.log2(size + k) % 1.0 == 0.0 for k in (0, 1))
    return is_nines or is_limit or size >= _HUGE


def _away(value: float, rest: NDArray[Any]) -> float:
    """Return how far a value is outside of others, not above 0 if it is not."""
    return float(max(rest[0] - value, value - rest[-1]))
