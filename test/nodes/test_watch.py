# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is watched is what the nodes said last, and what is not known is no number."""

import json
import math
import time
from pathlib import Path

import jsonschema
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.context import Context
from rclpy.node import Node
from rich.console import Console
from sensor_msgs.msg import JointState

from sosml_friction.nodes import watch
from sosml_friction.nodes.diagnostics import WARN, make_array, make_status
from sosml_friction.nodes.watch import Heard, run_watch


def state(**values):
    return JointState(name=['shoulder', 'elbow'], **values)


def heard_at(clock):
    heard = Heard(lambda: clock[0])
    heard.take('joint_states', state(velocity=[0.5, -0.1], effort=[1.25, 0.5]))
    heard.take('friction_estimate', state(effort=[0.9, math.nan]))
    heard.take('friction_estimate_error', state(effort=[0.05, math.nan]))
    return heard


def printed(heard):
    console = Console(width=120, highlight=False)
    with console.capture() as capture:
        console.print(heard.table())
    return capture.get()


def test_each_joint_has_its_friction_with_half_its_interval():
    shoulder, elbow = heard_at([0.0]).rows()
    assert shoulder == ('shoulder', '0.5000', '1.250', '0.900', '0.098', 'valid')
    assert elbow == ('elbow', '-0.1000', '0.5000', '-', '-', 'not known')


def test_what_has_not_come_for_long_is_silent_and_not_valid():
    clock = [0.0]
    heard = heard_at(clock)
    clock[0] = 7.0
    assert [row[-1] for row in heard.rows()] == ['silent for 7 s'] * 2
    assert 'joint_states silent for 7 s' in printed(heard)


def test_json_has_what_the_table_has_and_nothing_that_is_not_known():
    document = heard_at([0.0]).document()
    schema = Path(__file__).resolve().parents[2] / 'docs' / 'schema' / 'watch.schema.json'
    jsonschema.validate(document, json.loads(schema.read_text()))
    assert document['joints']['shoulder']['friction'] == 0.9
    assert document['joints']['elbow']['friction'] is None


def test_nodes_are_told_with_their_phase():
    heard = Heard()
    assert not heard.anything
    assert 'waiting' in printed(heard)
    status = make_status('identifier_node: run', WARN, 'T1 runs', {'phase': 'moving'})
    heard.on_diagnostics(make_array(JointState().header.stamp, [status]))
    assert heard.anything
    assert 'moving, T1 runs' in printed(heard)
    assert 'warning' in printed(heard)


def test_without_an_observer_there_is_motion_and_no_friction():
    heard = Heard()
    heard.take('joint_states', state(velocity=[0.5], effort=[]))
    assert next(heard.rows()) == ('shoulder', '0.5000', '-', '-', '-', 'no observer')


def test_a_node_that_publishes_is_heard_over_the_wire_until_ctrl_c(monkeypatch):
    context = Context()
    rclpy.init(context=context)
    node = Node('speaks', context=context, namespace='left')
    publisher = node.create_publisher(JointState, 'friction_estimate', 10)
    diagnostics = node.create_publisher(DiagnosticArray, '/diagnostics', 10)
    status = make_status('driver_node: driver', WARN, 'on its way', {})
    said = make_array(JointState().header.stamp, [status])
    heard, listen = Heard(), watch._listen
    end = time.monotonic() + 60.0

    def speak_and_listen(executor):
        assert time.monotonic() < end
        publisher.publish(state(effort=[0.75, 0.25]))
        diagnostics.publish(said)
        listen(executor)
        document = heard.document()
        if document['joints'] and document['nodes']:
            raise KeyboardInterrupt

    monkeypatch.setattr(watch, 'Heard', lambda: heard)
    monkeypatch.setattr(watch, '_listen', speak_and_listen)
    try:
        assert run_watch('left') is heard
    finally:
        node.destroy_node()
        rclpy.shutdown(context=context)
    assert '0.7500' in printed(heard)
    assert 'on its way' in printed(heard)


def test_a_watch_of_some_seconds_ends_by_itself():
    assert isinstance(run_watch('nobody', 0.2), Heard)


def test_where_nothing_runs_it_says_so(sosml):
    code, out, err = sosml('watch', '--namespace', 'nobody', '--seconds', '0')
    assert (code, out) == (2, '')
    assert '--seconds 0 is no time' in err
