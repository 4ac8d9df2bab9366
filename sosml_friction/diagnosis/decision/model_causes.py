# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Causes that candidates of the library show: accepted findings, with their numbers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sosml_friction.diagnosis.decision.cause import Cause
from sosml_friction.diagnosis.decision.finding import Finding, with_amplitudes
from sosml_friction.diagnosis.decision.selection import Selection
from sosml_friction.diagnosis.fitted import Fitted
from sosml_friction.regression.laboratory import Laboratory

FloatArray = NDArray[np.float64]


def model_causes(laboratory: Laboratory, selection: Selection) -> list[Cause]:
    """Return accepted findings as causes; several of one effect and joint are its harmonics."""
    names = laboratory.robot.names
    errors = standard_errors(laboratory, selection)
    causes: dict[tuple[str, int], Cause] = {}
    for finding, own in with_amplitudes(selection.accepted, len(laboratory.nominal.bound)):
        amplitude = selection.after.x[own]
        fit = Fitted(laboratory.signals[0], finding.joint, finding.inner, amplitude, errors[own])
        parameters = finding.effect.parameters(fit)
        term = ((dict(finding.inner), np.array(amplitude)),)
        if finding.key in causes:
            old = causes[finding.key]
            number = len(old.terms) + 1
            more = {f'{name}_{number}': value for name, value in parameters.items()}
            causes[finding.key] = replace(
                old, parameters={**old.parameters, **more}, terms=old.terms + term
            )
            continue
        effect, joint = finding.reported(names)
        rivals = _rivals(laboratory, finding)
        # What another cause explains as well may be that, beyond its own tolerance.
        alone = all(rival.partition('@')[0] == effect for rival in rivals)
        causes[finding.key] = Cause(
            effect,
            joint,
            parameters,
            _evidence(finding),
            rivals,
            term,
            alone and finding.effect.tolerated(fit, laboratory.settings.tolerance),
        )
    return list(causes.values())


def _evidence(finding: Finding) -> dict[str, float | None]:
    return {
        'delta_bic': finding.delta_bic,
        'p_adjusted': finding.p_adjusted,
        'cv_gain': finding.score.cv_gain,
        'cv_gain_se': finding.score.cv_se,
        'folds_improved': finding.score.improved,
        'floor': finding.floor,
    }


def _rivals(laboratory: Laboratory, finding: Finding) -> tuple[str, ...]:
    """Return what cannot be told from a finding, as effect@joint where that is another joint."""
    names = laboratory.robot.names
    _, own = finding.reported(names)
    rivals = list(laboratory.inseparable(finding.effect))
    for rival in finding.rivals:
        name, where = rival.reported(names)
        rivals.append(name if where == own else f'{name}@{where}')
    return tuple(dict.fromkeys(rivals))


def standard_errors(laboratory: Laboratory, selection: Selection) -> FloatArray:
    """Return standard errors (p,) from the whitened equations, scaled by what is left."""
    system = selection.system
    G = system.G.sum(axis=(0, 1)) + np.diag(system.penalty())
    scale = 1.0 / np.sqrt(np.diag(G))
    covariance = np.linalg.pinv(G * scale * scale[:, None]) * scale * scale[:, None]
    left = max(selection.after.cost / float(laboratory.known.sum()), 1.0)
    return np.asarray(np.sqrt(np.maximum(np.diag(covariance) * left, 0.0)))
