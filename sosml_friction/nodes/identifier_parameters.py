# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The parameters of identifier_node, those of every trajectory there is among them."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.friction_fit import METHODS
from sosml_friction.motion.trajectories import COMMON, TRAJECTORIES
from sosml_friction.motion.trajectory_option import TrajectoryOption
from sosml_friction.nodes.parameters import ParameterSpec
from sosml_friction.nodes.stated_model import WITHOUT_MODEL

#: Options of the first trajectory have no prefix.
PLAIN = 'speed_ladder'


def _options() -> dict[str, tuple[TrajectoryOption, str]]:
    """Return option and label of each trajectory's options, as ``multisine.amplitude``."""
    options = {
        option.name if kind.name == PLAIN else f'{kind.name}.{option.name}': (option, kind.label)
        for kind in TRAJECTORIES.values()
        for option in kind.options
    }
    return options | {option.name: (option, 'every trajectory') for option in COMMON}


def check_change(name: str, value: Any, joints: Sequence[str]) -> None:
    """
    Check the value of a parameter, as ~/start would.

    :param joints: of the robot; empty where they are not known yet.
    :raises SosmlFrictionError: why it cannot be used.
    """
    spec = next((spec for spec in PARAMETERS if spec.name == name), None)
    if spec is None:
        return
    if spec.choices and value not in spec.choices:
        raise ConfigurationError(f'{name} is {value!r}: use one of {", ".join(spec.choices)}')
    if name in (options := _options()):
        options[name][0].check(value)
    elif spec.type.startswith('double') and not np.isfinite(value).all():
        raise ConfigurationError(f'{name} is {value}: give finite numbers')
    lengths = {'centre': (0, len(joints)), 'acceleration_limit': (0, 1, len(joints))}
    if joints and name in lengths and len(value) not in lengths[name]:
        raise ConfigurationError(
            f'parameter {name} has {len(value)} values for the joints {", ".join(joints)}: give '
            'one for each'
        )


def _option_spec(name: str, option: TrajectoryOption, label: str) -> ParameterSpec:
    value = option.default
    return ParameterSpec(
        name,
        option.type,
        list(value) if isinstance(value, tuple) else value,
        f'{label}: {option.description}',
        option.unit,
        None if option.type == 'double_array' else option.range,
        read_only=False,
    )


PARAMETERS = (
    ParameterSpec(
        'model',
        'string',
        '',
        'nominal model folder, written into the bag; empty: exoskeleton, or with armature the '
        'robot of robot_description',
    ),
    *WITHOUT_MODEL,
    ParameterSpec('output', 'string', 'identification', 'folder that gets a folder for each run'),
    ParameterSpec('run_name', 'string', '', 'name of the run folder; empty: date and time in UTC'),
    ParameterSpec('observer_node', 'string', 'observer_node', 'node whose ~/reset is called'),
    ParameterSpec('driver_node', 'string', 'driver_node', 'node whose ~/stop is called on abort'),
    ParameterSpec(
        'trajectory',
        'string',
        PLAIN,
        'the trajectory that ~/start runs; sosml trajectory draws it; it, its options and what '
        'follows may be changed between runs',
        choices=tuple(TRAJECTORIES),
        read_only=False,
    ),
    *(_option_spec(name, *own) for name, own in _options().items()),
    ParameterSpec(
        'centre',
        'double_array',
        [],
        'about which each joint of the model moves; empty: where the robot is',
        'rad or m',
        read_only=False,
    ),
    ParameterSpec(
        'effort_margin',
        'double',
        0.85,
        'share of the URDF effort limit the rigid body alone may need; friction needs the rest',
        '',
        (0.01, 1.0),
        read_only=False,
    ),
    ParameterSpec(
        'acceleration_limit',
        'double_array',
        [],
        'largest acceleration, one for all joints or one for each; empty: effort alone limits it',
        'rad/s2 or m/s2',
        read_only=False,
    ),
    ParameterSpec(
        'tracking_tolerance',
        'double',
        0.2,
        'the run fails when a joint is farther than this from the trajectory for a second',
        'rad or m',
        (1e-4, 10.0),
        read_only=False,
    ),
    ParameterSpec(
        'method', 'string', 'auto', 'how friction is fitted', choices=METHODS, read_only=False
    ),
    ParameterSpec(
        'diagnose',
        'bool',
        False,
        'after the fit, say what the model (the one before the fit) gets wrong about the '
        'recording, and why, as sosml diagnose does; the sentence is in /diagnostics',
        read_only=False,
    ),
    ParameterSpec(
        'diagnose_without', 'string_array', [], 'effects that the diagnosis does not look for'
    ),
    ParameterSpec(
        'diagnose_trust',
        'string_array',
        [],
        'how far nominal parameters may be off and be no cause, as --trust of sosml diagnose: '
        'GROUP=SHARE, such as friction=inf for a friction that is a guess',
    ),
)
