# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How an actuator is mounted: what the driver is told and what the emulated hardware is."""

from __future__ import annotations

from sosml_friction.actuators.driver.configuration import DRIVERS
from sosml_friction.nodes.parameters import ParameterSpec

MOUNT_PARAMETERS = (
    ParameterSpec('{joint}.driver', 'string', None, 'the kind of actuator', choices=DRIVERS),
    ParameterSpec(
        '{joint}.direction', 'integer', None, '1 where it turns as the URDF says, or -1'
    ),
    ParameterSpec(
        '{joint}.zero_offset',
        'double',
        None,
        "the joint's position at the actuator's zero",
        unit='rad or m',
    ),
    ParameterSpec(
        '{joint}.torque_constant',
        'double',
        None,
        'effort at the joint per ampere',
        unit='Nm/A or N/A',
    ),
    ParameterSpec('{joint}.can_id', 'integer', 0, 'id of the motor, 1 to 32 (rmd_x: required)'),
    ParameterSpec(
        '{joint}.dbc',
        'string',
        '',
        'DBC of the servo bridge; empty: config/elbow_servo.dbc of the package',
    ),
    ParameterSpec(
        '{joint}.dbc_map',
        'string_array',
        (),
        "the DBC's own names as OURS=THEIRS: servo_state=STATE_1, servo_state.position=Pos",
    ),
)
