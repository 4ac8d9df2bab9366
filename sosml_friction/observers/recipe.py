# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Gains of all observers from stated quantities: noise, friction and motion, or a bandwidth."""

from collections.abc import Sequence

import numpy as np

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.robot import Robot
from sosml_friction.observers.conditions import Conditions
from sosml_friction.observers.observer import Recipe
from sosml_friction.observers.registry import OBSERVERS
from sosml_friction.observers.search_space import Gains

#: Bandwidth [rad/s] where none is given: settles in 0.1 s, well inside a plateau's trim.
BANDWIDTH = 40.0


def gains_for_bandwidth(bandwidth: float, momentum_noise: Sequence[float]) -> dict[str, Gains]:
    """
    Return gains of one bandwidth w for the observers that have one.

    All then follow a slow disturbance with the same delay, 1 / w.

    :param bandwidth: w [rad/s], positive.
    :param momentum_noise: s_p per joint [Nm s or N s], >= 0.
    :raises ConfigurationError: if a number is out of range.
    """
    if not 0.0 < bandwidth < np.inf or not all(0.0 <= s < np.inf for s in momentum_noise):
        raise ConfigurationError(
            f'bandwidth {bandwidth} rad/s and momentum noise {list(momentum_noise)}: the first '
            'must be positive, the second not negative, both finite'
        )
    w, s_p = np.full(len(momentum_noise), bandwidth), np.array(momentum_noise, dtype=float)
    recipes = {name: o.bandwidth_recipe(w, s_p) for name, o in OBSERVERS.items()}
    return {name: _gains(recipe, len(w)) for name, recipe in recipes.items() if recipe is not None}


def gains_for_conditions(conditions: Conditions) -> dict[str, Gains]:
    """Return the gains of every observer for the noise, the friction and the motion."""
    n = len(conditions.joints)
    return {name: _gains(o.recipe(conditions), n) for name, o in OBSERVERS.items()}


def recipe_gains(
    robot: Robot,
    bandwidth: float,
    position_noise: Sequence[float] = (),
    velocity_noise: Sequence[float] = (),
    friction_jump: Sequence[float] = (),
    reversal_time: Sequence[float] = (),
) -> dict[str, Gains]:
    """
    Return gains from what is stated of a robot, one value for each joint.

    With ``friction_jump`` all four quantities are needed and ``bandwidth`` is not used:
    :func:`gains_for_conditions`, at posture zero. Without it the observers that have a bandwidth
    get gains: :func:`gains_for_bandwidth`, with a sliding term if ``velocity_noise`` is known.

    :raises ConfigurationError: if a number is missing or out of range.
    """
    zero = np.zeros(robot.n)
    if len(friction_jump):
        return gains_for_conditions(
            Conditions.of(
                robot, zero, position_noise, velocity_noise, friction_jump, reversal_time
            )
        )
    noise = np.array(velocity_noise if len(velocity_noise) else zero, dtype=float)
    if not ((noise >= 0.0) & (noise < np.inf)).all():
        raise ConfigurationError(
            f'velocity_noise is {noise.tolist()}: a standard deviation is not negative'
        )
    if len(noise) != robot.n:
        raise ConfigurationError(
            f'velocity_noise has {len(noise)} values for the {robot.n} joints '
            f'{", ".join(robot.names)}: give one for each'
        )
    momentum_noise = np.sqrt(robot.inertia(zero) ** 2 @ noise**2)
    return gains_for_bandwidth(bandwidth, momentum_noise.tolist())


def _gains(recipe: Recipe, n: int) -> Gains:
    return {name: np.broadcast_to(value, n).tolist() for name, value in recipe.items()}
