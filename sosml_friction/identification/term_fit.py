# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The values of a given list of terms, by the regression that a diagnosis searches with."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.block_means import block_means
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.free_armature import fitted_armature, with_fitted
from sosml_friction.identification.parameter_interval import AT_ZERO, NON_NEGATIVE
from sosml_friction.identification.term_parameters import (
    linear_parameters,
    with_interval,
    with_profile,
)
from sosml_friction.model.laws import FRICTION_LAWS, JOINED, TERM_LISTS, LawDefinition, law_of
from sosml_friction.model.model_folder import (
    EffectTerm,
    FrictionParameters,
    JointModel,
    RobotModelFile,
)
from sosml_friction.model.parameter import AT_BOUND, Z_95, Parameter
from sosml_friction.model.terms.kinds.fading_term import KNEES
from sosml_friction.model.terms.kinds.scales import Scales
from sosml_friction.model.terms.kinds.term import ALL_JOINTS, TERMS, Term
from sosml_friction.regression.body_width import (
    WIDTHS,
    BodyWidth,
    check_tolerance,
    choose_width,
    with_width,
)
from sosml_friction.regression.carried_load import fitted_to_carried_load
from sosml_friction.regression.estimate import (
    Estimate,
    Linear,
    estimate,
    place,
    refined_again,
    settle,
)
from sosml_friction.regression.evidence import Fit
from sosml_friction.regression.known_effort import with_all_known
from sosml_friction.regression.placed import Placed, with_amplitudes
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare
from sosml_friction.regression.whitened import WhitenedRegression

#: Terms whose columns are those of the nominal friction: free where they are listed.
NOMINAL = ('coulomb', 'viscous', 'bias')


@dataclass(frozen=True)
class FittedTerm:
    """
    Hold the parameters of one term.

    ``joint``: its name, ``*`` for all. ``objection``: why its values are physically impossible,
    '' if they are not.
    """

    term: str
    joint: str
    parameters: Mapping[str, Parameter]
    objection: str = ''

    @property
    def label(self) -> str:
        """Return term and joint in one word."""
        return f'{self.term}@{self.joint}'


@dataclass(frozen=True)
class TermFit:
    """
    Hold the values of a list of terms.

    ``terms`` in the order of the list, joint by joint, and ``linear`` the same with intervals of
    the one covariance alone, which take no time; ``model``: the model with them, made of the one
    that is ``nominal`` beside them and of the friction that it ``had``. ``refit``: deviations of
    what was not listed, by name, with their standard errors in ``refit_errors``.
    ``before`` and ``after`` (n,) [Nm or N]: effort that is not explained in the band, root mean
    square, with the nominal model refitted without any of the terms, and with them;
    ``measured`` (n,): the effort itself. ``left``: what was left out, and why. ``body``: how far
    the rigid body may be off. ``armature``: by joint, of rotors that the model does not know.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    linear: tuple[FittedTerm, ...]
    nominal: RobotModelFile
    had: RobotModelFile
    refit: Mapping[str, float]
    refit_errors: Mapping[str, float]
    before: FloatArray
    after: FloatArray
    measured: FloatArray
    rows: int
    band_hz: float
    left: Mapping[str, str]
    body: BodyWidth
    laboratory: WhitenedRegression
    estimate: Estimate
    armature: Mapping[str, Parameter] = field(default_factory=dict)

    @cached_property
    def terms(self) -> tuple[FittedTerm, ...]:
        """Return the terms with their intervals."""
        return tuple(map(self.profiled, self.linear))

    @cached_property
    def model(self) -> RobotModelFile:
        """Return the model with the terms."""
        scales = self.laboratory.signals[0].scales
        return with_fitted(_model(self.had, self.nominal, self.terms, scales), self.armature)

    def profiled(self, term: FittedTerm) -> FittedTerm:
        """Return one of the linear ones with its intervals."""
        if self._placed(term)[0] is None:
            return term
        which, _ = self.place_of(term)
        own = with_profile(self.laboratory, self.estimate, which, term.parameters)
        return replace(term, parameters=own)

    def conf_int(self) -> dict[str, dict[str, tuple[float, float]]]:
        """Return 95 % intervals by term and joint, and by parameter."""
        return {
            term.label: {
                name: p.interval for name, p in term.parameters.items() if p.interval is not None
            }
            for term in self.terms
        }

    def evidence(self, term: FittedTerm) -> float:
        """
        Return z^2 of a term's first amplitude, to tell whether it is there.

        Its inner parameters are nothing where the term is not. So what they leave open, as which
        of its equations is true, makes its size less sure, and not that it is there: with them as
        they are, z^2 is what the sum of squares rises by without the term, in variances of what
        is left (the likelihood ratio).
        """
        found, (own, part) = self.estimate, self.place_of(term)
        x = found.fit.baseline.x
        held = frozenset((own, name) for name in found.placed[own].inner)
        linear = Linear.make(self.laboratory, found.placed, x, held)
        variance = linear.variances(found.fit)[0][part.start]
        return float(x[part.start] ** 2 / variance)

    def place_of(self, term: FittedTerm) -> tuple[int, slice]:
        """Return the number of a term that was placed, and where its amplitudes are."""
        placed, part = self._placed(term)
        return next(k for k, each in enumerate(self.estimate.placed) if each is placed), part

    def residual(self) -> FloatArray:
        """Return what is left of the effort in the band (rows, n) [Nm or N]."""
        y, Z = self.laboratory.unwhitened()
        left = y - np.einsum('rnp,p->rn', Z, self.estimate.fit.baseline.x[: Z.shape[2]])
        return left - sum(self.explained(term) for term in self.linear if self._placed(term)[0])

    def explained(self, term: FittedTerm) -> FloatArray:
        """Return what a term explains of the effort in the band (rows, n) [Nm or N]."""
        placed, part = self._placed(term)
        if placed is None:
            joint = self.names.index(term.joint)
            index = self.laboratory.nominal.names.index(f'{term.joint} {term.term}')
            _, Z = self.laboratory.unwhitened()
            result = np.zeros(Z.shape[:2])
            result[:, joint] = Z[:, joint, index] * self.estimate.fit.baseline.x[index]
            return result
        columns = self.laboratory.own_columns(placed.term, placed.joint, placed.inner)
        return np.asarray(columns @ placed.term.whole(self.estimate.fit.baseline.x[part]))

    def _placed(self, term: FittedTerm) -> tuple[Placed | None, slice]:
        """Return a term as it was fitted and where its amplitudes are, None if of the nominal."""
        first = len(self.laboratory.nominal.bound)
        for placed, part in with_amplitudes(self.estimate.placed, first):
            where = ALL_JOINTS if placed.term.of_robot else self.names[placed.joint]
            if (placed.term.identifier, where) == (term.term, term.joint):
                return placed, part
        return None, slice(0)

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers and strings."""
        return {
            'terms': self.terms,
            'effort': {
                name: {
                    'before': self.before[i],
                    'after': self.after[i],
                    'measured': self.measured[i],
                    'unit': self.units[i],
                }
                for i, name in enumerate(self.names)
            },
            'refit': {
                name: {'value': value, 'std_error': self.refit_errors[name]}
                for name, value in self.refit.items()
            },
            'rows': self.rows,
            'band_hz': self.band_hz,
            'left_out': self.left,
            'armature': self.armature,
        }

    def __repr__(self) -> str:
        return f'TermFit({", ".join(term.label for term in self.linear)})'


def parse_terms(names: Sequence[str], joints: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """
    Return by joint, ``*`` for the whole robot, the terms that are asked for.

    :param names: terms, ``TERM@JOINT`` for one joint alone; or names of lists.
    :raises ConfigurationError: if a term or joint is unknown, or there is none.
    """
    found: dict[str, list[str]] = {}
    for name in names:
        term, _, joint = name.partition('@')
        if joint and joint not in (*joints, ALL_JOINTS):
            raise ConfigurationError(
                f'term {name!r} is of an unknown joint: use one of {", ".join(joints)}, or *'
            )
        for each in named_terms(term):
            kind = TERMS[each]
            where = [joint] if joint else [ALL_JOINTS] if kind.of_robot else list(joints)
            for one in where:
                if kind.acting_in(one) is None:
                    raise ConfigurationError(
                        f'term {each!r} acts in all joints together: write {each} alone'
                        if kind.of_robot
                        else f'term {each!r} acts in one joint: write {each}@JOINT, or {each} for '
                        'all'
                    )
                found.setdefault(one, [])
                if each not in found[one]:
                    found[one].append(each)
    if not found:
        raise ConfigurationError(f'no term is named: use {", ".join(TERMS)}')
    return {joint: tuple(terms) for joint, terms in found.items()}


def named_terms(name: str) -> tuple[str, ...]:
    """
    Return the terms of a named list, of a law, or the one term of that name.

    :raises ConfigurationError: if there is none of these.
    """
    if name in TERM_LISTS:
        return TERM_LISTS[name]
    # A law whose name is that of a term, stribeck, is the term.
    if name in TERMS.classes:
        return (name,)
    if name in FRICTION_LAWS:
        return FRICTION_LAWS[name].terms
    raise ConfigurationError(
        f'term {name!r} is unknown: use {", ".join(TERMS)}, or a list: '
        f'{", ".join((*TERM_LISTS, *FRICTION_LAWS))}'
    )


def fit_terms(
    logs: Sequence[JointLog],
    model: RobotModelFile,
    terms: Sequence[str],
    settings: DiagnosisSettings | None = None,
    step: Callable[[str], None] = lambda text: None,
    body_tolerance: float | None = None,
    without: Collection[str] = (),
    rotors: Mapping[str, float] = MappingProxyType({}),
) -> TermFit:
    """
    Estimate the values of terms, with one covariance of all that is fitted.

    What is listed is free. All else of the model stays within the tolerance of the settings, so
    that terms which a diagnosis named have the values that it found. Where Coulomb or viscous
    friction of a joint is listed, its whole law is fitted: terms of the law that are not listed
    are 0, and only the bias stays free. If the data contradict the rigid body within that
    tolerance, it is refitted within the most likely one. An armature that the model does not know
    is free.

    :param body_tolerance: how far each number of the rigid body may be off, as a share of itself;
        None for what the data say (:func:`~sosml_friction.regression.body_width.choose_width`).
    :param without: terms that are not looked for: their effort counts as noise.
    :param rotors: by joint, the armature [kg m2 or kg] about which one that the model does not
        know is fitted, instead of 0: how late an effort is changes as it does.
    :raises ConfigurationError: if a term is unknown or can act in none of its joints.
    :raises DataError: if a recording is too short, or lacks a joint.
    """
    unknown = model.unknown_armature
    settings = replace(settings or DiagnosisSettings(), unknown_armature=unknown)
    model = model.with_armature({'*': 0.0, **rotors})
    robot = model.make_robot()
    wanted = parse_terms(terms, robot.names)
    step('preparing the recordings')
    logs = [block_means(log.select(robot.names))[0] for log in logs]
    nominal = _without(model, wanted)
    listed = {term for own in wanted.values() for term in own}
    knees = KNEES if 'stribeck' in listed else ()
    signals = prepare(logs, nominal, robot, settings, knees=knees)
    signals = with_all_known(signals, nominal, settings)
    laboratory = WhitenedRegression.make(
        signals, _library(wanted, without), settings, step, listed
    )
    keys, left = _keys(laboratory, wanted)
    step('fitting the terms')
    laboratory, body, placed = _with_body(laboratory, keys, body_tolerance, step)
    laboratory, found = _with_values(laboratory, keys, placed, step)
    torque, errors = found.in_torque(laboratory)
    fitted = _fitted_terms(laboratory, found, wanted, torque, errors)
    armature = fitted_armature(laboratory, found, body.tolerance)
    names = laboratory.nominal.names
    result = TermFit(
        names=robot.names,
        units=robot.effort_units,
        linear=fitted,
        nominal=nominal,
        had=model,
        refit=dict(zip(names, torque.tolist(), strict=False)),
        refit_errors=dict(zip(names, errors.tolist(), strict=False)),
        before=np.zeros(robot.n),
        after=np.zeros(robot.n),
        measured=_rms(laboratory.measured()),
        rows=len(laboratory.y),
        band_hz=signals[0].band.cutoff,
        left=left,
        body=body,
        laboratory=laboratory,
        estimate=found,
        armature=armature,
    )
    return replace(
        result, before=_rms(_without_terms(laboratory, wanted)), after=_rms(result.residual())
    )


def _with_body(
    laboratory: WhitenedRegression,
    keys: Sequence[tuple[str, int]],
    told: float | None,
    step: Callable[[str], None],
) -> tuple[WhitenedRegression, BodyWidth, list[Placed]]:
    """Return the regression with the tolerance of the body, told or most likely, and the terms."""
    if told is not None:
        check_tolerance(told)
        laboratory = with_width(laboratory, told)
        return laboratory, BodyWidth(told, {}), place(laboratory, keys, step)
    placed = place(with_width(laboratory, WIDTHS[-1]), keys, step)
    system = laboratory.system.extended([each.columns for each in placed])
    body = choose_width(laboratory, system)
    return with_width(laboratory, body.tolerance) if body.is_wider else laboratory, body, placed


def _with_values(
    laboratory: WhitenedRegression,
    keys: Sequence[tuple[str, int]],
    placed: list[Placed],
    step: Callable[[str], None],
) -> tuple[WhitenedRegression, Estimate]:
    """
    Return the values of terms, and the regression in which no friction is negative.

    Coulomb or viscous friction that would be is 0, and the rest is fitted beside that; what errors
    it makes is not changed by it.

    :param placed: the terms with the inner parameters that are settled from there.
    """
    while True:
        placed = refined_again(laboratory, placed)
        placed = settle(laboratory, placed, step)
        laboratory, placed = fitted_to_carried_load(laboratory, placed)
        # The order of the list, not that of the search.
        placed.sort(key=lambda each: keys.index((each.term.identifier, each.joint)))
        found = estimate(laboratory, placed)
        names = laboratory.nominal.names
        free = np.array([name.rpartition(' ')[2] in NON_NEGATIVE for name in names])
        negative = free & np.isinf(laboratory.system.bound)
        negative &= found.fit.baseline.x[: len(free)] < 0.0
        if not negative.any():
            return laboratory, found
        bound = np.where(negative, 0.0, laboratory.system.bound)
        laboratory = replace(laboratory, system=replace(laboratory.system, bound=bound))
        placed = place(laboratory, keys, step)


def _without_terms(
    laboratory: WhitenedRegression, wanted: Mapping[str, Sequence[str]]
) -> FloatArray:
    """Return what is left of the effort (rows, n) where none of the listed terms is."""
    listed = {f'{joint} {term}' for joint, terms in wanted.items() for term in terms}
    system = laboratory.system
    bound = np.where([name in listed for name in laboratory.nominal.names], 0.0, system.bound)
    locked = replace(system, bound=bound)
    x = Fit.make(locked, laboratory.y).baseline.x
    y, Z = laboratory.unwhitened()
    return np.asarray(y - np.einsum('rnp,p->rn', Z, x))


def _rms(x: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.mean(x**2, axis=0)))


def _without(model: RobotModelFile, wanted: Mapping[str, Sequence[str]]) -> RobotModelFile:
    """Return the model without what is listed: that is free."""
    joints = {}
    for name, joint in model.joints.items():
        own = wanted.get(name, ())
        friction = joint.friction
        if any(term in NOMINAL[:2] for term in own):
            # What is not listed of a law that is fitted is known to be nothing.
            missing = [term for term in NOMINAL[:2] if term not in own]
            friction = _nothing(missing, joint) if missing else None
        elif friction is not None and any(TERMS[term].of_law for term in own):
            friction = _less(friction, own)
        width = joint.sign_width
        joints[name] = replace(joint, friction=friction, smoothing_velocity=width)
    listed = {(term, name) for name, terms in wanted.items() for term in terms}
    effects = tuple(t for t in model.effects if (t.effect, t.joint) not in listed)
    return replace(model, joints=joints, effects=effects)


def _nothing(terms: Sequence[str], joint: JointModel) -> FrictionParameters:
    effort = 'Nm' if joint.armature.unit == 'kg m2' else 'N'
    law = LawDefinition(JOINED.join(terms), tuple(terms))
    parameters = {n: Parameter(0.0, law.unit(n, effort)) for n in law.parameter_names}
    return FrictionParameters(law.identifier, joint.sign_width, parameters)


def _less(friction: FrictionParameters, terms: Sequence[str]) -> FrictionParameters:
    """Return a law without some of its terms."""
    definition = friction.make_law().definition
    kept = tuple(term for term in definition.terms if term not in terms)
    law = LawDefinition(JOINED.join(kept), kept)
    values = {**friction.parameters}
    for name, value in definition.fixed.items():
        values.setdefault(name, Parameter(value, '1'))
    own = {name: values[name] for name in law.parameter_names}
    return FrictionParameters(law.identifier, friction.smoothing_velocity, own)


def _library(wanted: Mapping[str, Sequence[str]], without: Collection[str]) -> dict[str, Term]:
    """Return the terms that a diagnosis looks for, but for some, and those that are asked for."""
    searched = {
        name: kind()
        for name, kind in TERMS.classes.items()
        if kind.searched and name not in without
    }
    more = {term for terms in wanted.values() for term in terms if term not in NOMINAL}
    return {**searched, **{name: TERMS[name]() for name in sorted(more)}}


def _keys(
    laboratory: WhitenedRegression, wanted: Mapping[str, Sequence[str]]
) -> tuple[list[tuple[str, int]], dict[str, str]]:
    """Return the candidates that are asked for, and which terms cannot act, with the reason."""
    names = laboratory.robot.names
    where = {
        (
            each.effect.identifier,
            ALL_JOINTS if each.effect.of_robot else names[each.joint],
        ): each.joint
        for each in laboratory.candidates
    }
    keys: list[tuple[str, int]] = []
    left: dict[str, str] = {}
    for joint, terms in wanted.items():
        for term in terms:
            if term in NOMINAL and f'{joint} {term}' in laboratory.nominal.names:
                continue
            if (term, joint) in where:
                keys.append((term, where[term, joint]))
                continue
            left[f'{term}@{joint}'] = (
                f'{term} cannot act in {joint} on these data: the joint has none of what it '
                'follows, or the recording is too short for it'
            )
    if not keys and not any(term in NOMINAL for terms in wanted.values() for term in terms):
        raise ConfigurationError('; '.join(left.values()))
    return keys, left


def _fitted_terms(
    laboratory: WhitenedRegression,
    found: Estimate,
    wanted: Mapping[str, Sequence[str]],
    x: FloatArray,
    errors: FloatArray,
) -> tuple[FittedTerm, ...]:
    """Return the terms of a list; ``x`` and ``errors`` are those of the nominal's numbers."""
    names = laboratory.robot.names
    by_key: dict[tuple[str, str], FittedTerm] = {}
    fits, known = found.fitted(laboratory), linear_parameters(laboratory, found)
    for placed, fitted, parameters in zip(found.placed, fits, known, strict=True):
        where = ALL_JOINTS if placed.term.of_robot else names[placed.joint]
        objection = placed.term.implausible(fitted)
        by_key[placed.term.identifier, where] = FittedTerm(
            placed.term.identifier, where, parameters, objection
        )
    index = {name: k for k, name in enumerate(laboratory.nominal.names)}
    result = []
    for joint, terms in wanted.items():
        for term in terms:
            if (term, joint) in by_key:
                result.append(by_key[term, joint])
            elif term in NOMINAL and f'{joint} {term}' in index:
                k = index[f'{joint} {term}']
                i = names.index(joint)
                unit = TERMS[term].unit(term, laboratory.robot.effort_units[i])
                value, error = float(x[k]), float(errors[k])
                told = with_interval(Parameter(value, unit, error))
                if laboratory.system.bound[k] == 0.0:
                    high = Z_95 * error
                    told = replace(told, interval=(0.0, high), flags=(AT_BOUND,), reason=AT_ZERO)
                result.append(FittedTerm(term, joint, {term: told}))
    return tuple(result)


def _model(
    model: RobotModelFile, nominal: RobotModelFile, fitted: Sequence[FittedTerm], scales: Scales
) -> RobotModelFile:
    """Return the model with the terms: those of a law in the law, the others in its list."""
    joints = {}
    for (name, joint), width in zip(nominal.joints.items(), scales.width.tolist(), strict=True):
        own = [t for t in fitted if t.joint == name and TERMS[t.term].of_law]
        joints[name] = joint
        if not own:
            joints[name] = replace(joint, friction=model.joints[name].friction)
            continue
        parameters: dict[str, Parameter] = {}
        terms: list[str] = []
        kept = joint.friction
        # A law that was taken for nothing, to fit the rest, stays out of it.
        if kept is not None and any(p.value != 0.0 for p in kept.parameters.values()):
            definition = kept.make_law().definition
            terms += definition.terms
            parameters |= dict(kept.parameters)
        for term in own:
            terms.append(term.term)
            parameters |= term.parameters
        law = law_of([*terms, 'bias'], {n: p.value for n, p in parameters.items()})
        values = {name: parameters[name] for name in law.parameter_names if name in parameters}
        for missing in set(law.parameter_names) - set(values):
            effort = 'Nm' if joint.armature.unit == 'kg m2' else 'N'
            values[missing] = Parameter(0.0, law.unit(missing, effort))
        joints[name] = replace(joint, friction=FrictionParameters(law.identifier, width, values))
    more = tuple(
        EffectTerm(term.term, term.joint, term.parameters)
        for term in fitted
        if not TERMS[term.term].of_law
    )
    return replace(nominal, joints=joints, effects=(*nominal.effects, *more))
