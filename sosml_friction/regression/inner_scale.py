# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
How inner parameters are searched: sizes by their logarithm, places as they are.

A range that begins above 0 is that of a size; one that has both signs is that of a place, whose
unit is half of the range.
"""

import math

Ends = tuple[float, float]


def is_place(ends: Ends) -> bool:
    """Tell whether a range is that of a place."""
    return ends[0] < 0.0


def moved(value: float, by: float, ends: Ends) -> float:
    """Return a parameter moved by a step, within its range."""
    ahead = value + by * _half(ends) if is_place(ends) else value * math.exp(by)
    return float(min(max(ahead, ends[0]), ends[1]))


def step_between(value: float, other: float, ends: Ends) -> float:
    """Return the step from one value to another."""
    return (other - value) / _half(ends) if is_place(ends) else math.log(other / value)


def per_step(value: float, ends: Ends) -> float:
    """Return the derivative of the parameter over the step."""
    return _half(ends) if is_place(ends) else value


def open_ends(ends: Ends) -> Ends:
    """Return the ends of an interval that data leave open."""
    return (-math.inf if is_place(ends) else 0.0), math.inf


def _half(ends: Ends) -> float:
    return 0.5 * (ends[1] - ends[0])
