# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The quality-of-service profiles of the package's topics."""

from rclpy.qos import DurabilityPolicy, QoSProfile

# Two seconds at 500 Hz: a subscriber that is busy for that long loses nothing.
JOINT_STATES = QoSProfile(depth=1000)
"""``joint_states`` and ``friction_estimate``: reliable and deep."""

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""``robot_description`` and ``friction_parameters``: a late subscriber gets the last one."""
