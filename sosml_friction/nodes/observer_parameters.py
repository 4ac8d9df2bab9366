# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of observer_node, and the observers that they state."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sosml_friction.bags.bag import Bag
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.robot import Robot
from sosml_friction.nodes.parameters import ParameterSpec
from sosml_friction.nodes.stated_model import WITHOUT_MODEL
from sosml_friction.observers.configuration import ObserverConfiguration, parse_configuration
from sosml_friction.observers.log_conditions import DEFAULT_OBSERVERS
from sosml_friction.observers.momentum_sampler import EFFORT_HOLDS, VELOCITY_SOURCES
from sosml_friction.observers.plausibility import EXCESS
from sosml_friction.observers.recipe import BANDWIDTH, recipe_gains
from sosml_friction.observers.registry import OBSERVERS, on_line_names
from sosml_friction.observers.watched_estimator import LEAST_GAP_S

#: Of parameter ``reliability``.
RELIABILITIES = ('automatic', 'reliable', 'best_effort')

_OPTIONS = (
    ParameterSpec(
        'model',
        'string',
        '',
        'model folder with the armature of the joints; empty: exoskeleton, or with armature the '
        'robot of robot_description',
    ),
    *WITHOUT_MODEL,
    ParameterSpec(
        'urdf_path', 'string', '', 'URDF file; empty: wait for the topic robot_description'
    ),
    ParameterSpec(
        'configuration',
        'string',
        '',
        'bag, or file of its observer_configuration, whose observers and gains are run instead of '
        'those below: for a replay that gives the same numbers',
    ),
    ParameterSpec('observers', 'string_array', list(DEFAULT_OBSERVERS), 'observers to run'),
    ParameterSpec(
        'selected',
        'string',
        'sosml',
        'observer whose output is published as friction_estimate; may be changed at run time',
        read_only=False,
    ),
    ParameterSpec(
        'friction_jump',
        'double_array',
        [],
        'change of friction at a reversal, twice its level, of each joint: gains are made from it '
        'and the three that follow (sosml tune measures them in a bag); empty: from bandwidth',
        'Nm or N',
    ),
    ParameterSpec(
        'reversal_time', 'double_array', [], 'time between reversals of each joint', 's'
    ),
    ParameterSpec(
        'position_noise',
        'double_array',
        [],
        'standard deviation of the position of each joint, resolution / sqrt(12) included',
        'rad or m',
    ),
    ParameterSpec(
        'velocity_noise',
        'double_array',
        [],
        'standard deviation of the velocity of each joint; with bandwidth alone, empty: no '
        'sliding term is added',
        'rad/s or m/s',
    ),
    ParameterSpec(
        'bandwidth',
        'double',
        BANDWIDTH,
        'bandwidth the gains are made for, where neither friction_jump nor they are given',
        'rad/s',
        (0.1, 1e4),
    ),
    ParameterSpec(
        'effort_hold',
        'string_array',
        ['start'],
        'where in an interval an effort sample holds, for all joints or one for each: '
        f'{", ".join(EFFORT_HOLDS)}',
    ),
    ParameterSpec(
        'velocity_source',
        'string',
        'message',
        'velocity of joint_states, or backward difference of its position',
        choices=VELOCITY_SOURCES,
    ),
    ParameterSpec(
        'maximum_gap',
        'double',
        0.0,
        'a longer gap starts the observers afresh; 0: three intervals of the rate that is seen, '
        f'at least {LEAST_GAP_S}',
        's',
        (0.0, 10.0),
    ),
    ParameterSpec(
        'reliability',
        'string',
        'automatic',
        'of the subscription to joint_states; automatic: reliable, unless every publisher found '
        'is best_effort',
        choices=RELIABILITIES,
    ),
    ParameterSpec(
        'limit_excess',
        'double',
        EXCESS,
        'an effort or velocity beyond so many times its limit in the URDF is no measurement',
        range=(1.0, 1e6),
    ),
    ParameterSpec(
        'passive_joints',
        'string_array',
        [],
        'joints without an actuator: their effort is truly 0.0',
    ),
)


def parameters() -> tuple[ParameterSpec, ...]:
    """Return the table with the gains of every observer that there is by now."""
    gains = (
        ParameterSpec(
            f'{name}.{gain}',
            'double_array',
            [],
            f'gain of observer {name}, one for each joint; empty: by recipe; may be changed at '
            'run time',
            unit,
            read_only=False,
        )
        for name in on_line_names()
        for gain, unit in OBSERVERS[name].gain_units.items()
    )
    return (*_OPTIONS, *gains)


def configuration_of(p: Mapping[str, Any], robot: Robot) -> ObserverConfiguration:
    """
    Return the observers and gains that parameters ``p`` state for a robot.

    :raises ConfigurationError: if one does not fit the robot, or gains are lacking.
    """
    if p['configuration']:
        return _recorded(Path(p['configuration']))
    recipe = recipe_gains(
        robot,
        p['bandwidth'],
        p['position_noise'],
        p['velocity_noise'],
        p['friction_jump'],
        p['reversal_time'],
    )
    gains: dict[str, dict[str, Sequence[float]]] = {}
    for name in p['observers']:
        given = {
            gain: p[f'{name}.{gain}'] for gain in OBSERVERS[name].gain_units if p[f'{name}.{gain}']
        }
        missing = [gain for gain in OBSERVERS[name].gain_units if gain not in given]
        if missing and name not in recipe:
            lacking = ', '.join(f'{name}.{gain}' for gain in missing)
            raise ConfigurationError(
                f'observer {name} has no gains by bandwidth: set the parameters '
                'friction_jump, reversal_time, position_noise and velocity_noise (sosml tune '
                f'measures them in a bag), or {lacking}'
            )
        gains[name] = {**recipe.get(name, {}), **given}
    holds = p['effort_hold']
    return ObserverConfiguration(
        robot.names,
        gains,
        tuple(holds * robot.n if len(holds) == 1 else holds),
        p['velocity_source'],
        p['maximum_gap'] or LEAST_GAP_S,
    )


def _recorded(source: Path) -> ObserverConfiguration:
    if source.suffix == '.yaml' and source.is_file():
        text: str | None = source.read_text(encoding='utf-8')
    else:
        text = Bag.open(source).text('observer_configuration')
    if text is None:
        raise ConfigurationError(
            f'bag {source} (parameter configuration) has no observer_configuration: give the '
            'gains by the other parameters'
        )
    return parse_configuration(text, f'the observer_configuration of {source}')
