# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Driver and observer in one process: every sample observed, and no message between the two."""

from __future__ import annotations

import signal

import numpy as np
import pytest

pytest.importorskip('rclpy')

from can_chain import PARAMETER_FILE, CanChain
from lockstep import nominal_robot
from sensor_msgs.msg import JointState
from shipped_observers import shipped_estimator
from std_srvs.srv import SetBool, Trigger

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.nodes.demo import PATIENT_DRIVER, PATIENT_HARDWARE
from sosml_friction.nodes.qos import JOINT_STATES

PATIENT = [f'driver_node:{parameter}' for parameter in PATIENT_DRIVER]


def stamps(messages: list[JointState]) -> list[int]:
    return [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in messages]


def test_each_sample_gets_its_estimate_in_the_process_of_the_driver(ros, start_node):
    chain = CanChain(ros, start_node)
    states = ros.collect(JointState, 'joint_states', JOINT_STATES)
    estimates = ros.collect(JointState, 'friction_estimate', JOINT_STATES)
    chain.start_emulator(*PATIENT_HARDWARE)
    channel = f'driver_node:can_channel:=socket://127.0.0.1:{chain.port}'
    timeout = 'driver_node:host_timeout:=10.0'
    node = start_node('exoskeleton_node', channel, timeout, *PATIENT, files=(PARAMETER_FILE,))
    ros.spin_until(lambda: len(estimates) > 300)

    # No topic goes in: the observer hears nothing, the driver only commands.
    ros.discover('observer_node')
    heard = ros.node.get_subscriber_names_and_types_by_node('observer_node', '/')
    assert 'joint_states' not in ''.join(name for name, _ in heard)
    assert ros.node.count_publishers('joint_states') == 1

    # The numbers are those of the same samples in a batch, from a fresh start on.
    assert ros.call(Trigger, 'observer_node/reset').success
    before = len(estimates)
    ros.spin_until(lambda: len(estimates) > before + 300)
    live = np.array([m.effort for m in estimates])
    fresh = int(np.flatnonzero(np.isnan(live).all(axis=1))[-1])
    assert fresh > 0
    live, wanted = live[fresh:], stamps(estimates)[fresh : len(live)]
    taken = dict(zip(stamps(states), states, strict=True))
    samples = [taken[stamp] for stamp in wanted]
    log = JointLog(
        names=tuple(samples[0].name),
        t_ns=np.array(wanted, dtype=np.int64),
        q=np.array([m.position for m in samples]),
        v=np.array([m.velocity for m in samples]),
        tau=np.array([m.effort for m in samples]),
    )
    batch = shipped_estimator(nominal_robot(), ['sosml']).batch(log)['sosml']
    np.testing.assert_array_equal(live, batch)

    # Both answer.
    request = SetBool.Request(data=True)
    ros.spin_until(lambda: ros.call(SetBool, 'driver_node/enable', request).success)
    assert 'publishers' in chain.fresh('observer_node: observers')
    assert node.stop(signal.SIGTERM) == 0
    assert float(chain.fresh('emulator_node: shoulder')['commanded current [A]']) == 0.0
    assert 'Traceback' not in node.output


def test_a_parameter_of_one_node_is_given_by_its_name(refusal):
    said = ' '.join(refusal('exoskeleton_node', 'rate:=500.0', 'driver_node:autostart:=false'))
    assert 'observer_node has no parameter rate' in said
    assert '-p driver_node:NAME:=VALUE' in said


def test_an_unknown_parameter_is_refused_before_a_motor_is_asked(ros, start_node):
    """It was only after the start-up of all motors."""
    chain = CanChain(ros, start_node)
    chain.start_emulator(*PATIENT_HARDWARE)
    channel = f'driver_node:can_channel:=socket://127.0.0.1:{chain.port}'
    unknown = 'observer_node:bandwith:=40.0'
    node = start_node('exoskeleton_node', channel, unknown, *PATIENT, files=(PARAMETER_FILE,))
    assert node.wait() == 2
    assert 'observer_node has no parameter bandwith: did you mean bandwidth?' in node.output
    assert chain.fresh('emulator_node: shoulder')['frames'] == '0'
