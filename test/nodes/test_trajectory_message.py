# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A trajectory goes into a message and its bytes, and comes back the same."""

from __future__ import annotations

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from sosml_friction.bags.serialization import deserialize
from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.nodes.trajectory_message import (
    message_from_trajectory,
    trajectory_bytes,
    trajectory_from_message,
)

KIND = 'trajectory_msgs/msg/JointTrajectory'


@pytest.mark.parametrize('names', [('a',), ('shoulder', 'elbow'), ('one', 'zwei', 'trois')])
@pytest.mark.parametrize('with_velocity', [True, False])
def test_the_bytes_of_a_trajectory_end_where_it_does(names, with_velocity):
    """Package rosbags, which shares no code with ours, refuses a byte more or less."""
    t = np.linspace(0.0, 1.0, 7)
    q = np.outer(t, np.arange(1.0, len(names) + 1.0))
    sent = Trajectory(names, t, q, 2.0 * q if with_velocity else None)
    message = message_from_trajectory(sent)
    message.header.frame_id = 'base' * len(names)
    data = trajectory_bytes(message)
    read = get_typestore(Stores.ROS2_JAZZY).deserialize_cdr(data, KIND)
    assert read.joint_names == list(names)
    np.testing.assert_array_equal([point.positions for point in read.points], q)
    back = trajectory_from_message(deserialize(data, KIND))
    np.testing.assert_array_equal(back.q, sent.q)
    np.testing.assert_allclose(back.t, sent.t, atol=1e-9)
