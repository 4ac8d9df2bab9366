# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Causes that candidates of the library show: accepted findings, with their numbers."""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from sosml_friction.diagnosis.decision.cause import Cause
from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.diagnosis.decision.selection import Selection
from sosml_friction.diagnosis.extended_model.cause_gain import CauseGain
from sosml_friction.diagnosis.trust import scale_tolerance
from sosml_friction.identification.term_parameters import term_parameters
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.term import Term
from sosml_friction.model.terms.nonlinear_viscous import NonlinearViscous
from sosml_friction.regression.estimate import Estimate, estimate
from sosml_friction.regression.placed import with_amplitudes
from sosml_friction.regression.whitened import WhitenedRegression


def model_causes(
    laboratory: WhitenedRegression,
    selection: Selection,
    kept: Selection | None = None,
    gains: Mapping[tuple[str, int], CauseGain] = MappingProxyType({}),
) -> list[Cause]:
    """
    Return accepted findings as causes; several of one effect and joint are its harmonics.

    :param kept: those of them that the extended model has, fitted without the others, whose
        numbers are those of ``selection``; None for all.
    :param gains: of each, on data left out.
    """
    kept = selection if kept is None else kept
    found = _causes(laboratory, kept, gains)
    if kept is not selection:
        of_all = _causes(laboratory, selection, gains)
        found = {
            key: found[key] if key in found else replace(cause, terms=())
            for key, cause in of_all.items()
        }
    return list(found.values())


def _causes(
    laboratory: WhitenedRegression,
    selection: Selection,
    gains: Mapping[tuple[str, int], CauseGain],
) -> dict[tuple[str, int], Cause]:
    names = laboratory.robot.names
    found = estimated(laboratory, selection)
    causes: dict[tuple[str, int], Cause] = {}
    fits, known = found.fitted(laboratory), term_parameters(laboratory, found, reported=True)
    parts = with_amplitudes(selection.accepted, len(laboratory.nominal.bound))
    for (finding, part), fit, parameters in zip(parts, fits, known, strict=True):
        term = ((dict(finding.inner), np.array(fit.amplitude)),)
        errors = np.maximum(found.errors[part], np.finfo(float).tiny)
        moved = (found.by_tolerance[:, part] / errors).T.tolist()
        sizes = (finding.effect.reported_as.get(x, x) for x in finding.effect.amplitudes)
        tolerance = {name: (own, most) for name, (own, most) in zip(sizes, moved, strict=True)}
        if finding.key in causes:
            old = causes[finding.key]
            number = len(old.terms) + 1
            more = {f'{name}_{number}': value for name, value in parameters.items()}
            causes[finding.key] = replace(
                old,
                parameters={**old.parameters, **more},
                terms=old.terms + term,
                by_tolerance={
                    **old.by_tolerance,
                    **{f'{name}_{number}': moves for name, moves in tolerance.items()},
                },
            )
            continue
        effect, joint = finding.reported(names)
        causes[finding.key] = Cause(
            effect,
            joint,
            parameters,
            _evidence(finding),
            _rivals(laboratory, selection, finding, fit),
            term,
            # Whatever else explains it as well: what is expected is more likely than any cause.
            finding.effect.tolerated(fit, scale_tolerance(laboratory)),
            gains.get(finding.key),
            _stated(finding.effect),
            finding.effect.stated_names,
            len(laboratory.candidates),
            tolerance,
        )
    return causes


def _stated(term: Term) -> dict[str, float]:
    """Return what the model has of a term, by the names under which it is reported."""
    values = () if term.stated is None else term.stated.tolist()
    names = (term.reported_as.get(name, name) for name in term.amplitudes)
    return dict(zip(names, values, strict=False))


def estimated(laboratory: WhitenedRegression, selection: Selection) -> Estimate:
    """Return the accepted causes with one covariance of all that was fitted, as a fit has it."""
    return estimate(laboratory, [finding.placed for finding in selection.accepted])


def tolerated(laboratory: WhitenedRegression, selection: Selection) -> frozenset[tuple[str, int]]:
    """Return which causes have a size that is expected of any model: no cause, but a refit."""
    fits = estimated(laboratory, selection).fitted(laboratory)
    share = scale_tolerance(laboratory)
    # Of harmonics the first says it.
    found: dict[tuple[str, int], bool] = {}
    for finding, fit in zip(selection.accepted, fits, strict=True):
        found.setdefault(finding.key, finding.effect.tolerated(fit, share))
    return frozenset(key for key, is_refit in found.items() if is_refit)


def _evidence(finding: Finding) -> dict[str, float | None]:
    return {
        'delta_bic': finding.delta_bic,
        'cv_gain': finding.score.cv_gain,
        'cv_gain_se': finding.score.cv_se,
        'floor': finding.floor,
    }


def _rivals(
    laboratory: WhitenedRegression, selection: Selection, finding: Finding, fit: Fitted
) -> tuple[str, ...]:
    """Return what cannot be told from a finding, as effect@joint where that is another joint."""
    names = laboratory.robot.names
    _, own = finding.reported(names)
    rivals = list(laboratory.inseparable(finding.effect))
    for rival in finding.rivals:
        name, where = rival.reported(names)
        rivals.append(name if where == own else f'{name}@{where}')
    # Beside the others a part of it may be 0 that was not in the round that chose it.
    rivals += filter(None, [finding.effect.nested(fit)])
    if any(power.is_rival(finding) for power in selection.remainder.powers):
        rivals.append(NonlinearViscous.identifier)
    return tuple(dict.fromkeys(rivals))
