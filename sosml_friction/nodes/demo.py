# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The whole chain on emulated hardware, each node a process of its own, over CAN bytes and DDS."""

from __future__ import annotations

import ctypes
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.client import Client
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from std_srvs.srv import SetBool, Trigger

from sosml_friction.exceptions import ActuatorError, ConfigurationError
from sosml_friction.identification.bag_analysis import analyse_bag
from sosml_friction.model.model_folder import read_model
from sosml_friction.nodes.run import make_executor
from sosml_friction.report.common.output import to_json
from sosml_friction.report.common.progress import progress
from sosml_friction.report.common.tables import parameter_table, print_table
from sosml_friction.report.fit.results import (
    FILES,
    check_destination,
    fit_document,
    write_results,
)
from sosml_friction.share import share_directory

#: What the chain writes into the demo's folder, and so may replace.
RUN = 'run'
LOGS = 'logs'

# A busy machine may keep a process from running for longer than a real joint may go without a
# command. Nobody wears the emulated one, so its watchdogs and the driver wait for half a second,
# and a joint may be left behind by its reference meanwhile.
_PATIENT_HARDWARE = ('comm_timeout:=0.5', 'servo_watchdog:=0.5')
_PATIENT_DRIVER = (
    'missed_limit:=250',
    'reply_timeout:=0.02',
    'host_timeout:=5.0',
    'shoulder.tracking_limit:=1.0',
    'elbow.tracking_limit:=1.0',
)
_PR_SET_PDEATHSIG = 1
#: A service that has not replied by then [s] is asked again.
_REPLY_PATIENCE = 5.0


@dataclass(frozen=True)
class Progress:
    """Say how far a demo is: a phase in words and, while moving, 0..1."""

    phase: str
    share: float | None = None


def run_demo(output: Path, seed: int = 0, json: bool = False) -> int:
    """
    Identify the emulated exoskeleton, print the table and write the report.

    ``output`` gets ``report.html``, ``fit.json`` and the model (``model.yaml``, ``robot.urdf``),
    the bag in ``run/bag`` and what the nodes said in ``logs``.

    :param seed: of the emulated noise.
    :param json: print the object of ``sosml fit --json`` instead of the table.
    :return: exit code: 0, or 1 if a joint could not be fitted.
    :raises ConfigurationError: if ``output`` holds something else or cannot be written.
    :raises ActuatorError: if a node ends or does not answer.
    """
    check_destination(output, (RUN, LOGS))
    truth = read_model(share_directory() / 'config' / 'emulated_exoskeleton')
    with progress('the demonstration: about a minute and a half') as step:
        shown: list[str] = []

        def follow(state: Progress) -> None:
            if not shown or shown[-1] != state.phase:
                shown.append(state.phase)
                if not json and not sys.stderr.isatty():
                    print(state.phase, file=sys.stderr, flush=True)
            step(state.phase, state.share)

        # An interrupted demo must not leave an old report beside a new recording.
        for name in FILES:
            (output / name).unlink(missing_ok=True)
        run = run_chain(output, seed, follow)
        follow(Progress('drawing the report'))
        analysis = analyse_bag(run / 'bag')
        extra = {'seed of the emulator': str(seed)}
        write_results(output, analysis, truth, extra, beside=(RUN, LOGS))
    if json:
        print(to_json({**fit_document(analysis, truth), 'output': str(output)}))
    else:
        print_table(parameter_table(analysis, truth, 'truth in the\nemulator'))
        print(f'{output / "report.html"} shows it; the recording is in {run / "bag"}')
    return 1 if analysis.fit.unavailable else 0


def run_chain(
    output: Path,
    seed: int = 0,
    on_progress: Callable[[Progress], None] = lambda progress: None,
    speeds: tuple[float, ...] = (),
    plateau: float | None = None,
) -> Path:
    """
    Run emulator, driver, observers and identifier through T1 and return the run's folder.

    The nodes' own messages go to ``output/logs``. The DDS domain is this process's own and
    confined to this machine, whatever ROS_DOMAIN_ID says.

    :param output: folder for the results; what an earlier demo left there is replaced.
    :param seed: of the emulated noise.
    :param speeds: plateau speeds [rad/s], empty for those of T1.
    :param plateau: length of a plateau [s], None for T1's.
    :raises ActuatorError: if a node ends or does not answer; the sentence quotes its last words.
    :raises ConfigurationError: if ``output`` cannot be written.
    """
    _prepare(output)
    # Never the domain the user's shell names: a real robot may be on it, and it would move.
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    os.environ['ROS_DOMAIN_ID'] = str(1 + os.getpid() % 100)
    port = _free_port()
    parameters = share_directory() / 'config' / 'exoskeleton.yaml'
    identifier = [f'output:={output.resolve()}', f'run_name:={RUN}']
    if speeds:
        identifier.append(f'speeds:=[{", ".join(str(float(x)) for x in speeds)}]')
    if plateau is not None:
        identifier.append(f'plateau:={float(plateau)}')
    nodes = {
        'emulator_node': [f'can_channel:=127.0.0.1:{port}', f'seed:={seed}', *_PATIENT_HARDWARE],
        'driver_node': [f'can_channel:=socket://127.0.0.1:{port}', *_PATIENT_DRIVER],
        'observer_node': [],
        'identifier_node': identifier,
    }
    with ExitStack() as stack:
        stack.enter_context(_terminable())
        processes: dict[str, subprocess.Popen[bytes]] = {}
        chain = stack.enter_context(_chain(processes, output / LOGS, on_progress))
        chain.require_no_driver()
        for name, settings in nodes.items():
            arguments = ['--ros-args', '--params-file', str(parameters)]
            for setting in settings:
                arguments += ['-p', setting]
            log = output / LOGS / f'{name}.log'
            processes[name] = stack.enter_context(_process(name, arguments, log))
            if name == 'emulator_node':
                on_progress(Progress('starting the emulated exoskeleton'))
                _await_port(port, processes[name], log)
        on_progress(Progress('starting driver, observers and identifier'))
        chain.call(SetBool, 'driver_node/enable', SetBool.Request(data=True))
        chain.call(Trigger, 'identifier_node/start', Trigger.Request(), done=chain.has_begun)
        chain.await_end()
        chain.call(SetBool, 'driver_node/enable', SetBool.Request(data=False))
    return output / RUN


class _Chain:
    """The demo's own node: calls services, follows the identifier's phase, watches processes."""

    def __init__(
        self,
        node: Node,
        executor: Executor,
        processes: dict[str, subprocess.Popen[bytes]],
        logs: Path,
        on_progress: Callable[[Progress], None],
    ) -> None:
        self._node, self._executor = node, executor
        self._processes, self._logs, self._on_progress = processes, logs, on_progress
        self._phase, self._message = '', ''
        node.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 50)

    def require_no_driver(self) -> None:
        """Refuse to go on where another driver hears the demo's commands."""
        end = time.monotonic() + 1.0
        while time.monotonic() < end:
            self._spin()
        if 'driver_node' in self._node.get_node_names():
            raise ActuatorError(
                f'a driver_node runs already in ROS domain {os.environ["ROS_DOMAIN_ID"]}: stop '
                'it, or start the demo again, which takes another domain'
            )

    def call(
        self,
        kind: Any,
        name: str,
        request: Any,
        patience: float = 60.0,
        *,
        done: Callable[[], bool] = lambda: False,
    ) -> None:
        """
        Call a service until it says yes: a node that is still starting says no.

        :param done: tells that it said yes by what it does, where its reply may be lost.
        """
        client: Client = self._node.create_client(kind, name)
        answer = 'it is not there'
        end = time.monotonic() + patience
        while time.monotonic() < end:
            if not client.service_is_ready():
                self._spin()
                continue
            future = client.call_async(request)
            # DDS loses a reply to a client that a busy node has not discovered yet.
            asked = time.monotonic()
            while not future.done() and time.monotonic() < min(end, asked + _REPLY_PATIENCE):
                self._spin()
            if done():
                return
            if not future.done():
                client.remove_pending_request(future)
                answer = 'no answer'
            else:
                response = future.result()
                if response.success:
                    return
                answer = response.message
            pause = time.monotonic() + 0.3
            while time.monotonic() < pause:
                self._spin()
        raise ActuatorError(f'{name} did not succeed within {patience:.0f} s: {answer}')

    def has_begun(self) -> bool:
        """Tell whether the identifier reports a run."""
        return self._phase not in ('', 'idle')

    def await_end(self) -> None:
        """Return when the identifier is done."""
        heard = time.monotonic()
        before = ''
        while self._phase != 'done':
            self._spin()
            if self._phase == 'failed':
                raise ActuatorError(f'the identification failed: {self._message}')
            if (state := f'{self._phase}{self._message}') != before:
                before, heard = state, time.monotonic()
            elif time.monotonic() - heard > 300.0:
                raise ActuatorError(f'the identifier is still {self._phase!r} after 300 s')

    def _spin(self) -> None:
        self._executor.spin_once(timeout_sec=0.1)
        for name, process in self._processes.items():
            if process.poll() is not None:
                raise ActuatorError(_last_words(name, process, self._logs / f'{name}.log'))

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name != 'identifier_node: run':
                continue
            values = {item.key: item.value for item in status.values}
            self._phase, self._message = values.get('phase', ''), status.message
            share = values.get('progress [%]')
            text = status.message if self._phase != 'idle' else 'waiting for the robot'
            self._on_progress(Progress(text, None if share is None else float(share) / 100.0))


@contextmanager
def _chain(
    processes: dict[str, subprocess.Popen[bytes]],
    logs: Path,
    on_progress: Callable[[Progress], None],
) -> Iterator[_Chain]:
    # Ctrl-C is this process's own to handle: rclpy's handler would only end the context.
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = Node('demo')
    try:
        executor = make_executor()
        executor.add_node(node)
        yield _Chain(node, executor, processes, logs, on_progress)
        executor.remove_node(node)
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


@contextmanager
def _process(name: str, arguments: list[str], log: Path) -> Iterator[subprocess.Popen[bytes]]:
    with log.open('wb') as stream:
        process = subprocess.Popen(
            [sys.executable, '-m', f'sosml_friction.nodes.{name}', *arguments],
            stdin=subprocess.DEVNULL,
            stdout=stream,
            stderr=subprocess.STDOUT,
            # A Ctrl-C is the demo's to handle: it ends the nodes in order, the driver first to go.
            start_new_session=True,
            preexec_fn=_prepare_child,
        )
        try:
            yield process
        finally:
            process.terminate()
            try:
                process.wait(timeout=10.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def _prepare_child() -> None:
    # A control loop beside other work keeps its rate better so; only root may, and it is no must.
    with suppress(OSError):
        os.nice(-10)
    # A demo that is killed must not leave the nodes behind: Linux then ends them.
    with suppress(OSError, AttributeError):
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)


@contextmanager
def _terminable() -> Iterator[None]:
    """Let SIGTERM end the demo as Ctrl-C does, with its nodes."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _prepare(output: Path) -> None:
    mine = (output / LOGS / 'emulator_node.log').exists()
    if not mine and any((output / name).exists() for name in (RUN, LOGS)):
        raise ConfigurationError(
            f'{output} has a {RUN} or {LOGS} that no demo made, so it is not overwritten: choose '
            'another place with --out'
        )
    try:
        for name in (RUN, LOGS):
            if (output / name).exists():
                shutil.rmtree(output / name)
        (output / LOGS).mkdir(parents=True)
    except OSError as error:
        raise ConfigurationError(
            f'the folder {output} cannot be written ({error.strerror}): give another with --out'
        ) from error


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(('127.0.0.1', 0))
        return int(probe.getsockname()[1])


def _await_port(port: int, process: subprocess.Popen[bytes], log: Path) -> None:
    end = time.monotonic() + 60.0
    while time.monotonic() < end:
        if process.poll() is not None:
            raise ActuatorError(_last_words('emulator_node', process, log))
        if f':{port}' in log.read_text(errors='replace'):
            return
        time.sleep(0.05)
    raise ActuatorError(
        'emulator_node does not listen after 60 s: see its log in the output folder'
    )


def _last_words(name: str, process: subprocess.Popen[bytes], log: Path) -> str:
    lines = [line for line in log.read_text(errors='replace').splitlines() if line.strip()]
    return f'{name} ended with exit code {process.returncode}: {lines[-1] if lines else "no word"}'
