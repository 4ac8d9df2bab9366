# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of fitted terms with their intervals: what a fit and a diagnosis say alike."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.identification.identifiability import (
    SPREAD,
    DataReach,
    experiment_for,
    reason_for,
)
from sosml_friction.identification.number_text import format_interval, plus_minus
from sosml_friction.identification.parameter_interval import half_width
from sosml_friction.model.parameter import AT_BOUND, NOT_IDENTIFIABLE, Z_95, Parameter
from sosml_friction.model.terms.kinds.fading_term import fade
from sosml_friction.regression.estimate import Estimate
from sosml_friction.regression.inner_scale import is_place
from sosml_friction.regression.placed import with_amplitudes
from sosml_friction.regression.profile import Profile, farther
from sosml_friction.regression.report_slopes import ReportSlopes
from sosml_friction.regression.whitened import WhitenedRegression

#: A parameter within this share of the end of its physical range sits on it.
_AT_END = 1e-3
#: Share of the steady samples that may be slower than the slowest speed, as in a fit of a law.
_SLOWEST = 0.02
#: A sample is steady where its sign of motion is settled to this share, and its speed changes by
#: less than itself within a cycle of the band.
_SETTLED = 0.99
#: Share of friction that is none.
_NOTHING = 1e-6
_HOLDS_ZERO = 'its interval holds 0: these data do not show it'


def term_parameters(
    laboratory: WhitenedRegression, estimate: Estimate, reported: bool = False
) -> list[dict[str, Parameter]]:
    """
    Return the parameters of each term with 95 % intervals, and what speaks against their use.

    Intervals are of the one covariance of all that was fitted; of a term whose inner parameters
    are not known well enough to be linear, of the profile of the cost. Where that is open, or its
    ends differ by a factor of more than 3, its sizes and inner parameters are known together
    only: each is a range, and flagged.

    :param reported: whether by the names under which a diagnosis reports them.
    """
    result = []
    for k, linear in enumerate(linear_parameters(laboratory, estimate, not reported)):
        own = with_profile(laboratory, estimate, k, linear)
        if reported:
            names = estimate.placed[k].term.reported_as
            own = {names.get(name, name): p for name, p in own.items()}
        result.append(own)
    return result


def linear_parameters(
    laboratory: WhitenedRegression, estimate: Estimate, asked: bool = True
) -> list[dict[str, Parameter]]:
    """Return the parameters of each term with intervals of the one covariance alone."""
    result = []
    for placed, fitted in zip(estimate.placed, estimate.fitted(laboratory), strict=True):
        bounds = placed.term.inner_bounds(laboratory.signals[0], fitted.joint)
        result.append(
            {
                name: with_interval(p, bounds.get(name), asked)
                for name, p in placed.term.parameters(fitted).items()
            }
        )
    return result


def with_profile(
    laboratory: WhitenedRegression,
    estimate: Estimate,
    which: int,
    linear: Mapping[str, Parameter],
) -> dict[str, Parameter]:
    """Return the parameters of a term, those that are not linear by the profile of the cost."""
    profile = Profile.make(laboratory, estimate, which)
    followed = _followed(laboratory, estimate, which, linear, profile) if profile else {}
    return {**linear, **followed}


def with_interval(
    p: Parameter, bounds: tuple[float, float] | None = None, asked: bool = True
) -> Parameter:
    """
    Return a parameter with its interval, and what speaks against using it blindly.

    :param asked: whether it was asked for, and may not be there: of a cause that was named, a
        component may well be 0.
    """
    if not math.isfinite(p.std_error):
        return p
    low, high = p.value - Z_95 * p.std_error, p.value + Z_95 * p.std_error
    flags: tuple[str, ...] = ()
    reason = ''
    if bounds is not None and (
        p.value <= bounds[0] + _AT_END * abs(bounds[0])
        or p.value >= bounds[1] - _AT_END * abs(bounds[1])
    ):
        flags = (AT_BOUND,)
        reason = f'it sits at the end of its physical range, {bounds[0]:.3g} to {bounds[1]:.3g}'
    elif asked and low <= 0.0 <= high and not (bounds and is_place(bounds)):
        flags = (NOT_IDENTIFIABLE,)
        reason = _HOLDS_ZERO
    return replace(p, interval=(low, high), flags=flags, reason=reason)


def size_text(p: Parameter) -> str:
    """Return a value with half of its 95 % interval, or its range; alone if neither is known."""
    if not math.isfinite(p.std_error) or p.std_error <= 0.0:
        return f'{p.value:.4g}'
    if p.interval is not None and NOT_IDENTIFIABLE in p.flags and p.reason != _HOLDS_ZERO:
        low, high = p.interval
        upper = f'to {high:.3g}' if math.isfinite(high) else 'up'
        return f'{p.value:.3g} (somewhere from {low:.3g} {upper})'
    return plus_minus(p.value, half_width(p))


def _followed(
    laboratory: WhitenedRegression,
    estimate: Estimate,
    which: int,
    linear: Mapping[str, Parameter],
    profile: Profile,
) -> dict[str, Parameter]:
    """Return the parameters that a profile has intervals of."""
    placed = estimate.placed[which]
    term = placed.term
    ends = {**profile.inner}
    parts = with_amplitudes(estimate.placed, len(laboratory.nominal.bound))
    part = list(parts)[which][1]
    slopes = ReportSlopes.of(laboratory, estimate.placed).slopes(estimate.fit.baseline.x)
    torque, errors = estimate.in_torque(laboratory)
    # What not knowing the report adds.
    more = np.sqrt(np.maximum(errors**2 - (estimate.errors / slopes) ** 2, 0.0))
    sizes = np.sort(profile.amplitude / slopes[part, None], axis=1)
    rows = zip(sizes.tolist(), torque[part].tolist(), more[part].tolist(), strict=True)
    for name, ((low, high), value, by) in zip(term.amplitudes, rows, strict=True):
        ends[name] = farther((low, high), value, by)
    found = {name: replace(linear[name], interval=ends[name]) for name in ends if name in linear}
    ranges = term.searched_inner(laboratory.signals[0], placed.joint)
    told = {name: own for name, own in profile.inner.items() if name in term.inner}
    open_ = [name for name, own in told.items() if _is_open(own, ranges[name])]
    reach = _reach(laboratory, estimate, which)
    reason = next(filter(None, (reason_for(n, reach, ends[n]) for n in _KNEE if n in ends)), '')
    if not reason and open_:
        name = open_[0]
        low, high = ends[name]
        reason = f'{name.replace("_", " ")} is only known to be between {low:.3g} and {high:.3g}'
    if not reason:
        return found
    experiment = ''
    if term.identifier == 'stribeck':
        reason = f'{reason}; {_at_slowest(reach, profile, float(slopes[part.start]))}'
        experiment = experiment_for('stribeck', reach)
    flags = (NOT_IDENTIFIABLE,)
    return {
        name: replace(p, flags=flags, reason=reason, experiment=experiment)
        for name, p in found.items()
    }


def _is_open(interval: tuple[float, float], ends: tuple[float, float]) -> bool:
    """Tell whether of a size not even a factor, of a place not both sides are known."""
    low, high = interval
    if is_place(ends):
        return not (math.isfinite(low) and math.isfinite(high))
    return not (low > 0.0 and high <= SPREAD * low)


#: What a fit of a law asks for its reason, in this order.
_KNEE = ('stribeck_velocity', 'stribeck')


def _reach(laboratory: WhitenedRegression, estimate: Estimate, which: int) -> DataReach:
    """Return what the recordings cover in the joint of a term."""
    placed = estimate.placed[which]
    i = placed.joint
    steady = steady_speeds(laboratory, i)
    return DataReach(
        laboratory.robot.effort_units[i],
        slowest_speed(steady),
        float(steady.max()),
        float(laboratory.signals[0].scales.level(i)),
        {name: float(x) for name, x in placed.inner.items()},
    )


def steady_speeds(laboratory: WhitenedRegression, i: int) -> FloatArray:
    """Return the speeds of joint ``i`` away from its turning points, 0 where there are none."""
    speeds = []
    for s in laboratory.signals:
        speed, change = np.abs(s.v[:, i]), np.abs(s.a[:, i]) / s.band.cutoff
        speeds.append(speed[(np.abs(s.sign[:, i]) > _SETTLED) & (change < speed)])
    steady = np.concatenate(speeds)
    return steady if len(steady) else np.zeros(1)


def slowest_speed(steady: FloatArray) -> float:
    """Return the speed at which data begin, but for a few of them."""
    return float(np.quantile(steady, _SLOWEST))


def _at_slowest(reach: DataReach, profile: Profile, slope: float) -> str:
    """
    Return what is known of a Stribeck term where it was recorded.

    :param slope: by which the profile's sizes are reported.
    """
    ends = []
    for point in profile.points:
        v_s, exponent = point.inner['stribeck_velocity'], point.inner['exponent']
        left = float(fade(reach.slowest, v_s, exponent)) / slope
        ends += [left * float(point.amplitude[0] + way * point.half[0]) for way in (-1.0, 1.0)]
    if max(ends) < _NOTHING * reach.level:
        return f'at {reach.speed(reach.slowest)} nothing is left of it'
    known = format_interval(max(min(ends), 0.0), max(ends))
    return f'at {reach.speed(reach.slowest)} it is {known} {reach.effort_unit}'
