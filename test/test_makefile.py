# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""make install: the right interpreter, one sentence where there is none, no installation twice."""

import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


def run_make(*args, cwd, path, **environment):
    """Run make on a copy of the Makefile with nothing but these programs on PATH."""
    return subprocess.run(
        ['make', *args],
        cwd=cwd,
        env={'PATH': str(path), **environment},
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )


@pytest.fixture
def bare_machine(tmp_path):
    """Return a copy of what make needs, and a PATH on which there is no Python yet."""
    for name in ('Makefile', 'setup.py', 'setup.cfg', 'pyproject.toml', 'package.xml'):
        (tmp_path / name).write_bytes((ROOT / name).read_bytes())
    programs = tmp_path / 'bin'
    programs.mkdir()
    for name in ('make', 'sh', 'cat', 'rm', 'touch'):
        found = subprocess.run(['which', name], capture_output=True, text=True, check=True)
        (programs / name).symlink_to(found.stdout.strip())
    return tmp_path, programs


def add_python(programs, name, version, *, lacks='nothing'):
    """Put a pretended interpreter on PATH: it knows its version and which module it lacks."""
    script = programs / name
    script.write_text(
        f'#!{sys.executable}\n'
        'import sys\n'
        f'sys.version_info = {version}\n'
        f'if "{lacks}" in sys.argv[-1]: sys.exit(1)\n'
        'if "-m" in sys.argv: sys.exit("reached " + " ".join(sys.argv[1:]))\n'
        'if "import sys" in sys.argv[-1] or "print" in sys.argv[-1]: exec(sys.argv[-1])\n'
    )
    script.chmod(0o755)


def sentences(result):
    assert result.returncode == 2
    lines = [line for line in result.stderr.splitlines() if not line.startswith('make: ***')]
    assert len(lines) == 1, result.stderr
    return lines[0]


def test_make_install_without_python_is_one_sentence(bare_machine):
    folder, programs = bare_machine
    said = sentences(run_make('install', cwd=folder, path=programs))
    assert 'Python 3.10 to 3.13' in said
    assert 'sudo apt install python3-venv' in said


@pytest.mark.parametrize('version', [(3, 9, 2), (3, 14, 0)])
def test_make_install_with_unsuitable_python_is_one_sentence(bare_machine, version):
    folder, programs = bare_machine
    add_python(programs, 'python3', version)
    said = sentences(run_make('install', cwd=folder, path=programs))
    assert 'Python 3.10 to 3.13' in said
    assert 'sudo apt install python3.12-venv' in said


def test_make_install_without_venv_names_the_package_that_has_it(bare_machine):
    folder, programs = bare_machine
    add_python(programs, 'python3', (3, 12, 3), lacks='ensurepip')
    said = sentences(run_make('install', cwd=folder, path=programs))
    assert 'sudo apt install python3.12-venv' in said


def test_make_install_tries_the_other_pythons_on_the_path(bare_machine):
    folder, programs = bare_machine
    add_python(programs, 'python3', (3, 14, 0))
    add_python(programs, 'python3.13', (3, 13, 1), lacks='ensurepip')
    add_python(programs, 'python3.11', (3, 11, 7))
    result = run_make('install', cwd=folder, path=programs)
    assert 'reached -m venv --clear .venv' in result.stderr
    assert not (folder / '.venv' / '.installed').exists()


def test_make_install_uses_the_python_of_the_sourced_distribution(bare_machine):
    folder, programs = bare_machine
    ros = folder / 'ros'
    (ros / 'lib' / 'python3.12' / 'site-packages' / 'rclpy').mkdir(parents=True)
    marker = ros / 'share' / 'ament_index' / 'resource_index' / 'packages' / 'rclpy'
    marker.parent.mkdir(parents=True)
    marker.write_text('')
    add_python(programs, 'python3', (3, 11, 7))
    sourced = {'ROS_DISTRO': 'jazzy', 'AMENT_PREFIX_PATH': f'/nowhere:{ros}'}
    said = sentences(run_make('install', cwd=folder, path=programs, **sourced))
    assert 'sudo apt install python3.12-venv' in said
    add_python(programs, 'python3.12', (3, 12, 3), lacks='pinocchio')
    said = sentences(run_make('install', cwd=folder, path=programs, **sourced))
    assert 'sudo apt install ros-jazzy-pinocchio' in said
    add_python(programs, 'python3.12', (3, 12, 3))
    result = run_make('install', cwd=folder, path=programs, **sourced)
    assert 'reached -m venv --clear --system-site-packages .venv' in result.stderr


def test_finished_installation_is_not_repeated_unless_it_is_for_something_else(bare_machine):
    folder, programs = bare_machine
    add_python(programs, 'python3', (3, 14, 0))
    stamp = folder / '.venv' / '.installed'
    stamp.parent.mkdir()
    stamp.write_text(f'{folder} with the ROS wheels\n\n')
    assert run_make('install', cwd=folder, path=programs).returncode == 0
    assert run_make('install', 'PYTHON=python3', cwd=folder, path=programs).returncode == 2
    stamp.write_text(f'{folder}/elsewhere with the ROS wheels\n\n')
    assert run_make('install', cwd=folder, path=programs).returncode == 2


@pytest.mark.parametrize(
    ('arguments', 'parallel'),
    [
        ('', True),
        ("-k 'one or two'", True),
        ('-s -k one', False),
        ('--pdb', False),
    ],
)
@pytest.mark.parametrize('sourced', [False, True])
def test_tests_run_in_parallel_unless_they_are_to_print(
    bare_machine, arguments, parallel, sourced
):
    """Where ROS 2 is sourced no plugin is loaded by itself, so that of parallel runs is named."""
    folder, programs = bare_machine
    stamp = folder / '.venv' / '.installed'
    stamp.parent.mkdir()
    ros = folder / 'ros'
    for path in (
        'lib/python3.12/site-packages/rclpy',
        'share/ament_index/resource_index/packages',
    ):
        (ros / path).mkdir(parents=True)
    (ros / 'share/ament_index/resource_index/packages/rclpy').touch()
    stamp.write_text(f'{folder} with {ros if sourced else "the ROS wheels"}\n\n')
    (stamp.parent / 'bin').mkdir()
    pytest_program = stamp.parent / 'bin' / 'pytest'
    pytest_program.write_text(
        '#!/bin/sh\nprintf "%s\\n" "${PYTEST_DISABLE_PLUGIN_AUTOLOAD:-0}" "$@"\n'
    )
    pytest_program.chmod(0o755)
    shell = {'ROS_DISTRO': 'jazzy', 'AMENT_PREFIX_PATH': str(ros)} if sourced else {}
    said = run_make('test', f'ARGS={arguments}', cwd=folder, path=programs, **shell)
    assert said.returncode == 0, said.stderr
    off, *given = said.stdout.splitlines()
    assert off == ('1' if sourced else '0')
    assert given[:2] == ['-p', 'xdist']
    assert ('-n' in given) == parallel
    assert given[-1:] == (shlex.split(arguments)[-1:] or ['loadfile'])
