# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Laws of the regression beside rigid bodies, where they are better than those of other fits."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from sosml_friction.arrays import FloatArray
from sosml_friction.identification.body_comparison import BodyComparison
from sosml_friction.identification.data_finding import WARNING, DataFinding
from sosml_friction.identification.fitted_model import preferred_observer
from sosml_friction.identification.friction_fit import REGRESSION, WEAK_FORM, FrictionFit, JointFit
from sosml_friction.identification.law.law_checks import ODD_EVEN
from sosml_friction.identification.law.law_fit import LawFit
from sosml_friction.identification.law.law_form import LawForm
from sosml_friction.model.model_folder import EffectTerm
from sosml_friction.model.parameter import Parameter

#: Terms of the weak form's law that the regression of the bodies has not.
_CURVES = {'stribeck', 'nonlinear_viscous'}


def with_regression(
    fit: FrictionFit, compared: BodyComparison, form: LawForm
) -> tuple[FrictionFit, tuple[EffectTerm, ...]]:
    """
    Return the fits with the laws of the regression, and friction by load beside them.

    * Of joints in which the weak form has no fit.
    * Of those whose friction by load is shown: what the weak form, which has none, takes for a
      Stribeck term is that.
    * Of those whose effort repeats with position, where it is surer of C: to the weak form that is
      noise, which goes with C and B.
    * Beside refitted bodies, of all in which the weak form finds a straight line.

    Where another ``form`` is stated than such a law has, that of the weak form stays.
    """
    refitted = compared.refit is not None and bool(compared.refit.laws)

    def is_better(name: str, fits: Mapping[str, JointFit]) -> bool:
        if WEAK_FORM not in fits or name in compared.loads:
            return True
        if name in compared.repeats:
            own, law = fits[WEAK_FORM].fit, compared.friction()[0].get(name)
            # What is no number has an error that is none.
            return law is not None and not _error(law) >= _error(own)
        return refitted and not _CURVES & {*fits[WEAK_FORM].fit.drawn}

    wanted = [name for name, fits in fit.joints.items() if is_better(name, fits)]
    if not wanted:
        return fit, compared.friction()[1] if refitted else ()
    laws, loads = compared.friction()
    kept = {
        name
        for name in wanted
        if name in laws and WEAK_FORM in fit.joints[name] and not _is_of(form, laws[name])
    }
    wanted = [name for name in wanted if name not in kept]
    loads = tuple(term for term in loads if term.joint not in kept)
    joints = {name: dict(fits) for name, fits in fit.joints.items()}
    for name in wanted:
        if name in laws:
            joints[name][REGRESSION] = _with_law(joints[name], laws[name])
    return replace(fit, joints=joints), loads


def _is_of(form: LawForm, law: LawFit) -> bool:
    """Tell whether a law of the regression has the form that is stated."""
    knee = 'stribeck' in law.drawn
    if not form.symmetric or (knee and form.alpha is not None):
        return False
    return form.law == 'auto' or knee == (form.law == 'stribeck')


def _error(law: LawFit) -> float:
    """Return the standard error of C."""
    return law.parameters['coulomb'].std_error


def _with_law(fits: Mapping[str, JointFit], law: LawFit) -> JointFit:
    """Return the fit of a joint by the regression, with the windows of another one."""
    like = fits.get(WEAK_FORM) or next(iter(fits.values()))
    return replace(like, observer=REGRESSION, method=REGRESSION, fit=law, inertia=None)


def with_regression_estimates(
    estimates: Mapping[str, FloatArray], fit: FrictionFit, names: Sequence[str]
) -> dict[str, FloatArray]:
    """Return the estimates with those that laws of the regression are drawn over."""
    if not any(REGRESSION in fits for fits in fit.joints.values()):
        return dict(estimates)
    own = estimates[WEAK_FORM].copy()
    for i, name in enumerate(names):
        fits = fit.joints.get(name, {})
        observer = next(iter(fits), '')
        if WEAK_FORM not in fits and observer in estimates:
            own[:, i] = estimates[observer][:, i]
    return {**estimates, REGRESSION: own}


def laws_of_observers(fit: FrictionFit) -> list[DataFinding]:
    """Return what is to be known of joints whose law is that of an observer."""
    return [
        DataFinding(
            'observer_law',
            name,
            WARNING,
            f'the law of joint {name} is that of an observer, {observer}: what its lag and its '
            'smoothing do to C and B is not in their intervals; record several speeds in both '
            'directions, so that the weak form has a fit',
        )
        for name, fits in fit.joints.items()
        if not {WEAK_FORM, REGRESSION} & {*fits} and (observer := preferred_observer(fits))
    ]


def without_direction(fit: FrictionFit, loads: Mapping[str, Parameter]) -> FrictionFit:
    """Return the fits without what laws say of the way, where friction by load makes it."""

    def changed(joint: str, law: LawFit) -> LawFit:
        kept = tuple(c for c in law.checks if c.passed or c.name != ODD_EVEN)
        return replace(law, checks=kept) if joint in loads else law

    return fit.changed(changed)
