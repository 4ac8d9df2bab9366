# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a motion says of the rigid body of a model, and of when effort acts."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial

import numpy as np

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import DataError
from sosml_friction.identification.body_doubt import BodyDoubt
from sosml_friction.identification.body_refit import (
    FRICTION,
    LOAD,
    NOMINAL,
    BodyRefit,
    friction_beside,
)
from sosml_friction.identification.effort_timing import EffortTiming
from sosml_friction.identification.late_effort import (
    Late,
    beyond_interval,
    delays_of,
    find_late,
    hold_columns,
    sooner,
    undone,
)
from sosml_friction.identification.law.law_fit import LawFit
from sosml_friction.identification.repeating_effort import COGGING, repeating
from sosml_friction.identification.term_fit import FittedTerm, TermFit, fit_terms
from sosml_friction.model.model_folder import EffectTerm, RobotModelFile
from sosml_friction.model.parameter import AT_BOUND, Parameter
from sosml_friction.regression.rival import VERY_STRONG
from sosml_friction.regression.settings import DiagnosisSettings

#: What repeats over position is noise beside bodies, but for what is much of all that is left: its
#: hundreds of lines are much of the time of a comparison, and of an hour most of its memory.
_WITHOUT = (COGGING,)
#: Friction that is fitted again only where the data show it.
_MORE_FRICTION = tuple(term for term in FRICTION if term not in NOMINAL)
#: By joint, the law that was fitted beside bodies, and friction by load.
FrictionBeside = tuple[Mapping[str, LawFit], tuple[EffectTerm, ...]]
#: What friction by load has of the load.
COEFFICIENT = 'load_coefficient'


@dataclass(frozen=True)
class BodyComparison:
    """
    Hold what a regression finds of a model before its friction law is fitted.

    ``refit``: the rigid body that fits, None where the model's does within the usual tolerance.
    ``timing``: by joint, when effort is reported; none where nothing was fitted. ``doubt``: what
    the bodies may be off by where the model's are kept, None where they are exact, as told, or
    refitted.
    ``late``: by joint, by how much effort was taken sooner, or later, for all of these, or would
    be if no hold were stated; none where it acts between its samples.
    ``loads``: by joint, the share of its load that is friction, where the data show it.
    ``repeats``: by joint, the cogging that was fitted besides, where it is much of what is left.
    ``friction`` returns what was fitted beside these bodies: by joint its law, and friction by
    load. Beside the model's own bodies it is fitted when it is asked for.
    """

    refit: BodyRefit | None = None
    timing: Mapping[str, EffortTiming] = field(default_factory=dict)
    doubt: BodyDoubt | None = None
    late: Late = field(default_factory=dict)
    loads: Mapping[str, Parameter] = field(default_factory=dict)
    repeats: Mapping[str, FittedTerm] = field(default_factory=dict)
    friction: Callable[[], FrictionBeside] = field(default=lambda: ({}, ()), repr=False)

    @classmethod
    def of(
        cls,
        logs: Sequence[JointLog],
        model: RobotModelFile,
        tolerance: float | None = None,
        step: Callable[[str], None] = lambda text: None,
        stated: bool = False,
        only_late: bool = False,
    ) -> BodyComparison:
        """
        Compare a model with a motion; an armature that it does not know is fitted in any case.

        Beside Coulomb, viscous, Stribeck and load-dependent friction, so that a weight that is off
        is not taken for friction, nor friction by load for a weight. Each recording has Coulomb
        and viscous friction and a bias of its own, which warmth or the zero of a current change:
        what differs between recordings is none of the bodies that they share. In motion alone:
        for how long a joint sticks where it turns around says nothing of bodies, and a slow
        recording does not show it.

        :param logs: the motion; its joints include the model's.
        :param tolerance: how far each number may be off, as a share of itself; None for what the
            data say (:func:`~sosml_friction.regression.body_width.choose_width`); 0 for not at
            all: then rotors that are not known and when effort acts are found alone.
        :param stated: whether the hold of effort is stated: then effort is used as it is.
        :param only_late: whether nothing but ``late`` is asked for.
        :raises DataError: if a tolerance was told, or an armature is not known, and the recording
            is too short for a refit.
        """
        unknown = model.unknown_armature
        bare = replace(model, effects=())
        settings = DiagnosisSettings(moving_only=True, own_friction=True)
        plain = partial(fit_terms, settings=settings, step=step, without=_WITHOUT)
        first = partial(plain, model=bare, body_tolerance=tolerance)
        try:
            fit = first(logs, terms=FRICTION)
        except DataError as error:
            if unknown:
                raise DataError(
                    f'{error}; or state the armature of {", ".join(unknown)} with --armature: it '
                    'is fitted as it is not known'
                ) from error
            if not tolerance:
                return cls()
            raise
        late: Late = {}
        lines = repeating(fit)
        beside = (*FRICTION, *lines)
        if lines:
            step('fitting what repeats with position besides')
            fit = first(logs, terms=beside)
        if any(_rotors(fit).values()):
            # Effort that is late is that of all inertia, the rotors' too.
            fit = first(logs, terms=beside, rotors=_rotors(fit))
        # Beyond an interval effort is as late as it is, which reads as viscous friction. The
        # column is the slope of a small delay: a large one is found in several rounds.
        recorded, as_recorded = logs, fit
        tried = [_samples(late)]
        while beyond := beyond_interval(fit, late):
            step('measuring how late effort is')
            delayed = first(logs, terms=(*beside, *delays_of(fit.names)), rotors=_rotors(fit))
            more = find_late(delayed, logs, late, beyond)
            if _samples(more) in tried:
                break
            late = more
            tried.append(_samples(late))
            logs = [undone(late, log) for log in recorded]
            fit = first(logs, terms=beside, rotors=_rotors(delayed))
        if late:
            late = _measured_again(late, _measured(fit, logs, late))
        if only_late:
            return cls(late=late)
        taken = late
        if stated:
            logs, fit, taken = recorded, as_recorded, {}
        fit_with = partial(plain, logs, rotors=_rotors(fit))
        repeats = {t.joint: fit.profiled(t) for t in fit.linear if t.term == COGGING}
        shown = [t for t in fit.linear if t.term in _MORE_FRICTION and _is_shown(fit, t)]
        # What is said of a law is a name: it has to be worth the price of a parameter besides.
        price = float(np.log(fit.rows))
        loads = {
            term.joint: term.parameters[COEFFICIENT]
            for term in shown
            if term.term == LOAD
            and _is_shown(fit, term, price)
            and not term.parameters[COEFFICIENT].may_be(0.0)
        }
        listed = (*NOMINAL, *(term.label for term in shown), *lines)
        curved = {term.joint for term in shown if term.term == 'stribeck'} == {*fit.names}
        # The fit itself is not kept for what may be asked later: of an hour it is 0.3 GB
        # (benchmarks/long_recordings.py 60).
        own = partial(fit_with, body_tolerance=fit.body.tolerance)

        def again(known: RobotModelFile) -> tuple[TermFit, TermFit]:
            """Return fits of what shows, and with a Stribeck term in all joints besides."""
            found = own(known, listed)
            return found, found if curved else own(known, (*listed, 'stribeck'))

        if tolerance == 0.0 or (tolerance is None and not fit.body.is_wider):
            rotors = BodyRefit.of_rotors(fit, model) if unknown else None
            doubt = None
            if tolerance != 0.0:
                doubt = BodyDoubt.of(fit.laboratory, fit.estimate.fit, fit.armature)

            @cache
            def fitted_friction() -> FrictionBeside:
                step('fitting friction beside the rigid body')
                return friction_beside(*again(bare))

            timing = _timing(fit, logs, late, taken)
            return cls(rotors, timing, doubt, late, loads, repeats, fitted_friction)
        step('fitting beside the friction that the data show')
        found, hidden = again(bare)
        fit = replace(found, body=fit.body)
        body = BodyRefit.of(fit, model, hidden)
        if body.loads and not body.refused:
            # Load is what the bodies of the model need: with those that fit it is another one.
            step('fitting friction by the load of these bodies')
            fitted = replace(body.model, effects=())
            laws, loads_there = friction_beside(*again(fitted))
            body = replace(body, laws=laws, loads=loads_there)
        friction = (body.laws, body.loads)
        timing = _timing(fit, logs, late, taken)
        return cls(body, timing, None, late, loads, repeats, lambda: friction)


def _rotors(fit: TermFit) -> dict[str, float]:
    """Return the armatures that a fit found, of rotors that the model does not know."""
    return {joint: p.value for joint, p in fit.armature.items()}


def _samples(late: Late) -> dict[str, int]:
    """Return by joint how many samples sooner its effort is taken."""
    return {joint: each.samples for joint, each in late.items()}


def _measured_again(late: Late, timing: Mapping[str, EffortTiming]) -> Late:
    """
    Return delays by what is left when their samples are undone.

    The column of a delay is right for a small one. Where nobody knows how many samples it is, or
    where in an interval, it is as it was found.
    """
    result = {}
    for joint, each in late.items():
        its = timing[joint]
        if each.left.is_told(each.step_s) and its.is_told(each.step_s):
            delay = each.samples * each.step_s + its.delay_s
            each = replace(each, delay_s=delay, std_error=its.std_error)
        result[joint] = each
    return result


def _measured(fit: TermFit, logs: Sequence[JointLog], late: Late) -> dict[str, EffortTiming]:
    """Return when effort that was taken sooner is reported, as a regression has it."""
    nominal, columns = fit.laboratory.nominal, hold_columns(fit)
    step = float(np.median([log.step for log in logs]))
    names = [nominal.names[k] for k in columns.values()]
    delays, errors = (
        np.array([each[name] for name in names]) for each in (fit.refit, fit.refit_errors)
    )
    prior = float(nominal.prior[min(columns.values())])
    found = EffortTiming.of(delays, errors, prior, step, sooner(late, columns))
    return dict(zip(columns, found, strict=True))


def _timing(
    fit: TermFit, logs: Sequence[JointLog], late: Late, taken: Late
) -> dict[str, EffortTiming]:
    """
    Return when effort is reported, as a regression has it beside all else.

    :param taken: those of ``late`` whose effort the fit has sooner.
    """
    # Known to whole samples no better than by chance, it is not within the interval for sure.
    rough = {j: each.left for j, each in late.items() if not each.left.is_told(each.step_s)}
    return _measured(fit, logs, taken) | rough


def _is_shown(fit: TermFit, term: FittedTerm, price: float = 0.0) -> bool:
    """
    Tell whether the data show very strongly that a term is there, z^2 of its likelihood.

    :param price: what it has to exceed besides.
    """
    p = term.parameters[COEFFICIENT if term.term == LOAD else 'stribeck']
    if term.objection or not (p.value > 0.0 and fit.evidence(term) > VERY_STRONG + price):
        return False
    return not any(AT_BOUND in q.flags for q in fit.profiled(term).parameters.values())
