# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The emulator as a process, spoken to in slcan bytes."""

from __future__ import annotations

import math
import signal
import socket
import time

import pytest

pytest.importorskip('rclpy')

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.bus.open_bus import open_bus
from sosml_friction.actuators.rmd_x import codec as rmd_x
from sosml_friction.actuators.servo.dbc import Mode, ServoCommand, ServoDbc
from sosml_friction.share import share_directory

CONFIG = share_directory() / 'config'
PARAMETER_FILE = CONFIG / 'exoskeleton.yaml'
DBC = ServoDbc(CONFIG / 'elbow_servo.dbc')
PATIENCE = 60.0


@pytest.fixture
def port():
    with socket.socket() as probe:
        probe.bind(('127.0.0.1', 0))
        return int(probe.getsockname()[1])


def connect(port, node):
    # Knocking before anybody listens can make a socket connect to itself and take the port.
    while 'emulating' not in node.output:
        assert node.process.poll() is None, node.output
        time.sleep(0.05)
    return open_bus('slcan', f'socket://127.0.0.1:{port}', 1_000_000)


def ask(bus, frame):
    bus.send(frame.to_message())
    received = None
    while received is None:
        message = bus.recv(PATIENCE)
        assert message is not None, 'no reply'
        received = Frame.from_message(message)
    return received


def test_it_answers_over_tcp_client_after_client(start_node, port):
    node = start_node(
        'emulator_node',
        f'can_channel:=127.0.0.1:{port}',
        'servo_current_available:=false',
        # Between two clients more time passes than a motor waits: it would echo the first request.
        'timeout_echo:=false',
        files=(PARAMETER_FILE,),
    )
    for _ in range(2):
        bus = connect(port, node)
        _, version = rmd_x.decode_reply(ask(bus, rmd_x.encode_request(1, rmd_x.ReadVersion())))
        assert version.date == 20220206
        _, angle = rmd_x.decode_reply(ask(bus, rmd_x.encode_request(1, rmd_x.ReadAngle())))
        assert abs(angle.angle) <= 2 * rmd_x.ANGLE_RESOLUTION
        state = DBC.decode_state(ask(bus, DBC.encode_command(ServoCommand(Mode.OFF, 9))))
        assert state.sequence_echo == 9
        assert math.isnan(state.current)
        bus.shutdown()
    assert node.stop(signal.SIGTERM) == 0
    assert 'Traceback' not in node.output


@pytest.mark.parametrize(
    ('parameters', 'sentence'),
    [
        (['model:=/no/such/model'], 'model /no/such/model cannot be read'),
        (['can_channel:=127.0.0.1:99999'], 'cannot listen for slcan on 127.0.0.1:99999'),
        (['start_position:=[0.0]'], 'the start position 1 values'),
        (['latency:=-1.0'], 'latency'),
        (['joints:=[shoulder, wrist]'], 'wrist.driver'),
    ],
)
def test_a_bad_configuration_is_one_line_and_exit_code_two(refusal, parameters, sentence):
    (line,) = refusal('emulator_node', *parameters, files=(PARAMETER_FILE,))
    assert sentence in line
