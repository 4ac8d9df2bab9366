# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A rigid body that the data contradict, refitted beside friction before anything uses it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.identification.body_doubt import rows_worth
from sosml_friction.identification.data_finding import NOTE, WARNING, DataFinding
from sosml_friction.identification.free_armature import armature_sentence, with_fitted
from sosml_friction.identification.law.law_fit import LawFit
from sosml_friction.identification.number_text import plus_minus
from sosml_friction.identification.parameter_interval import half_width
from sosml_friction.identification.term_fit import FittedTerm, TermFit
from sosml_friction.identification.term_parameters import slowest_speed, steady_speeds
from sosml_friction.model.consistent_inertias import nearest_bodies
from sosml_friction.model.laws import FrictionLaw, law_of, unit_of
from sosml_friction.model.model_folder import EffectTerm, RobotModelFile
from sosml_friction.model.parameter import NOT_IDENTIFIABLE, Z_95, Parameter
from sosml_friction.model.rigid_changes import REFIT, Change, with_changes
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.term import ALL_JOINTS, TERMS
from sosml_friction.regression.body_width import body_precision, body_variance
from sosml_friction.regression.nominal import Nominal
from sosml_friction.regression.rival import VERY_STRONG, rival_probability

#: The friction that stands beside the bodies: what can be taken for weight or inertia.
LOAD = 'load_dependent_friction'
NOMINAL = ('coulomb', 'viscous')
FRICTION = (*NOMINAL, 'stribeck', LOAD)
#: What every law has.
_LINEAR = (*NOMINAL, 'bias')
#: What a Stribeck term is, if it is known; else both are ranges.
_KNEE = ('stribeck', 'stribeck_velocity')
#: Share of the variance of what bodies changed an effort by that one factor on all of it explains,
#: and most rows that it is asked of. Chosen, no measurement.
_ONE_FACTOR, _ROWS = 0.9, 2000
#: Probability that such a factor is the torque constant's and not the masses': nothing tells.
_OF_EFFORT = 0.5
#: A tolerance from which on it is a warning: masses are seldom as wrong. Chosen, no measurement.
_FAR = 1.0
#: The ten numbers of a body, in the joint's frame and about its origin.
_MOMENTS = tuple((f'first moment {axis}', 'kg m') for axis in 'xyz')
_INERTIAS = tuple((f'inertia {axes}', 'kg m2') for axes in ('xx', 'xy', 'yy', 'xz', 'yz', 'zz'))
_NUMBERS = (('mass', 'kg'), *_MOMENTS, *_INERTIAS)


@dataclass(frozen=True)
class BodyRefit:
    """
    Hold a refitted rigid body.

    ``model``: the model with the bodies that fit. ``laws``: by joint, the friction that was fitted
    beside them; ``loads``: friction by load, where the data show it. ``tolerance``: how far each
    number was allowed to be off, as a share of itself;
    ``log_evidence``: of tolerances against the usual one, empty where it was told.
    ``deviations``: by name, refitted minus the model's. ``variance``: by joint and parameter, what
    not knowing bodies and rotors adds to its variance. ``refused``: why the bodies are not in the
    model, '' if they are. ``armature``: by joint, of rotors that the model did not know; where
    nothing else was refitted, ``deviations`` is empty. ``scales``: by joint, the factor on all of
    its effort that says the same as the refitted bodies, where it is beyond what was allowed
    before anything was refitted.
    """

    model: RobotModelFile
    laws: Mapping[str, LawFit]
    loads: tuple[EffectTerm, ...]
    tolerance: float
    log_evidence: Mapping[float, float]
    deviations: Mapping[str, Parameter]
    variance: Mapping[str, Mapping[str, float]]
    refused: str = ''
    armature: Mapping[str, Parameter] = field(default_factory=dict)
    scales: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def of_rotors(cls, fit: TermFit, model: RobotModelFile) -> BodyRefit:
        """Return the rotors that a fit of terms has beside them, and the model with these."""
        names = fit.laboratory.nominal.names
        variance = _variance(fit, np.array([names.index(f'{j} armature') for j in fit.armature]))
        known = with_fitted(model, fit.armature)
        return cls(known, {}, (), 0.0, {}, {}, variance, armature=fit.armature)

    @classmethod
    def of(cls, fit: TermFit, model: RobotModelFile, curved: TermFit) -> BodyRefit:
        """
        Return the bodies that a fit of terms has beside them, and the model with these.

        :param curved: of :func:`friction_beside`.
        """
        nominal = fit.laboratory.nominal
        robot = fit.laboratory.robot
        columns = nominal.rigid_columns
        x = np.array([fit.refit[nominal.names[k]] for k in columns])
        precision = body_precision(fit.estimate.fit.system, columns)
        rotors = np.array(robot.armature)
        for joint in fit.armature:
            # The model knows nothing of it, and of the body something: all inertia that no motion
            # tells from that of the body is the rotor's, as where the bodies are kept.
            i = robot.names.index(joint)
            rotors[i] = max(rotors[i] + fit.refit[f'{joint} armature'], 0.0)
        bodies, rotors, deviation = nearest_bodies(
            robot, nominal.rigid.tolist(), x, precision, rotors
        )
        for i, joint in enumerate(robot.names):
            if joint in fit.armature and fit.armature[joint].flags:
                rotors[i] = fit.armature[joint].value
        known = model.with_armature({'*': 0.0})
        moved = rotors - np.array(known.make_robot().armature)
        change = Change(REFIT, bodies - robot.inertial_parameters(), moved)
        deviations = {
            label: Parameter(float(value), unit, fit.refit_errors[nominal.names[k]])
            for (label, unit), value, k in zip(
                _labels(nominal, robot), deviation, columns, strict=True
            )
            if label.removesuffix(' armature') not in fit.armature
        }
        changed = with_changes(known, [change])
        refused = changed.refused.get(REFIT, '')
        armature = {
            joint: p if refused else _moved(p, float(rotors[robot.names.index(joint)]))
            for joint, p in fit.armature.items()
        }
        variance = _variance(fit, columns)
        return cls(
            with_fitted(changed.model, armature),
            *friction_beside(fit, curved),
            fit.body.tolerance,
            fit.body.log_evidence,
            deviations,
            variance,
            refused,
            armature,
            {} if refused else _scales(fit, bodies, moved),
        )

    def findings(self) -> list[DataFinding]:
        """Return for a person what was done, and why."""
        told = [
            DataFinding('rigid_body', ALL_JOINTS, NOTE, armature_sentence(joint, p))
            for joint, p in self.armature.items()
        ]
        if self.deviations:
            level = WARNING if self._is_far else NOTE
            told.append(DataFinding('rigid_body', ALL_JOINTS, level, self._of_bodies()))
        for joint, scale in self.scales.items():
            text = (
                f'the bodies refitted for joint {joint} need {scale:.3g} times the effort of '
                'those of the URDF, whatever it does: the masses are off by that factor, or the '
                'scale of the effort is (a torque constant, a gear ratio), by which friction '
                'would be off as well; the motion tells their product alone, and the errors hold '
                'both. Weigh the body, or check the torque constant; where the effort is sure, '
                f'--body-tolerance {max(self.tolerance, 2.0 * abs(scale - 1.0)):.2g} says so'
            )
            told.append(DataFinding('effort_scale', joint, WARNING, text))
        return told

    def sentences(self) -> list[str]:
        """Return for a person what was done, and why, without full stops."""
        return [found.sentence for found in self.findings()]

    @property
    def _is_far(self) -> bool:
        """Tell whether the data, and nobody else, want bodies that are hardly as wrong."""
        return bool(self.log_evidence) and self.tolerance >= _FAR

    def shift_by_scale(self, joint: str, law: LawFit) -> dict[str, float]:
        """
        Return by parameter what friction is off by where the scale of effort may be.

        Where all effort of a joint is k times what its bodies need, the masses are off, and
        friction is what it is, or the scale of effort is, and friction is 1 / k of it. Both are as
        likely: p d d' with p one half is the covariance of what d it is off by. Of a range, its
        end.
        """
        if joint not in self.scales:
            return {}
        share = np.sqrt(_OF_EFFORT) * (1.0 - 1.0 / self.scales[joint])
        amplitudes = {name for kind in TERMS.classes.values() for name in kind.amplitudes}
        known = {
            name: (p.value, *(p.interval or ())[::-1])
            for name, p in law.parameters.items()
            if name in amplitudes
        }
        sizes = {name: next(filter(np.isfinite, known[name]), 0.0) for name in known}
        return {name: float(share * x) for name, x in sizes.items()}

    def _of_bodies(self) -> str:
        share = f'{100.0 * self.tolerance:g} % of itself'
        if not self.log_evidence:
            text = f'each number of the rigid body was refitted within {share}, as told'
        else:
            text = (
                'the data contradict the bodies of the URDF: the rigid body was refitted within '
                f'{share}, which explains them better than the usual tolerance (log evidence '
                f'{self.log_evidence[self.tolerance]:+.0f})'
            )
        clearest = sorted(self.deviations.items(), key=lambda item: -_sigmas(item[1]))[:3]
        told = ', '.join(
            f'{name} {"+" if p.value > 0.0 else ""}{plus_minus(p.value, half_width(p), p.unit)}'
            for name, p in clearest
        )
        text += f' (clearest: {told})' if told else ''
        if self._is_far:
            text += (
                '. Masses are seldom as wrong: see the unit and zero of position, a gear ratio, '
                'the scale of the effort, whether it carries what the URDF lacks, and whether '
                'its motor moves it or a hand does'
            )
        if self.refused:
            text += f'; the model keeps its own bodies: {self.refused}'
        return text

    def to_dict(self) -> dict[str, Any]:
        """Return plain numbers and strings."""
        return {
            'tolerance': self.tolerance,
            'log_evidence': {f'{w:g}': value for w, value in self.log_evidence.items()},
            'deviations': self.deviations,
            'loads': [{'joint': t.joint, 'parameters': t.parameters} for t in self.loads],
            'refused': self.refused,
        }


def _moved(p: Parameter, value: float) -> Parameter:
    """Return what is known of a rotor whose value is that beside refitted bodies."""
    if p.flags:
        return p
    half = Z_95 * p.std_error
    return replace(p, value=value, interval=(max(value - half, 0.0), value + half))


def _variance(fit: TermFit, columns: IndexArray) -> dict[str, dict[str, float]]:
    """Return what not knowing the parameters ``columns`` adds to the variance of friction."""
    names, own = fit.laboratory.nominal.names, fit.estimate.fit
    # As unsure as the bodies are beside all that the model lacks, and not only beside noise.
    worth = rows_worth(fit.laboratory, own, columns, own.system.prior_weight())
    return {
        joint: {
            name: body_variance(own.system, columns, names.index(f'{joint} {name}'), worth)
            for name in ('coulomb', 'viscous', 'bias')
        }
        for joint in fit.names
        # A joint whose effort nobody knows has no friction.
        if f'{joint} coulomb' in names
    }


def _scales(fit: TermFit, bodies: FloatArray, moved: FloatArray) -> dict[str, float]:
    """
    Return by joint the factor on its effort that refitted bodies stand for; not where none does.

    Where they differ from the model's in one factor, as all of a pendulum's gravity does, the
    scale of the effort says the same. A bias is free, and so may be acceleration, of a rotor.

    :param bodies: the refitted ones (n, 10).
    :param moved: what was added to the rotors (n,).
    """
    laboratory = fit.laboratory
    robot, told = laboratory.robot, fit.body
    within = laboratory.settings.tolerance if told.log_evidence else told.tolerance
    every = max(1, sum(len(s.a) for s in laboratory.signals) // _ROWS)
    regressor = np.concatenate([s.regressor[::every] for s in laboratory.signals])
    a = np.concatenate([s.a[::every] for s in laboratory.signals])
    before = robot.inertial_parameters()
    own = np.array(robot.armature)
    result = {}
    for i, joint in enumerate(robot.names):
        need, more = (
            regressor[:, i] @ x.ravel() + a[:, i] * rotor[i]
            for x, rotor in ((before, own), (bodies - before, moved))
        )
        free = [np.ones(len(a)), *([a[:, i]] if joint in fit.armature else [])]
        basis = np.linalg.qr(np.column_stack(free))[0]
        need, more = (x - basis @ (basis.T @ x) for x in (need, more))
        square = float(need @ need)
        factor = float(need @ more) / square if square > 0.0 else 0.0
        explained = factor**2 * square > _ONE_FACTOR * float(more @ more)
        if explained and abs(factor) > within and factor > -1.0:
            result[joint] = 1.0 + factor
    return result


def friction_beside(
    fit: TermFit, curved: TermFit
) -> tuple[dict[str, LawFit], tuple[EffectTerm, ...]]:
    """
    Return by joint the law of a fit of terms, and friction by load.

    :param curved: the same with a Stribeck term in all joints: what one that the data do not show
        moves is in the errors of the laws without.
    """
    names = fit.laboratory.nominal.names
    knees = {term.joint: fit.profiled(term) for term in fit.linear if term.term == 'stribeck'}
    laws = {
        name: _law(fit, i, knees.get(name))
        for i, name in enumerate(fit.names)
        if f'{name} coulomb' in names
    }
    hidden = {name: law for name, law in laws.items() if name not in knees}
    laws |= {name: _with_hidden_knee(law, name, fit, curved) for name, law in hidden.items()}
    loads = [EffectTerm(t.term, t.joint, t.parameters) for t in fit.linear if t.term == LOAD]
    return laws, tuple(loads)


def _with_hidden_knee(law: LawFit, joint: str, fit: TermFit, curved: TermFit) -> LawFit:
    """
    Return a law with w d^2 in its variances, by a Stribeck term that is not shown.

    d: what the law moves by beside the term; w: how probable the term is, 1 / (1 + exp(-z^2 / 2))
    by its evidence z^2. One that would make friction less near standstill is impossible: it is
    another law where the data are very sure that its size is below 0, and nothing where not.
    """
    term = next(t for t in curved.linear if (t.term, t.joint) == ('stribeck', joint))
    size = term.parameters['stribeck']
    if size.value <= 0.0 and size.value**2 < VERY_STRONG * size.std_error**2:
        return law
    evidence = curved.evidence(term)
    weight = rival_probability(-evidence)
    moved = {
        name: curved.refit[f'{joint} {name}'] - fit.refit[f'{joint} {name}']
        for name in law.parameters
        if f'{joint} {name}' in fit.refit
    }
    wide = law.with_variance({name: weight * by**2 for name, by in moved.items()})
    other = (_curve(_drawn(curved, joint, term)[1]), weight)
    return replace(wide, covariance=law.covariance, others=(*law.others, other))


def _law(fit: TermFit, i: int, knee: FittedTerm | None) -> LawFit:
    """Return the law of joint ``i`` as other fits hold them; ``knee``: its Stribeck term."""
    joint, unit = fit.names[i], fit.units[i]
    drawn_law, drawn = _drawn(fit, joint, knee)
    parameters = {}
    for name in _LINEAR:
        value = drawn[name]
        error = fit.refit_errors[f'{joint} {name}']
        told = Parameter.estimated(value, unit_of(name, unit), error, Z_95)
        low, high = value - Z_95 * error, value + Z_95 * error
        if name != 'bias' and low <= 0.0:
            reason = (
                f'its 95 % interval, {low:.3g} to {high:.3g} {told.unit}, does not leave out 0'
            )
            told = replace(told, value=np.nan, flags=(NOT_IDENTIFIABLE,), reason=reason)
        parameters[name] = told
    law = 'coulomb_viscous'
    if knee is None:
        for name in _KNEE:
            parameters[name] = Parameter.not_told(
                unit_of(name, unit),
                'beside the bodies and what else was fitted, the data do not show more friction '
                'near standstill',
            )
    else:
        parameters |= {name: _or_range(p) for name, p in knee.parameters.items()}
        if all(np.isfinite(parameters[name].value) for name in _KNEE):
            law = drawn_law
    left = fit.residual()[:, i]
    own = sum(fit.explained(t)[:, i] for t in fit.linear if t.term in FRICTION)
    covariance, covariance_of = _covariance(fit, joint, knee)
    return LawFit(
        law,
        parameters,
        float(np.std(left)),
        100.0 * float(np.linalg.norm(left) / max(float(np.linalg.norm(left + own)), 1e-300)),
        fit.rows,
        fit.laboratory.settings.blocks,
        drawn=drawn,
        drawn_law=drawn_law,
        covariance=covariance,
        covariance_of=covariance_of,
        freedom=np.inf,
        others=_rivals(fit, joint, knee),
        slowest=slowest_speed(steady_speeds(fit.laboratory, i)),
    )


def _drawn(fit: TermFit, joint: str, knee: FittedTerm | None) -> tuple[str, dict[str, float]]:
    """Return the law of the best fit, and its numbers."""
    drawn = {name: fit.refit[f'{joint} {name}'] for name in _LINEAR}
    if knee is None:
        return 'coulomb_viscous', drawn
    drawn |= {name: p.value for name, p in knee.parameters.items()}
    return law_of((*_LINEAR, 'stribeck'), drawn).identifier, drawn


def _covariance(
    fit: TermFit, joint: str, knee: FittedTerm | None
) -> tuple[FloatArray, tuple[str, ...]]:
    """
    Return the covariance of a joint's law in the regression, and of which parameters.

    The parameters of a knee that is wide open are far off together, and the curve is not. So it
    is taken as a whole to the size of the errors that are said, by the mean of their ratios for
    C, B and bias: a factor for each parameter would leave of the curve what they differ by.
    """
    found, nominal = fit.estimate, fit.laboratory.nominal.names
    at = [nominal.index(f'{joint} {name}') for name in _LINEAR]
    size = [1.0] * len(at)
    names = list(_LINEAR)
    C = found.covariance
    said = found.errors[at] ** 2 - found.shift[at] ** 2
    factor = float(np.mean(said / np.diag(C)[at]))
    if knee is not None:
        which, part = fit.place_of(knee)
        at.append(part.start)
        size.append(1.0)
        names += [*TERMS[knee.term].amplitudes]
        for k, (owner, name) in enumerate(found.owners):
            if owner == which:
                at.append(len(found.errors) + k)
                # Those of a knee are sizes, searched by their logarithms.
                size.append(float(found.placed[which].inner[name]))
                names.append(name)
    return factor * C[np.ix_(at, at)] * np.outer(size, size), tuple(names)


def _rivals(
    fit: TermFit, joint: str, knee: FittedTerm | None
) -> tuple[tuple[FrictionLaw, float], ...]:
    """Return the laws that may be in place of one with a knee, each with its probability."""
    if knee is None:
        return ()
    nominal = fit.laboratory.nominal.names
    which, part = fit.place_of(knee)
    (size,) = TERMS[knee.term].amplitudes
    result = []
    for rival in fit.estimate.rivals:
        if rival.which != which:
            continue
        values = {name: float(rival.x[nominal.index(f'{joint} {name}')]) for name in _LINEAR}
        values |= {size: float(rival.x[part.start]), **rival.inner[which]}
        result.append((_curve(values).rival(), rival.probability))
    return tuple(result)


def _curve(values: Mapping[str, float]) -> FrictionLaw:
    """Return the law with a Stribeck term of these numbers, its sign that of a step."""
    law = law_of((*_LINEAR, 'stribeck'), values)
    return FrictionLaw(law, {name: values[name] for name in law.parameter_names}, 0.0)


def _or_range(p: Parameter) -> Parameter:
    """Return a parameter as a law has it: without a value where it is a range."""
    if NOT_IDENTIFIABLE not in p.flags:
        return p
    return replace(p, value=np.nan, reason='known together only, each as a range')


def _sigmas(p: Parameter) -> float:
    return abs(p.value) / p.std_error if p.std_error > 0.0 else 0.0


def _labels(nominal: Nominal, robot: Robot) -> list[tuple[str, str]]:
    """Return what each deviation of the rigid body is, in words, and its unit."""
    result = []
    for index in nominal.rigid.tolist():
        body, number = divmod(index, 10)
        if body < robot.n:
            words, unit = _NUMBERS[number]
            result.append((f'{robot.names[body]} {words}', unit))
        else:
            joint = index - 10 * robot.n
            unit = 'kg m2' if robot.effort_units[joint] == 'Nm' else 'kg'
            result.append((f'{robot.names[joint]} armature', unit))
    return result
