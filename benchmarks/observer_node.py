# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
What observer_node costs at 1 and 2 kHz, and whether it loses a sample: ``make benchmark``.

The node as it is shipped, FO and SOSML, for an arm of seven skew axes, in a process of its own;
another one publishes joint_states by DDS at the rate, and this one hears friction_estimate. Its
share of a core is the processor time of the node, all its threads, over the time of the samples.
The time from the stamp of a sample, taken just before it is published, to its estimate is by DDS's
own source time of the estimate, so that the way to this program is not in it. Lost are samples
without an estimate. Nothing here is a test.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from performance import skew_arm
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import JointState

from sosml_friction.nodes.qos import JOINT_STATES
from sosml_friction.report.common.table import print_table, terminal_table

JOINTS, RATES = 7, (1000, 2000)
#: What is counted begins after so long [s]: the first estimates are late for their compilation.
#: What is on its way at the end is waited for as long.
SETTLE_S = 5.0


def publish(rate: int, count: int) -> None:
    """Publish a motion in real time; once told that estimates come, say from which stamp on."""
    rclpy.init()
    node = rclpy.create_node('arm')
    publisher = node.create_publisher(JointState, 'joint_states', JOINT_STATES)
    while not publisher.get_subscription_count():
        time.sleep(0.05)
    rng, phase = np.random.default_rng(0), np.arange(JOINTS)
    message = JointState(name=[f'j{k}' for k in range(JOINTS)])
    begin_ns: list[int] = []

    def await_word() -> None:
        input()
        begin_ns.append(time.time_ns() + round(1e9 * SETTLE_S))
        print(begin_ns[0], flush=True)

    threading.Thread(target=await_word, daemon=True).start()
    first, k = time.monotonic(), 0
    while count:
        time.sleep(max(first + k / rate - time.monotonic(), 0.0))
        q, v, tau = rng.normal(size=(3, JOINTS)) * [[1e-5], [1e-3], [1.0]]
        message.position = (0.3 * np.sin(3.0 * k / rate + phase) + q).tolist()
        message.velocity = (0.9 * np.cos(3.0 * k / rate + phase) + v).tolist()
        message.effort = tau.tolist()
        now = time.time_ns()
        count -= bool(begin_ns) and now >= begin_ns[0]
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(now, 10**9)
        publisher.publish(message)
        k += 1
    publisher.wait_for_all_acked()
    rclpy.try_shutdown()


def busy_s(process: subprocess.Popen[Any]) -> float:
    """Return the processor time of a process until now [s]."""
    fields = Path(f'/proc/{process.pid}/stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


def measure(rate: int, count: int, folder: Path) -> tuple[float, np.ndarray, int]:
    """Return the share of a core, the time to each estimate [s], and how many were lost."""
    (folder / 'arm.urdf').write_text(skew_arm(JOINTS).document)
    said = {
        'urdf_path': f'{folder}/arm.urdf',
        'joints': str([f'j{k}' for k in range(JOINTS)]),
        'armature': str([0.1] * JOINTS),
        'velocity_noise': str([1e-3] * JOINTS),
        'position_noise': str([1e-5] * JOINTS),
    }
    command = [sys.executable, '-m', 'sosml_friction.nodes.observer_node', '--ros-args']
    for name, value in said.items():
        command += ['-p', f'{name}:={value}']
    found: list[tuple[int, int]] = []

    def take(estimate: JointState, info: dict[str, Any]) -> None:
        stamp = estimate.header.stamp
        found.append((stamp.sec * 10**9 + stamp.nanosec, info['source_timestamp']))

    hearer = rclpy.create_node('hearer')
    hearer.create_subscription(JointState, 'friction_estimate', take, JOINT_STATES)
    executor = SingleThreadedExecutor()
    executor.add_node(hearer)
    arm = [sys.executable, __file__, '--publish', str(rate), '--samples', str(count)]
    with (
        subprocess.Popen(command) as node,
        subprocess.Popen(
            arm, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1
        ) as source,
    ):
        assert source.stdin is not None
        assert source.stdout is not None
        while not found:
            if node.poll() is not None or source.poll() is not None:
                sys.exit('observer_node ended, or who publishes to it: the reason is above')
            executor.spin_once(timeout_sec=0.1)
        source.stdin.write('go\n')
        begin_ns = int(source.stdout.readline())
        while time.time_ns() < begin_ns:
            executor.spin_once(timeout_sec=0.01)
        busy, begun = busy_s(node), time.monotonic()
        while source.poll() is None:
            executor.spin_once(timeout_sec=0.1)
        share = (busy_s(node) - busy) / (time.monotonic() - begun)
        end = time.monotonic() + SETTLE_S
        while time.monotonic() < end:
            executor.spin_once(timeout_sec=0.1)
        node.terminate()
    hearer.destroy_node()
    times = np.array([(done - stamp) * 1e-9 for stamp, done in found if stamp >= begin_ns])
    return share, times, count - len(times)


def main() -> None:
    """Measure all rates, one after the other, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--samples', type=int, default=60_000, help='of each rate (60 000)')
    parser.add_argument('--publish', type=int, default=0, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.publish:
        publish(options.publish, options.samples)
        return
    # Other work waits for all three, as in ``sosml demo``, where that is permitted.
    with suppress(OSError):
        os.nice(-10)
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    os.environ.setdefault('ROS_DOMAIN_ID', str(1 + os.getpid() % 100))
    rclpy.init()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for rate in RATES:
            share, times, lost = measure(rate, options.samples, Path(folder))
            late = [f'{1e3 * x:.2f}' for x in (np.median(times), np.quantile(times, 0.99))]
            rows.append([f'{rate}', f'{100.0 * share:.1f}', *late, f'{lost} of {options.samples}'])
    heads = ('of a core [%]', 'median [ms]', '99 % [ms]', 'lost')
    print_table(
        terminal_table({'observer_node, seven joints [Hz]': '', **dict.fromkeys(heads, 'n')}, rows)
    )
    rclpy.try_shutdown()


if __name__ == '__main__':
    main()
