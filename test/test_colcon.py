# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""`colcon build`: the workspace has what `ros2 run` and `ros2 launch` look for, and it runs."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
NOT_SOURCE = shutil.ignore_patterns(
    '.*', '__pycache__', 'build', 'install', 'log', 'dist', 'demo_output', '*.egg-info'
)
NODES = ('driver_node', 'emulator_node', 'identifier_node', 'observer_node', 'replay_node')


def run(*command, cwd):
    environment = {
        name: value for name, value in os.environ.items() if not name.startswith('COLCON_')
    }
    environment['COLCON_HOME'] = str(cwd / 'colcon_home')
    return subprocess.run(
        [str(word) for word in command],
        cwd=cwd,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
    )


@pytest.fixture(scope='module', params=[(), ('--symlink-install',)], ids=['copy', 'symlink'])
def workspace(request, tmp_path_factory):
    """Return a workspace in which a copy of the package is built."""
    folder = tmp_path_factory.mktemp('workspace')
    shutil.copytree(ROOT, folder / 'src' / 'sosml_friction', ignore=NOT_SOURCE)
    beside_python = Path(sys.executable).parent / 'colcon'
    colcon = beside_python if beside_python.exists() else shutil.which('colcon')
    assert colcon, "colcon is missing: pip install 'colcon-common-extensions'"
    built = run(colcon, 'build', *request.param, cwd=folder)
    assert built.returncode == 0, built.stdout + built.stderr
    return folder


def run_in(workspace, *command):
    """Run a command in a shell that has sourced the workspace."""
    line = '. install/local_setup.bash && exec "$@"'
    return run('bash', '-c', line, 'bash', *command, cwd=workspace)


@pytest.mark.parametrize('name', [*NODES, 'sosml'])
def test_executable_is_where_ros2_run_looks(workspace, name):
    executable = workspace / 'install' / 'sosml_friction' / 'lib' / 'sosml_friction' / name
    assert os.access(executable, os.X_OK)


def test_share_folder_has_the_data_of_the_source(workspace):
    share = workspace / 'install' / 'sosml_friction' / 'share'
    marker = share / 'ament_index' / 'resource_index' / 'packages' / 'sosml_friction'
    assert marker.is_file()
    for folder, pattern in (('config', '*'), ('urdf', '*'), ('launch', '*.launch.py')):
        files = [path for path in (ROOT / folder).rglob(pattern) if path.is_file()]
        assert files
        for path in files:
            if '__pycache__' not in path.parts:
                installed = share / 'sosml_friction' / path.relative_to(ROOT)
                assert installed.read_bytes() == path.read_bytes()
    assert (share / 'sosml_friction' / 'package.xml').is_file()


def test_code_and_data_are_those_of_the_workspace(workspace):
    program = (
        'import sosml_friction.share as s; print(s.__file__); print(s.share_directory().resolve())'
    )
    said = run_in(workspace, sys.executable, '-c', program)
    assert said.returncode == 0, said.stderr
    module, share = map(Path, said.stdout.splitlines())
    assert module.is_relative_to(workspace)
    assert share.is_relative_to(workspace)
    assert (share / 'config' / 'exoskeleton' / 'model.yaml').is_file()


def test_observer_node_runs_and_refuses_a_missing_model_in_one_sentence(workspace, tmp_path):
    executable = workspace / 'install' / 'sosml_friction' / 'lib' / 'sosml_friction'
    missing = tmp_path / 'nonexistent'
    said = run_in(workspace, executable / 'observer_node', '--ros-args', '-p', f'model:={missing}')
    assert said.returncode == 2, said.stderr
    lines = said.stderr.splitlines()
    assert len(lines) == 1, said.stderr
    assert str(missing) in lines[0]
