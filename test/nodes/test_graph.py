# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
What config/ says of topics, services and diagnostics is what the running nodes have.

The SROS 2 policy, the layouts of Foxglove and PlotJuggler, and the tree of diagnostic_aggregator,
beside the graph of driver, observer, identifier and emulator, one of each.
"""

from __future__ import annotations

import importlib
import json
import re
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path

import pytest

pytest.importorskip('rclpy')

import yaml
from can_chain import PARAMETER_FILE, CanChain
from diagnostic_msgs.msg import DiagnosticArray

CONFIG = Path(__file__).resolve().parents[2] / 'config'
NODES = ('driver_node', 'observer_node', 'identifier_node')
JOINTS = ('shoulder', 'elbow')
KINDS = ('publish', 'subscribe', 'reply', 'request', 'execute', 'call')


@dataclass
class Graph:
    """Hold what each node has, names with types by kind, and the names of what is diagnosed."""

    nodes: dict[str, dict[str, dict[str, str]]] = field(default_factory=dict)
    statuses: set[str] = field(default_factory=set)

    def type_of(self, topic: str) -> type:
        """Return the class of the messages that some node publishes on ``topic``."""
        kinds = [own['publish'][topic] for own in self.nodes.values() if topic in own['publish']]
        assert kinds, f'nobody publishes {topic}'
        package, _, name = kinds[0].partition('/msg/')
        return getattr(importlib.import_module(f'{package}.msg'), name)


_FOUND: list[Graph] = []


@pytest.fixture
def graph(request) -> Graph:
    """Return the graph of one of each node, with nothing moving; found once."""
    if not _FOUND:
        ros, start_node = (request.getfixturevalue(name) for name in ('ros', 'start_node'))
        folder = request.getfixturevalue('tmp_path')
        chain = CanChain(ros, start_node)
        chain.start_emulator()
        chain.start_driver()
        start_node('observer_node', files=(PARAMETER_FILE,))
        start_node('identifier_node', f'output:={folder}', files=(PARAMETER_FILE,))
        names = (*NODES, 'emulator_node')
        ros.spin_until(
            lambda: all(any(said.startswith(f'{name}: ') for said in chain.diagnostics)
                        for name in names)
            and 'observer_node: shoulder' in chain.diagnostics
        )  # fmt: skip
        ros.discover(*names)
        found = Graph(statuses=set(chain.diagnostics))
        node = ros.node

        def look(name: str) -> dict[str, dict[str, str]]:
            asked = {
                'publish': node.get_publisher_names_and_types_by_node,
                'subscribe': node.get_subscriber_names_and_types_by_node,
                'reply': node.get_service_names_and_types_by_node,
                'request': node.get_client_names_and_types_by_node,
            }
            return {
                # What an action is made of is allowed with it.
                kind: {own: types[0] for own, types in ask(name, '/') if '/_action/' not in own}
                for kind, ask in asked.items()
            }

        # The identifier subscribes to the observers' topics once it has their configuration.
        ros.spin_until(lambda: '/friction_estimate/sosml' in look('identifier_node')['subscribe'])
        found.nodes = {name: look(name) for name in names}
        _FOUND.append(found)
    return _FOUND[0]


# ---- security


def policy() -> dict[tuple[str, str], dict[str, set[str]]]:
    """Return what the policy allows by (enclave, node) and kind, by full names."""
    root = ElementTree.parse(CONFIG / 'security' / 'policy.xml').getroot()
    assert (root.tag, root.get('version')) == ('policy', '0.2.0')
    allowed: dict[tuple[str, str], dict[str, set[str]]] = {}
    for enclave in root.iter('enclave'):
        for profile in enclave.iter('profile'):
            own = allowed.setdefault(
                (enclave.get('path', ''), profile.get('node', '')),
                {kind: set() for kind in KINDS},
            )
            for rule in profile:
                for kind in rule.attrib:
                    assert rule.get(kind) == 'ALLOW'
                    own[kind] |= {profile.get('ns', '') + (item.text or '') for item in rule}
    return allowed


@pytest.mark.parametrize('name', NODES)
def test_the_policy_allows_a_node_all_that_it_has_and_nothing_else(graph, name):
    allowed = policy()['/exoskeleton/' + name, name]
    for kind, names in graph.nodes[name].items():
        denied = [own for own in names if not any(fnmatchcase(own, p) for p in allowed[kind])]
        assert not denied, f'{kind}: {denied} would be denied'
        idle = [p for p in allowed[kind] if not any(fnmatchcase(own, p) for own in names)]
        assert not idle, f'{kind}: {idle} is allowed and not needed'


def test_only_identifier_and_operator_may_command_and_only_the_operator_may_enable():
    may = {
        kind: {enclave for (enclave, _), own in policy().items() if name in own[kind]}
        for kind, name in (('publish', '/joint_trajectory'), ('request', '/driver_node/enable'))
    }
    operator = '/exoskeleton/operator'
    # Where control_msgs is installed.
    action = '/driver_node/follow_joint_trajectory'
    assert {enclave for (enclave, _), own in policy().items() if action in own['call']} == {
        operator
    }
    assert may == {'publish': {'/exoskeleton/identifier_node', operator}, 'request': {operator}}


def test_driver_and_observer_in_one_process_may_what_they_may_in_two_but_hear_no_joint_states():
    allowed = policy()
    one = '/exoskeleton/exoskeleton_node'
    assert allowed[one, 'driver_node'] == allowed['/exoskeleton/driver_node', 'driver_node']
    apart = allowed['/exoskeleton/observer_node', 'observer_node']
    apart['subscribe'].remove('/joint_states')
    assert allowed[one, 'observer_node'] == apart


# ---- tools


def require(graph: Graph, topic: str, message_field: str) -> None:
    assert message_field in graph.type_of(topic).get_fields_and_field_types()


def test_the_layout_of_foxglove_names_fields_that_there_are(graph):
    layout = json.loads((CONFIG / 'tools' / 'foxglove_layout.json').read_text())
    panels = layout['configById']
    shown: list[str] = []

    def walk(place) -> None:
        if isinstance(place, str):
            shown.append(place)
            return
        assert place['direction'] in ('row', 'column')
        walk(place['first'])
        walk(place['second'])

    walk(layout['layout'])
    assert sorted(shown) == sorted(panels)
    paths = [path for panel in panels.values() for path in panel.get('paths', [])]
    assert len(paths) > 8
    for path in paths:
        topic, name, index = re.fullmatch(r'(/[\w/]+)\.(\w+)\[(\d)\]', path['value']).groups()
        require(graph, topic, name)
        assert path['label'].endswith(JOINTS[int(index)])
    (status,) = [own for name, own in panels.items() if name.startswith('DiagnosticSummary!')]
    assert graph.type_of(status['topicToRender']) is DiagnosticArray
    (raw,) = [own for name, own in panels.items() if name.startswith('RawMessages!')]
    assert graph.type_of(raw['topicPath'])


def test_the_layout_of_plotjuggler_names_fields_that_there_are(graph):
    root = ElementTree.parse(CONFIG / 'tools' / 'plotjuggler_layout.xml').getroot()
    curves = [curve.get('name', '') for curve in root.iter('curve')]
    assert len(curves) > 8
    for curve in curves:
        topic, joint, name = curve.rsplit('/', 2)
        require(graph, topic, name)
        assert joint in JOINTS
    for splitter in root.iter('DockSplitter'):
        assert int(splitter.get('count', '')) == len(splitter)


def test_every_status_has_its_place_in_the_tree_of_diagnostic_aggregator(graph):
    text = (CONFIG / 'tools' / 'diagnostic_aggregator.yaml').read_text()
    parameters = yaml.safe_load(text)['/**']['ros__parameters']
    analyzers = [own for own in parameters.values() if isinstance(own, dict)]
    starts = [start for own in analyzers for start in own['startswith']]
    assert all(own['type'] == 'diagnostic_aggregator/GenericAnalyzer' for own in analyzers)
    for name in graph.statuses:
        assert sum(name.startswith(start) for start in starts) == 1, name
    for start in starts:
        assert any(name.startswith(start) for name in graph.statuses), start
