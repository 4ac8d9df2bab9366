# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""ROS parameter files: a node's own parameters count more than those for any."""

import pytest

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.motion.parameter_file import node_parameters


@pytest.mark.parametrize('node', ['arm', '/arm', '/**/arm', '/left/arm'])
def test_a_nodes_own_come_first_wherever_they_stand(tmp_path, node):
    file = tmp_path / 'p.yaml'
    own = f'{node}: {{ros__parameters: {{b: 3, j: {{c: 4}}, j.d: 5}}}}\n'
    file.write_text(own + '/**: {ros__parameters: {a: 1, b: 2}}\nleg: {ros__parameters: {e: 6}}\n')
    assert node_parameters(file, 'arm') == {'a': 1, 'b': 3, 'j.c': 4, 'j.d': 5}


@pytest.mark.parametrize('text', ['', 'leg: {ros__parameters: {a: 1}}', 'arm: {}'])
def test_a_file_without_the_node_has_nothing(tmp_path, text):
    file = tmp_path / 'p.yaml'
    file.write_text(text)
    assert node_parameters(file, 'arm') == {}


@pytest.mark.parametrize('text', ['[1]', 'arm: 5', 'arm: {ros__parameters: [1]}'])
def test_a_file_of_something_else_is_refused(tmp_path, text):
    file = tmp_path / 'p.yaml'
    file.write_text(text)
    with pytest.raises(ConfigurationError, match=r'the file .*p.yaml cannot be read: it has no n'):
        node_parameters(file, 'arm', 'the file')
