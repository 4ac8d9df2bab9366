# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Driver and emulator as processes on one TCP port, and what they say of themselves."""

from __future__ import annotations

import socket
import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from trajectory_msgs.msg import JointTrajectory

from sosml_friction.share import share_directory

PARAMETER_FILE = share_directory() / 'config' / 'exoskeleton.yaml'


class CanChain:
    """
    Hear both on /diagnostics and command the driver.

    :param ros: the fixture of that name, as ``start_node``.
    """

    def __init__(self, ros: Any, start_node: Any) -> None:
        self.ros = ros
        self.start_node = start_node
        with socket.socket() as probe:
            probe.bind(('127.0.0.1', 0))
            self.port = int(probe.getsockname()[1])
        self.diagnostics: dict[str, tuple[str, dict[str, str]]] = {}
        self._since_ns = 0
        ros.node.create_subscription(DiagnosticArray, '/diagnostics', self._hear, 50)
        self.trajectories = ros.node.create_publisher(JointTrajectory, 'joint_trajectory', 10)

    def _hear(self, message: DiagnosticArray) -> None:
        stamp = message.header.stamp
        if stamp.sec * 10**9 + stamp.nanosec < self._since_ns:
            return
        for status in message.status:
            values = {item.key: item.value for item in status.values}
            self.diagnostics[status.name] = (status.message, values)

    def start_emulator(self, *parameters: str) -> Any:
        """Start it and wait until it speaks or has ended."""
        channel = f'can_channel:=127.0.0.1:{self.port}'
        node = self.start_node('emulator_node', channel, *parameters, files=(PARAMETER_FILE,))
        self.ros.spin_until(
            lambda: 'emulator_node: plant' in self.diagnostics or node.process.poll() is not None
        )
        return node

    def start_driver(self, *parameters: str) -> Any:
        """Start it; that it measures is for the caller to wait for."""
        channel = f'can_channel:=socket://127.0.0.1:{self.port}'
        return self.start_node('driver_node', channel, *parameters, files=(PARAMETER_FILE,))

    def value(self, name: str, key: str) -> str:
        """Return what the status called ``name`` said last, or nothing."""
        return self.diagnostics.get(name, ('', {}))[1].get(key, '')

    def fresh(self, name: str) -> dict[str, str]:
        """Wait for a status called ``name`` that is made from now on and return its values."""
        # What was made before and is still on its way knows nothing of what the test just did.
        self._since_ns = time.time_ns()
        self.diagnostics.pop(name, None)
        self.ros.spin_until(lambda: name in self.diagnostics)
        return self.diagnostics[name][1]
