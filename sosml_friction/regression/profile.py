# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the data leave open of a term whose inner parameters are known too poorly to linearise."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.parameter import Z_95, Parameter
from sosml_friction.model.terms.kinds.term import Inner
from sosml_friction.regression.estimate import Estimate, Linear, equations_of, settle
from sosml_friction.regression.inner_scale import moved, open_ends, per_step, step_between
from sosml_friction.regression.placed import Placed, with_amplitudes
from sosml_friction.regression.whitened import WhitenedRegression

#: An inner parameter with a larger error, as of inner_scale.py, is followed: where it is 0.05, S
#: at 0.6 Stribeck velocities has 17 of 20 linearised intervals that hold the truth.
_LINEAR = 0.03
#: Step along the profile in standard errors, and the most as of inner_scale.py.
_STEP, _LONGEST = 0.5, 0.3
#: Steps after which each is twice the last. A parabola needs no more than three; it is time that
#: hangs on it.
_MANY = 12


@dataclass(frozen=True)
class ProfilePoint:
    """
    Hold the best fit at one value of an inner parameter.

    ``excess``: cost above the least, in units of the 95 % limit; ``inner`` and ``amplitude`` (k,)
    of the term there, ``half`` (k,) half of the range of each within the limit.
    """

    excess: float
    inner: Inner
    amplitude: FloatArray
    half: FloatArray


@dataclass(frozen=True)
class Profile:
    """
    Hold the 95 % intervals of a term along the profile of the cost.

    ``inner`` by name, an end that the physical range sets is open (inner_scale.py); ``amplitude``
    (k, 2); ``points`` within the limit.
    """

    inner: Mapping[str, tuple[float, float]]
    amplitude: FloatArray
    points: tuple[ProfilePoint, ...]

    @classmethod
    def make(
        cls, laboratory: WhitenedRegression, estimate: Estimate, which: int
    ) -> 'Profile | None':
        """
        Return the profile of a term; None where its linearised intervals hold.

        Along each of its inner parameters, the term's others and all sizes are fitted anew; the
        inner parameters of other terms stay. The limit is where the cost is 1.96^2 times the
        variance of what is left above the least; each end is as much farther as a rival of the
        term says.
        """
        placed = estimate.placed[which]
        ranges = placed.term.searched_inner(laboratory.signals[0], placed.joint)
        errors = {
            name: float(
                _without(error, estimate.inner_shift[which][name])
                / per_step(float(placed.inner[name]), ranges[name])
            )
            for name, error in estimate.inner_errors[which].items()
        }
        if max(errors.values(), default=0.0) < _LINEAR:
            return None
        walk = _Walk(laboratory, estimate, which)
        found: dict[str, tuple[float, float]] = {}
        points = [walk.at({}, ())]
        for name, error in errors.items():
            ends = []
            for way in (-1.0, 1.0):
                end, passed = walk.along(name, way * min(_STEP * error, _LONGEST))
                ends.append(end)
                points += passed
            by = estimate.inner_shift[which][name]
            found[name] = farther((ends[0], ends[1]), float(placed.inner[name]), by)
        low = np.min([p.amplitude - p.half for p in points], axis=0)
        high = np.max([p.amplitude + p.half for p in points], axis=0)
        fitted = (x[walk.part] for x in (estimate.fit.baseline.x, estimate.shift))
        rows = zip(*(x.tolist() for x in (low, high, *fitted)), strict=True)
        sizes = np.array([farther((a, b), x, by) for a, b, x, by in rows])
        return cls(found, sizes, tuple(points))


def _without(error: FloatArray | float, part: FloatArray | float) -> FloatArray:
    """Return an error without one of the independent parts that it is made of."""
    return np.sqrt(np.maximum(np.square(error) - np.square(part), 0.0))


def farther(ends: tuple[float, float], value: float, shift: float) -> tuple[float, float]:
    """Return a 95 % interval about a value with another error added; it does not pass 0."""
    low, high = Parameter(value, '', 0.0, ends).with_variance(shift**2).interval or ends
    return (max(low, 0.0) if ends[0] >= 0.0 else low), (min(high, 0.0) if ends[1] <= 0.0 else high)


class _Walk:
    """Go along the profile from the best fit."""

    def __init__(self, laboratory: WhitenedRegression, estimate: Estimate, which: int) -> None:
        self.laboratory, self.estimate = laboratory, estimate
        others = [each for k, each in enumerate(estimate.placed) if k != which]
        self.placed = [*others, estimate.placed[which]]
        self.least = estimate.fit.baseline.cost
        linear = Linear.make(laboratory, estimate.placed, estimate.fit.baseline.x)
        parts = list(with_amplitudes(estimate.placed, len(laboratory.nominal.bound)))
        self.part = parts[which][1]
        modelled = np.diag(linear.covariance()[0])[self.part]
        # How much more scatter there is than the modelled noise makes, in this term's sizes.
        errors = _without(estimate.errors[self.part], estimate.shift[self.part])
        self.limit = Z_95**2 * float(np.max(errors**2 / modelled))
        self.now: list[Placed] = self.placed

    def at(self, inner: Mapping[str, float], held: tuple[str, ...]) -> ProfilePoint:
        """Return the best fit with some inner parameters of the term held."""
        own = self.now[-1]
        start = [*self.now[:-1], own.with_inner(self.laboratory, {**own.inner, **inner})]
        first = self.laboratory.signals[0]
        everything = frozenset(
            (k, name)
            for k, each in enumerate(start[:-1])
            for name in each.term.searched_inner(first, each.joint)
        )
        mine = frozenset((len(start) - 1, name) for name in held)
        self.now = settle(self.laboratory, start, held=everything | mine) if held else start
        x, cost = equations_of(self.laboratory, self.now).solve()
        shape = frozenset((len(start) - 1, name) for name in own.inner)
        linear = Linear.make(self.laboratory, self.now, x, everything | shape)
        modelled = np.diag(linear.covariance()[0])
        part = list(with_amplitudes(self.now, len(self.laboratory.nominal.bound)))[-1][1]
        excess = (cost - self.least) / self.limit
        room = max(1.0 - excess, 0.0) * self.limit
        half = np.sqrt(room * modelled[part])
        return ProfilePoint(excess, dict(self.now[-1].inner), x[part], half)

    def along(self, name: str, step: float) -> tuple[float, list[ProfilePoint]]:
        """Return where an inner parameter leaves the limit, and the points before."""
        self.now = self.placed
        own = self.placed[-1]
        ends = own.term.searched_inner(self.laboratory.signals[0], own.joint)[name]
        value, root = float(own.inner[name]), 0.0
        passed: list[ProfilePoint] = []
        while True:
            # From one end of its range it goes to the other.
            inside = value > ends[0] if step < 0.0 else value < ends[1]
            if not inside:
                return open_ends(ends)[int(step > 0.0)], passed
            ahead = moved(value, step, ends)
            point = self.at({name: ahead}, (name,))
            reached = float(np.sqrt(max(point.excess, 0.0)))
            if reached > 1.0:
                # A cost is a parabola about its least: its root is nearly straight.
                share = (1.0 - root) / max(reached - root, 1e-12)
                return moved(value, share * step_between(value, ahead, ends), ends), passed
            passed.append(point)
            value, root = ahead, reached
            # The error was far too small: the end is not near.
            if len(passed) > _MANY:
                step = float(np.copysign(min(2.0 * abs(step), _LONGEST), step))
