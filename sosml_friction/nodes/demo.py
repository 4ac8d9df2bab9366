# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The whole chain on emulated hardware, each node a process of its own, over CAN bytes and DDS."""

import os
import shutil
import signal
import socket
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from std_srvs.srv import SetBool, Trigger

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.bag_analysis import analyse_bag
from sosml_friction.model.model_folder import read_model
from sosml_friction.nodes.demo_client import DemoClient
from sosml_friction.nodes.node_process import NodeProcess
from sosml_friction.nodes.run import plain_node
from sosml_friction.report.common.output import check_output_folder, to_json
from sosml_friction.report.common.progress import Step, progress
from sosml_friction.report.common.table import print_table
from sosml_friction.report.common.tables import parameter_table
from sosml_friction.report.fit.results import KIND, fit_document, write_results
from sosml_friction.share import share_directory

#: What the chain writes into the demo's folder, and so may replace.
RUN = 'run'
LOGS = 'logs'

# A busy machine may keep a process from running for longer than a real joint may go without a
# command, or each answer for longer than it may take. Nobody wears the emulated one, so its
# watchdogs and the driver wait for two seconds, the most there is, and a joint may be left behind
# by its reference meanwhile.
PATIENT_HARDWARE = ('comm_timeout:=2.0', 'servo_watchdog:=2.0')
PATIENT_DRIVER = (
    'missed_limit:=1000',
    'reply_timeout:=0.1',
    'shoulder.tracking_limit:=3.0',
    'elbow.tracking_limit:=3.0',
)


# The gap that an idle machine has: where it followed the rate of a busy one, the observers would
# have another configuration in the middle of a run.
_STATED_GAP = ('maximum_gap:=0.05',)


def run_demo(output: Path, seed: int = 0, json: bool = False) -> int:
    """
    Identify the emulated exoskeleton, print the table and write the report; return the exit code.

    ``output`` gets ``report.html``, ``fit.json`` and the model (``model.yaml``, ``robot.urdf``),
    the bag in ``run/bag`` and what the nodes said in ``logs``. With ``json`` the object of ``sosml
    fit --json`` is printed. The code is 1 if a joint could not be fitted.

    :raises ConfigurationError: if ``output`` holds something else or cannot be written.
    :raises ActuatorError: if a node ends or does not answer.
    """
    check_output_folder(output, KIND, (RUN, LOGS))
    truth = read_model(share_directory() / 'config' / 'emulated_exoskeleton')
    with progress('the demonstration: about a minute and a half') as bar:
        shown = ''

        def step(what: str, share: float | None = None) -> None:
            nonlocal shown
            if what != shown and not json and not sys.stderr.isatty():
                print(what, file=sys.stderr, flush=True)
            shown = what
            bar(what, share)

        # An interrupted demo must not leave an old report beside a new recording.
        for name in KIND.files:
            (output / name).unlink(missing_ok=True)
        run = run_chain(output, seed, step)
        step('drawing the report')
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
    step: Step = lambda what, share=None: None,
    plateau: float | None = None,
) -> Path:
    """
    Run emulator, driver, observers and identifier through T1 and return the run's folder.

    The nodes' own messages go to ``output/logs``; what an earlier demo left there is replaced. The
    DDS domain is this process's own and confined to this machine, whatever ROS_DOMAIN_ID says.

    :param step: called with the phase in words and, while the robot moves, the share done.
    :param plateau: length of a plateau [s], None for T1's.
    :raises ActuatorError: if a node ends or does not answer; the sentence quotes its last words.
    :raises ConfigurationError: if ``output`` cannot be written.
    """
    _prepare(output)
    # Never the domain the user's shell names: a real robot may be on it, and it would move.
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    os.environ['ROS_DOMAIN_ID'] = str(1 + os.getpid() % 100)
    port = _free_port()
    identifier = [f'output:={output.resolve()}', f'run_name:={RUN}']
    if plateau is not None:
        identifier.append(f'plateau:={float(plateau)}')
    nodes = {
        'emulator_node': [f'can_channel:=127.0.0.1:{port}', f'seed:={seed}', *PATIENT_HARDWARE],
        'driver_node': [
            f'can_channel:=socket://127.0.0.1:{port}',
            'host_timeout:=10.0',
            *PATIENT_DRIVER,
        ],
        'observer_node': [*_STATED_GAP],
        'identifier_node': identifier,
    }
    file = share_directory() / 'config' / 'exoskeleton.yaml'
    with ExitStack() as stack:
        stack.enter_context(_terminable())
        processes: list[NodeProcess] = []
        node, executor = stack.enter_context(plain_node('demo'))
        client = DemoClient(node, executor, processes, step)
        client.require_no_driver()
        step('starting the emulated exoskeleton')
        for name, parameters in nodes.items():
            process = NodeProcess(name, file, parameters, output / LOGS / f'{name}.log')
            processes.append(stack.enter_context(process))
            if name == 'emulator_node':
                process.await_words(f':{port}', 'listen')
                step('starting driver, observers and identifier')
        client.call(SetBool, 'driver_node/enable', SetBool.Request(data=True))
        client.call(Trigger, 'identifier_node/start', Trigger.Request(), client.has_begun)
        client.await_end()
        client.call(SetBool, 'driver_node/enable', SetBool.Request(data=False))
    return output / RUN


@contextmanager
def _terminable() -> Iterator[None]:
    """Let SIGTERM end the demo as Ctrl-C does, with its nodes."""
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
