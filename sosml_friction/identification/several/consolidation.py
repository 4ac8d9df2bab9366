# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What several recordings of one robot say of its friction together."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from sosml_friction.exceptions import DataError
from sosml_friction.identification.friction_fit import FrictionFit, JointFit
from sosml_friction.identification.law.law_fit import LawFit
from sosml_friction.identification.law.law_rows import LawRows
from sosml_friction.identification.law.law_stack import (
    OWN,
    RowNoise,
    joined,
    row_noise,
    stack_rows,
)
from sosml_friction.identification.number_text import with_interval
from sosml_friction.identification.several.bag_agreement import Agreement, find_agreement
from sosml_friction.identification.several.bag_roles import ROLES, BagRole
from sosml_friction.model.laws import law_definition, unit_of
from sosml_friction.model.parameter import NOT_IDENTIFIABLE, Parameter
from sosml_friction.motion.trajectories import TRAJECTORIES

#: What of the law comes from bags of which role, by the paper's rule.
RULE = {
    'coulomb': ('T1', 'T3'),
    'viscous': ('T1', 'T3'),
    'stribeck': ('T2',),
    'stribeck_velocity': ('T2',),
    'bias': ('T3',),
}
#: The same for parameters that only some laws have: each comes with the one that it modifies.
_OF_SOME = {
    'exponent': ('T2',),
    'viscous_asymmetry': ('T1', 'T3'),
    'stribeck_asymmetry': ('T2',),
    'nonlinear_viscous': ('T1', 'T3'),
    'power': ('T1', 'T3'),
}
#: Which of the ways is to be used.
JOINT, BY_RULE, MEAN = 'joint', 'rule', 'mean'
#: Bags are said to agree if they would be as different by chance in more than this share of cases.
_AGREE = 0.01
_TRAJECTORY = {kind.role: kind.name for kind in TRAJECTORIES.values() if kind.role}
_STRIBECK = ('stribeck', 'stribeck_velocity')


@dataclass(frozen=True)
class RuleFit:
    """
    Hold what the paper's rule makes of the fits of single recordings.

    C and B from T1 and T3, S and v_s from T2, the bias from T3. Several fits of one parameter are
    averaged, weighted by their information; where they scatter more than their errors say, the
    error of the mean is larger by as much. ``sources``: the bags each parameter comes from; one
    that comes from none is flagged. ``missing``: roles that no bag has; ``reason`` says what is
    missing and what to record, without stop, empty if nothing is.
    """

    parameters: Mapping[str, Parameter]
    sources: Mapping[str, tuple[str, ...]]
    missing: tuple[str, ...] = ()
    reason: str = ''


@dataclass(frozen=True)
class Consolidated:
    """
    Hold one joint's friction from all recordings, by one observer or by the weak form.

    ``fits`` are the fits of single bags, ``unavailable`` says why a bag has none; both by the
    label of the bag. ``rule`` is the paper's, ``joint_fit`` the law fitted to all bags at once,
    None where that is not possible; its residual is in units of a bag of usual noise. ``noise`` is
    the standard deviation that each bag's rows were weighted by [Nm or N]. ``own``: the parameters
    that the joint fit leaves to each bag; ``agreement`` holds the bags against one law for all.
    ``preferred`` is ``joint``, ``rule`` or, where bags are not of one law, ``mean``: that of what
    single bags say. It is empty where there is none; ``reason`` is one sentence on why.
    """

    joint: str
    observer: str
    unit: str
    fits: Mapping[str, JointFit]
    unavailable: Mapping[str, str]
    rule: RuleFit
    joint_fit: LawFit | None
    noise: Mapping[str, float]
    own: tuple[str, ...]
    agreement: Agreement
    preferred: str
    reason: str

    @property
    def parameters(self) -> Mapping[str, Parameter]:
        """Return the parameters of the way that is preferred, empty where there is none."""
        if self.preferred == JOINT and self.joint_fit is not None:
            return {**self.joint_fit.parameters, **self._of_bags()}
        if self.preferred == MEAN:
            return mean_of_bags(self.fits, self.agreement.differing, self.unit)
        return self.rule.parameters if self.preferred == BY_RULE else {}

    @property
    def own_bias(self) -> bool:
        """Tell whether each bag has a bias of its own."""
        return 'bias' in self.own

    def _of_bags(self) -> dict[str, Parameter]:
        """Return what differs between bags: a bias by the rule where it has one, else a spread."""
        result = {name: spread_over(self.agreement.own[name]) for name in self.own}
        if self.own_bias and self.rule.sources.get('bias'):
            result['bias'] = self.rule.parameters['bias']
        return result

    @property
    def smoothing_velocity(self) -> float:
        """Return v0 of the sign of the law that :attr:`parameters` are of [rad/s or m/s]."""
        if self.preferred == JOINT and self.joint_fit is not None:
            return self.joint_fit.smoothing_velocity
        return max((fit.fit.smoothing_velocity for fit in self.fits.values()), default=0.0)

    @property
    def law(self) -> str:
        """Return the name of the law that :attr:`parameters` are of."""
        if self.preferred == JOINT and self.joint_fit is not None:
            return self.joint_fit.law
        parameters = self.parameters
        known = all(name in parameters and _known(parameters[name]) for name in _STRIBECK)
        laws = [fit.fit.law for fit in self.fits.values()]
        # Of laws that all fit, that with the most terms has all of the parameters.
        for law in sorted(laws, key=lambda law: -len(law_definition(law).terms)):
            names = law_definition(law).parameter_names
            if ('stribeck' in names) == known and all(name in parameters for name in names):
                return law
        asymmetric = '_asymmetric' if 'viscous_asymmetry' in parameters else ''
        return f'{"stribeck" if known else "coulomb_viscous"}{asymmetric}'

    def to_dict(self) -> dict[str, Any]:
        """Return the entry of ``sosml fit --json``."""
        fit = self.joint_fit
        joint = None if fit is None else {**fit.to_dict(), 'residual_unit': self.unit}
        return {
            'bags': self.fits,
            'unavailable': self.unavailable,
            'rule': self.rule,
            'joint': joint,
            'noise': self.noise,
            'bias': self.agreement.own.get('bias', {}),
            'own_bias': self.own_bias,
            'own': {name: self.agreement.own[name] for name in self.own},
            'disagreements': self.agreement.disagreements,
            **self.agreement.odds(),
            'preferred': self.preferred,
            'reason': self.reason,
            'parameters': self.parameters,
        }


@dataclass(frozen=True)
class Consolidation:
    """
    Hold what several recordings say together.

    ``bags`` are labels, by which all else names a recording; ``joints[joint][observer]``, where
    the observer may be ``weak_form``; ``model[joint]`` is the observer whose result is in the
    model; ``unavailable[joint]`` says why a joint has nothing.
    """

    bags: tuple[str, ...]
    roles: Mapping[str, BagRole]
    joints: Mapping[str, Mapping[str, Consolidated]]
    model: Mapping[str, str] = field(default_factory=dict)
    unavailable: Mapping[str, str] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Return the entry ``consolidation`` of ``sosml fit --json``."""
        return {
            'bags': self.bags,
            'roles': self.roles,
            'joints': self.joints,
            'unavailable': self.unavailable,
        }


def consolidate(
    joint: str,
    observer: str,
    unit: str,
    recordings: Mapping[str, FrictionFit],
    roles: Mapping[str, BagRole],
    own_bias: bool | None = None,
    variance: Mapping[str, float] = MappingProxyType({}),
) -> Consolidated:
    """
    Say what recordings tell together of one joint, by one observer.

    The paper's rule combines the fits of single bags. The joint fit is one regression over the
    rows of all bags, both sides divided by the noise that the bag's own rows have about a smooth
    curve of their own: a bag counts by its information, and clusters of different bags are
    different, so that standard errors hold whatever the weights. Where the bags differ in their
    bias, which posture, temperature or the zero of a current sensor may change, it is left to
    each.

    :param unit: ``Nm`` or ``N``.
    :param recordings: the fits of each bag by its label, with their rows.
    :param own_bias: whether each bag has a bias of its own; None to see from the data.
    :param variance: by parameter, a variance that no rows show: that of not knowing the bodies,
        which all bags share. The fits of single bags have it already.
    """
    fits, unavailable, rows = {}, {}, {}
    for label, fit in recordings.items():
        if observer in fit.joints.get(joint, {}):
            fits[label] = fit.joints[joint][observer]
        else:
            unavailable[label] = fit.unavailable.get(joint, f'{observer} has no estimate')
        if observer in fit.rows.get(joint, {}):
            rows[label] = fit.rows[joint][observer]
    rule = paper_rule(fits, roles, unit)
    widths = [fit.fit.smoothing_velocity for fit in fits.values()]
    width = float(np.median(widths)) if widths else None
    found = _JointFit(rows, unit, own_bias, width, [fit.fit for fit in fits.values()])
    preferred, reason = _choose(found, rule, fits)
    return Consolidated(
        joint,
        observer,
        unit,
        fits,
        unavailable,
        rule,
        None if found.fit is None else found.fit.with_variance(variance),
        {label: noise.effective for label, noise in found.noise.items()},
        found.own,
        found.agreement.with_variance(variance),
        preferred,
        reason,
    )


class _JointFit:
    """One law for all bags, and how well they agree with it."""

    def __init__(
        self,
        parts: Mapping[str, LawRows],
        unit: str,
        own_bias: bool | None,
        smoothing_velocity: float | None,
        fits: Sequence[LawFit],
    ) -> None:
        self.fit: LawFit | None = None
        self.problem = ''
        self.own: tuple[str, ...] = ('bias',) if own_bias else ()
        self.noise: dict[str, RowNoise] = {}
        self.agreement = Agreement(np.nan, 0, np.nan, (), {})
        known = {label: rows for label, rows in parts.items() if rows.keep.any()}
        if not known:
            self.problem = 'no bag has motion to fit'
            return
        first = {label: row_noise(rows, smoothing_velocity) for label, rows in known.items()}
        known = {label: joined(rows, first[label]) for label, rows in known.items()}
        self.noise = {label: row_noise(rows, smoothing_velocity) for label, rows in known.items()}
        positive = [n.effective for n in self.noise.values() if n.effective > 0.0]
        usual = float(np.exp(np.mean(np.log(positive)))) if positive else 1.0
        # Exact data have no noise to weigh them by.
        least = 1e-9 * usual
        weights = [usual / max(n.effective, least) for n in self.noise.values()]
        stack = stack_rows(list(known.values()), weights)
        try:
            self.fit = (stack.own(self.own) if self.own else stack).rows.fit(unit)
        except DataError as error:
            self.problem = str(error)
            return
        labels = list(known)
        self.agreement = find_agreement(stack, labels, unit, [self.fit, *fits])
        differing = {n for n in self.agreement.differing if n in OWN}
        if own_bias is not None:
            differing = differing - {'bias'} | set(self.own)
        if differing - set(self.own):
            self.own = tuple(name for name in OWN if name in differing)
            before, self.fit = self.fit, stack.own(self.own).rows.fit(unit)
            if self.fit.law != before.law:
                # What differs had been taken for a bend of the law.
                self.agreement = find_agreement(stack, labels, unit, [self.fit, *fits])


def _choose(found: _JointFit, rule: RuleFit, fits: Mapping[str, JointFit]) -> tuple[str, str]:
    """Return which way is preferred, and the sentence that says why."""
    usable = bool(rule.sources.get('coulomb') and rule.sources.get('viscous'))
    if found.fit is None:
        if usable:
            return BY_RULE, f'No law can be fitted to all bags at once ({found.problem}).'
        return '', f'Neither way gives a law: {found.problem}; {rule.reason}.'
    agreement = found.agreement
    of_law = [entry for entry in agreement.disagreements if entry.parameter not in OWN]
    of_bags = [entry for entry in agreement.disagreements if entry.parameter in OWN]
    if of_law:
        said = '; '.join(entry.sentence for entry in agreement.disagreements)
        if usable and not rule.missing:
            return BY_RULE, f'The bags are not of one law: {said}.'
        why = f'The rule cannot be applied ({rule.reason or "a bag it needs has no fit"})'
        if fits:
            return MEAN, (
                f'The bags are not of one law: {said}. {why}: each value given is the mean of '
                'what single bags say, its interval holds them all.'
            )
        return JOINT, (
            f'The bags are not of one law: {said}. {why}, and no bag has a fit of its own: '
            'the joint fit averages them.'
        )
    if of_bags:
        said = '; '.join(entry.sentence for entry in of_bags)
        if agreement.differing == ('bias',):
            return JOINT, (
                f'The bags agree in friction and not in bias: {said}. An offset of gravity or of '
                'the current has changed, and each bag has its own in the joint fit.'
            )
        words = ' and '.join(name.replace('_', ' ') for name in agreement.differing)
        return JOINT, (
            f'The bags differ in {words}: {said}. Each bag has its own in the joint fit, which '
            'shares the rest; the value given is the mean over bags, its interval holds them all.'
        )
    if len(found.noise) == 1:
        return JOINT, 'There is one bag with motion of this joint.'
    odds = f'chi-square {agreement.chi_square:.1f} with {agreement.degrees} degrees of freedom'
    if agreement.degrees and agreement.p_value < _AGREE:
        return JOINT, (
            f'The bags differ ({odds}), but in no single parameter beyond its error, so that the '
            'joint fit averages them.'
        )
    return JOINT, (
        f'The bags agree ({odds}), and the joint fit uses all they know of each parameter.'
    )


def paper_rule(fits: Mapping[str, JointFit], roles: Mapping[str, BagRole], unit: str) -> RuleFit:
    """Return the paper's combination of the fits of single bags, by their labels."""
    missing = tuple(
        role for role in ROLES if not any(entry.role == role for entry in roles.values())
    )
    parameters, sources = {}, {}
    rule = dict(RULE)
    for name, wanted in _OF_SOME.items():
        if any(name in fit.fit.parameters for fit in fits.values()):
            rule[name] = wanted
    for name, wanted in rule.items():
        own = {
            label: fit.fit.parameters[name]
            for label, fit in fits.items()
            if roles[label].role in wanted and name in fit.fit.parameters
        }
        known = {label: p for label, p in own.items() if _known(p)}
        sources[name] = tuple(known)
        if known:
            parameters[name] = weighted_mean(list(known.values()))
            continue
        parameters[name] = _open(name, unit, list(own.values()), wanted)
    lacking = ' and '.join(
        f'{role} ({_TRAJECTORY[role]}), from which the rule takes '
        + ', '.join(name.replace('_', ' ') for name, wanted in RULE.items() if role in wanted)
        for role in missing
    )
    reason = (
        f'no bag is {lacking}: record it, or say which bag it is with --role' if lacking else ''
    )
    return RuleFit(parameters, sources, missing, reason)


def _known(parameter: Parameter) -> bool:
    return NOT_IDENTIFIABLE not in parameter.flags and bool(np.isfinite(parameter.value))


def _open(name: str, unit: str, own: Sequence[Parameter], wanted: Sequence[str]) -> Parameter:
    """Return a flagged parameter, its range what all of the bags leave open."""
    if not own:
        reason = f'no bag is {" or ".join(wanted)}'
        experiment = ' and '.join(f'record {_TRAJECTORY[role]}' for role in wanted)
    else:
        first = own[0]
        reason = first.reason or f'{" and ".join(wanted)} alone do not tell it'
        experiment = first.experiment
    ranges = [p.interval for p in own if p.interval is not None]
    low = max((r[0] for r in ranges), default=np.nan)
    high = min((r[1] for r in ranges), default=np.nan)
    interval = (low, high) if ranges and not low > high else None
    return Parameter.not_told(unit_of(name, unit), reason, interval, experiment)


def mean_of_bags(
    fits: Mapping[str, JointFit], differing: Sequence[str], unit: str
) -> dict[str, Parameter]:
    """
    Return what bags that are not of one law say in the mean, each by a fit of its own.

    One that no bag tells is a range that reaches over those of all bags.

    :param differing: the parameters that are known to differ.
    """
    result = {}
    for name in dict.fromkeys(n for fit in fits.values() for n in fit.fit.parameters):
        own = {k: f.fit.parameters[name] for k, f in fits.items() if name in f.fit.parameters}
        known = {label: p for label, p in own.items() if _known(p)}
        if known:
            mean = spread_over(known)
            result[name] = mean if name in differing else replace(mean, reason='', experiment='')
            continue
        first = next(iter(own.values()))
        ends = np.array([p.interval or (np.nan, np.nan) for p in own.values()])
        low, high = float(np.min(ends[:, 0])), float(np.max(ends[:, 1]))
        interval = None if np.isnan(low + high) else (low, high)
        result[name] = Parameter.not_told(
            unit_of(name, unit), first.reason, interval, first.experiment
        )
    return result


def spread_over(bags: Mapping[str, Parameter]) -> Parameter:
    """
    Return a parameter that differs between bags: their mean, and how far they are spread.

    The random effect of DerSimonian and Laird (Controlled Clinical Trials 7, 1986): weights
    1 / (s_k^2 + d^2), d the standard deviation between bags; the standard error is that of another
    bag, sqrt(d^2 + s^2), and at least that of the surest bag: a mean does not reduce what bags
    share, such as the bodies. The interval reaches from the lowest to the highest end of any bag.
    """
    if len(bags) == 1:
        return next(iter(bags.values()))
    known = {label: p for label, p in bags.items() if np.isfinite(p.std_error)}
    values, errors = (
        np.array([getattr(p, n) for p in known.values()]) for n in ('value', 'std_error')
    )
    w = np.maximum(errors, 1e-12 * max(float(np.abs(values).max()), 1e-300)) ** -2.0
    q = float(w @ (values - w @ values / w.sum()) ** 2)
    between = max(0.0, (q - (len(values) - 1)) / float(w.sum() - w @ w / w.sum()))
    w = 1.0 / (1.0 / w + between)
    ends = np.array([p.interval or (np.nan, np.nan) for p in known.values()])
    told = ', '.join(f'{label} {with_interval(p, p.unit)}' for label, p in known.items())
    return Parameter(
        float(w @ values / w.sum()),
        next(iter(known.values())).unit,
        max(float(np.sqrt(between + 1.0 / w.sum())), float(errors.min())),
        (float(np.nanmin(ends[:, 0])), float(np.nanmax(ends[:, 1]))),
        reason=f'it differs between the bags: {told}',
        experiment='find out what changed between them: temperature, posture, zero of current',
    )


def weighted_mean(parameters: Sequence[Parameter]) -> Parameter:
    """
    Return the mean of estimates of one parameter, weighted by their information.

    Each interval keeps the quantile it was made with. Errors are larger by the root of chi-square
    over its degrees of freedom where that is above 1 (Birge): estimates that scatter more than
    their errors say are less sure than these. An estimate without error takes part only alone.
    """
    if len(parameters) == 1:
        return parameters[0]
    sure = [p for p in parameters if np.isfinite(p.std_error) and p.std_error > 0.0]
    if len(sure) < 2:
        return (sure or list(parameters))[0]
    values, errors = (np.array([getattr(p, n) for p in sure]) for n in ('value', 'std_error'))
    weights = errors**-2 / np.sum(errors**-2)
    mean = float(weights @ values)
    birge = max(1.0, float(np.sqrt(np.sum(((values - mean) / errors) ** 2) / (len(sure) - 1))))
    halves = [0.5 * (p.interval[1] - p.interval[0]) if p.interval else np.nan for p in sure]
    half = np.where(np.isfinite(halves), halves, 2.0 * errors)
    spread = birge * float(np.sqrt(np.sum((weights * half) ** 2)))
    error = birge * float(np.sqrt(np.sum((weights * errors) ** 2)))
    return Parameter(mean, sure[0].unit, error, (mean - spread, mean + spread))
