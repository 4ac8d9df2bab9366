# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""--help of every node: what it is, all of its parameters, an example, and no ROS."""

from __future__ import annotations

import importlib
import subprocess
import sys

import pytest
import rclpy

from sosml_friction.nodes.node_help import NodeHelp

NODES = (
    'driver_node',
    'observer_node',
    'exoskeleton_node',
    'identifier_node',
    'replay_node',
    'emulator_node',
)


@pytest.mark.parametrize('name', NODES)
@pytest.mark.parametrize('option', ['--help', '-h'])
def test_help_lists_every_parameter_and_starts_nothing(capsys, monkeypatch, name, option):
    node = importlib.import_module(f'sosml_friction.nodes.{name}')

    def refuse(*_, **__):
        raise AssertionError('ROS was started')

    monkeypatch.setattr(rclpy, 'init', refuse)
    assert node.main([option]) == 0
    out, err = capsys.readouterr()
    assert err == ''
    assert out.startswith(f'Usage: {name} ')
    assert f'\nExample: {name} --ros-args ' in out
    words = ' '.join(out.split())
    for spec in node.PARAMETERS:
        assert f'\n  {spec.name} ({spec.type}' in out
        assert ' '.join(spec.description.split()) in words
    assert max(map(len, out.splitlines())) <= 160


@pytest.mark.parametrize('name', NODES)
def test_the_example_names_parameters_that_exist(name):
    node = importlib.import_module(f'sosml_friction.nodes.{name}')
    named = [word.split(':=')[0] for word in node.HELP.example.split() if ':=' in word]
    assert set(named) <= {spec.name for spec in node.PARAMETERS}


def test_the_program_prints_it_and_ends_with_0():
    command = [sys.executable, '-m', 'sosml_friction.nodes.replay_node', '--help']
    ran = subprocess.run(command, capture_output=True, text=True)
    assert (ran.returncode, ran.stderr) == (0, '')
    assert 'bag (string, required)' in ran.stdout


def test_what_ros_is_asked_is_not_our_help():
    assert not NodeHelp.asked_for(['--ros-args', '--help'])
    assert NodeHelp.asked_for(['-h', '--ros-args', '-p', 'rate:=2.0'])
