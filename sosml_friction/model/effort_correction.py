# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The torque behind a reported effort, where a model knows how the two differ."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.model_folder import EffectTerm, RobotModelFile

FloatArray = NDArray[np.float64]

#: Effects of the way from torque to reported effort that can be undone sample by sample, and
#: their parameters.
CORRECTED: Mapping[str, tuple[str, ...]] = {
    'effort_scale': ('error',),
    'effort_bias': ('bias',),
    'effort_saturation': ('excess', 'reference'),
    'joint_coupling': ('coupling', 'source'),
}
#: Effects of the measurement that observers do not undo, and why.
_LEFT_OUT = {
    'effort_delay': 'the effort belongs to an earlier position, which shows as viscous friction '
    'where gravity changes: mend it in the driver',
    'encoder_eccentricity': 'the position is wrong once per turn: mend it in the driver',
}
#: The joint of an effect that acts in all joints alike, and which of them can.
_ALL, _EVERYWHERE = '*', {'effort_scale'}
#: Rounds of Newton's rule: the cube is at most half of the torque, and its error squares.
_ROUNDS = 8


class EffortCorrection:
    """
    Undo what the effects of a model do to effort, the last in its list first.

        effort_scale       reported = tau (1 + error), in joint '*' of all joints
        effort_bias        reported = tau + bias
        effort_saturation  reported = tau + excess (tau / reference)^3
        joint_coupling     reported = tau + coupling tau_source

    Effort that is not known stays so, and makes that of a joint it is passed on to unknown.
    ``done`` names what is undone, ``left_out`` says in a sentence each what is not.

    :raises ConfigurationError: if a parameter is missing or cannot be undone.
    """

    def __init__(self, model: RobotModelFile) -> None:
        self._names = model.joint_names
        self._terms = [
            part for term in model.effects if term.effect in CORRECTED for part in _parts(term)
        ]
        for term in self._terms:
            self._check(term, model.name)
        self.done = tuple(f'{term.effect} of {term.joint}' for term in self._terms)
        self.left_out = tuple(
            f'the {term.effect} of model {model.name} ('
            f'{"all joints" if term.joint == _ALL else term.joint}) is left out: '
            f'{_LEFT_OUT[term.effect]}'
            for term in model.effects
            if term.effect in _LEFT_OUT
        )

    def __bool__(self) -> bool:
        """Tell whether there is anything to undo."""
        return bool(self._terms)

    def torque(self, reported: FloatArray) -> FloatArray:
        """Return the torque (..., n) behind a reported effort (..., n) [Nm or N], a copy."""
        tau = np.array(reported, dtype=float)
        for term in reversed(self._terms):
            i = slice(None) if term.joint == _ALL else self._names.index(term.joint)
            own = tau[..., i]
            values = {key: parameter.value for key, parameter in term.parameters.items()}
            if term.effect == 'effort_scale':
                tau[..., i] = own / (1.0 + values['error'])
            elif term.effect == 'effort_bias':
                tau[..., i] = own - values['bias']
            elif term.effect == 'joint_coupling':
                tau[..., i] = own - values['coupling'] * tau[..., int(values['source'])]
            else:
                tau[..., i] = _without_cube(own, values['excess'] / values['reference'] ** 3)
        return tau

    def _check(self, term: EffectTerm, model: str) -> None:
        where = f'effect {term.effect} of {term.joint} of model {model}'
        for name in CORRECTED[term.effect]:
            if name not in term.parameters or not np.isfinite(term.parameters[name].value):
                raise ConfigurationError(f'{where} has no {name}: give it a value')
        values = {key: parameter.value for key, parameter in term.parameters.items()}
        source = values.get('source', 0.0)
        wrong = (
            not (term.joint in self._names or (term.joint == _ALL and term.effect in _EVERYWHERE))
            or (term.effect == 'effort_scale' and values['error'] <= -1.0)
            or (
                term.effect == 'effort_saturation'
                and not (values['excess'] >= 0.0 and values['reference'] > 0.0)
            )
            or source not in range(len(self._names))
            or (term.effect == 'joint_coupling' and self._names[int(source)] == term.joint)
        )
        if wrong:
            raise ConfigurationError(
                f'{where} cannot be undone, with {values}: correct it or remove it'
            )


def _parts(term: EffectTerm) -> list[EffectTerm]:
    """Return what a term is a sum of: the parameters of its second part end in ``_2``."""
    names = CORRECTED[term.effect]
    result = [term]
    while True:
        number = len(result) + 1
        own = {name: term.parameters.get(f'{name}_{number}') for name in names}
        if all(parameter is None for parameter in own.values()):
            return result
        known = {name: parameter for name, parameter in own.items() if parameter is not None}
        result.append(replace(term, parameters=known))


def _without_cube(reported: FloatArray, gain: float) -> FloatArray:
    """Return tau of reported = tau + gain tau^3, gain >= 0, by Newton's rule."""
    tau = reported.copy()
    for _ in range(_ROUNDS):
        square = gain * tau * tau
        tau = tau - (tau + square * tau - reported) / (1.0 + 3.0 * square)
    return tau
