# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Real nodes in processes of their own, over real DDS confined to this machine."""

from __future__ import annotations

import gc
import importlib
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest
from lockstep import emulated_exoskeleton

from sosml_friction.model.model_folder import read_model
from sosml_friction.observers.friction_estimator import FrictionEstimator
from sosml_friction.observers.recipe import BANDWIDTH, recipe_gains
from sosml_friction.observers.registry import make_observer, on_line_names
from sosml_friction.share import share_directory

os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
os.environ.setdefault('ROS_DOMAIN_ID', str(1 + os.getpid() % 100))
# Wrong types in a message are an error here, not bytes on the wire.
os.environ.setdefault('ROS_PYTHON_CHECK_FIELDS', '1')

SHARED = Path(__file__).resolve().parents[1] / 'shared'
#: A condition that has not come true by then never will; no test judges how long it took.
PATIENCE = 180.0

# The longest a node here takes to answer is the second of a failed CAN start-up, on a machine
# that is busy many times that. [s]
REPLY_PATIENCE = 15.0


@pytest.fixture(scope='session', autouse=True)
def compiled() -> None:
    """Compile what the nodes run, so that none takes half a minute to start."""
    conditions = ([1e-4], [1e-3], [1.0], [1.0])
    robot = read_model(share_directory() / 'config' / 'emps').make_robot()
    gains = recipe_gains(robot, BANDWIDTH, *conditions)
    FrictionEstimator(robot, [make_observer(name, gains[name]) for name in on_line_names()])
    emulated_exoskeleton()


class NodeProcess:
    """A node of the package as a program, its output in a file."""

    def __init__(self, name: str, arguments: list[str], log: Path, module: str) -> None:
        self.name, self.log = name, log
        module = module or f'sosml_friction.nodes.{name}'
        path = os.pathsep.join([str(SHARED), os.environ.get('PYTHONPATH', '')])
        with log.open('wb') as stream:
            self.process = subprocess.Popen(
                [sys.executable, '-m', module, *arguments],
                env={**os.environ, 'PYTHONPATH': path},
                stdin=subprocess.DEVNULL,
                stdout=stream,
                stderr=subprocess.STDOUT,
            )

    @property
    def output(self) -> str:
        """Return what it printed so far."""
        return self.log.read_text(errors='replace')

    def wait(self) -> int:
        """Return its exit code when it has ended by itself."""
        return self.process.wait(timeout=PATIENCE)

    def stop(self, number: int = signal.SIGTERM) -> int:
        """Send a signal and return the exit code."""
        if self.process.poll() is None:
            self.process.send_signal(number)
        try:
            return self.process.wait(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise


class Ros:
    """A node of the test itself."""

    def __init__(self, name: str = 'test') -> None:
        import rclpy
        from rclpy.experimental import EventsExecutor

        self.context = rclpy.Context()
        rclpy.init(context=self.context)
        self.node = rclpy.create_node(name, context=self.context)
        self.executor = EventsExecutor(context=self.context)
        self.executor.add_node(self.node)
        self._clients: dict[str, Any] = {}

    def spin_until(self, condition: Callable[[], Any], patience: float = PATIENCE) -> None:
        """Handle messages until ``condition()`` holds; fail the test if it never does."""
        end = time.monotonic() + patience
        while not condition():
            assert time.monotonic() < end, 'the condition did not come true'
            self.executor.spin_once(timeout_sec=0.05)

    def discover(self, *names: str) -> None:
        """Wait until the graph holds these nodes: DDS may tell of a node after its messages."""
        self.spin_until(lambda: set(names) <= set(self.node.get_node_names()))

    def call(
        self, kind: Any, name: str, request: Any = None, done: Callable[[], bool] = lambda: False
    ) -> Any:
        """
        Call a service once it is there and return its response.

        DDS loses the response to a client that a busy node has not discovered yet, so the
        request is sent again where none comes: a service that would refuse it the second time
        needs ``done``, which tells that the first was obeyed; the response is then None.
        """
        if name not in self._clients:
            self._clients[name] = self.node.create_client(kind, name)
        client = self._clients[name]
        self.spin_until(client.service_is_ready)
        end = time.monotonic() + PATIENCE
        while True:
            assert time.monotonic() < end, f'{name} did not answer'
            future = client.call_async(request or kind.Request())
            late = time.monotonic() + REPLY_PATIENCE
            while not future.done() and time.monotonic() < late:
                self.executor.spin_once(timeout_sec=0.05)
            if future.done():
                return future.result()
            client.remove_pending_request(future)
            if done():
                return None

    def collect(self, kind: Any, topic: str, qos: Any, raw: bool = False) -> list[Any]:
        """Return a list that the messages of a topic are appended to, undecoded if ``raw``."""
        messages: list[Any] = []
        self.node.create_subscription(kind, topic, messages.append, qos, raw=raw)
        return messages

    def close(self) -> None:
        """Destroy the node and its context."""
        self.executor.shutdown()
        self.node.destroy_node()
        self.context.try_shutdown()


@pytest.fixture
def ros() -> Iterator[Ros]:
    """Return a node of the test's own."""
    peer = Ros()
    yield peer
    peer.close()


@pytest.fixture
def other() -> Iterator[Ros]:
    """Return a node as of another process: a participant of its own."""
    peer = Ros('other')
    yield peer
    peer.close()


def ros_arguments(parameters: Iterable[str], files: Iterable[Path]) -> list[str]:
    """Return the arguments that give a node ``key:=value`` parameters and parameter files."""
    arguments = ['--ros-args']
    for file in files:
        arguments += ['--params-file', str(file)]
    for parameter in parameters:
        arguments += ['-p', parameter]
    return arguments


@pytest.fixture
def refusal(capfd: pytest.CaptureFixture[str]) -> Callable[..., list[str]]:
    """
    Return a function that runs a node in this process, which must end it with exit code 2.

    The function returns the lines that were printed. A process for each would spend its time on
    imports; that a program ends with the code of its ``main`` is in the other tests of the node.
    """

    def refused(name: str, *parameters: str, files: tuple[Path, ...] = ()) -> list[str]:
        main = importlib.import_module(f'sosml_friction.nodes.{name}').main
        capfd.readouterr()
        # A node that runs instead is ended as any program is, and its code is not 2.
        late = threading.Timer(PATIENCE, os.kill, (os.getpid(), signal.SIGTERM))
        late.start()
        try:
            code = main(ros_arguments(parameters, files))
        finally:
            late.cancel()
            gc.unfreeze()
        out, err = capfd.readouterr()
        assert code == 2, out + err
        return (out + err).splitlines()

    return refused


@pytest.fixture
def start_node(tmp_path: Path) -> Iterator[Callable[..., NodeProcess]]:
    """Return a function that starts a node by name with ``key:=value`` parameters."""
    started: list[NodeProcess] = []

    def start(
        name: str,
        *parameters: str,
        files: tuple[Path, ...] = (),
        module: str = '',
        namespace: str = '',
    ) -> NodeProcess:
        arguments = ros_arguments(parameters, files)
        if namespace:
            arguments += ['--ros-args', '-r', f'__ns:={namespace}']
        node = NodeProcess(name, arguments, tmp_path / f'{name}_{len(started)}.log', module)
        started.append(node)
        return node

    yield start
    for node in reversed(started):
        node.stop()
