# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The quality-of-service profiles of the package's topics."""

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

# Two seconds at 500 Hz: a subscriber that is busy for that long loses nothing.
JOINT_STATES = QoSProfile(
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.VOLATILE,
    history=HistoryPolicy.KEEP_LAST,
    depth=1000,
)
"""``joint_states`` and ``friction_estimate``: reliable and deep."""

LATCHED = QoSProfile(
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
    history=HistoryPolicy.KEEP_LAST,
    depth=1,
)
"""``robot_description`` and ``friction_parameters``: a late subscriber gets the last one."""
