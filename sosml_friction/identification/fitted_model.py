# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The model that a fit makes: whose law it has, and what it keeps of the nominal one."""

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from datetime import datetime, timezone
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.source import Source
from sosml_friction.identification.friction_fit import (
    REGRESSION,
    WEAK_FORM,
    FitSettings,
    FrictionFit,
)
from sosml_friction.model.effort_correction import is_corrected
from sosml_friction.model.laws import law_definition
from sosml_friction.model.model_folder import EffectTerm, FrictionParameters, RobotModelFile
from sosml_friction.model.parameter import Parameter
from sosml_friction.observers.configuration import ObserverConfiguration
from sosml_friction.observers.registry import OBSERVERS
from sosml_friction.plain_document import to_plain

#: The fit that becomes the model, where there are several: the first of these, else the first.
PREFERRED = (REGRESSION, WEAK_FORM, 'sosml')


def preferred_observer(fits: Iterable[str]) -> str | None:
    """
    Return which of a joint's fits, by observer, becomes the model, None if there is none.

    The regression where it is better, the weak form where it was asked for, else SOSML, else
    the first that ran; one that carries a law only where there is no other.
    """
    known = list(fits)
    for name in PREFERRED:
        if name in known:
            return name
    free = [name for name in known if name in OBSERVERS and not OBSERVERS[name].carries_law]
    return next(iter(free or known), None)


def friction_of(
    law: str, parameters: Mapping[str, Parameter], smoothing_velocity: float
) -> FrictionParameters | None:
    """
    Return what a model holds of a fitted law: without Stribeck term where it is not a number.

    None where what is left is no number either: a model must not be made of it.

    :param smoothing_velocity: v0 of the sign; plateaus say nothing of it, 0 is the law as fitted.
    """
    plain = 'coulomb_viscous_asymmetric' if law.endswith('_asymmetric') else 'coulomb_viscous'
    for name in (law, plain):
        own = {key: parameters.get(key) for key in law_definition(name).parameter_names}
        known = {key: p for key, p in own.items() if p is not None and np.isfinite(p.value)}
        if len(known) == len(own):
            return FrictionParameters(name, smoothing_velocity, known)
    return None


def unusable_reason(parameters: Mapping[str, Parameter]) -> str:
    """Return why :func:`friction_of` has nothing, as part of a sentence."""
    for name in ('coulomb', 'viscous', 'bias'):
        p = parameters.get(name)
        if p is not None and not np.isfinite(p.value):
            reason = f'{name} is not identifiable' + (f': {p.reason}' if p.reason else '')
            return f'{reason}; {p.experiment}' if p.experiment else reason
    return 'its law has no numbers'


def effects_in_law(nominal: RobotModelFile) -> list[EffectTerm]:
    """Return the effects of a model that a fitted law holds: effort is not corrected by them."""
    return [term for term in nominal.effects if not is_corrected(term)]


def fitted_model(
    nominal: RobotModelFile,
    fit: FrictionFit,
    provenance: Mapping[str, Any],
    loads: Sequence[EffectTerm] = (),
) -> RobotModelFile:
    """
    Return the nominal model with the friction that was fitted; a joint without a fit has none.

    Effects by which the effort was corrected before the fit stay. The others were part of the
    fitted friction, and the law now contains them; the provenance names them under
    ``effects_left_out``.

    :param loads: friction by load that was fitted beside the law of the regression.
    """
    joints = {}
    beside = set()
    for name, joint in nominal.joints.items():
        fits = fit.joints.get(name, {})
        observer = preferred_observer(fits)
        friction = None
        if observer is not None:
            law = fits[observer].fit
            beside |= {name} if observer == REGRESSION else set()
            friction = friction_of(law.law, law.parameters, law.smoothing_velocity)
        joints[name] = replace(joint, friction=friction)
    kept = {
        key: nominal.provenance[key]
        for key in ('rigid_body',)
        if key in nominal.provenance and key not in provenance
    }
    gone = [f'{term.effect} of {term.joint}' for term in effects_in_law(nominal)]
    return replace(
        nominal,
        joints=joints,
        provenance={**provenance, **kept, **({'effects_left_out': gone} if gone else {})},
        effects=(
            *(term for term in nominal.effects if is_corrected(term)),
            *(term for term in loads if term.joint in beside),
        ),
    )


def fit_provenance(
    source: Source,
    log: JointLog,
    configuration: ObserverConfiguration,
    fit: FrictionFit,
    settings: FitSettings,
    command: str,
) -> dict[str, Any]:
    """Return what a fitted model rests on: which data, versions, gains, settings and command."""
    document = {
        'bag': source.name,
        'sha256': source.sha256,
        'start_ns': int(log.t_ns.min()),
        'end_ns': int(log.t_ns.max()),
        'samples': len(log),
        'recovered': bool(source.recovery),
        'fitted': datetime.now(timezone.utc).isoformat(timespec='seconds'),
        'versions': versions(),
        'observers': configuration.gains,
        'fits': fit.joints,
        'unavailable': fit.unavailable,
        'settings': settings,
        'command': command,
    }
    return to_plain(document)


def versions() -> dict[str, str]:
    """Return the versions of the package and of what computes for it."""
    found = dict.fromkeys(('sosml_friction', 'numpy', 'scipy', 'pin'), 'unknown')
    for name in found:
        with suppress(PackageNotFoundError):
            found[name] = version(name)
    return found
