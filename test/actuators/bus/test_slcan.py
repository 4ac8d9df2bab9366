# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""slcan over TCP: python-can's interface on one end, the emulated adapter on the other."""

from __future__ import annotations

import fcntl
import socket
import termios
import threading
import time
from array import array

import can
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sosml_friction.actuators.bus.open_bus import open_bus
from sosml_friction.actuators.bus.slcan_client import SlcanClient
from sosml_friction.actuators.bus.slcan_lines import SlcanLines
from sosml_friction.actuators.bus.slcan_server import SlcanServerBus
from sosml_friction.exceptions import ActuatorError, ConfigurationError

PATIENCE = 30.0


@pytest.fixture
def server():
    bus = SlcanServerBus('127.0.0.1:0')
    yield bus
    bus.shutdown()


def connect(server):
    """Open the driver's end and let the server take the connection."""
    client = open_bus('slcan', f'socket://127.0.0.1:{server.port}', 1_000_000)
    probe = can.Message(arbitration_id=0x7FF, data=b'', is_extended_id=False)
    client.send(probe)
    assert server.recv(PATIENCE).arbitration_id == 0x7FF
    assert server.connected
    return client


def arrive(server, client, lines):
    """Send lines and a frame behind them, and wait until all of it can be read at once."""
    server._client.sendall(lines)
    # The frame is t, 3 digits, the length, 16 digits and the end, behind what was to be answered.
    there, count = array('i', [0]), len(lines) + len(server._answers) + 22
    server.send(MESSAGES[0])
    end = time.monotonic() + 2.0 * PATIENCE
    while there[0] < count:
        assert time.monotonic() < end
        fcntl.ioctl(client.serialPortOrig.fileno(), termios.FIONREAD, there)


def received(bus):
    """Return the next frame, however long the server takes to send it."""
    end = time.monotonic() + 2.0 * PATIENCE
    while (message := bus.recv(PATIENCE)) is None:
        assert time.monotonic() < end
    return message


def read_on(bus):
    """Receive until that is an error."""
    end = time.monotonic() + 2.0 * PATIENCE
    while time.monotonic() < end:
        bus.recv(PATIENCE)


def same(a, b):
    return (a.arbitration_id, a.is_extended_id, a.dlc, bytes(a.data)) == (
        b.arbitration_id,
        b.is_extended_id,
        b.dlc,
        bytes(b.data),
    )


MESSAGES = [
    can.Message(arbitration_id=0x141, data=bytes(range(8)), is_extended_id=False),
    can.Message(arbitration_id=0x000, data=b'', is_extended_id=False),
    can.Message(arbitration_id=0x7FF, data=b'\xff' * 8, is_extended_id=False),
    can.Message(arbitration_id=0x1FFFFFFF, data=b'\x0d\x07', is_extended_id=True),
]


def test_frames_pass_both_ways_in_order(server):
    client = connect(server)
    for sender, receiver in ((client, server), (server, client)):
        for message in MESSAGES * 20:
            sender.send(message)
        for message in MESSAGES * 20:
            assert same(receiver.recv(PATIENCE), message)
    client.shutdown()


def test_waiting_for_nothing_returns_nothing(server):
    client = connect(server)
    assert client.recv(0.0) is None
    assert client.recv(0.01) is None
    assert server.recv(0.0) is None
    client.shutdown()


@pytest.mark.parametrize('interface', ['ours', "python-can's own"])
def test_the_next_client_is_accepted_when_one_goes(server, interface):
    for number in range(3):
        if interface == 'ours':
            client = connect(server)
        else:
            client = can.Bus(
                interface='slcan',
                channel=f'socket://127.0.0.1:{server.port}',
                bitrate=1_000_000,
                sleep_after_open=0.0,
            )
        message = can.Message(arbitration_id=0x100 + number, data=b'1', is_extended_id=False)
        client.send(message)
        assert same(server.recv(PATIENCE), message)
        server.send(message)
        assert same(received(client), message)
        client.shutdown()
        assert server.recv(0.2) is None
        assert not server.connected


def test_what_is_sent_while_nobody_listens_is_dropped(server):
    server.send(MESSAGES[0])
    client = connect(server)
    assert client.recv(0.05) is None
    client.shutdown()


def test_commands_are_answered_and_garbage_gets_a_bell(server):
    with socket.create_connection(('127.0.0.1', server.port)) as raw:
        raw.settimeout(PATIENCE)
        raw.sendall(b'\rC\rS8\rV\rF\rN\rO\rt14\rtXYZ0\rt1418FF\rt9001AB\rt10010A\r')
        message = server.recv(PATIENCE)
        assert (message.arbitration_id, bytes(message.data)) == (0x100, b'\x0a')
        assert server.recv(0.05) is None
        answer = b''
        while not answer.endswith(b'z\r'):
            answer += raw.recv(100)
        assert answer == b'\r\rV1013\rF00\rNEMUL\r\r\a\a\a\az\r'
    assert server.malformed == 4


def test_a_malformed_line_is_skipped_and_counted_by_the_client(server):
    client = connect(server)
    for line in (b't14', b'tXYZ8', b't1418ZZ', b'\xff\xfe', b'T'):
        server._write(line + b'\r')
    server.send(MESSAGES[0])
    assert same(received(client), MESSAGES[0])
    assert client.malformed >= 3
    client.shutdown()


def test_a_wait_of_nothing_sees_the_frame_behind_acknowledgements_and_garbage(server):
    """Else a driver that empties the buffer before it asks takes an old answer for the new one."""
    client = connect(server)
    arrive(server, client, b'z\rZ\r\rtXYZ8\rz\r')
    assert same(client.recv(0.0), MESSAGES[0])
    assert client.recv(0.0) is None
    client.shutdown()


def test_a_flood_of_acknowledgements_does_not_keep_a_wait_of_nothing(server):
    client = connect(server)
    arrive(server, client, b'z\r' * 600)
    waits = [client.recv(0.0) for _ in range(3)]
    assert waits[:2] == [None, None]
    assert same(waits[2], MESSAGES[0])
    client.shutdown()


def test_a_server_that_goes_away_is_an_error_not_a_silence(server):
    client = connect(server)
    server._drop_client()

    with pytest.raises(can.CanOperationError):
        read_on(client)
    client.shutdown()


@given(st.binary(max_size=200), st.integers(1, 50))
def test_lines_do_not_depend_on_how_the_stream_is_cut(data, size):
    whole, cut = SlcanLines(), SlcanLines()
    whole.feed(data)
    for i in range(0, len(data), size):
        cut.feed(data[i : i + size])

    def lines(source):
        return list(iter(source.pop, None))

    assert lines(whole) == lines(cut)


def test_lines_without_an_end_do_not_grow():
    lines = SlcanLines()
    for _ in range(100):
        lines.feed(b'x' * 4096)
    assert len(lines._rest) <= 4096


# ---- opening


@pytest.mark.parametrize(
    ('interface', 'channel', 'kind'),
    [
        ('no_such_interface', 'x', ConfigurationError),
        ('slcan', 'socket://127.0.0.1:1', ActuatorError),
        ('slcan', 'no://such', ActuatorError),
        ('slcan', '', ActuatorError),
        ('socketcan', 'no_such_can0', ActuatorError),
        ('slcan_server', '127.0.0.1:notaport', ActuatorError),
        ('slcan_server', '127.0.0.1:99999', ActuatorError),
    ],
)
def test_a_bus_that_cannot_be_opened_is_one_sentence(interface, channel, kind):
    with pytest.raises(kind) as caught:
        open_bus(interface, channel, 1_000_000)
    assert interface in str(caught.value)
    assert '\n' not in str(caught.value)


def test_a_port_that_is_taken_is_one_sentence(server):
    with pytest.raises(ActuatorError, match=str(server.port)):
        open_bus('slcan_server', f'127.0.0.1:{server.port}', 1_000_000)


def test_the_virtual_interface_opens():
    a, b = (open_bus('virtual', 'sosml_friction_test', 1_000_000) for _ in range(2))
    a.send(MESSAGES[0])
    assert same(b.recv(PATIENCE), MESSAGES[0])
    a.shutdown()
    b.shutdown()


def test_the_server_survives_a_client_that_reads_nothing_and_vanishes(server):
    client = connect(server)
    thread = threading.Thread(target=client.shutdown)
    thread.start()
    thread.join()
    for _ in range(100):
        server.send(MESSAGES[0])
    connect(server).shutdown()


# ---- a terminal in place of a port


def test_frames_pass_both_ways_over_a_terminal_and_its_link_goes_at_the_end(tmp_path):
    path = tmp_path / 'ttyCAN'
    server = open_bus('slcan_server', f'pty:{path}', 1_000_000)
    for _ in range(2):
        client = SlcanClient(channel=str(path), bitrate=1_000_000, sleep_after_open=0.0)
        for sender, receiver in ((client, server), (server, client)):
            for message in MESSAGES * 20:
                sender.send(message)
                assert same(received(receiver), message)
        client.shutdown()
        assert server.recv(0.1) is None
        assert not server.connected
    server.shutdown()
    assert not path.is_symlink()


def test_a_terminal_that_is_unplugged_is_an_error_and_comes_back(tmp_path):
    path = tmp_path / 'ttyCAN'
    server = open_bus('slcan_server', f'pty:{path}', 1_000_000)
    client = SlcanClient(channel=str(path), bitrate=1_000_000, sleep_after_open=0.0)
    server.fault = 'adapter_gone'
    assert server.recv(0.0) is None
    assert not path.is_symlink()

    with pytest.raises(can.CanOperationError):
        read_on(client)
    client.shutdown()
    server.fault = ''
    assert server.recv(0.0) is None
    assert path.is_symlink()
    server.shutdown()


def test_a_terminal_does_not_replace_a_file(tmp_path):
    path = tmp_path / 'precious'
    path.write_text('x')
    with pytest.raises(ActuatorError, match='cannot make the terminal'):
        open_bus('slcan_server', f'pty:{path}', 1_000_000)
    assert path.read_text() == 'x'
