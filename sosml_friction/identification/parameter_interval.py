# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the 95 % intervals of parameters allow, and which of them exclude each other."""

import math
from collections.abc import Mapping

from sosml_friction.model.parameter import NOT_IDENTIFIABLE, Z_95, Parameter

#: The parameters of every friction law, in the order in which they are compared.
LAW_PARAMETERS = ('coulomb', 'viscous', 'stribeck', 'stribeck_velocity', 'bias')
#: Parameters that cannot be negative.
NON_NEGATIVE = LAW_PARAMETERS[:-1]
#: Why one of them is 0.
AT_ZERO = 'the best fit is at zero, as negative friction is not possible'
#: No physical quantity is larger, and rounding overflows close to 1e308.
HUGE = 1e300


def allowed_range(name: str, parameter: Parameter) -> tuple[float, float] | None:
    """
    Return the interval of a parameter cut at what it can be at all, its open ends infinite.

    C, B, S and v_s are not negative. An end that is NaN, as in a file, is open. None where the
    data say nothing: no interval, one without width, or one that allows all there can be.
    """
    if parameter.interval is None:
        return None
    low, high = parameter.interval
    lowest = 0.0 if name in NON_NEGATIVE else -math.inf
    low = low if abs(low) < HUGE and low > lowest else lowest
    high = max(high, lowest) if abs(high) < HUGE else math.inf
    return (low, high) if high > low and (low > lowest or high < math.inf) else None


def finite_interval(parameter: Parameter) -> tuple[float, float] | None:
    """Return the 95 % interval of a parameter that is identifiable, None if an end is open."""
    if NOT_IDENTIFIABLE in parameter.flags or parameter.interval is None:
        return None
    return parameter.interval if all(map(math.isfinite, parameter.interval)) else None


def covers(parameter: Parameter, value: float) -> bool:
    """Tell whether a value is within the 95 % interval."""
    interval = finite_interval(parameter)
    return interval is not None and interval[0] <= value <= interval[1]


def half_width(parameter: Parameter) -> float:
    """Return half of the 95 % interval: what ± says, in every sentence."""
    if parameter.interval is None:
        return Z_95 * parameter.std_error
    return 0.5 * (parameter.interval[1] - parameter.interval[0])


def missed_truths(
    parameters: Mapping[str, Parameter], known: Mapping[str, Parameter]
) -> list[str]:
    """Return the parameters whose 95 % interval leaves out what is known to be true."""
    return [
        name
        for name, truth in known.items()
        if name in parameters
        and finite_interval(parameters[name]) is not None
        and not covers(parameters[name], truth.value)
    ]


def excluding(one: Mapping[str, Parameter], other: Mapping[str, Parameter]) -> list[str]:
    """Return the parameters of two laws whose 95 % intervals have no value in common."""
    names = []
    for name in LAW_PARAMETERS:
        a, b = finite_interval(one[name]), finite_interval(other[name])
        if a is not None and b is not None and (a[0] > b[1] or b[0] > a[1]):
            names.append(name)
    return names
