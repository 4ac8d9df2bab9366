# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A number a person can trust: value, uncertainty, unit, flags."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from sosml_friction.exceptions import ConfigurationError

AT_BOUND = 'at_bound'
NOT_IDENTIFIABLE = 'not_identifiable'
#: Half width of a 95 % interval in standard errors: of the normal distribution, which Student's
#: t is for many rows.
Z_95 = 1.959964


@dataclass(frozen=True)
class Parameter:
    """
    Hold one parameter of a model.

    ``std_error`` is NaN where it is not known. ``interval`` is the 95 % confidence interval, given
    where it is not value +- t * std_error; an open end is infinite. ``flags`` say that the value
    must not be used blindly, ``reason`` why, and ``experiment`` what to record instead: parts of a
    sentence without its full stop, empty where there is nothing to say. A parameter that is not
    identifiable has the value NaN and its interval alone.
    """

    value: float
    unit: str
    std_error: float = math.nan
    interval: tuple[float, float] | None = None
    flags: tuple[str, ...] = ()
    reason: str = ''
    experiment: str = ''

    @classmethod
    def estimated(cls, value: float, unit: str, error: float, quantile: float) -> Parameter:
        """Return one with an interval of ``quantile`` standard errors to both sides."""
        half = quantile * error
        return cls(value, unit, error, (value - half, value + half))

    @classmethod
    def not_told(
        cls,
        unit: str,
        reason: str = '',
        interval: tuple[float, float] | None = None,
        experiment: str = '',
    ) -> Parameter:
        """Return one that the data do not tell: its value is NaN, and it is flagged."""
        return cls(math.nan, unit, math.nan, interval, (NOT_IDENTIFIABLE,), reason, experiment)

    def with_variance(self, more: float) -> Parameter:
        """
        Return the parameter with a variance added, of an error independent of its own.

        Both halves of the interval grow as its standard error does: in squares, by the square of
        1.96 standard deviations of what is added.
        """
        std_error, interval = math.hypot(self.std_error, math.sqrt(more)), self.interval
        if interval is not None:
            low, high = interval
            middle = self.value if math.isfinite(self.value) else 0.5 * (low + high)
            add = Z_95 * math.sqrt(more)
            if math.isfinite(middle):
                low = middle - math.hypot(middle - low, add)
                high = middle + math.hypot(high - middle, add)
            interval = (low, high)
        return replace(self, std_error=std_error, interval=interval)

    def may_be(self, value: float, wider: float = 1.0) -> bool:
        """
        Tell whether the interval, made wider about the estimate, holds a value; False without one.

        The range of what is not identifiable is no multiple of an error, and stays.

        :param wider: factor of both halves: 1 for 95 %.
        """
        if self.interval is None:
            return False
        low, high = self.interval
        if NOT_IDENTIFIABLE not in self.flags:
            low, high = (self.value + wider * (bound - self.value) for bound in (low, high))
        return low <= value <= high

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers and strings, unknown as None, ready for YAML or JSON."""
        result: dict[str, Any] = {
            'value': _finite(self.value),
            'std_error': _finite(self.std_error),
            'unit': self.unit,
            'flags': list(self.flags),
        }
        if self.interval is not None:
            result['interval'] = [_finite(bound) for bound in self.interval]
        for name in ('reason', 'experiment'):
            if getattr(self, name):
                result[name] = getattr(self, name)
        return result

    @classmethod
    def from_dict(cls, data: Any, where: str) -> Parameter:
        """
        Read what :meth:`to_dict` wrote.

        :param where: what the entry is, for the error sentence.
        :raises ConfigurationError: if ``value`` or ``unit`` is missing or not a number.
        """
        try:
            interval, flags = data.get('interval'), data.get('flags', ())
            if isinstance(flags, str):
                raise ValueError('flags is a list')
            return cls(
                value=_number(data['value']),
                unit=str(data['unit']),
                std_error=_number(data.get('std_error')),
                interval=None
                if interval is None
                else (_number(interval[0]), _number(interval[1])),
                flags=tuple(flags),
                reason=str(data.get('reason', '')),
                experiment=str(data.get('experiment', '')),
            )
        except (AttributeError, KeyError, TypeError, ValueError, IndexError) as error:
            raise ConfigurationError(
                f'{where} is {data!r}: write it as {{value: NUMBER, unit: UNIT}}'
            ) from error


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _number(value: Any) -> float:
    return math.nan if value is None else float(value)
