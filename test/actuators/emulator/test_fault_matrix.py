# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Every fault of the emulator, in idle, holding and moving, judged by what the emulator saw.

The real driver core on the emulator in emulated time. In each cell: within 100 ms no torque on
the plant, or the degraded mode that docs/faults.md promises; the driver's report, which is what
``/diagnostics`` shows, says why; no frame asks for more than the limits; and when the fault is
gone ``enable`` brings the joints back.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass

import numpy as np
import pytest

from sosml_friction.actuators.driver.report import DriverState
from sosml_friction.exceptions import ActuatorError

STATES = ('idle', 'holding', 'moving')
LIMIT_S = 0.1

# What becomes of the torque.
OFF = 'off'  # on no joint any torque within 100 ms, latched
RIDES = 'rides'  # the motion goes on, and what was lost is counted
KEPT = 'kept'  # cannot be noticed: the torque stays what it was


@dataclass(frozen=True)
class Case:
    """
    A fault, what it ends in, and what the report must say of it (a pattern).

    ``idle``: what it says in idle; None where it cannot be known there.
    """

    fault: str
    says: str
    idle: str | None = ''
    holding: str = OFF
    moving: str = OFF

    def outcome(self, state: str) -> str:
        """Return what becomes of the torque; in idle there is none."""
        return {'idle': OFF, 'holding': self.holding, 'moving': self.moving}[state]

    def pattern(self, state: str) -> str | None:
        """Return what the report must say in ``state``, None for nothing."""
        if self.outcome(state) == KEPT:
            return None
        return self.idle if state == 'idle' and self.idle != '' else self.says


CASES = (
    Case('drop joint=shoulder', 'joint shoulder: no answer from 0x241'),
    Case('drop joint=elbow', 'joint elbow: no answer from 0x171'),
    Case('drop fraction=0.1 direction=replies', 'missed [1-9]', '', RIDES, RIDES),
    Case('delay seconds=0.002', 'latency [2-9]', '', RIDES, RIDES),
    Case('delay seconds=0.2', 'no answer from'),
    Case('duplicate', 'stale [1-9]', '', RIDES, RIDES),
    Case('reorder joint=shoulder', 'stale [1-9]', '', RIDES, RIDES),
    Case('bit_errors', 'joint (shoulder|elbow)', '(stale|undecodable|missed) [1-9]'),
    Case('silent joint=shoulder', 'joint shoulder: no answer from 0x241'),
    Case('silent joint=elbow', 'joint elbow: no answer from 0x171'),
    Case('reboot joint=shoulder', 'joint shoulder: no answer from 0x241'),
    Case('reboot joint=elbow', 'joint elbow: no answer from 0x171'),
    Case('power_cycle joint=shoulder turns=1', 'joint shoulder: no answer from 0x241'),
    Case('watchdog joint=shoulder', 'shoulder.*watchdog', 'shoulder timeouts [1-9]'),
    Case('watchdog joint=elbow', 'elbow.*watchdog', None),
    Case('error_bits joint=shoulder bits=0x12', 'shoulder.*stall, over_current'),
    Case('error_bits joint=elbow bits=4', 'elbow.*under_voltage'),
    Case('stuck_encoder joint=shoulder', 'joint shoulder stays', None, KEPT),
    Case('stuck_encoder joint=elbow', 'joint elbow stays', None, KEPT),
    Case('bus_off', 'bus-off'),
    Case('tx_full', 'transmit buffer full'),
    Case('tx_full errno=105', 'transmit buffer full'),
    Case('adapter_gone', 'the CAN bus failed .*No such device'),
)

CELLS = [
    pytest.param(case, state, id=f'{case.fault}-{state}') for case in CASES for state in STATES
]


def bring_into(lockstep, state, trajectory):
    lockstep.driver.configure()
    lockstep.run(0.05)
    if state == 'idle':
        return
    lockstep.driver.enable()
    if state == 'holding':
        lockstep.run(0.05)
        return
    lockstep.driver.follow(trajectory)
    lockstep.run(0.4)
    assert np.abs(lockstep.emulator.v).min() > 0.2
    assert np.abs(lockstep.currents()[-50:]).min() > 0.1


def assert_within_limits(lockstep):
    """No current above its limit or rate, no target outside the joint's limits or too fast."""
    configuration = lockstep.driver.configuration
    shoulder, _ = configuration.joints
    limit = min(shoulder.current_limit, 8.0 / shoulder.torque_constant)
    currents = lockstep.currents()
    assert np.abs(currents).max() <= limit + 0.005
    steps = np.abs(np.diff(currents))
    steps = steps[currents[1:] != 0.0]
    assert steps.max(initial=0.0) <= shoulder.current_rate_limit / configuration.rate + 0.0101
    targets = [
        int.from_bytes(frame.data[2:4], 'little', signed=True) * 0.0002
        for _, frame in lockstep.seen
        if frame.can_id == 0x170 and frame.data[0] == 1
    ]
    assert all(-0.05 <= target <= 2.5 for target in targets)
    commands = {frame.data[0] for _, frame in lockstep.seen if frame.can_id == 0x141}
    assert commands <= {0xA1, 0x92, 0x9A, 0x9C, 0xB1, 0xB2, 0xB5, 0x77, 0x80, 0x81}


def assert_no_torque(lockstep, seconds):
    """For so long: no effort on the plant, and nothing but zero asked for."""
    since = len(lockstep.seen)
    end_ns = lockstep.clock.now_ns() + round(seconds * 1e9)
    while lockstep.clock.now_ns() < end_ns:
        np.testing.assert_allclose(lockstep.emulator.effort, 0.0, atol=1e-3)
        lockstep.step()
    assert not lockstep.currents(since).any()
    assert lockstep.servo_modes(since) <= {0}


def said(lockstep):
    """Return all that the report says, as /diagnostics shows it."""
    report = lockstep.driver.report()
    bus = report.bus
    words = [report.reason, *(joint.problem for joint in report.joints)]
    words += [f'{joint.name} timeouts {joint.timeouts}' for joint in report.joints]
    words += [f'missed {joint.missed}' for joint in report.joints]
    words += [f'latency {1e3 * joint.latency:.1f}' for joint in report.joints]
    words += [f'stale {bus.stale}', f'undecodable {bus.undecodable}']
    return ' | '.join(word for word in words if word)


def recover(lockstep, patience_s):
    """Enable as soon as that is granted; the last refusal if it never is."""
    end_ns = lockstep.clock.now_ns() + round(patience_s * 1e9)
    while lockstep.driver.state is not DriverState.ENABLED:
        try:
            lockstep.driver.enable()
        except ActuatorError:
            if lockstep.clock.now_ns() > end_ns:
                raise
            lockstep.run(0.02)


@pytest.mark.parametrize(('case', 'state'), CELLS)
def test_fault(make_lockstep, there_and_back, case, state):
    lockstep = make_lockstep(seed=1)
    bring_into(lockstep, state, there_and_back)
    driver, emulator = lockstep.driver, lockstep.emulator
    outcome, pattern = case.outcome(state), case.pattern(state)
    held = emulator.effort
    emulator.inject(case.fault)
    end_ns = lockstep.clock.now_ns() + round(LIMIT_S * 1e9)
    while lockstep.clock.now_ns() < end_ns:
        lockstep.step()
    if outcome == OFF:
        assert_no_torque(lockstep, 0.1)
        assert driver.state is (DriverState.DISABLED if state == 'idle' else DriverState.FAULT)
    else:
        assert driver.state is DriverState.ENABLED, said(lockstep)
        if outcome == KEPT:
            # What a frozen angle of a joint at rest may change is friction's share.
            np.testing.assert_allclose(emulator.effort, held, atol=0.3)
        else:
            errors = [joint.tracking_error for joint in driver.report().joints]
            assert np.abs(errors).max() < 0.1
    if pattern is not None:
        assert re.search(pattern, said(lockstep)), said(lockstep)
    # The fault ends: nothing that was held back may move a joint, and only enable brings it back.
    since = len(lockstep.seen)
    emulator.clear()
    lockstep.run(0.05)
    if outcome == OFF:
        assert not lockstep.currents(since).any()
        assert lockstep.servo_modes(since) <= {0}
        assert driver.state is not DriverState.ENABLED
    recover(lockstep, 3.0)
    lockstep.run(0.1)
    assert driver.state is DriverState.ENABLED
    assert driver.report().reason == ''
    np.testing.assert_allclose(lockstep.samples[-1].q, emulator.q, atol=0.02)
    assert_within_limits(lockstep)


@pytest.mark.parametrize('turns', [1, -1])
def test_a_lost_motor_turn_within_the_limits_is_never_enabled(make_lockstep, turns):
    """The fault still stands: 45 degrees off, where only the way since the last answer tells."""
    lockstep = make_lockstep(seed=1)
    bring_into(lockstep, 'holding', None)
    driver, emulator = lockstep.driver, lockstep.emulator
    emulator.inject(f'power_cycle joint=shoulder turns={turns}')
    lockstep.run(1.5)
    since = len(lockstep.seen)
    for _ in range(3):
        lockstep.run(0.1)
        with pytest.raises(ActuatorError):
            driver.enable()
    assert 'came back 0.78' in said(lockstep)
    assert not lockstep.currents(since).any()
    emulator.clear()
    recover(lockstep, 3.0)
    lockstep.run(0.1)
    np.testing.assert_allclose(lockstep.samples[-1].q, emulator.q, atol=0.02)


@pytest.mark.parametrize('lost_turns', ['refuse', 'output'])
def test_a_lost_turn_of_the_output_is_refused_or_corrected_as_configured(
    make_lockstep, lost_turns
):
    lockstep = make_lockstep(seed=1, joint={'shoulder': {'lost_turns': lost_turns}})
    bring_into(lockstep, 'holding', None)
    lockstep.emulator.inject('power_cycle joint=shoulder turns=8')
    lockstep.run(1.5)
    if lost_turns == 'refuse':
        with pytest.raises(ActuatorError, match='outside its limits'):
            lockstep.driver.enable()
        return
    recover(lockstep, 1.0)
    lockstep.run(0.1)
    np.testing.assert_allclose(lockstep.samples[-1].q, lockstep.emulator.q, atol=0.02)


@pytest.mark.parametrize(
    ('fault', 'error'),
    [
        ('', 0.01),
        ('drop fraction=0.1 direction=replies', 0.02),
        ('drop fraction=0.1', 0.2),
        ('delay seconds=0.002', 0.01),
        ('reorder', 0.02),
    ],
)
def test_a_whole_motion_rides_through(make_lockstep, there_and_back, fault, error):
    """
    With the wait as shipped, 6 ms, lost replies do not make the shoulder swing.

    Prints what docs/faults.md says; SOSML_FRICTION_SEEDS for more than one seed. The bound of the
    tracking error is about twice the worst of 6 seeds. Where requests are lost too, an old current
    goes on and then a jump of it follows: that does swing.
    """
    torques, errors, missed = [], [], []
    for seed in range(int(os.environ.get('SOSML_FRICTION_SEEDS', '1'))):
        lockstep = make_lockstep(seed=seed)
        bring_into(lockstep, 'holding', there_and_back)
        driver, emulator = lockstep.driver, lockstep.emulator
        driver.follow(there_and_back)
        if fault:
            emulator.inject(fault)
        torque, off = [], []
        while driver.trajectory_running and driver.state is DriverState.ENABLED:
            lockstep.step()
            torque.append(abs(emulator.effort[0]))
            off.append(abs(driver.report().joints[0].tracking_error))
        assert driver.state is DriverState.ENABLED, said(lockstep)
        torques.append(max(torque))
        errors.append(max(off))
        missed.append(driver.report().incomplete_cycles / driver.report().cycles)
        assert_within_limits(lockstep)
    print(
        f'{fault or "no fault"}: torque up to {min(torques):.2f} .. {max(torques):.2f} Nm, error '
        f'up to {max(errors):.3f} rad, {100 * np.mean(missed):.0f} % of the cycles incomplete'
    )
    assert max(errors) < error
