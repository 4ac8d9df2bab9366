# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The effects that a model folder lists: as columns, and as terms of the simulation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sosml_friction.diagnosis.effect import ALL_JOINTS, Effect, FloatArray, Inner
from sosml_friction.diagnosis.library import DATA_CAUSES, EFFECTS, EVERYWHERE
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.model_folder import EffectTerm, RobotModelFile
from sosml_friction.model.robot import Robot
from sosml_friction.regression.signals import Signals, nominal_friction
from sosml_friction.simulation.forward_friction import ForwardFriction
from sosml_friction.simulation.forward_term import ForwardTerm


@dataclass(frozen=True)
class KnownEffect:
    """Hold an effect of known size; ``joint`` is 0 where it is of the whole robot."""

    effect: Effect
    joint: int
    inner: Inner
    amplitude: FloatArray

    def term(self, robot: Robot) -> ForwardTerm:
        """Return how it enters the simulation."""
        return self.effect.term(robot, self.joint, self.inner, self.amplitude)


def known_effects(model: RobotModelFile) -> list[KnownEffect]:
    """
    Return the effects that a model lists, a harmonic each.

    The parameters of the second harmonic end in ``_2``, and so on.

    :raises ConfigurationError: if one is unknown, lacks a parameter, or is in the wrong joint.
    """
    return [found for entry in model.effects for found in _read(entry, model)]


def _read(entry: EffectTerm, model: RobotModelFile) -> list[KnownEffect]:
    where = f'effect {entry.effect!r} of model {model.name}'
    # A fault of data or of one occasion: a folder may list it, and nothing comes of it.
    if entry.effect in DATA_CAUSES:
        return []
    if entry.effect not in EFFECTS:
        raise ConfigurationError(
            f'{where} is unknown: remove it, or use one of {", ".join(sorted(EFFECTS))}'
        )
    everywhere = entry.joint == ALL_JOINTS and entry.effect in EVERYWHERE
    effect = (EVERYWHERE if everywhere else EFFECTS)[entry.effect]()
    if effect.of_robot != (entry.joint == ALL_JOINTS):
        wanted = '*, all joints' if effect.of_robot else 'one joint'
        raise ConfigurationError(f'{where} is in joint {entry.joint}: it acts in {wanted}')
    joint = 0 if effect.of_robot else model.joint_names.index(entry.joint)
    names = (*effect.amplitudes, *effect.inner)
    result: list[KnownEffect] = []
    while True:
        number = len(result) + 1
        keys = {name: name if number == 1 else f'{name}_{number}' for name in names}
        missing = [key for key in keys.values() if key not in entry.parameters]
        if number > 1 and len(missing) == len(keys):
            break
        if missing:
            raise ConfigurationError(f'{where} has no {", ".join(missing)}: give each a value')
        own = {name: entry.parameters[key] for name, key in keys.items()}
        bad = [name for name, p in own.items() if not np.isfinite(p.value)]
        if bad:
            raise ConfigurationError(f'{where} has no value of {", ".join(bad)}: give a number')
        result.append(KnownEffect(effect, joint, *effect.restore(own)))
    unknown = sorted(set(entry.parameters) - {
        name if k == 0 else f'{name}_{k + 1}' for k in range(len(result)) for name in names
    })  # fmt: skip
    if unknown:
        raise ConfigurationError(f'{where} has an unknown parameter {unknown[0]}: remove it')
    return result


def model_friction(model: RobotModelFile) -> ForwardFriction:
    """Return the friction laws of a model for the simulation; a joint without one has none."""
    return ForwardFriction.of(
        [
            None if joint.friction is None else joint.friction.make_law()
            for joint in model.joints.values()
        ]
    )


def with_known(signals: Sequence[Signals], model: RobotModelFile) -> list[Signals]:
    """
    Return the signals with what the model has beyond the rigid body and (17) as ``known``.

    The columns of its effects times their amplitudes, seen as a diagnosis saw them that found
    them: beside the model without effects. And what its friction law has that the nominal columns
    have not, asymmetries and another exponent.
    """
    effects = known_effects(model)
    friction = model_friction(model)
    result = []
    for s in signals:
        known = friction.torque(s.v, s.sign) - nominal_friction(s.v, s.sign, s.scales)
        for found in effects:
            columns = found.effect.columns(s, found.joint, found.inner)
            known = known + columns @ found.amplitude
        # What was computed for the columns may depend on the nominal effort.
        result.append(replace(s, known=known, cache={}) if known.any() else s)
    return result
