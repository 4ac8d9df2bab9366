# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The torque behind a reported effort, where a model knows how the two differ."""

from collections.abc import Mapping

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.known_terms import read_term
from sosml_friction.model.model_folder import EffectTerm, RobotModelFile
from sosml_friction.model.terms.kinds.measurement_term import MeasurementTerm
from sosml_friction.model.terms.kinds.term import ALL_JOINTS, TERMS


def is_corrected(term: EffectTerm) -> bool:
    """Tell whether observers are given efforts from which a term of a model is undone."""
    return term.effect in TERMS.classes and issubclass(TERMS[term.effect], MeasurementTerm)


class EffortCorrection:
    """
    Undo what the measurement terms of a model do to effort, the last in its list first.

    Unknown effort stays unknown, also in a joint that it is passed on to. ``done`` names the terms
    that are undone; ``left_out`` has a sentence for each of the others.

    :raises ConfigurationError: if a parameter is missing or cannot be undone.
    """

    def __init__(self, model: RobotModelFile) -> None:
        self._terms = []
        entries = [term for term in model.effects if is_corrected(term)]
        for entry in entries:
            where = f'effect {entry.effect} of {entry.joint} of model {model.name}'
            values = {key: parameter.value for key, parameter in entry.parameters.items()}
            for known in read_term(entry, model):
                term = known.term
                assert isinstance(term, MeasurementTerm)
                n = len(model.joint_names)
                if term.not_undone(n, known.joint, known.inner, known.amplitude):
                    raise ConfigurationError(
                        f'{where} cannot be undone, with {values}: correct it or remove it'
                    )
                self._terms.append(term.simulated(None, known.joint, known.inner, known.amplitude))
        self.done = tuple(f'{term.effect} of {term.joint}' for term in entries)
        self.left_out = tuple(
            f'the {term.effect} of model {model.name} ('
            f'{"all joints" if term.joint == ALL_JOINTS else term.joint}) is left out: '
            f'{_left_out()[term.effect]}'
            for term in model.effects
            if term.effect in _left_out()
        )

    def __bool__(self) -> bool:
        """Tell whether there is anything to undo."""
        return bool(self._terms)

    def torque(self, reported: FloatArray) -> FloatArray:
        """Return the torque (..., n) behind a reported effort (..., n) [Nm or N], a copy."""
        tau = np.array(reported, dtype=float)
        for term in reversed(self._terms):
            tau = term.torque(tau)
        return tau


def _left_out() -> Mapping[str, str]:
    """Return the terms of the measurement that observers do not undo, and why."""
    return {name: kind.left_out for name, kind in TERMS.classes.items() if kind.left_out}
