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

from sosml_friction.nodes.demo import PATIENT_DRIVER, PATIENT_HARDWARE

HANGING = np.array([-np.pi / 2, 0.0])
# The answer that is missing is told before the status that is, five of which take half a second.
DRIVER = (*PATIENT_DRIVER, 'missed_limit:=200')
UP = HANGING + np.array([0.5, 0.8])


class Session(CanChain):
    """Driver and emulator that stay up through faults."""

    def start(self):
        """Start both and wait until the driver measures; return the driver's process."""
        self.start_emulator(*PATIENT_HARDWARE)
        driver = self.start_driver(*DRIVER)
        self.ros.spin_until(lambda: self.value('driver_node: driver', 'state') == 'disabled')
        return driver

    def current(self, joint: str) -> float:
        return float(self.fresh(f'emulator_node: {joint}')['commanded current [A]'])

    def enable(self) -> None:
        request = SetBool.Request(data=True)
        self.ros.spin_until(lambda: self.ros.call(SetBool, 'driver_node/enable', request).success)

    def comes_back(self) -> bool:
        """Enable it, and tell whether it is without a fault then."""
        self.enable()
        return self.fresh('driver_node: driver')['fault'] == ''

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

    def fault(self, text: str) -> str:
        """Let a fault happen to the moving arm, see it end in no torque, and return its reason."""
        self.enable()
        self.go_up()
        assert self.set_faults(text).successful
        self.ros.spin_until(lambda: self.value('driver_node: driver', 'state') == 'fault')
        reason, values = self.diagnostics['driver_node: driver']
        assert values['fault'] in reason
        self.ros.spin_until(
            lambda: self.current('shoulder') == 0.0 and self.current('elbow') == 0.0
        )
        assert self.value('emulator_node: plant', 'faults').startswith(text)
        assert self.set_faults('').successful
        return values['fault']


@pytest.fixture
def session(ros, start_node):
    return Session(ros, start_node)


def test_faults_over_the_wire_end_in_no_torque_with_their_reason_and_are_cleared(session):
    """A few cells of the matrix, on real processes, bytes and messages."""
    driver = session.start()
    refused = session.set_faults('silence joint=shoulder')
    assert not refused.successful
    assert "there is no fault 'silence'" in refused.reason
    for fault, reason in (
        ('error_bits joint=elbow bits=4', 'under_voltage'),
        ('silent joint=shoulder', 'no answer from 0x241'),
        ('adapter_gone', 'bus'),
    ):
        texts = []
        # A process that stood still for half a second on a busy machine is a fault as well, and
        # may come first: then once more.
        while not any(reason in text for text in texts) and len(texts) < 4:
            texts.append(session.fault(fault))
        assert reason in texts[-1], fault
    session.ros.spin_until(session.comes_back)
    assert driver.stop(signal.SIGTERM) == 0
    assert 'Traceback' not in driver.output


def test_kill_nine_while_moving_is_ended_by_the_actuators_own_watchdogs(session):
    """Nobody sends zero any more: 0xB3 is what is left (without it: sosml can check warns)."""
    driver = session.start()
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
