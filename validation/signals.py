# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
End each node in each phase by each signal, and see what becomes of the others.

    python -m validation.signals

The chain on emulated hardware, every node a program. Of SIGINT, SIGTERM and kill -9, while the
node starts, waits, or the robot moves: the other nodes go on, no torque is left where the driver
ended, what was recorded can be read, and the node works again when it is started again. Prints the
matrix of docs/reliability.md. It runs in real time, and takes ten minutes.
"""

from __future__ import annotations

import argparse
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger

from sosml_friction.bags.bag import Bag
from sosml_friction.exceptions import SosmlFrictionError
from sosml_friction.nodes.qos import JOINT_STATES
from sosml_friction.share import share_directory

NODES = ('driver_node', 'observer_node', 'identifier_node', 'emulator_node')
PHASES = ('starting', 'waiting', 'moving')
SIGNALS = {'SIGINT': signal.SIGINT, 'SIGTERM': signal.SIGTERM, 'kill -9': signal.SIGKILL}
#: What has not happened by then never will [s]; how long the robot moves before the signal.
PATIENCE_S, MOVES_S = 60.0, 1.5
#: What a killed recording may lack [s]: it is flushed ten times a second, by a timer that waits.
FLUSH_S = 0.5
FILE = share_directory() / 'config' / 'exoskeleton.yaml'
#: As the demonstration: nobody wears the emulated joint, and a busy machine is not what is tried.
_PATIENT = {
    'emulator_node': ['comm_timeout:=0.5', 'servo_watchdog:=0.5'],
    'driver_node': [
        'bus_wait:=60.0', 'missed_limit:=250', 'reply_timeout:=0.02', 'host_timeout:=5.0',
        'shoulder.tracking_limit:=1.0', 'elbow.tracking_limit:=1.0',
    ],
}  # fmt: skip


class BrokenError(Exception):
    """Say which promise was broken."""


class Chain:
    """Hold the four programs, and hear what they say."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        with socket.socket() as probe:
            probe.bind(('127.0.0.1', 0))
            self._port = probe.getsockname()[1]
        self.processes: dict[str, subprocess.Popen[bytes]] = {}
        #: Samples that were published while the robot moved, before the signal.
        self.heard = 0
        self._counts: Counter[str] = Counter()
        self._said: dict[str, dict[str, str]] = {}
        self._node = rclpy.create_node('signals')
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self._node.create_subscription(DiagnosticArray, '/diagnostics', self._hear, 50)
        for topic in ('joint_states', 'friction_estimate'):
            self._node.create_subscription(
                JointState, topic, lambda _, topic=topic: self._count(topic), JOINT_STATES
            )

    def _count(self, topic: str) -> None:
        self._counts[topic] += 1

    def _hear(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self._said[status.name] = {item.key: item.value for item in status.values}

    def start(self, name: str) -> None:
        """Start one program."""
        place = f'127.0.0.1:{self._port}'
        own = {
            'emulator_node': [f'can_channel:={place}'],
            'driver_node': [f'can_channel:=socket://{place}'],
            'identifier_node': [f'output:={self.folder}'],
        }
        command = [sys.executable, '-m', f'sosml_friction.nodes.{name}', '--ros-args']
        command += ['--params-file', str(FILE)]
        for parameter in [*own.get(name, []), *_PATIENT.get(name, [])]:
            command += ['-p', parameter]
        with self.log(name).open('wb') as stream:
            self.processes[name] = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=stream, stderr=subprocess.STDOUT
            )

    def log(self, name: str) -> Path:
        """Return the file with what a program says."""
        return self.folder / f'{name}.log'

    def spin(self, condition: Callable[[], Any], what: str, patience: float = PATIENCE_S) -> None:
        """
        Wait for ``condition``.

        :raises BrokenError: ``what``, if it does not come.
        """
        end = time.monotonic() + patience
        while not condition():
            if time.monotonic() > end:
                raise BrokenError(what)
            self._executor.spin_once(timeout_sec=0.05)

    def pause(self, seconds: float) -> None:
        """Hear for so long."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._executor.spin_once(timeout_sec=0.05)

    def fresh(self, name: str, key: str) -> str:
        """Return what a status says next."""
        self._said.pop(name, None)
        self.spin(lambda: name in self._said, f'no {name} in /diagnostics')
        return self._said[name].get(key, '')

    def works(self) -> None:
        """Wait until samples, estimates and the identifier's status come anew."""
        before = Counter(self._counts)
        for topic in ('joint_states', 'friction_estimate'):
            self.spin(
                lambda topic=topic: self._counts[topic] > before[topic] + 20,
                f'no {topic} after the restart',
            )
        self.fresh('identifier_node: run', 'phase')

    def call(self, kind: Any, name: str, request: Any, patience: float = PATIENCE_S) -> None:
        """Call a service until it says yes."""
        client = self._node.create_client(kind, name)
        end = time.monotonic() + patience
        answer = 'no answer'
        while time.monotonic() < end:
            if client.service_is_ready():
                future = client.call_async(request)
                late = time.monotonic() + 3.0
                while not future.done() and time.monotonic() < late:
                    self._executor.spin_once(timeout_sec=0.05)
                if future.done() and future.result().success:
                    self._node.destroy_client(client)
                    return
                answer = future.result().message if future.done() else answer
            self.pause(0.2)
        self._node.destroy_client(client)
        raise BrokenError(f'{name}: {answer}')

    def move(self) -> None:
        """Let the identifier move the robot."""
        self.call(SetBool, 'driver_node/enable', SetBool.Request(data=True))
        begun = lambda: self._said.get('identifier_node: run', {}).get('phase') == 'moving'  # noqa: E731
        end = time.monotonic() + PATIENCE_S
        while not begun():
            if time.monotonic() > end:
                raise BrokenError('the identifier did not begin')
            try:
                self.call(Trigger, 'identifier_node/start', Trigger.Request(), 4.0)
            except BrokenError:
                self.pause(0.5)
            self.pause(1.0)
        before = self._counts['joint_states']
        self.pause(MOVES_S)
        self.heard = self._counts['joint_states'] - before

    def settle(self) -> None:
        """End any motion and run, as far as there are."""
        for kind, name, request in (
            (SetBool, 'driver_node/enable', SetBool.Request()),
            (Trigger, 'identifier_node/abort', Trigger.Request()),
        ):
            try:
                self.call(kind, name, request, 4.0)
            except BrokenError:
                continue

    def close(self) -> None:
        """End all programs."""
        for name in reversed(list(self.processes)):
            process = self.processes[name]
            process.terminate()
            try:
                process.wait(timeout=20.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self._executor.remove_node(self._node)
        self._node.destroy_node()


def run_cell(chain: Chain, victim: str, phase: str, number: int) -> None:
    """
    End ``victim`` and judge what follows.

    :raises BrokenError: with the promise that was broken.
    """
    if phase == 'starting':
        process = chain.processes[victim]
        process.terminate()
        process.wait(timeout=PATIENCE_S)
        chain.start(victim)
        chain.pause(1.0)
    elif phase == 'moving':
        chain.move()
    process = chain.processes[victim]
    process.send_signal(number)
    try:
        code = process.wait(timeout=20.0)
    except subprocess.TimeoutExpired:
        raise BrokenError('it does not end') from None
    said = chain.log(victim).read_text(errors='replace')
    # While Python still imports, Python itself ends the program, in its own way.
    if phase != 'starting' and code != (-9 if number == signal.SIGKILL else 0):
        raise BrokenError(f'exit code {code}: {said.strip().splitlines()[-1:]}')
    if phase != 'starting' and 'Traceback' in said:
        raise BrokenError('a traceback')
    chain.pause(2.0)
    for name, other in chain.processes.items():
        if name != victim and other.poll() is not None:
            raise BrokenError(f'{name} has ended, too, with {other.returncode}')
    if victim == 'driver_node':
        for joint in ('shoulder', 'elbow'):
            if float(chain.fresh(f'emulator_node: {joint}', 'commanded current [A]')) != 0.0:
                raise BrokenError(f'{joint} is left with a current')
    chain.start(victim)
    chain.works()
    chain.settle()
    if phase == 'moving':
        _read_newest(chain.folder, chain.heard)


def _read_newest(folder: Path, heard: int) -> None:
    """Read the bag of the last run: what was published before, but for the last flush."""
    newest = max(folder.glob('*/bag'), key=lambda path: path.stat().st_mtime)
    try:
        bag = Bag.open(newest)
    except SosmlFrictionError as error:
        raise BrokenError(f'the recording cannot be read: {error}') from error
    count = bag.topics.get('/joint_states', ('', 0))[1]
    if not count >= (1.0 - FLUSH_S / MOVES_S) * heard > 0.0:
        raise BrokenError(f'the recording has {count} samples of {heard}')


def run(nodes: Sequence[str], phases: Sequence[str]) -> dict[tuple[str, str, str], str]:
    """Return what came of each cell: ok, or the promise that was broken."""
    found: dict[tuple[str, str, str], str] = {}
    chain: Chain | None = None
    with tempfile.TemporaryDirectory() as folder:
        for number, cell in enumerate(product(nodes, phases, SIGNALS)):
            begun = time.monotonic()
            try:
                if chain is None:
                    place = Path(folder) / str(number)
                    place.mkdir()
                    chain = Chain(place)
                    for name in reversed(NODES):
                        chain.start(name)
                    chain.works()
                run_cell(chain, cell[0], cell[1], SIGNALS[cell[2]])
                found[cell] = 'ok'
            except BrokenError as error:
                found[cell] = str(error)
                if chain is not None:
                    chain.close()
                chain = None
            seconds = time.monotonic() - begun
            print(f'{", ".join(cell)}: {found[cell]} ({seconds:.0f} s)', file=sys.stderr)
        if chain is not None:
            chain.close()
    return found


def table(found: dict[tuple[str, str, str], str]) -> str:
    """Return the matrix of docs/reliability.md."""
    rows = [f'| node | phase | {" | ".join(SIGNALS)} |', '|---|---|---|---|---|']
    for node, phase in dict.fromkeys((node, phase) for node, phase, _ in found):
        cells = (found[node, phase, name] for name in SIGNALS)
        rows.append(f'| {node} | {phase} | {" | ".join(cells)} |')
    return '\n'.join(rows)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the matrix and print it; return 1 if a promise was broken."""
    assert __doc__ is not None
    parser = argparse.ArgumentParser(
        prog='python -m validation.signals', description=__doc__.strip().split('\n\n')[0]
    )
    parser.add_argument('--nodes', default=','.join(NODES), help='some of them, with commas')
    parser.add_argument('--phases', default=','.join(PHASES), help='some of them, with commas')
    options = parser.parse_args(arguments)
    # Never a domain with a real robot.
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    os.environ['ROS_DOMAIN_ID'] = str(1 + os.getpid() % 100)
    rclpy.init()
    try:
        found = run(options.nodes.split(','), options.phases.split(','))
    finally:
        rclpy.try_shutdown()
    print(table(found))
    return int(any(outcome != 'ok' for outcome in found.values()))


if __name__ == '__main__':
    sys.exit(main())
