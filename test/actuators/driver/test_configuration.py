# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The driver's configuration: nothing physical is assumed, and each lack is one sentence."""

from __future__ import annotations

from dataclasses import replace

import pytest
from lockstep import Lockstep, emulated_exoskeleton

from sosml_friction.actuators.driver.configuration import (
    DriverConfiguration,
    joints_from_parameters,
    read_parameters,
)
from sosml_friction.actuators.driver.driver import JointDriver
from sosml_friction.actuators.emulator.emulator import ExoskeletonEmulator
from sosml_friction.actuators.emulator.options import EmulatorOptions
from sosml_friction.actuators.parameter import parameters_of
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.model_folder import read_model
from sosml_friction.share import share_directory

CONFIG = share_directory() / 'config'


@pytest.fixture
def values():
    return read_parameters(CONFIG / 'exoskeleton.yaml', 'driver_node')


def build(values):
    return DriverConfiguration.from_parameters(values)


def test_the_shipped_file_configures_driver_and_emulator_alike(values):
    configuration = build(values)
    emulated = joints_from_parameters(
        read_parameters(CONFIG / 'exoskeleton.yaml', 'emulator_node')
    )
    for ours, theirs in zip(configuration.joints, emulated, strict=True):
        assert type(ours) is type(theirs)
        mounted = [key for key, (_, said) in parameters_of(theirs).items() if said.mount]
        assert len(mounted) >= 4
        for key in mounted:
            assert getattr(ours, key) == getattr(theirs, key)


@pytest.mark.parametrize(
    'key',
    [
        'joints',
        'shoulder.driver',
        'shoulder.can_id',
        'shoulder.torque_constant',
        'shoulder.current_limit',
        'shoulder.current_rate_limit',
        'shoulder.direction',
        'shoulder.zero_offset',
        'shoulder.kp',
        'shoulder.kd',
        'elbow.driver',
        'elbow.torque_constant',
        'elbow.direction',
        'elbow.zero_offset',
    ],
)
def test_nothing_physical_has_a_silent_default(values, key):
    del values[key]
    with pytest.raises(ConfigurationError, match=key):
        build(values)


@pytest.mark.parametrize(
    ('key', 'value'),
    [
        ('shoulder.driver', 'dynamixel'),
        ('shoulder.direction', 0),
        ('shoulder.can_id', 33),
        ('shoulder.torque_constant', -1.0),
        ('shoulder.torque_constant', float('nan')),
        ('shoulder.current_limit', 0.0),
        ('shoulder.kd', -1.0),
        ('elbow.temperature_limit', float('inf')),
        # A single wait would be longer than an actuator may be silent.
        ('reply_timeout', 0.1),
        ('shoulder.mode', 'fast'),
        ('elbow.mode', 'speed'),
        ('shoulder.lost_turns', 'some'),
        ('shoulder.at_end', 'run'),
        ('shoulder.motor_watchdog_ms', -1),
        ('shoulder.counts_per_turn', -1),
        ('shoulder.tracking_limit', 0.0),
        ('host_timeout', 0.0),
        ('joints', []),
        # As a YAML file may say it that was read without ROS.
        ('joints', 'shoulder'),
        ('rate', 'fast'),
        ('missed_limit', [3]),
        ('shoulder.can_id', '1'),
        ('shoulder.can_id', True),
        ('shoulder.kp', 'abc'),
        ('shoulder.brake', 1),
        ('elbow.dbc_map', 'a=b'),
        ('joints', ['shoulder', 'shoulder']),
        ('rate', 0.0),
    ],
)
def test_a_value_that_does_not_fit_is_refused_by_name(values, key, value):
    values[key] = value
    with pytest.raises(ConfigurationError) as caught:
        build(values)
    assert key.split('.')[-1] in str(caught.value)


@pytest.mark.parametrize(
    ('key', 'value', 'needs'),
    [('mode', 'speed', 'position_gain'), ('lost_turns', 'motor', 'gear_ratio')],
)
def test_what_a_choice_needs_must_be_given(values, key, value, needs):
    values[f'shoulder.{key}'] = value
    with pytest.raises(ConfigurationError, match=f'shoulder.{needs} is nan'):
        build(values)
    values[f'shoulder.{needs}'] = 8.0
    assert getattr(build(values).joints[0], needs) == 8.0


def test_gains_are_needed_only_by_the_loop_on_the_host(values):
    del values['shoulder.kp'], values['shoulder.kd']
    values['shoulder.mode'] = 'position'
    assert build(values).joints[0].mode == 'position'


def test_two_motors_with_one_id_are_refused(values):
    values.update({f'elbow.{key}': values[f'shoulder.{key}'] for key in (
        'driver', 'can_id', 'current_limit', 'current_rate_limit', 'kp', 'kd'
    )})  # fmt: skip
    configuration = build(values)
    robot = read_model(CONFIG / 'exoskeleton').make_robot()
    with pytest.raises(ConfigurationError, match='shoulder and elbow both answer from 0x241'):
        JointDriver(configuration, robot, bus=None, clock=None)
    with pytest.raises(ConfigurationError, match='listen to one identifier'):
        emulated_exoskeleton(configuration=configuration)


def test_joints_that_differ_from_the_models_are_refused(values):
    robot = read_model(CONFIG / 'exoskeleton').make_robot()
    configuration = build(values)
    swapped = replace(configuration, joints=configuration.joints[::-1])
    with pytest.raises(ConfigurationError, match='same order'):
        JointDriver(swapped, robot, bus=None, clock=None)
    with pytest.raises(ConfigurationError, match='start position'):
        ExoskeletonEmulator(
            read_model(CONFIG / 'emulated_exoskeleton'), configuration.joints, (0.0,)
        )


def test_an_elbow_with_an_rmd_x_works_as_well(values):
    """``driver: rmd_x`` at both joints: the swap the design promises."""
    values.update({f'elbow.{key}': values[f'shoulder.{key}'] for key in (
        'driver', 'current_limit', 'current_rate_limit', 'torque_constant'
    )})  # fmt: skip
    values.update({'elbow.can_id': 2, 'elbow.kp': 40.0, 'elbow.kd': 1.0, 'rate': 400.0})
    configuration = build(values)
    options = EmulatorOptions(rmd_current_noise=0.0)
    emulator = emulated_exoskeleton(options=options, configuration=configuration)
    with Lockstep(emulator, configuration) as lockstep:
        lockstep.driver.configure()
        lockstep.run(0.1)
        lockstep.driver.enable()
        lockstep.run(0.5)
        assert lockstep.driver.report().reason == ''
        assert abs(emulator.q[1]) < 0.01


@pytest.mark.parametrize('text', [None, 'a: [', 'other_node: {ros__parameters: {a: 1}}', '[1]'])
def test_a_parameter_file_that_says_nothing_is_refused(tmp_path, text):
    file = tmp_path / 'p.yaml'
    if text is not None:
        file.write_text(text)
    with pytest.raises(ConfigurationError, match=r'p\.yaml'):
        read_parameters(file, 'driver_node')


def test_parameters_for_all_nodes_count_and_a_nodes_own_come_first(tmp_path):
    file = tmp_path / 'p.yaml'
    file.write_text(
        '/**: {ros__parameters: {a: 1, b: 2}}\ndriver_node: {ros__parameters: {b: 3, j: {c: 4}}}\n'
    )
    assert read_parameters(file, 'driver_node') == {'a': 1, 'b': 3, 'j.c': 4}
