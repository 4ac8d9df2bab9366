# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a fitted law says of each of its parameters."""

from dataclasses import replace
from functools import cached_property

import numpy as np

from sosml_friction.identification.identifiability import (
    LINEAR,
    SPREAD,
    DataReach,
    experiment_for,
    judged,
    reason_for,
)
from sosml_friction.identification.law.jackknife import t_95
from sosml_friction.identification.law.law_checks import dissipation_check, even_part
from sosml_friction.identification.law.law_curve import largest_friction
from sosml_friction.identification.law.law_fit import STRIBECK_AT_SLOWEST, LawFit
from sosml_friction.identification.law.law_in_place import LawInPlace
from sosml_friction.identification.law.law_problem import EXPONENT, POWER, LawProblem
from sosml_friction.identification.law.law_profile import LawProfile, about_best
from sosml_friction.identification.law.law_search import LawSearch, within
from sosml_friction.identification.law.other_laws import OtherLaws
from sosml_friction.identification.parameter_interval import AT_ZERO, NON_NEGATIVE
from sosml_friction.model.laws import law_definition, law_of, unit_of
from sosml_friction.model.parameter import AT_BOUND, NOT_IDENTIFIABLE, Parameter
from sosml_friction.model.terms.kinds.fading_term import EXPONENTS, fade
from sosml_friction.model.terms.nonlinear_viscous import POWERS, NonlinearViscous

#: Number of points of the profile at which the other parameters are solved for.
_ALONG = 5
#: v_s counts as known if an interval this many times as wide as that of 95 % is narrow, too:
#: 1.5 * 1.96 = 2.9, about three standard errors.
_SURE = 1.5
_ORDER = (
    *('coulomb', 'viscous', 'stribeck', 'stribeck_velocity', EXPONENT),
    *('nonlinear_viscous', POWER, 'bias', 'viscous_asymmetry', 'stribeck_asymmetry'),
)
_NO_COULOMB = (
    'the best fit has no Coulomb friction, the Stribeck term stands in its place: the data do not '
    'tell one from the other'
)
_NO_EXPONENT = (
    f'no exponent from {EXPONENTS[0]:g} to {EXPONENTS[1]:g} makes a Stribeck term that bends as '
    'friction does: what it is at standstill is not known'
)
_AT_END = 'the best fit is at an end of its range, {:g} to {:g}'
_NO_FADE = (
    'a power of speed in its place explains more: friction bends with speed, and what it is at '
    'standstill is not known'
)
_IN_PLACE = (
    'what bends does not fade within the data as extra friction near standstill does: the law has '
    'a power of speed in its place'
)
_NO_SIGN = (
    'its sign is as smooth as the Stribeck term of the best fit is wide: together they are a '
    'bend, and extra friction that is gone before it has its sign is in no data'
)


class LawSummary:
    """
    Say what is known of every parameter of a law that was searched.

    ``shown``: whether the Stribeck term explains more than chance; ``solution``: the law with it
    or without; ``best``: its parameters by name; ``C``: their covariance, by pairs of names;
    ``profile``: None where no Stribeck term was asked for. What costs most, the profile and the
    other laws that may be true, is found when it is asked for. ``in_place``: the law that is named
    for one whose Stribeck term is a bend.

    :param power: of speed, where the law is known to have it and no Stribeck term.
    """

    def __init__(self, search: LawSearch, effort_unit: str, power: float | None = None) -> None:
        self.search, self.form = search, search.form
        self.problem: LawProblem = search.problem
        self.shown = power is None and search.shows_stribeck()
        self.solution = search.full if self.shown else search.plain
        self.found = search.found(self.solution)
        self.in_place = LawInPlace.of(search) if self.shown else None
        if power is not None:
            self.in_place = LawInPlace.at_power(search, power)
        if self.in_place is not None:
            self.shown = False
            self.problem, self.solution = self.in_place.problem, self.in_place.solution
            self.found = self.in_place.found
        self.best = self.problem.values_of(self.solution)
        if EXPONENT not in self.found:
            self.best.pop(EXPONENT, None)
        self.names = tuple(self.best)
        # What one that sits on its bound could be is not known either: the others are as unsure as
        # if it were free.
        self.C = self.problem.covariance(self.solution, self.found)
        freedom = self.problem.freedom(self.solution, self.found)
        self.quantile = {name: t_95(own) for name, own in freedom.items()}
        level = search.level
        # A power of speed that is told may be all that friction grows by.
        (name,) = NonlinearViscous.amplitudes
        absent: tuple[str, ...] = ()
        if (name, name) in self.C:
            half = self.quantile[name] * float(np.sqrt(self.C[name, name]))
            absent = ('viscous',) if self.best[name] > half else ()
        speeds = (search.slowest, search.fastest)
        self.reach = DataReach(effort_unit, *speeds, level, self.best, absent)

    @cached_property
    def profile(self) -> LawProfile | None:
        """Return the profile of the cost over v_s."""
        if self.form.law == 'coulomb_viscous':
            return None
        if not self.shown:
            limit = self.search.limit(self.search.full, 'stribeck', ('stribeck_velocity',))
            return LawProfile.over(self.search, limit)
        v_s, variance = self.best['stribeck_velocity'], self.C[('stribeck_velocity',) * 2]
        half = self.quantile['stribeck_velocity'] * float(np.sqrt(variance))
        limit = self.search.limit(self.solution, 'stribeck_velocity')
        return LawProfile.over(self.search, limit, about_best(self.search, v_s, half / v_s))

    @cached_property
    def others(self) -> OtherLaws:
        """Return the laws that may be true as well."""
        unit = self.reach.effort_unit
        return OtherLaws(self.search, self.solution, self.shown, unit, self.in_place)

    def law(self) -> LawFit:
        """Return the law that fits best, without what the data know of its parameters."""
        problem, residual = self.problem, self.solution.residual
        scale = float(np.linalg.norm(problem.y))
        drawn_law = self._identifier(self.shown)
        return LawFit(
            law=drawn_law,
            parameters={},
            residual_std=float(np.sqrt(np.mean(residual**2))),
            relative_error=(
                100.0 * float(np.linalg.norm(residual)) / scale if scale > 0.0 else np.nan
            ),
            pairs=len(problem.y),
            clusters=problem.count,
            smoothing_velocity=self.solution.v0,
            drawn={n: x for n, x in self.best.items() if n not in problem.extra},
            drawn_law=drawn_law,
            slowest=self.search.slowest,
            extra=tuple(Parameter(self.best[n], '1') for n in problem.extra),
        )

    def fit(self) -> LawFit:
        """Return the law with all that is known of it."""
        problem, solution, best, search = self.problem, self.solution, self.best, self.search
        linear = problem.names(solution.v_s)
        parameters = {name: self._linear(name) for name in linear}
        extra = tuple(parameters.pop(name) for name in problem.extra)
        knee, identified = self._knee()
        parameters.update(knee)
        if self.problem.power is not None:
            parameters[POWER] = self._searched(POWER, (POWERS[0], POWERS[-1]))
        derived = {}
        if self.profile is not None and self.shown and not identified:
            for name in ('coulomb', 'viscous'):
                parameters[name] = self._along(name, parameters[name], self.profile)
        if not self.form.symmetric:
            derived.update(self._by_direction(identified))
        checked = {n: (best[n], parameters[n].interval) for n in best if n in parameters}
        of = tuple(n for n in self.names if (n, n) in self.C and n not in problem.extra)
        unit, speeds = self.reach.effort_unit, (search.slowest, search.fastest)
        found = replace(
            self.law(),
            law=self._identifier(self.shown and identified),
            parameters={
                n: self._beside_others(n, parameters[n]) for n in _ORDER if n in parameters
            },
            derived=derived,
            checks=(
                dissipation_check(checked, unit, *speeds, solution.alpha),
                even_part(problem, solution, self.found, np.array(speeds), unit),
                *self.others.checks,
            ),
            covariance=np.array([[self.C[a, b] for b in of] for a in of]),
            covariance_of=of,
            profile=self.profile,
            extra=extra,
            others=tuple(self.others.curves),
            reach=self.reach,
        )
        if self.profile is None or identified or self.in_place is not None:
            return found
        extra_friction = self._at_slowest(self.profile, found)
        if extra_friction.interval is None or not np.isfinite(extra_friction.interval[1]):
            return found
        return replace(found, derived={STRIBECK_AT_SLOWEST: extra_friction, **derived})

    def _identifier(self, knee: bool) -> str:
        """Return the name of the law, with its Stribeck term or without."""
        name = self.form.identifier(self.solution.alpha if knee else None)
        if self.problem.power is None:
            return name
        return law_of((*law_definition(name).terms, NonlinearViscous.identifier), {}).identifier

    def _beside_others(self, name: str, found: Parameter) -> Parameter:
        """Return a parameter as unsure as other laws make it; a knee's range holds in any."""
        if name in LINEAR or np.isfinite(found.value):
            found = found.with_variance(self.others.variance(name))
        return judged(name, found, self.reach)

    def _linear(self, name: str) -> Parameter:
        """Return a parameter that the law is linear in."""
        value, quantile, reach = self.best[name], self.quantile[name], self.reach
        unit = '1' if name in self.problem.extra else unit_of(name, reach.effort_unit)
        if name in NON_NEGATIVE and value <= 0.0:
            # Free to move, it would go below zero: how far up it may be all the same.
            free = self.problem.free_step(self.solution, self.found, name)
            high = max(free + quantile * float(np.sqrt(self.C[name, name])), 0.0)
            if name != 'coulomb' or self.solution.v_s is None:
                return Parameter(0.0, unit, np.nan, (0.0, high), (AT_BOUND,), AT_ZERO)
            # All of the level at standstill may be Coulomb friction as well as S, and what
            # viscous friction makes of it below the data.
            viscous = self.best['viscous'] * self.search.slowest
            high = max(high, self.problem.stribeck_at(self.solution) + viscous)
            experiment = experiment_for(name, reach)
            none = Parameter.not_told(unit, _NO_COULOMB, (0.0, high), experiment)
            return replace(none, flags=(AT_BOUND, NOT_IDENTIFIABLE))
        return Parameter.estimated(value, unit, float(np.sqrt(self.C[name, name])), quantile)

    def _along(self, name: str, found: Parameter, profile: LawProfile) -> Parameter:
        """
        Return a parameter with what it may be at every v_s that the data leave open.

        The law is not linear in v_s over so wide a range, so that the jackknife at the best fit
        says too little: what is left of the limit at each v_s is left for the parameter there.
        A term that has not faded in the data is Coulomb friction at standstill, and what B is
        beside it no data tell, unless the best fit is such a one.
        """
        problem, search, quantile = self.problem, self.search, self.quantile[name]
        found_there = search.found(search.full)
        last = search.last_knee if search.is_knee(search.full) else np.inf
        open_ = np.flatnonzero(profile.excess <= 1.0)
        picked = np.unique(open_[np.linspace(0, len(open_) - 1, _ALONG).astype(int)])
        ends = [] if found.interval is None else [found.interval]
        for k in picked:
            v_s = float(profile.stribeck_velocity[k])
            if v_s > last and name != 'coulomb':
                continue
            of = (name, 'stribeck') if v_s > last else (name,)
            fit = search.whole(search.at(v_s))
            values = problem.values_of(fit)
            value = sum(values[one] for one in of)
            C = problem.covariance(fit, found_there, ('stribeck_velocity',))
            variance = sum(C[one, two] for one in of for two in of)
            room = np.sqrt(max(1.0 - float(profile.excess[k]), 0.0))
            half = quantile * float(np.sqrt(max(variance, 0.0))) * room
            ends.append((value - half, value + half))
        interval = (max(min(low for low, _ in ends), 0.0), max(high for _, high in ends))
        if NOT_IDENTIFIABLE in found.flags:
            return replace(found, interval=interval)
        error = max(found.std_error, 0.5 * (interval[1] - interval[0]) / quantile)
        return replace(found, std_error=error, interval=interval)

    def _knee(self) -> tuple[dict[str, Parameter], bool]:
        """Return S and v_s, and whether the data give both."""
        shown, best, C, reach, profile = self.shown, self.best, self.C, self.reach, self.profile
        units = {n: unit_of(n, reach.effort_unit) for n in ('stribeck', 'stribeck_velocity')}
        if profile is None:
            reason = 'the law that was asked for has no such term'
            return {n: Parameter.not_told(unit, reason) for n, unit in units.items()}, False
        v_s = profile.velocity_interval() if shown else (0.0, np.inf)
        reason = reason_for('stribeck_velocity', reach, v_s)
        if shown and not reason:
            # The interval of 95 % may be closed by chance; at three standard errors it is then
            # open or lopsided.
            wide = profile.velocity_interval(_SURE**2)
            if not (wide[0] > 0.0 and wide[1] <= SPREAD**_SURE * wide[0]):
                reason = reason_for('stribeck_velocity', reach, wide)
        if self.in_place is not None:
            reason = _NO_SIGN if self.problem.power is None else _IN_PLACE
        reason = self._no_knee() or reason
        if shown and not reason:
            error = float(np.sqrt(C['stribeck', 'stribeck']))
            half = self.quantile['stribeck'] * error
            S = (best['stribeck'] - half, best['stribeck'] + half)
            # S goes with the exponential of 1 / v_s: where that matters its range is lopsided.
            low, high = profile.stribeck_interval()
            reason = reason_for('stribeck', reach, (min(low, S[0]), max(high, S[1])))
            if not reason:
                knee = {
                    'stribeck': Parameter(best['stribeck'], units['stribeck'], error, S),
                    'stribeck_velocity': Parameter(
                        best['stribeck_velocity'],
                        units['stribeck_velocity'],
                        float(np.sqrt(C['stribeck_velocity', 'stribeck_velocity'])),
                        v_s,
                    ),
                }
                if EXPONENT in best:
                    knee[EXPONENT] = self._searched(EXPONENT, EXPONENTS)
                return knee, True
        # What may fade below the slowest speed may be anything at standstill: no data reach there.
        # And nothing is known of it where what bends is no such term.
        reaches = v_s[0] >= self.search.slowest and not self._no_knee()
        low, high = profile.stribeck_interval() if reaches else (0.0, np.inf)
        if shown:
            # The profile is of any exponent; the best fit may be of one, at another v_s.
            found, name = best['stribeck_velocity'], 'stribeck_velocity'
            half = self.quantile[name] * float(np.sqrt(C[name, name]))
            v_s = max(min(v_s[0], found - half), 0.0), max(v_s[1], found + half)
        ranges = {'stribeck': (low, high), 'stribeck_velocity': v_s if shown else None}
        experiment = experiment_for('stribeck', reach)
        knee = {n: Parameter.not_told(units[n], reason, ranges[n], experiment) for n in units}
        if EXPONENT in best:
            knee[EXPONENT] = Parameter.not_told('1', reason, EXPONENTS, experiment)
        if not shown and self.search.problem.stribeck_at(self.search.full) <= 0.0:
            knee['stribeck'] = replace(knee['stribeck'], flags=(NOT_IDENTIFIABLE, AT_BOUND))
        return knee, False

    def _no_knee(self) -> str:
        """Return why the best fit is none of a Stribeck term as friction has it, '' if it may."""
        if not self.shown:
            return ''
        if self.search.is_smooth(self.solution):
            return _NO_SIGN
        if EXPONENT in self.best and self._would_go_beyond():
            return _NO_EXPONENT
        if not self.others.is_faded:
            return _NO_FADE
        return _NO_COULOMB if self.best['coulomb'] <= 0.0 else ''

    def _would_go_beyond(self) -> bool:
        """Tell whether the exponent is at an end of its range and would leave it beyond chance."""
        if within(self.best[EXPONENT], EXPONENTS):
            return False
        step = self.problem.free_step(self.solution, self.found, EXPONENT)
        error = float(np.sqrt(self.C[EXPONENT, EXPONENT]))
        return abs(step) > self.quantile[EXPONENT] * error

    def _searched(self, name: str, ends: tuple[float, float]) -> Parameter:
        """Return power or exponent; at an end of its range it is what is within that."""
        value, error = self.best[name], float(np.sqrt(self.C[name, name]))
        found = Parameter.estimated(value, '1', error, self.quantile[name])
        if found.interval is None or (name == EXPONENT and within(value, ends)):
            return found
        low, high = np.clip(found.interval, *ends).tolist()
        cut = replace(found, interval=(low, high))
        if within(value, ends):
            return cut
        return replace(cut, flags=(AT_BOUND,), reason=_AT_END.format(*ends))

    def _at_slowest(self, profile: LawProfile, fit: LawFit) -> Parameter:
        """
        Return the extra friction at the slowest speed of the data: at most all that is there.

        S f(w) <= C + S f(w) + B w, as neither C nor B is below 0: beside a negative C it had no
        end. ``fit`` says what friction is there.
        """
        slowest = self.search.slowest
        low, high = profile.stribeck_interval(slowest)
        all_of_it = largest_friction(fit, slowest)
        if np.isfinite(high) and all_of_it is not None:
            high = min(high, all_of_it)
        value = np.nan
        if self.shown and not self._no_knee():
            left = fade(np.asarray(slowest), self.best['stribeck_velocity'], self.solution.alpha)
            value = self.best['stribeck'] * float(left)
        else:
            # No S at all is what the test did not refuse, or what bends is none.
            low = 0.0
        return Parameter(
            value if low > 0.0 else np.nan,
            self.reach.effort_unit,
            interval=(low, high),
            flags=() if low > 0.0 else (NOT_IDENTIFIABLE,),
        )

    def _by_direction(self, identified: bool) -> dict[str, Parameter]:
        """Return the friction of each direction, of a law that tells them apart."""
        best, C = self.best, self.C
        pairs = [('coulomb', 'bias'), ('viscous', 'viscous_asymmetry')]
        if identified:
            pairs.append(('stribeck', 'stribeck_asymmetry'))
        result = {}
        for one, two in pairs:
            if (one, one) not in C:
                continue
            for way, side in ((1.0, 'positive'), (-1.0, 'negative')):
                value = best[one] + way * best[two]
                error = float(
                    np.sqrt(max(C[one, one] + C[two, two] + 2.0 * way * C[one, two], 0.0))
                )
                unit = unit_of(one, self.reach.effort_unit)
                quantile = max(self.quantile[one], self.quantile[two])
                result[f'{one}_{side}'] = Parameter.estimated(value, unit, error, quantile)
        return result
