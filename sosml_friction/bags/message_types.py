# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Names of the message types that are read of bags."""

JOINT_STATE = 'sensor_msgs/msg/JointState'
TEMPERATURE = 'sensor_msgs/msg/Temperature'
STRING = 'std_msgs/msg/String'
TRAJECTORY = 'trajectory_msgs/msg/JointTrajectory'
