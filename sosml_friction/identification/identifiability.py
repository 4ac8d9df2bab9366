# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
When a parameter counts as identifiable, why not if not, and what to record instead.

The rule is stated on the 95 % interval of half width h that the data leave:

* C and B: the interval leaves out 0, so that it is known that the term is there, or the torque
  that h stands for is at most 1 % of the friction level (the median of |tau_f|): h itself, for
  viscous terms h times the fastest speed. A wide interval is a number with a wide interval.
* Bias and the asymmetries, which may well be 0, and B beside a power of speed that is told: that
  torque is at most the friction level.
* S and v_s: the profile interval is closed, and its ends differ by a factor of at most 3. That the
  term is there at all is tested by itself.

S and v_s are identifiable together or not at all.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from sosml_friction.identification.parameter_interval import NON_NEGATIVE
from sosml_friction.model.laws import unit_of
from sosml_friction.model.parameter import NOT_IDENTIFIABLE, Parameter

#: Torque that half of an interval may stand for, though it does not leave out 0, as a share of the
#: friction level, and that of what may well be 0.
SHARE_OF_LEVEL, SHARE_OF_OFFSET = 0.01, 1.0
#: Largest ratio of the ends of the intervals of S and v_s.
SPREAD = 3.0
#: Parameters that a law is linear in, whatever its knee.
LINEAR = ('coulomb', 'viscous', 'bias', 'viscous_asymmetry', 'stribeck_asymmetry')
#: How a reason begins that is an interval.
_ITS_INTERVAL = 'its 95 % interval is'


@dataclass(frozen=True)
class DataReach:
    """
    Hold what a recording covers.

    ``slowest`` and ``fastest`` [rad/s or m/s]; ``level``: median of |tau_f| [Nm or N]; ``best``:
    the best fit by parameter; ``absent``: which may well be 0 beside the others of the law.
    """

    effort_unit: str
    slowest: float
    fastest: float
    level: float
    best: Mapping[str, float] = field(default_factory=dict)
    absent: tuple[str, ...] = ()

    def speed(self, value: float) -> str:
        """Return a speed with its unit."""
        return f'{value:.3g} {unit_of("stribeck_velocity", self.effort_unit)}'


def reason_for(name: str, reach: DataReach, interval: tuple[float, float]) -> str:
    """Return why a parameter with this 95 % interval is not identifiable, '' if it is."""
    low, high = interval
    if name == 'stribeck_velocity':
        return _velocity_reason(reach, interval)
    if name == 'stribeck':
        if low > 0.0 and high <= SPREAD * low:
            return ''
        v_s = reach.best.get('stribeck_velocity', np.nan)
        if v_s < reach.slowest:
            return (
                f'the data begin at {reach.speed(reach.slowest)} and the Stribeck velocity of the '
                f'best fit is {reach.speed(v_s)}: what is nearer to standstill is not in them'
            )
        return (
            f'the Stribeck friction is only known to be between {max(low, 0.0):.3g} and '
            f'{high:.3g} {reach.effort_unit}'
        )
    half = 0.5 * (high - low)
    present = name in ('coulomb', 'viscous') and name not in reach.absent
    floor = SHARE_OF_LEVEL if present else SHARE_OF_OFFSET
    floor *= reach.level / (max(reach.fastest, 1e-300) if name.startswith('viscous') else 1.0)
    if low > 0.0 or high < 0.0 or half <= floor:
        return ''
    unit = unit_of(name, reach.effort_unit)
    low = max(low, 0.0) if name in NON_NEGATIVE else low
    text = f'{_ITS_INTERVAL} {low:.3g} to {high:.3g} {unit}, which does not leave out 0'
    if name.startswith('viscous'):
        text += f', from speeds up to {reach.speed(reach.fastest)} only'
    return text


def judged(name: str, found: Parameter, reach: DataReach | None) -> Parameter:
    """
    Return a parameter with what its interval makes of it.

    No end is where the parameter cannot be. One that the law is linear in is not identifiable if
    the interval says so, whatever widened it; one that was not stays so. S and v_s are told
    together, by their profile.

    :param reach: None where only the ends are to be looked at.
    """
    if found.interval is None:
        return found
    low, high = found.interval
    if name in NON_NEGATIVE:
        low, high = max(low, 0.0), max(high, 0.0)
    cut = replace(found, interval=(low, high))
    if reach is None or name not in LINEAR:
        return cut
    reason = reason_for(name, reach, found.interval)
    if NOT_IDENTIFIABLE in found.flags:
        old = found.reason
        return replace(cut, reason=reason if old.startswith(_ITS_INTERVAL) and reason else old)
    if not reason:
        return cut
    return replace(
        cut,
        value=np.nan,
        std_error=np.nan,
        flags=(*found.flags, NOT_IDENTIFIABLE),
        reason=reason,
        experiment=experiment_for(name, reach),
    )


def _velocity_reason(reach: DataReach, interval: tuple[float, float]) -> str:
    low, high = interval
    if low > 0.0 and high <= SPREAD * low:
        return ''
    v_s = reach.best.get('stribeck_velocity', np.nan)
    if not np.isfinite(v_s):
        return (
            'the data show no extra friction near standstill: their slowest speed is '
            f'{reach.speed(reach.slowest)}'
        )
    ratio = reach.slowest / v_s
    if low <= 0.0:
        return f'the slowest speed is {ratio:.2g} times the Stribeck velocity of the best fit'
    if not np.isfinite(high):
        return (
            f'the fastest speed, {reach.speed(reach.fastest)}, is only '
            f'{reach.fastest / v_s:.2g} times the Stribeck velocity of the best fit'
        )
    return f'the Stribeck velocity is only known to be between {low:.3g} and {reach.speed(high)}'


def experiment_for(name: str, reach: DataReach) -> str:
    """Return what to record for a parameter that is not identifiable."""
    if name in ('stribeck', 'stribeck_velocity', 'stribeck_asymmetry'):
        v_s = reach.best.get('stribeck_velocity', np.nan)
        first = 0.25 * reach.slowest if not np.isfinite(v_s) else min(v_s / 3.0, reach.slowest)
        begin = float(f'{first:.1g}')
        text = f'record T3, a slow ladder with plateaus from {reach.speed(begin)}'
        if np.isfinite(v_s) and reach.fastest < 8.0 * v_s:
            fast = float(f'{20.0 * v_s:.1g}')
            return f'record T1, a speed ladder up to {reach.speed(fast)}, and fit both together'
        return f'{text}: at most twice the Stribeck velocity'
    if name.startswith('viscous'):
        fast = float(f'{10.0 * reach.fastest:.1g}')
        return f'record T1, a speed ladder up to {reach.speed(fast)} or what the joint allows'
    if name == 'coulomb':
        return 'record T1, a speed ladder in both directions with plateaus over a decade of speeds'
    return 'record plateaus in both directions at the same places'
