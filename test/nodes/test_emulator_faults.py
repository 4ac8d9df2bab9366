# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Faults over slcan bytes and DDS: what /diagnostics says, and what reaches the motors."""

from __future__ import annotations

import signal

import numpy as np
import pytest

pytest.importorskip('rclpy')

from builtin_interfaces.msg import Duration
from can_chain import CanChain
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

HANGING = np.array([-np.pi / 2, 0.0])
# A busy machine may stop a process for longer than a real joint may go without a command.
PATIENT = ('comm_timeout:=0.5', 'servo_watchdog:=0.5')
UP = HANGING + np.array([0.5, 0.8])


class Session(CanChain):
    """Driver and emulator that stay up through faults."""

    def start(self, *hardware: str):
        """Start both and wait until the driver measures; return the driver's process."""
        self.start_emulator(*hardware)
        driver = self.start_driver('missed_limit:=250', 'reply_timeout:=0.02')
        self.ros.spin_until(lambda: self.value('driver_node: driver', 'state') == 'disabled')
        return driver

    def current(self, joint: str) -> float:
        return float(self.fresh(f'emulator_node: {joint}')['commanded current [A]'])

    def enable(self) -> None:
        request = SetBool.Request(data=True)
        self.ros.spin_until(lambda: self.ros.call(SetBool, 'driver_node/enable', request).success)

    def go_up(self) -> None:
        """Let both joints move up, where holding takes current: they are on the way, or there."""
        self.ros.spin_until(lambda: self.trajectories.get_subscription_count() > 0)
        message = JointTrajectory(joint_names=['shoulder', 'elbow'])
        message.points.append(
            JointTrajectoryPoint(
                positions=[float(x) for x in UP],
                velocities=[0.0, 0.0],
                time_from_start=Duration(sec=2),
            )
        )
        self.trajectories.publish(message)

        def up() -> bool:
            # Told once a second: on a busy machine the two seconds of motion may be missed.
            shoulder = self.fresh('emulator_node: shoulder')
            there = abs(float(shoulder['true position']) - float(UP[0])) < 0.05
            if there or abs(float(shoulder['true velocity'])) > 0.05:
                return True
            # A machine that stood still is a fault of its own, and no part of this test.
            if self.value('driver_node: driver', 'state') in ('fault', 'disabled'):
                self.enable()
            self.trajectories.publish(message)
            return False

        self.ros.spin_until(up)

    def set_faults(self, text: str):
        value = ParameterValue(type=ParameterType.PARAMETER_STRING, string_value=text)
        request = SetParameters.Request(parameters=[Parameter(name='faults', value=value)])
        (result,) = self.ros.call(SetParameters, 'emulator_node/set_parameters', request).results
        return result


@pytest.fixture
def session(ros, start_node):
    return Session(ros, start_node)


def test_faults_over_the_wire_end_in_no_torque_with_their_reason_and_are_cleared(session):
    """A few cells of the matrix, on real processes, bytes and messages."""
    driver = session.start(*PATIENT)
    refused = session.set_faults('silence joint=shoulder')
    assert not refused.successful
    assert "there is no fault 'silence'" in refused.reason
    for fault, reason in (
        ('error_bits joint=elbow bits=4', 'under_voltage'),
        ('silent joint=shoulder', 'no answer from 0x241'),
        ('adapter_gone', 'bus'),
    ):
        session.enable()
        session.go_up()
        assert session.set_faults(fault).successful
        session.ros.spin_until(lambda: session.value('driver_node: driver', 'state') == 'fault')
        text, values = session.diagnostics['driver_node: driver']
        assert reason in text, fault
        assert reason in values['fault']
        session.ros.spin_until(
            lambda: session.current('shoulder') == 0.0 and session.current('elbow') == 0.0
        )
        assert session.value('emulator_node: plant', 'faults').startswith(fault)
        assert session.set_faults('').successful
    session.enable()
    assert session.fresh('driver_node: driver')['fault'] == ''
    assert driver.stop(signal.SIGTERM) == 0
    assert 'Traceback' not in driver.output


def test_kill_nine_while_moving_is_ended_by_the_actuators_own_watchdogs(session):
    """Nobody sends zero any more: 0xB3 is what is left (without it: sosml can check warns)."""
    driver = session.start(*PATIENT)
    session.enable()
    session.go_up()
    driver.process.kill()
    assert driver.process.wait() == -signal.SIGKILL
    for joint in ('shoulder', 'elbow'):
        session.ros.spin_until(
            lambda name=f'emulator_node: {joint}': session.fresh(name)['watchdog trips'] == '1'
        )
        assert session.current(joint) == 0.0
    assert session.fresh('emulator_node: shoulder')['shutdowns'] == '0'
