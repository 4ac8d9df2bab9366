# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The rows of a regression of friction: what a fit is made of, and what several share."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray, IndexArray
from sosml_friction.exceptions import DataError
from sosml_friction.identification.law.friction_memory import FrictionMemory, friction_memory
from sosml_friction.identification.law.friction_trend import FrictionTrend, friction_trend
from sosml_friction.identification.law.law_fit import LawFit
from sosml_friction.identification.law.law_form import LawForm
from sosml_friction.identification.law.law_problem import POWER
from sosml_friction.identification.law.law_search import LawSearch, search_law
from sosml_friction.identification.law.law_summary import LawSummary

#: How far the velocities may be wrong after smoothing, as a share of what it changed. Chosen
#: by S of the rippling exoskeleton, seeds 1 to 5; test/identification/test_rippling_loop.py prints
#: the share of other seeds.
_UNSURE = 0.25


@dataclass(frozen=True)
class LawRows:
    """
    Hold what :func:`~sosml_friction.identification.law.law_search.search_law` takes and explains.

    ``find_smoothing``: fit v0 of the law's sign, and do not use ``smoothing_velocity``.
    ``unsmoothed``: the same rows with velocities from positions alone, if ``v`` is smoothed by the
    torque, else None. ``ways``: what y may be as well, by name (K,): ``held`` if effort is held
    where samples were lost, ``late`` if it acts one standard error later, ``remembered`` if
    friction follows its law over another distance.
    ``trend``: how friction changes over the recording, which y is without; ``trending`` (K, T):
    what y may be off by in that.
    """

    v: FloatArray
    y: FloatArray
    clusters: IndexArray
    keep: BoolArray
    mean_v: FloatArray
    lag: Callable[[FloatArray], FloatArray]
    smoothing_velocity: float = 0.0
    find_smoothing: bool = False
    form: LawForm = field(default_factory=LawForm)
    extra: FloatArray | None = None
    unsmoothed: LawRows | None = None
    ways: Mapping[str, FloatArray] = field(default_factory=dict)
    unsure: FloatArray | None = None
    trending: FloatArray | None = None
    trend: FrictionTrend | None = None

    @property
    def known(self) -> BoolArray:
        """Return which rows take part and have numbers, (K,)."""
        return np.asarray(self.keep & np.isfinite(self.y) & np.isfinite(self.mean_v))

    def fit(self, effort_unit: str) -> LawFit:
        """
        Fit the law to the rows; errors as of ``search_law``.

        Velocities, and effort between samples, may be other than they were taken. Each other way
        changes all parameters together by d, which adds d d^T, times how unsure it is, to their
        covariance.
        """
        fit = self._summary(effort_unit).fit()
        form = replace(self.form, alpha=fit.drawn.get('exponent', self.form.usual))
        for other, unsure in self._other_ways():
            same = replace(
                other, smoothing_velocity=fit.smoothing_velocity, find_smoothing=False, form=form
            )
            try:
                way = same._summary(effort_unit, fit.drawn.get(POWER)).law().drawn
            except DataError:
                continue
            fit = fit.with_shift(
                {n: unsure * (x - way[n]) for n, x in fit.drawn.items() if n in way}
            )
        said = self.trend.check() if self.trend else None
        return replace(fit, checks=(*fit.checks, said)) if said else fit

    def law(self, effort_unit: str) -> LawFit:
        """Return the law that fits best, without what the rows know of its parameters."""
        return self._summary(effort_unit).law()

    def mapped(self, change: Callable[[FloatArray], FloatArray]) -> LawRows:
        """Return the rows with each column of numbers (K,) changed in the same way."""

        def each(x: FloatArray | None) -> FloatArray | None:
            return None if x is None else np.apply_along_axis(change, 0, np.nan_to_num(x))

        return replace(
            self,
            y=change(np.nan_to_num(self.y)),
            lag=lambda column: change(self.lag(column)),
            extra=each(self.extra),
            ways={name: change(np.nan_to_num(y)) for name, y in self.ways.items()},
            unsure=each(self.unsure),
            trending=each(self.trending),
        )

    def memory(
        self, following: Callable[[FloatArray, FloatArray], FloatArray]
    ) -> FrictionMemory | None:
        """
        Return over which distance friction follows its law, None where it follows at once.

        :param following: as for :func:`~.friction_memory.friction_memory`.
        """
        return friction_memory(self._search, following, self.known)

    def with_memory(self, memory: FrictionMemory) -> LawRows:
        """
        Return the rows of the law itself: y without what friction differs from it.

        What is not known is another way: a distance that goes with friction, and one standard
        error more of it; where it does not show, all of it.
        """
        if not memory.shown:
            result = self._with_way(self.y - memory.effort)
            # Which is none of what is searched: the search that told the memory is its own too.
            vars(result)['_search'] = self._search
            return result
        return self.without(memory.effort)._with_way(self.y - memory.bristles)

    def _with_way(self, remembered: FloatArray) -> LawRows:
        return replace(self, ways={**self.ways, 'remembered': remembered})

    def with_trend(self) -> LawRows:
        """Return the rows in the middle of their recording, where friction has a trend."""
        trend = friction_trend(self._search, self.clusters[self.known])
        if trend is None:
            return self
        effort, unsure = np.zeros(len(self.y)), np.zeros((len(self.y), trend.unsure.shape[1]))
        effort[self.known], unsure[self.known] = trend.effort, trend.unsure
        return replace(self.without(effort), trending=unsure, trend=trend)

    def without(self, effort: FloatArray) -> LawRows:
        """Return the rows without an effort (K,), which is none of the law's."""
        slope = self.unsmoothed
        return replace(
            self,
            y=self.y - effort,
            unsmoothed=None if slope is None else replace(slope, y=slope.y - effort),
            ways={name: y - effort for name, y in self.ways.items()},
        )

    def _other_ways(self) -> Iterator[tuple[LawRows, float]]:
        """Yield rows that could be as true, and which share of what they change is unsure."""
        if self.unsmoothed is not None:
            yield self.unsmoothed, _UNSURE
        for y in self.ways.values():
            yield replace(self, y=y), 1.0

    @property
    def _unsure(self) -> FloatArray | None:
        """Return all that y may be off by (K, U)."""
        known = [each for each in (self.unsure, self.trending) if each is not None]
        return np.hstack(known) if known else None

    def _summary(self, effort_unit: str, power: float | None = None) -> LawSummary:
        return LawSummary(self._search, effort_unit, power)

    def smoothing(self) -> float:
        """Return v0 of the law's sign that the rows show, 0 for the sign itself."""
        return self._search.full.v0

    @cached_property
    def _search(self) -> LawSearch:
        return search_law(
            self.v,
            self.y,
            self.clusters,
            self.lag,
            self.keep,
            None if self.find_smoothing else self.smoothing_velocity,
            self.mean_v,
            self.form,
            self.extra,
            self._unsure,
        )
