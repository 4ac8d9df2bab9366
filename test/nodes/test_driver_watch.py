# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a driver says of itself is taken from its own diagnostics alone."""

import pytest

pytest.importorskip('rclpy')

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from sosml_friction.nodes.driver_watch import DriverWatch


def said(name: str, state: str, commander: str = 'nobody') -> DiagnosticArray:
    pairs = {'state': state, 'fault': '', 'commander': commander}
    values = [KeyValue(key=key, value=value) for key, value in pairs.items()]
    return DiagnosticArray(status=[DiagnosticStatus(name=name, values=values)])


def test_two_drivers_are_told_apart_by_their_namespace():
    left, right = DriverWatch('/left/driver_node'), DriverWatch('/right/driver_node')
    for watch in (left, right):
        watch.take(said('left/driver_node: driver', 'disabled'))
        watch.take(said('right/driver_node: driver', 'enabled'))
    assert left.refusal('me') == 'left/driver_node is disabled: call its ~/enable first'
    assert right.refusal('me') == ''


def test_a_driver_that_another_node_holds_would_not_follow():
    watch = DriverWatch('driver_node')
    watch.take(said('driver_node: driver', 'enabled', 'demo'))
    assert watch.refusal('me').startswith('driver_node is held by demo: wait')
    assert watch.refusal('demo') == ''


def test_what_a_driver_said_last_is_quoted_while_it_is_fresh():
    watch = DriverWatch('driver_node')
    assert watch.said == 'no diagnostics come from driver_node: does it run, and is it enabled?'
    message = said('driver_node: driver', 'enabled')
    message.status[0].message = 'trajectory refused: too fast'
    watch.take(message)
    assert watch.said == 'driver_node says: trajectory refused: too fast'
