# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Tests on two workers: what runs in real time stays together, and no worker disturbs another."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip('xdist')

ROOT = Path(__file__).resolve().parents[1]
NODES = ('nodes/test_one', 'nodes/test_two')
OTHERS = ('bags/test_first', 'report/test_last')
PROGRAM = """
import json, os, pathlib

def test_tells():
    pathlib.Path({told!r}).write_text(json.dumps({{
        'worker': os.environ['PYTEST_XDIST_WORKER'],
        'domain': int(os.environ['ROS_DOMAIN_ID']),
        'niceness': os.getpriority(os.PRIO_PROCESS, 0),
    }}))
"""


@pytest.fixture(scope='module')
def told(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, object]]:
    """Return what each of four tests saw of its worker."""
    folder = tmp_path_factory.mktemp('workers')
    (folder / 'sosml_friction').symlink_to(ROOT / 'sosml_friction')
    shutil.copy(ROOT / 'setup.cfg', folder)
    for name in (*NODES, *OTHERS):
        path = folder / 'test' / f'{name}.py'
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(PROGRAM.format(told=str(folder / f'{path.stem}.json')))
    shutil.copy(ROOT / 'test' / 'conftest.py', folder / 'test')
    environment = {
        name: value for name, value in os.environ.items() if not name.startswith('PYTEST_')
    }
    # As where ROS 2 is sourced.
    environment |= {'PYTEST_DISABLE_PLUGIN_AUTOLOAD': '1', 'ROS_DOMAIN_ID': '101'}
    command = ['pytest', '-q', '-p', 'no:cacheprovider', '-p', 'xdist', '-n', '2']
    ran = subprocess.run(
        [
            sys.executable,
            '-m',
            *command,
            '--dist',
            'loadfile',
            f'--basetemp={folder / "basetemp"}',
        ],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    return {
        name: json.loads((folder / f'{Path(name).name}.json').read_text())
        for name in (*NODES, *OTHERS)
    }


def test_all_node_tests_are_one_worker_s_and_others_run_meanwhile(told):
    ours = {told[name]['worker'] for name in NODES}
    theirs = {told[name]['worker'] for name in OTHERS}
    assert len(ours) == 1
    assert theirs - ours


def test_node_tests_go_before_others_where_both_want_a_core(told):
    """By niceness; a worker that began with node tests cannot have been put behind already."""
    assert {told[name]['niceness'] for name in NODES} == {os.getpriority(os.PRIO_PROCESS, 0)}
    for name in OTHERS:
        assert told[name]['niceness'] == min(os.getpriority(os.PRIO_PROCESS, 0) + 5, 19)


def test_each_worker_has_a_domain_of_its_own(told):
    domains = {row['worker']: row['domain'] for row in told.values()}
    assert set(domains) == {'gw0', 'gw1'}
    assert domains['gw0'] == 101
    assert 1 <= domains['gw1'] < 101
