# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The model that a node takes where none is stated."""

import pytest

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.nodes.stated_model import StatedModel
from sosml_friction.share import share_directory

NOTHING = {'model': '', 'armature': [], 'joints': []}


def test_another_robot_with_joints_of_the_same_names_does_not_get_the_exoskeletons_rotors():
    """Any arm with a shoulder and an elbow got them, without a word."""
    urdf = (share_directory() / 'urdf' / 'exoskeleton.urdf').read_text()
    stated = StatedModel(NOTHING)
    assert stated.robot(urdf).names == ('shoulder', 'elbow')
    other = urdf.replace('<robot name="exoskeleton">', '<robot name="my_arm">')
    with pytest.raises(ConfigurationError, match=r"'my_arm', .* set parameter armature"):
        stated.robot(other)
