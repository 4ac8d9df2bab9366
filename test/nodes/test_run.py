# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A node as a program: signals, exit codes, one line on stderr; each in a real process."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest

pytest.importorskip('rclpy')

PROGRAM = """
import sys
from rclpy.node import Node
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.nodes.run import run_node


class Example(Node):
    def __init__(self):
        super().__init__('example')
        self.create_timer(0.01, self.tick)
        self.ticks = 0

    def tick(self):
        self.ticks += 1
        if self.ticks == 5:
            print('spinning', flush=True)
            {tick}

    def destroy_node(self):
        assert self.context.ok()
        # What still comes is for no node that is gone.
        assert self.executor is None or self not in self.executor.get_nodes()
        print('destroyed', flush=True)
        super().destroy_node()


def factory():
    {factory}
    return Example()


sys.exit(run_node(factory, {args}))
"""


@pytest.fixture
def start():
    processes = []

    def begin(tick='pass', factory='pass', args='None'):
        environment = dict(
            os.environ, ROS_DOMAIN_ID='91', ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST'
        )
        process = subprocess.Popen(
            [sys.executable, '-c', PROGRAM.format(tick=tick, factory=factory, args=args)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=environment,
        )
        processes.append(process)
        return process

    yield begin
    for process in processes:
        if process.poll() is None:
            process.kill()
        process.communicate()


def finish(process):
    out, err = process.communicate(timeout=300)
    return process.returncode, out.split(), err


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_in_a_clean_zero_with_the_context_still_valid(start, number):
    process = start()
    assert process.stdout.readline().strip() == 'spinning'
    process.send_signal(number)
    code, out, err = finish(process)
    assert (code, out, err) == (0, ['destroyed'], '')


def test_an_error_of_the_package_in_a_callback_is_one_sentence_and_two(start):
    code, out, err = finish(start(tick="raise ConfigurationError('the gain is missing')"))
    assert (code, out) == (2, ['spinning', 'destroyed'])
    # The executor has its say before it lets the exception through.
    assert err.splitlines()[-1] == 'the gain is missing'
    assert 'Traceback' not in err


def test_an_error_of_the_package_in_the_factory_is_one_sentence_and_two(start):
    code, out, err = finish(start(factory="raise ConfigurationError('no\\nURDF')"))
    assert (code, out, err) == (2, [], 'no URDF\n')


def test_a_signal_ends_a_factory_that_waits_without_a_word(start):
    waits = (
        "print('waiting', flush=True)\n"
        '    while not run.stop_requested():\n'
        '        time.sleep(0.01)\n'
        "    raise ConfigurationError('no bus')"
    )
    process = start(factory=f'import time; from sosml_friction.nodes import run\n    {waits}')
    assert process.stdout.readline().strip() == 'waiting'
    process.send_signal(signal.SIGINT)
    assert finish(process) == (0, [], '')


def test_a_callback_may_end_the_program(start):
    assert finish(start(tick='raise SystemExit'))[:2] == (0, ['spinning', 'destroyed'])
    assert finish(start(tick='raise SystemExit(1)'))[:2] == (1, ['spinning', 'destroyed'])


def test_ros_arguments_that_cannot_be_read_are_one_sentence_and_two(start):
    code, out, err = finish(start(args="['--ros-args', '--params-file', '/no/such/file.yaml']"))
    assert (code, out) == (2, [])
    # rcl may say a line of its own first.
    assert err.splitlines()[-1].startswith('ROS arguments cannot be read: ')
    assert '/no/such/file.yaml' in err.splitlines()[-1]
    assert 'Traceback' not in err
