# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a model has beyond its rigid body and the nominal columns of friction, as effort."""

from collections.abc import Sequence
from dataclasses import replace

from sosml_friction.model.known_terms import known_terms, model_friction
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.regression.signals import Signals, nominal_friction


def with_known(signals: Sequence[Signals], model: RobotModelFile) -> list[Signals]:
    """
    Return the signals with what the model has beyond the rigid body and (17) as ``known``.

    The columns of its terms times their amplitudes, seen as a diagnosis saw them that found
    them: beside the model without terms. And what its friction law has that the nominal columns
    have not, asymmetries and another exponent.
    """
    terms = known_terms(model)
    friction = model_friction(model)
    result = []
    for s in signals:
        known = friction.torque(s.v, s.sign) - nominal_friction(s.v, s.sign, s.scales)
        for found in terms:
            known = known + found.term.columns(s, found.joint, found.inner) @ found.amplitude
        # What was computed for the columns may depend on the nominal effort.
        result.append(replace(s, known=known, cache={}) if known.any() else s)
    return result
