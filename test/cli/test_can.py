# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""``sosml can`` on emulated actuators behind slcan over TCP, judged by what they were sent."""

from __future__ import annotations

import json
import time
from pathlib import Path

import jsonschema
import pytest
from lockstep import emulated_exoskeleton

from sosml_friction.actuators.bus import can_check
from sosml_friction.actuators.bus import open_bus as bus_opening
from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.bus.open_bus import open_bus
from sosml_friction.actuators.bus.slcan_server import SlcanServerBus
from sosml_friction.actuators.emulator.emulator_thread import EmulatorThread
from sosml_friction.actuators.emulator.options import EmulatorOptions
from sosml_friction.actuators.rmd_x import codec as rmd_x
from sosml_friction.cli.main import main
from sosml_friction.share import share_directory

CONFIG = share_directory() / 'config' / 'exoskeleton.yaml'
SCHEMAS = Path(__file__).resolve().parents[2] / 'docs' / 'schema'
# An answer ends the wait; a busy machine may take its time with it.
PATIENT = ('--wait', '60')
# Questions; and B3 must not be among them: it is written to ROM.
READ_ONLY = {0x92, 0x9A, 0xB1, 0xB2, 0xB5, 0x60, 0x9C}


class Hardware:
    """Emulated actuators on a TCP port, and every frame they were sent."""

    def __init__(self, **options) -> None:
        self.emulator = emulated_exoskeleton(options=EmulatorOptions(**options))
        self.seen: list[Frame] = []
        handle = self.emulator.handle

        def noted(frame, t_ns):
            self.seen.append(frame)
            return handle(frame, t_ns)

        self.emulator.handle = noted
        self.server = SlcanServerBus('127.0.0.1:0')
        self.thread = EmulatorThread(self.server, self.emulator)
        self.thread.start()

    @property
    def bus(self) -> list[str]:
        return ['--interface', 'slcan', '--channel', f'socket://127.0.0.1:{self.server.port}']

    def close(self) -> None:
        self.thread.stop()
        self.server.shutdown()
        assert self.thread.error is None

    def assert_never_commanded(self) -> None:
        assert {f.data[0] for f in self.seen if 0x141 <= f.can_id <= 0x160} <= READ_ONLY
        assert {f.data[0] for f in self.seen if f.can_id == 0x170} <= {0}
        assert all(0x141 <= f.can_id <= 0x160 or f.can_id == 0x170 for f in self.seen)


@pytest.fixture
def hardware():
    made: list[Hardware] = []

    def make(**options) -> Hardware:
        made.append(Hardware(**options))
        return made[-1]

    yield make
    for one in made:
        one.close()


def run(capsys, *arguments: str) -> tuple[int, str, str]:
    code = main(['can', *arguments])
    out, err = capsys.readouterr()
    return code, out, err


def document(name: str, text: str) -> dict:
    result = json.loads(text)
    schema = json.loads((SCHEMAS / f'can_{name}.schema.json').read_text())
    jsonschema.validate(result, schema, cls=jsonschema.Draft202012Validator)
    return result


# ---- scan


def test_scan_lists_motor_and_bridge_and_commands_nothing(hardware, capsys):
    machine = hardware()
    code, out, err = run(
        capsys, 'scan', *machine.bus, *PATIENT, '--config', str(CONFIG), '--ids', '1', '--json'
    )
    assert (code, err) == (0, '')
    motor, bridge = document('scan', out)['actuators']
    assert motor == {
        'can_id': 0x141,
        'kind': 'rmd_x',
        'motor_id': 1,
        'model': 'X6-8',
        'version': 20220206,
        'voltage': 48.0,
        'temperature': 25.0,
        'errors': 'none',
        'remarks': [],
    }
    assert (bridge['kind'], bridge['can_id'], bridge['version']) == ('servo_dbc', 0x170, None)
    machine.assert_never_commanded()


def test_scan_asks_every_id_there_is(hardware, capsys):
    machine = hardware()
    run(capsys, 'scan', *machine.bus, '--wait', '0.01')
    end = time.monotonic() + 60.0
    while {frame.can_id for frame in machine.seen} != set(range(0x141, 0x161)):
        assert time.monotonic() < end
        time.sleep(0.01)
    machine.assert_never_commanded()


def test_scan_prints_a_table(hardware, capsys):
    machine = hardware(rmd_firmware=2026042402, rmd_model='X6-P20-60-E')
    machine.thread.set_faults('error_bits joint=shoulder bits=0x12')
    code, out, _ = run(capsys, 'scan', *machine.bus, *PATIENT, '--ids', '1')
    assert code == 0
    for text in ('1 (0x141)', 'rmd_x', 'X6-P20-60-E', '2026042402', '48.0', 'stall, over_current'):
        assert text in out
    assert 'servo' not in out
    machine.assert_never_commanded()


def test_scan_says_that_a_timeout_had_tripped(hardware, capsys):
    machine = hardware()
    for _ in range(2):
        code, out, _ = run(capsys, 'scan', *machine.bus, *PATIENT, '--ids', '1', '--json')
    (motor,) = document('scan', out)['actuators']
    assert motor['version'] == 20220206
    assert motor['remarks'] == ['its communication timeout had tripped']
    assert code == 0


def test_scan_says_that_two_motors_may_share_an_id(hardware, capsys):
    machine = hardware()
    machine.thread.set_faults('duplicate direction=replies')
    _, out, _ = run(capsys, 'scan', *machine.bus, *PATIENT, '--ids', '1', '--json')
    (motor,) = document('scan', out)['actuators']
    assert 'two motors may share id 1' in motor['remarks'][0]


def test_scan_of_an_empty_bus_is_exit_code_one(hardware, capsys):
    machine = hardware()
    machine.thread.set_faults('bus_off')
    code, out, err = run(capsys, 'scan', *machine.bus, '--ids', '1-2', '--json')
    assert code == 1
    assert document('scan', out)['actuators'] == []
    assert 'nobody answers' in err
    assert len(err.splitlines()) == 1


class AnotherHost:
    """A host whose frame is on the bus as soon as the command has opened it, and what it hears."""

    def __init__(self, monkeypatch, channel: str, frame: Frame) -> None:
        self.arguments = ('--interface', 'virtual', '--channel', channel)
        self.message = frame.to_message()
        self._own = open_bus('virtual', channel, 1_000_000)
        self._heard = open_bus('virtual', channel, 1_000_000)

        def opened(*name):
            bus = open_bus(*name)
            self._own.send(self.message)
            return bus

        monkeypatch.setattr(bus_opening, 'open_bus', opened)
        monkeypatch.setattr(can_check, 'open_bus', opened)

    def assert_alone(self) -> None:
        """Nothing but its own frame was on the bus."""
        heard = []
        while (message := self._heard.recv(0.0)) is not None:
            heard.append((message.arbitration_id, bytes(message.data)))
        assert heard == [(self.message.arbitration_id, bytes(self.message.data))]

    def close(self) -> None:
        self._own.shutdown()
        self._heard.shutdown()


@pytest.fixture
def another_host(monkeypatch):
    hosts = []

    def make(channel: str, frame: Frame) -> AnotherHost:
        hosts.append(AnotherHost(monkeypatch, channel, frame))
        return hosts[-1]

    yield make
    for host in hosts:
        host.close()


def test_scan_asks_nothing_where_another_host_talks(another_host, capsys):
    other = another_host('sosml_test_company', Frame(0x141, bytes([0x92] + 7 * [0])))
    code, out, err = run(capsys, 'scan', *other.arguments)
    assert (code, out) == (2, '')
    assert 'another host is talking' in err
    other.assert_alone()


# ---- check


def verdicts(checks: list[dict]) -> dict[tuple[str, str], str]:
    return {(own['joint'], own['step']): own['verdict'] for own in checks}


def test_check_asks_nothing_where_another_host_drives(another_host, capsys):
    """Its question to a servo's bridge is a command off."""
    other = another_host('sosml_test_driven', rmd_x.encode_request(1, rmd_x.SetCurrent(0.5)))
    code, out, err = run(capsys, 'check', *other.arguments)
    assert (code, out) == (2, '')
    assert 'another host commands these actuators' in err
    other.assert_alone()


def test_check_passes_good_hardware_and_commands_nothing(hardware, capsys):
    machine = hardware()
    code, out, err = run(capsys, 'check', *machine.bus, '--json')
    assert (code, err) == (0, '')
    result = document('check', out)
    assert result['ready']
    found = verdicts(result['checks'])
    assert set(found.values()) == {'ok'}
    assert {step for joint, step in found if joint == 'shoulder'} >= {
        'version',
        'model',
        'status',
        'position',
        'watchdog',
    }
    assert ('bus', 'load') in found
    assert ('elbow', 'position') in found
    machine.assert_never_commanded()


def test_check_warns_that_a_motor_without_timeout_would_not_stop(hardware, capsys):
    """0xB3 = 0, the factory's setting: found by its silence, as it cannot be read."""
    machine = hardware(comm_timeout=0.0)
    code, out, _ = run(capsys, 'check', *machine.bus, '--json')
    result = document('check', out)
    (watchdog,) = (own for own in result['checks'] if own['step'] == 'watchdog')
    assert watchdog['verdict'] == 'warning'
    assert 'if this program is killed' in watchdog['why']
    assert code == 0
    assert result['ready']
    machine.assert_never_commanded()


def test_check_says_what_speaks_against_enabling(hardware, capsys):
    machine = hardware()
    machine.thread.set_faults('error_bits joint=shoulder bits=0x12; silent joint=elbow')
    code, out, err = run(capsys, 'check', *machine.bus)
    assert code == 1
    assert err == ''
    words = ' '.join(out.split())
    assert 'stall, over_current' in words
    assert 'no answer' in words
    assert 'speak against enabling' in words
    machine.assert_never_commanded()


def test_check_of_a_cycle_that_does_not_fit_shows_the_arithmetic(hardware, capsys):
    machine = hardware()
    code, out, _ = run(capsys, 'check', *machine.bus, '--bitrate', '250000', '--json')
    (load,) = (own for own in document('check', out)['checks'] if own['step'] == 'load')
    assert code == 1
    assert load['verdict'] == 'problem'
    assert '250000 bit/s' in load['found']


# ---- refusals


@pytest.mark.parametrize(
    ('arguments', 'sentence'),
    [
        (['scan'], 'which bus is not said'),
        (['scan', '--interface', 'slcan'], 'which bus is not said'),
        (['scan', '--interface', 'no_such', '--channel', 'x'], "'no_such' cannot be used"),
        (['scan', '--interface', 'slcan', '--channel', 'socket://127.0.0.1:1'], 'cannot be open'),
        (['scan', '--interface', 'virtual', '--channel', 'x', '--ids', '0-3'], '1 to 32'),
        (['scan', '--interface', 'virtual', '--channel', 'x', '--bitrate', '5'], 'bit rate is 5'),
        (['scan', '--interface', 'virtual', '--channel', 'x', '--wait', '0'], 'the wait is 0'),
        (['scan', '--config', '/no/such.yaml'], '/no/such.yaml cannot be read'),
        (['scan', '--interface', 'virtual', '--channel', 'x', '--dbc', '/no.dbc'], '/no.dbc'),
        (['check', '--config', '/no/such.yaml'], '/no/such.yaml cannot be read'),
        (['check', '--interface', 'virtual', '--channel', 'x', '--bitrate', '9'], 'bit rate is 9'),
        (['frobnicate'], 'see sosml can --help'),
    ],
)
def test_bad_input_is_one_sentence_and_exit_code_two(capsys, arguments, sentence):
    code, out, err = run(capsys, *arguments)
    assert (code, out) == (2, '')
    assert len(err.splitlines()) == 1
    assert sentence in err


@pytest.mark.parametrize('command', ['scan', 'check'])
def test_help_has_an_example(capsys, command):
    code, out, _ = run(capsys, command, '--help')
    assert code == 0
    assert f'Example: sosml can {command}' in out
