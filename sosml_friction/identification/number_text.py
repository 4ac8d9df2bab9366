# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Numbers as a person reads them: as many digits as the uncertainty supports, and no more."""

import math
from collections.abc import Mapping

from sosml_friction.identification.parameter_interval import (
    HUGE,
    allowed_range,
    finite_interval,
    half_width,
)
from sosml_friction.model.parameter import AT_BOUND, NOT_IDENTIFIABLE, Parameter
from sosml_friction.model.terms.kinds.term import ALL_JOINTS

UNKNOWN = '-'
NOT_IDENTIFIABLE_TEXT = 'not identifiable'


def format_number(value: float, uncertainty: float = math.nan) -> str:
    """
    Return ``value`` rounded to two significant digits of its uncertainty.

    Without an uncertainty it gets four significant digits. From 1e6 on, and below 0.01 where
    digits beyond the sixth decimal count, it is in the form 1.2e-07.

    :param uncertainty: standard error or the like, in the unit of the value.
    """
    if not abs(value) < HUGE:
        return UNKNOWN
    if math.isfinite(uncertainty) and uncertainty > 0.0:
        place = _leading(uncertainty) - 1
    elif value == 0.0:
        return '0'
    else:
        place = _leading(value) - 3
    rounded = round(value, -place)
    if rounded == 0.0:
        # Not -0.00, and not the digits of a value that the uncertainty hides.
        return f'{0.0:.{-place}f}' if -6 <= place < 0 else '0'
    leading = _leading(rounded)
    # A double has no more than 15 digits to show.
    place = max(place, leading - 14)
    if leading >= 6 or (place < -6 and leading < -2):
        return f'{rounded:.{max(leading - place, 0)}e}'
    return f'{rounded:.{max(0, -place)}f}'


def _leading(x: float) -> int:
    """Return the power of ten of the first digit."""
    return int(f'{x:e}'.partition('e')[2])


def rounded(value: float) -> str:
    """Return a number of which two digits count."""
    return format_number(value, value)


def plus_minus(value: float, half: float, unit: str = '') -> str:
    """Return a value and half of its interval, each with the digits that the latter supports."""
    end = f' {unit}' if unit else ''
    if not (math.isfinite(half) and half > 0.0):
        return format_number(value) + end
    return f'{format_number(value, half)} ± {rounded(half)}{end}'


def percent(share: float) -> str:
    """Return a share of one in percent, empty where it is not known."""
    return f'{100.0 * share:.2f} %' if math.isfinite(share) else ''


def truth_text(known: Mapping[str, Parameter], name: str) -> str:
    """Return a parameter that is known, a dash where it is not."""
    return f'{known[name].value:.4g}' if name in known else UNKNOWN


def words(identifier: str) -> str:
    """Return an identifier as words, ``effect@joint`` with its joint in brackets."""
    name, _, joint = identifier.partition('@')
    return name.replace('_', ' ') + (f' ({joint_text(joint)})' if joint else '')


def joint_text(joint: str) -> str:
    """Return the name of a joint, or that it is all of them."""
    return 'all joints' if joint == ALL_JOINTS else joint


def of_joint(joint: str) -> str:
    """Return " of" a joint, '' for all of them."""
    return '' if joint == ALL_JOINTS else f' of {joint}'


def format_interval(low: float, high: float, uncertainty: float = math.nan) -> str:
    """Return ``low to high``; the digits follow the uncertainty, else the width."""
    if not (math.isfinite(uncertainty) and uncertainty > 0.0):
        uncertainty = (high - low) / 4.0
    # A zero is a bound, and exact.
    begin = '0' if low == 0.0 else format_number(low, uncertainty)
    return f'{begin} to {format_number(high, uncertainty)}'


def value_text(name: str, parameter: Parameter) -> str:
    """
    Return what stands for the value of a parameter in a table.

    A parameter that is not identifiable is a range (``0 to 1.2``, ``above 0.3``), or the words
    where the data leave no range: never a number.
    """
    if NOT_IDENTIFIABLE in parameter.flags:
        return range_text(name, parameter) or NOT_IDENTIFIABLE_TEXT
    text = format_number(parameter.value, _uncertainty(parameter))
    return f'{text} (at bound)' if AT_BOUND in parameter.flags else text


def number_text(name: str, parameter: Parameter) -> str:
    """Return a value with its 95 % interval, or the range that the data allow."""
    half = half_width(parameter)
    if NOT_IDENTIFIABLE in parameter.flags:
        return range_text(name, parameter) or 'not told by these data'
    if not (half > 0.0 and math.isfinite(half)):
        return value_text(name, parameter)
    return with_interval(parameter)


def with_interval(parameter: Parameter, unit: str = '') -> str:
    """Return a value with half of its 95 % interval, or with its ends where half is no error."""
    half, interval = half_width(parameter), finite_interval(parameter)
    if interval is None or not _lopsided(parameter, half):
        return plus_minus(parameter.value, half, unit)
    text = format_number(parameter.value, _uncertainty(parameter)) + (f' {unit}' if unit else '')
    bound = ', at bound' if AT_BOUND in parameter.flags else ''
    return f'{text} ({format_interval(*interval)}{bound})'


def _lopsided(parameter: Parameter, half: float) -> bool:
    """
    Tell whether half of an interval is no error of its value: it is about another one.

    By more than a tenth of it, as two digits of it are told; one of a profile in any case.
    """
    assert parameter.interval is not None
    if not math.isfinite(parameter.std_error):
        return True
    return abs(sum(parameter.interval) / 2.0 - parameter.value) > 0.1 * half


def error_text(parameter: Parameter) -> str:
    """Return the standard error, ``-`` where the value itself is not to be used."""
    if NOT_IDENTIFIABLE in parameter.flags:
        return UNKNOWN
    return format_number(parameter.std_error, parameter.std_error)


def interval_text(parameter: Parameter) -> str:
    """Return the 95 % interval, ``-`` where there is none; a range stands for the value."""
    interval = finite_interval(parameter)
    return UNKNOWN if interval is None else format_interval(*interval, parameter.std_error)


def range_text(name: str, parameter: Parameter) -> str:
    """Return the range that the data allow in words, empty where there is none."""
    allowed = allowed_range(name, parameter)
    if allowed is None:
        return ''
    low, high = allowed
    if math.isinf(high):
        return f'above {format_number(low, 0.1 * abs(low))}'
    if math.isinf(low):
        return f'below {format_number(high, 0.1 * abs(high))}'
    return format_interval(low, high)


def _uncertainty(parameter: Parameter) -> float:
    if math.isfinite(parameter.std_error) or parameter.interval is None:
        return parameter.std_error
    # An infinite end makes this infinite, and the number gets its usual digits.
    return (parameter.interval[1] - parameter.interval[0]) / 4.0
