# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
What every type of actuator promises, those of the package and one from outside it.

The real driver on the emulator in emulated time: one joint has the type under test, the other the
shipped servo or motor. ``bench_drive`` is defined in the tests alone: its class is all there is.
"""

from __future__ import annotations

import importlib.util
import math
import re
import sys
from dataclasses import fields, replace

import numpy as np
import pytest
from emulated_clock import EmulatedClock
from lockstep import Lockstep, emulated_exoskeleton

from sosml_friction import actuators
from sosml_friction.actuators.actuator import Actuator
from sosml_friction.actuators.bus.inquiry import Inquiry
from sosml_friction.actuators.driver.configuration import DriverConfiguration, read_parameters
from sosml_friction.actuators.driver.driven_joint import DOUBTFUL_CYCLES
from sosml_friction.actuators.driver.report import DriverState
from sosml_friction.actuators.emulator.options import EmulatorOptions
from sosml_friction.actuators.joint_configuration import JointConfiguration
from sosml_friction.actuators.measurement import Setpoint
from sosml_friction.actuators.parameter import parameters_of
from sosml_friction.exceptions import ActuatorError, CanProtocolError, ConfigurationError
from sosml_friction.model.robot import JointLimits
from sosml_friction.share import share_directory

# The joint that has the type, and its parameters where they are not the shipped ones.
SAMPLES = {
    'rmd_x': ('shoulder', {}),
    'servo_dbc': ('elbow', {}),
    'bench_drive': (
        'shoulder',
        {'node': 3, 'direction': -1, 'zero_offset': 0.2, 'torque_constant': 1.25},
    ),
}
LIMIT_S = 0.1
LIMITS = JointLimits(-2.0, 2.0, 3.0, 8.0)


def parameters(driver):
    """Return the driver's parameters with the type's joint in the place of the shipped one."""
    values = read_parameters(share_directory() / 'config' / 'exoskeleton.yaml', 'driver_node')
    joint, own = SAMPLES[driver]
    if not own:
        return values
    values = {key: value for key, value in values.items() if not key.startswith(f'{joint}.')}
    return values | {f'{joint}.driver': driver} | {f'{joint}.{k}': v for k, v in own.items()}


@pytest.fixture(autouse=True)
def outside(monkeypatch):
    """Define the type from outside anew, and forget it after the test."""
    monkeypatch.setattr(Actuator.registry, 'known', dict(Actuator.registry))
    spec = importlib.util.find_spec('bench_drive')
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, 'bench_drive', module)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(params=sorted(SAMPLES))
def driver_name(request):
    return request.param


@pytest.fixture
def bench(driver_name):
    """Return a lockstep that is configured and has run, and the joint's number."""
    configuration = DriverConfiguration.from_parameters(parameters(driver_name))
    with Lockstep(emulated_exoskeleton(1, configuration=configuration), configuration) as lockstep:
        lockstep.driver.configure()
        lockstep.run(0.06)
        yield lockstep, configuration.names.index(SAMPLES[driver_name][0])


@pytest.fixture
def own(driver_name):
    """Return an actuator of the type by itself."""
    configuration = DriverConfiguration.from_parameters(parameters(driver_name))
    joint = next(j for j in configuration.joints if j.name == SAMPLES[driver_name][0])
    return Actuator.kind(driver_name)(joint, LIMITS, 500.0, margin=0.1, stop_deceleration=5.0)


def test_every_type_there_is_has_its_sample_here():
    """A new type in the package is held to these promises, or this test says so."""
    assert set(Actuator.registry) == set(SAMPLES)


# ---- what its class says


def test_a_type_is_known_by_its_class_alone(driver_name):
    kind = Actuator.kind(driver_name)
    assert kind.configuration_type.driver == driver_name
    assert issubclass(kind.configuration_type, JointConfiguration)
    for key, (_, said) in parameters_of(kind.emulated_type.options_type).items():
        assert EmulatorOptions.parameters()[key][1] == said
    described = parameters_of(kind.configuration_type)
    assert {own.name for own in fields(kind.configuration_type)} == {'name', *described}
    assert all(said.description for _, said in described.values())


def test_an_unknown_driver_is_an_error_that_names_what_exists():
    values = parameters('rmd_x') | {'shoulder.driver': 'dynamixel'}
    with pytest.raises(ConfigurationError) as caught:
        DriverConfiguration.from_parameters(values)
    assert str(caught.value) == (
        "shoulder.driver is 'dynamixel': use one of bench_drive, rmd_x, servo_dbc"
    )


def test_a_parameter_of_another_type_is_an_error_that_names_what_exists(driver_name):
    joint = SAMPLES[driver_name][0]
    values = parameters(driver_name) | {f'{joint}.ticks': 5}
    with pytest.raises(ConfigurationError, match=f'ticks is no parameter of driver {driver_name}'):
        DriverConfiguration.from_parameters(values)
    with pytest.raises(ConfigurationError, match=r'no option ticks: use one of .*latency'):
        EmulatorOptions(ticks=5)


def test_two_types_cannot_have_one_name(outside):
    own = {'configuration_type': outside.BenchConfiguration}
    with pytest.raises(ConfigurationError, match="two drivers of the name 'bench_drive'"):
        type('Other', (outside.BenchActuator,), own)
    assert Actuator.kind('bench_drive') is outside.BenchActuator


def test_a_class_that_does_not_say_what_it_must_is_refused(outside):
    def all_of(base):
        return {name: lambda *_: None for name in base.__abstractmethods__}

    with pytest.raises(TypeError, match='does not state its configuration_type'):
        type('Half', (Actuator,), all_of(Actuator) | {'emulated_type': outside.EmulatedBench})
    with pytest.raises(TypeError, match='does not state its emulated_type'):
        type(
            'Half',
            (Actuator,),
            all_of(Actuator) | {'configuration_type': outside.BenchConfiguration},
        )


def test_a_file_in_the_folder_is_found_without_being_named(tmp_path, monkeypatch):
    """As the package's own folder is searched: one more place on its path, one file there."""
    text = (
        'from dataclasses import dataclass\n'
        'from bench_drive import BenchActuator, BenchConfiguration\n\n\n'
        '@dataclass(frozen=True)\n'
        'class OneFileConfiguration(BenchConfiguration):\n'
        "    driver = 'one_file'\n\n\n"
        'class OneFileActuator(BenchActuator):\n'
        '    configuration_type = OneFileConfiguration\n'
    )
    (tmp_path / 'one_file.py').write_text(text)
    monkeypatch.setattr(actuators, '__path__', [*actuators.__path__, str(tmp_path)])
    monkeypatch.setattr(Actuator.registry, '_loaded', False)
    assert Actuator.kind('one_file').__module__ == 'sosml_friction.actuators.one_file'


@pytest.mark.parametrize('value', [math.nan, math.inf, 'x', True])
@pytest.mark.parametrize(
    'key', ['zero_offset', 'torque_constant', 'temperature_limit', 'tracking_limit']
)
def test_no_type_takes_a_number_that_is_none(own, key, value):
    with pytest.raises(ConfigurationError, match=key):
        replace(own.configuration, **{key: value})


# ---- its frames


def test_what_is_not_finite_is_never_commanded(own):
    nothing = Setpoint(math.nan, math.nan, math.nan)
    with pytest.raises(CanProtocolError, match='not finite'):
        own.command(nothing, 0)


def test_its_requests_bring_the_replies_they_wait_for(own, driver_name):
    """Key by key, from an emulated one: release, command, observe, probe, the last word."""
    kind = Actuator.kind(driver_name).emulated_type
    options = EmulatorOptions().of(kind)
    emulated = kind(own.configuration, options, np.random.SeedSequence(0))
    assert emulated.request_id in own.request_ids
    own.configuration.check_drive()
    setpoint = Setpoint(1.0, 0.1, 0.0)
    driven = own.command(setpoint, 1)
    for requests in (own.probe(), own.release(0), driven, own.observe(2), own.shut_down()):
        assert requests
        for request in requests:
            reply = emulated.take(request.frame, 1_000_000, 0.1, 0.0)
            assert reply.can_id == own.reply_id
            assert own.key(reply) == request.key
            own.accept(reply, 1_000_000)
    assert own.measurement.q == pytest.approx(0.1, abs=1e-3)
    assert own.measurement.stamp_ns == 1_000_000
    assert emulated.commanded_current == 0.0
    assert len(own.release(3)) <= own.frames_per_cycle


def test_to_let_go_or_to_observe_is_no_command(own, driver_name):
    kind = Actuator.kind(driver_name).emulated_type
    emulated = kind(own.configuration, EmulatorOptions().of(kind), np.random.SeedSequence(0))
    t_ns = 0

    def exchange(requests):
        nonlocal t_ns
        for request in requests:
            reply = emulated.take(request.frame, t_ns, 0.1, 0.0)
            own.accept(reply, t_ns)
        for _ in range(10):
            t_ns += 250_000
            emulated.run(t_ns, 0.1, 0.0)

    exchange(own.release(t_ns))
    for _ in range(20):
        exchange(own.command(Setpoint(4.0, 0.2, 0.0), t_ns))
    driven = emulated.commanded_current
    assert abs(driven) > 1.0
    assert math.copysign(1.0, driven) == own.configuration.direction
    exchange(own.observe(t_ns))
    assert emulated.commanded_current == pytest.approx(driven, rel=0.05)
    exchange(own.release(t_ns))
    assert emulated.commanded_current == 0.0


def test_a_scan_of_an_empty_bus_finds_nobody(driver_name):
    class Empty:
        def send(self, message):
            pass

        def recv(self, timeout):
            clock.sleep_until_ns(clock.now_ns() + round(timeout * 1e9) + 1)

    clock = EmulatedClock()
    assert Actuator.kind(driver_name).scan(Inquiry(Empty(), clock, [1, 2])) == []


# ---- driven


def test_enabled_it_holds_and_moves_as_it_is_told(bench, there_and_back):
    lockstep, i = bench
    driver, emulator = lockstep.driver, lockstep.emulator
    before = emulator.q
    lockstep.run(0.1)
    assert not emulator.effort.any()
    driver.enable()
    lockstep.run(0.2)
    np.testing.assert_allclose(emulator.q, before, atol=1e-3)
    driver.follow(there_and_back)
    lockstep.run(1.0)
    assert driver.state is DriverState.ENABLED, driver.report().reason
    assert emulator.q[i] - before[i] == pytest.approx((0.5, 0.8)[i], abs=0.04)
    np.testing.assert_allclose(lockstep.samples[-1].q, emulator.q, atol=5e-3)
    np.testing.assert_allclose(lockstep.samples[-1].tau, emulator.effort, atol=0.15)
    lockstep.run(1.3)
    assert emulator.q[i] == pytest.approx(before[i], abs=0.04)


@pytest.mark.parametrize(
    ('fault', 'says'),
    [
        ('drop joint={joint}', 'no answer from'),
        ('delay seconds=0.2', 'no answer from'),
        ('silent joint={joint}', 'joint {joint}: no answer from'),
        ('reboot joint={joint}', 'joint {joint}: no answer from'),
        ('watchdog joint={joint}', 'joint {joint}.*watchdog'),
        ('error_bits joint={joint} bits=4', 'joint {joint}.*reports'),
        ('stuck_encoder joint={joint}', 'joint {joint} stays at'),
        ('bus_off', 'bus-off'),
        ('tx_full', 'transmit buffer full'),
        ('adapter_gone', 'No such device'),
    ],
)
def test_every_fault_in_motion_ends_without_torque_and_comes_back(
    bench, there_and_back, driver_name, fault, says
):
    lockstep, i = bench
    joint = SAMPLES[driver_name][0]
    driver, emulator = lockstep.driver, lockstep.emulator
    driver.enable()
    driver.follow(there_and_back)
    lockstep.run(0.4)
    assert abs(emulator.v[i]) > 0.2
    assert abs(emulator.effort[i]) > 0.1
    emulator.inject(fault.format(joint=joint))
    lockstep.run(LIMIT_S)
    for _ in range(50):
        lockstep.step()
        np.testing.assert_allclose(emulator.effort, 0.0, atol=1e-3)
    report = driver.report()
    assert report.state is DriverState.FAULT
    assert re.search(says.format(joint=joint), report.reason), report.reason
    emulator.clear()
    lockstep.run(0.05)
    np.testing.assert_allclose(emulator.effort, 0.0, atol=1e-3)
    end_ns = lockstep.clock.now_ns() + 3_000_000_000
    while driver.state is not DriverState.ENABLED:
        try:
            driver.enable()
        except ActuatorError:
            assert lockstep.clock.now_ns() < end_ns
            lockstep.run(0.02)
    lockstep.run(0.1)
    assert driver.report().reason == ''


def test_no_more_effort_is_given_than_the_joint_may_have(bench):
    """A blow of 1.5 rad/s, which asks for more than there is: the URDF's effort is the most."""
    lockstep, i = bench
    driver, emulator = lockstep.driver, lockstep.emulator
    limit = driver._actuators[i].limits.effort
    driver.enable()
    for sign in (1.0, -1.0):
        lockstep.run(0.5)
        emulator.plant.v[i] += sign * 1.5
        efforts = []
        for _ in range(30):
            lockstep.step()
            efforts.append(emulator.effort[i])
        assert np.abs(efforts).max() <= limit + 0.02
        assert np.abs(efforts).max() > 0.9 * limit, driver.report().reason
        # Back to where it was: the effort acts against the blow.
        assert sign * efforts[np.argmax(np.abs(efforts))] < 0.0


# ---- a measurement that cannot be true, whatever the type


def lie(lockstep, i, **changes):
    """Let the joint's actuator measure what it does not; a function is given the number."""
    own = lockstep.driver._actuators[i]
    accept, count = own.accept, [0]

    def accept_and_lie(frame, stamp_ns):
        before = own.measurement.stamp_ns
        accept(frame, stamp_ns)
        count[0] += own.measurement.stamp_ns != before
        for key, value in changes.items():
            said = value(count[0], own.measurement) if callable(value) else value
            setattr(own.measurement, key, said)

    own.accept = accept_and_lie


@pytest.mark.parametrize(
    ('changes', 'says'),
    [
        ({'current': 40.0}, 'reports 40.00 A where its limit is'),
        ({'current': -40.0}, 'reports -40.00 A where its limit is'),
        ({'speed': 2.0}, 'reports 2.00 per second, its position says'),
        ({'temperature': -273.0}, 'reports -273 degC, below -40'),
        ({'temperature': 76.0}, '76 degC is above 75'),
        ({'q': lambda n, m: m.q if n % 2 else -1.5}, 'is at|jumps by|moves at'),
        ({'q': math.nan}, 'is at nan'),
    ],
)
def test_what_cannot_be_true_is_a_fault_of_every_type(bench, changes, says):
    lockstep, i = bench
    driver = lockstep.driver
    driver.enable()
    lockstep.run(0.05)
    lie(lockstep, i, **changes)
    lockstep.run((DOUBTFUL_CYCLES + 5) / 500.0)
    report = driver.report()
    assert report.state is DriverState.FAULT
    assert re.search(says, report.reason), report.reason
    lockstep.run(0.02)
    np.testing.assert_allclose(lockstep.emulator.effort, 0.0, atol=1e-3)
