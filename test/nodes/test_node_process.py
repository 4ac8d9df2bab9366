# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A node as a process of the demo: it is ended with the block, and its own end is told."""

from __future__ import annotations

import pytest

from sosml_friction.exceptions import ActuatorError
from sosml_friction.nodes.node_process import NodeProcess
from sosml_friction.share import share_directory

CONFIG = share_directory() / 'config' / 'exoskeleton.yaml'


def test_a_node_that_ends_is_told_with_its_last_words(tmp_path):
    """The player of bags ends at once where it is given none."""
    process = NodeProcess('replay_node', CONFIG, [], tmp_path / 'log')
    told = 'replay_node ended with exit code 2: parameter bag of replay_node is not set'
    with process, pytest.raises(ActuatorError, match=told):
        process.await_words('never said', 'play')


def test_a_node_runs_until_the_end_of_the_block(tmp_path):
    """It waits for a robot, and says where it found the model."""
    log = tmp_path / 'log'
    with NodeProcess('identifier_node', CONFIG, [f'output:={tmp_path}'], log) as process:
        process.await_words('joints shoulder, elbow', 'read its model')
        process.require_running()
    with pytest.raises(ActuatorError, match='identifier_node ended with exit code 0'):
        process.require_running()
