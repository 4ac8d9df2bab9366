# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The model with what was found: refitted friction, and the causes as terms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from sosml_friction.diagnosis.diagnosis import Diagnosis
from sosml_friction.model.model_folder import EffectTerm, RobotModelFile
from sosml_friction.model.parameter import Parameter

#: Faults of data or of one occasion: nothing that a model should have.
_NO_TERM = ('velocity_lag', 'dropped_samples', 'external_contact')


def extended_model(
    model: RobotModelFile, diagnosis: Diagnosis, provenance: Mapping[str, Any]
) -> RobotModelFile:
    """
    Return ``model`` with its friction refitted within the tolerance and the causes as effects.

    Deviations of rigid-body parameters, which are combinations, stay in the provenance
    (``refit``). A joint without friction in the model stays without: what was fitted in its place
    is in the provenance too.
    """
    joints = {}
    for name, joint in model.joints.items():
        if joint.friction is None:
            joints[name] = joint
            continue
        parameters = {}
        for key, old in joint.friction.parameters.items():
            change = diagnosis.refit.get(f'{name} {key}', 0.0)
            parameters[key] = Parameter(old.value + change, old.unit)
        joints[name] = replace(joint, friction=replace(joint.friction, parameters=parameters))
    terms = [
        EffectTerm(cause.effect, cause.joint, cause.parameters)
        for cause in diagnosis.causes
        if cause.effect not in _NO_TERM
    ]
    return replace(
        model,
        joints=joints,
        effects=(*model.effects, *terms),
        provenance={**provenance, 'refit': dict(diagnosis.refit)},
    )
