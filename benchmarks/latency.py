# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
From the stamp of a sample to its estimate: two processes beside one, ``make latency``.

The emulated exoskeleton over slcan/TCP at 500 Hz, in real time; the time is that from the receive
time of the last position to the moment at which the observer publishes ``friction_estimate``, by
DDS's own source time, so that the way to this program is not in it. Nothing here is a test.
"""

from __future__ import annotations

import argparse
import os
import socket
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import JointState

from sosml_friction.nodes.node_process import NodeProcess
from sosml_friction.nodes.qos import JOINT_STATES
from sosml_friction.report.common.table import print_table, terminal_table
from sosml_friction.share import share_directory

FILE = share_directory() / 'config' / 'exoskeleton.yaml'
#: What is measured begins after the first estimates [s]: the first are late for their compilation.
SETTLE_S = 3.0
ARRANGEMENTS = {
    'two processes': ('driver_node', 'observer_node'),
    'one process': ('exoskeleton_node',),
}


def measure(nodes: tuple[str, ...], seconds: float, logs: Path) -> np.ndarray:
    """Return the latency of each estimate [s]."""
    with socket.socket() as probe:
        probe.bind(('127.0.0.1', 0))
        port = probe.getsockname()[1]
    latencies: list[float] = []

    def take(message: JointState, info: dict[str, Any]) -> None:
        stamp_ns = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
        latencies.append((info['source_timestamp'] - stamp_ns) * 1e-9)

    node = rclpy.create_node('latency')
    node.create_subscription(JointState, 'friction_estimate', take, JOINT_STATES)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    with ExitStack() as stack:
        started = [('emulator_node', f'can_channel:=127.0.0.1:{port}')]
        channel = f'driver_node:can_channel:=socket://127.0.0.1:{port}'
        started += [(name, channel) for name in nodes]
        for name, parameter in started:
            process = NodeProcess(name, FILE, [parameter], logs / f'{name}.log')
            stack.enter_context(process)
            if name == 'emulator_node':
                process.await_words(f':{port}', 'listen')
        while not latencies:
            executor.spin_once(timeout_sec=0.1)
        end = time.monotonic() + SETTLE_S
        while time.monotonic() < end:
            executor.spin_once(timeout_sec=0.1)
        latencies.clear()
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            executor.spin_once(timeout_sec=0.1)
    executor.remove_node(node)
    node.destroy_node()
    return np.array(latencies)


def main() -> None:
    """Measure both arrangements, one after the other, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--seconds', type=float, default=20.0, help='of each (20)')
    options = parser.parse_args()
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    os.environ['ROS_DOMAIN_ID'] = str(1 + os.getpid() % 100)
    rclpy.init()
    rows = []
    with tempfile.TemporaryDirectory() as logs:
        for name, nodes in ARRANGEMENTS.items():
            latency = 1e3 * measure(nodes, options.seconds, Path(logs))
            figures = (np.median(latency), np.quantile(latency, 0.99), latency.max())
            rows.append([name, *(f'{value:.2f}' for value in figures), str(len(latency))])
    heads = ('median', '99 %', 'most', 'estimates')
    columns = {'from stamp to estimate [ms]': '', **dict.fromkeys(heads, 'n')}
    print_table(terminal_table(columns, rows))
    rclpy.try_shutdown()


if __name__ == '__main__':
    main()
