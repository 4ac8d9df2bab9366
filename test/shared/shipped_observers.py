# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The observers of the exoskeleton as ``config/exoskeleton.yaml`` sets them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import yaml

from sosml_friction.model.robot import Robot
from sosml_friction.observers.configuration import ObserverConfiguration
from sosml_friction.observers.friction_estimator import FrictionEstimator
from sosml_friction.observers.recipe import BANDWIDTH, recipe_gains
from sosml_friction.share import share_directory


def settings_of(node: str) -> dict[str, Any]:
    """Return the shipped parameters of a node."""
    document = yaml.safe_load((share_directory() / 'config' / 'exoskeleton.yaml').read_text())
    return document[f'/**/{node}']['ros__parameters']


def shipped_estimator(robot: Robot, observers: Iterable[str]) -> FrictionEstimator:
    """Return an estimator with these observers, their gains by recipe."""
    settings = settings_of('observer_node')
    conditions = ('position_noise', 'velocity_noise', 'friction_jump', 'reversal_time')
    recipe = recipe_gains(robot, BANDWIDTH, *(settings[name] for name in conditions))
    gains = {name: recipe[name] for name in observers}
    hold = tuple(settings['effort_hold'] * robot.n)
    return ObserverConfiguration(robot.names, gains, hold).make_estimator(robot)
