# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is missing on a machine is said, with what to do about it."""

import json
import resource
from pathlib import Path

import jsonschema
import pytest

from sosml_friction.report.plan import machine
from sosml_friction.report.plan.machine import GOOD, MISSING, OPTIONAL

ROOT = Path(__file__).resolve().parents[2]


def of(name):
    return next(one for one in machine.examine() if one.name == name)


def test_this_machine_has_what_the_tests_need(sosml):
    code, out, err = sosml('doctor', '--json')
    assert (code, err) == (0, '')
    document = json.loads(out)
    schema = json.loads((ROOT / 'docs' / 'schema' / 'doctor.schema.json').read_text())
    jsonschema.validate(document, schema)
    assert document['ready']
    assert sosml('doctor')[1].count('good') >= 4


def test_whatever_is_not_there_comes_with_what_to_do():
    for one in machine.examine():
        assert bool(one.advice) == (one.verdict != GOOD), one.name


def test_a_library_that_every_command_needs_makes_it_1(sosml, monkeypatch):
    monkeypatch.setattr(machine, '_NEEDED', ('numpy', 'no_such_library'))
    found = of('libraries')
    assert found.verdict == MISSING
    assert 'no_such_library' in found.advice
    code, out, _ = sosml('doctor')
    assert code == 1
    assert 'needed by every command: libraries' in out


@pytest.mark.parametrize('state', ['up', 'down'])
def test_a_can_interface_is_found_and_one_that_is_down_is_brought_up(tmp_path, monkeypatch, state):
    for name, kind in (('can0', '280'), ('lo', '772')):
        (tmp_path / name).mkdir()
        (tmp_path / name / 'type').write_text(f'{kind}\n')
        (tmp_path / name / 'operstate').write_text(f'{state}\n')
    monkeypatch.setattr(machine, '_NET', tmp_path)
    found = of('CAN')
    assert found.found == f'can0 ({state})'
    assert ('ip link set can0 up' in found.advice) == (state == 'down')


def test_a_cache_that_cannot_be_written_is_told(monkeypatch, tmp_path):
    monkeypatch.setenv('NUMBA_CACHE_DIR', str(tmp_path / 'not_there'))
    assert of('cache').verdict == OPTIONAL
    assert 'NUMBA_CACHE_DIR' in of('cache').advice


def test_a_user_without_the_permission_is_told_how_to_get_it(monkeypatch):
    monkeypatch.setattr(machine.os, 'geteuid', lambda: 1000)
    monkeypatch.setattr(resource, 'getrlimit', lambda which: (0, 0))
    assert 'rtprio' in of('real time').advice
