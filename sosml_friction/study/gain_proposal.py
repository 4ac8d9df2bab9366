# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Gains proposed for a recording, with what they are expected to do."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from sosml_friction.bags.recorded_robot import RecordedRobot
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.identification.bag_analysis import recorded_configuration
from sosml_friction.identification.log_analysis import effort_holds
from sosml_friction.observers.log_conditions import LogConditions, measure_conditions
from sosml_friction.observers.momentum_sampler import EFFORT_HOLDS
from sosml_friction.observers.recipe import gains_for_conditions
from sosml_friction.observers.registry import OBSERVERS, check_observers
from sosml_friction.observers.search_space import Gains
from sosml_friction.study.expected_performance import Expectation, expected_performance

#: What a user may state instead of having it measured.
STATED = ('position_noise', 'velocity_noise', 'friction_jump', 'reversal_time')


@dataclass(frozen=True)
class GainProposal:
    """Hold what was measured or stated, the gains made from it, and what they will do."""

    bag: str
    conditions: LogConditions
    stated: Mapping[str, Mapping[str, float]]
    effort_units: tuple[str, ...]
    gains: Mapping[str, Gains]
    expected: Mapping[str, Expectation]
    effort_hold: tuple[str, ...]

    @property
    def on_line(self) -> tuple[str, ...]:
        """Return those observers that can run in a node."""
        return tuple(name for name in self.gains if OBSERVERS[name].causal)


def parse_stated(name: str, entries: Sequence[str], joints: Sequence[str]) -> dict[str, float]:
    """
    Read ``JOINT=VALUE`` or ``VALUE`` for all joints.

    :raises ConfigurationError: if an entry is neither, or names no joint of the robot.
    """
    option = f'--{name.replace("_", "-")}'
    stated: dict[str, float] = {}
    for entry in entries:
        joint, _, text = entry.rpartition('=')
        try:
            value = float(text)
        except ValueError:
            value = np.nan
        if not 0.0 < value < np.inf:
            raise ConfigurationError(
                f'{option} {entry} has no positive number: write {option} {joints[0]}=VALUE, or '
                'VALUE for all joints'
            )
        if joint and joint not in joints:
            raise ConfigurationError(
                f'{option} {entry} names no joint of this robot: it has {", ".join(joints)}'
            )
        stated.update(dict.fromkeys([joint] if joint else joints, value))
    return stated


def parse_effort_hold(entries: Sequence[str], joints: Sequence[str]) -> dict[str, str]:
    """
    Read ``JOINT=HOLD`` or ``HOLD`` for all joints.

    :raises ConfigurationError: if an entry is neither, or names no joint of the robot.
    """
    stated: dict[str, str] = {}
    for entry in entries:
        joint, _, hold = entry.rpartition('=')
        if hold not in EFFORT_HOLDS or (joint and joint not in joints):
            raise ConfigurationError(
                f'--effort-hold {entry} is not known: write {" or ".join(EFFORT_HOLDS)}, for all '
                f'joints or as JOINT=HOLD for one of {", ".join(joints)}'
            )
        stated.update(dict.fromkeys([joint] if joint else joints, hold))
    return stated


def propose_gains(
    recorded: RecordedRobot,
    name: str,
    stated: Mapping[str, Mapping[str, float]],
    observers: Sequence[str] | None = None,
    effort_hold: Mapping[str, str] | None = None,
) -> GainProposal:
    """
    Measure noise, friction and motion in a recording and make gains from them.

    :param stated: values by quantity (:data:`STATED`) and joint that replace measured ones.
    :param effort_hold: by joint, where in an interval its effort holds; others as in the bag.
    :raises ConfigurationError: if an observer is unknown.
    :raises DataError: if something was neither stated nor can be measured.
    """
    check_observers(observers or ())
    robot = recorded.robot
    ran = recorded_configuration(recorded.bag, name)
    holds = effort_holds(robot.names, effort_hold or {}, ran)
    measured = measure_conditions(recorded.log, robot, holds)
    for quantity, values in stated.items():
        column = getattr(measured, quantity).copy()
        for joint, value in values.items():
            column[robot.names.index(joint)] = value
        measured = replace(measured, **{quantity: column})
    try:
        recipe = gains_for_conditions(measured.conditions(robot))
    except DataError as error:
        options = ', '.join(f'--{quantity.replace("_", "-")}' for quantity in STATED)
        raise DataError(f'{error}: state it as JOINT=VALUE with one of {options}') from error
    gains = {key: recipe[key] for key in (observers or OBSERVERS)}
    # A joint that hardly moved is tried at a speed at which its encoder sees it move.
    slowest = 50.0 * measured.position_noise / np.maximum(measured.reversal_time, 0.1)
    tried = replace(measured, top_speed=np.maximum(measured.top_speed, slowest))
    expected = expected_performance(gains, robot.inertia(measured.posture), tried)
    return GainProposal(name, measured, stated, robot.effort_units, gains, expected, holds)
