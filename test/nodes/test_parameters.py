# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The parameter tables: declared from, documented from, and used by the shipped files."""

from __future__ import annotations

from pathlib import Path

import pytest
import rclpy
import yaml
from rclpy.node import Node

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.nodes import (
    driver_node,
    emulator_node,
    identifier_node,
    observer_node,
    replay_node,
)
from sosml_friction.nodes.parameters import ParameterSpec, declare
from sosml_friction.share import share_directory
from validation.parameter_tables import parameter_document

REPOSITORY = Path(__file__).resolve().parents[2]
TABLES = {
    module.__name__.rpartition('.')[2]: module.PARAMETERS
    for module in (driver_node, emulator_node, identifier_node, observer_node, replay_node)
}


@pytest.fixture
def make_node():
    """Return a function that makes a node with the given overrides."""
    contexts = []

    def make(**overrides) -> Node:
        context = rclpy.Context()
        arguments = ['--ros-args']
        for name, value in overrides.items():
            arguments += ['-p', f'{name}:={value}']
        rclpy.init(args=arguments, context=context)
        contexts.append(context)
        return Node('parameters_test', context=context)

    yield make
    for context in contexts:
        context.try_shutdown()


def test_the_page_of_parameters_is_what_the_tables_say():
    """Run ``python -m validation.parameter_tables > docs/parameters.md`` if it fails."""
    assert (REPOSITORY / 'docs' / 'parameters.md').read_text() == parameter_document()


@pytest.mark.parametrize('name', TABLES)
def test_every_parameter_is_named_once_and_described(name):
    names = [spec.name for spec in TABLES[name]]
    assert len(set(names)) == len(names)
    assert all(spec.description for spec in TABLES[name])
    for spec in TABLES[name]:
        if spec.range is not None and spec.default is not None:
            assert spec.range[0] <= spec.default <= spec.range[1]
        if spec.choices and spec.default is not None:
            assert spec.default in spec.choices


def test_the_shipped_parameter_file_sets_only_parameters_that_exist():
    """ROS ignores unknown names in a file silently; a misspelt limit must not pass so."""
    document = yaml.safe_load((share_directory() / 'config' / 'exoskeleton.yaml').read_text())
    for node, content in document.items():
        known = {spec.name for spec in TABLES[node.removeprefix('/**/')]}
        for name, value in content['ros__parameters'].items():
            inner = [f'{{joint}}.{key}' for key in value] if isinstance(value, dict) else [name]
            assert set(inner) <= known, f'{node}: {name}'


@pytest.mark.parametrize(
    ('overrides', 'spec', 'words'),
    [
        ({}, ParameterSpec('mass', 'double', None, 'the mass', 'kg'), 'is not set: give the mass'),
        ({'mass': 7}, ParameterSpec('mass', 'double', None, 'the mass'), 'as in 7.0'),
        ({'mass': -1.0}, ParameterSpec('mass', 'double', 1.0, 'it', '', (0.0, 5.0)), 'between 0'),
        (
            {'way': 'up'},
            ParameterSpec('way', 'string', 'on', 'it', choices=('on', 'off')),
            'on, off',
        ),
    ],
)
def test_a_value_that_does_not_fit_is_refused_with_its_name(make_node, overrides, spec, words):
    with pytest.raises(ConfigurationError, match=spec.name) as caught:
        declare(make_node(**overrides), [spec])
    assert words in str(caught.value)


def test_a_table_for_each_joint_is_declared_under_its_name(make_node):
    """An empty list is a list, not the byte array that rclpy makes of it."""
    table = (
        ParameterSpec('gains', 'double_array', [], 'gains'),
        ParameterSpec('{joint}.kp', 'double', 1.5, 'gain'),
    )
    node = make_node(**{'elbow.kp': 2.5})
    assert declare(node, table) == {'gains': []}
    assert declare(node, table, 'elbow') == {'kp': 2.5}
    assert declare(node, table, 'wrist') == {'kp': 1.5}
    assert node.get_parameter('elbow.kp').value == 2.5
