# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""`pip install .`: the wheel, installed into an environment of its own, is complete."""

import json
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


def run(*command, cwd, environment=None, check=True):
    """Run a program where nothing of the source tree is in reach; raise with what it said."""
    env = dict(os.environ, PIP_NO_INDEX='1', PIP_DISABLE_PIP_VERSION_CHECK='1')
    env['PYTHONPATH'] = os.pathsep.join(
        path
        for path in os.environ.get('PYTHONPATH', '').split(os.pathsep)
        if path and Path(path).resolve() != ROOT
    )
    env.update(environment or {})
    result = subprocess.run(
        [str(word) for word in command],
        cwd=cwd,
        env=env,
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
    )
    assert result.returncode == 0 or not check, f'{command}\n{result.stdout}\n{result.stderr}'
    return result


@pytest.fixture(scope='module')
def source(tmp_path_factory):
    """Return a copy of the source, as builds write into the tree they build from."""
    copy = tmp_path_factory.mktemp('wheel') / 'source'
    shutil.copytree(ROOT, copy, ignore=NOT_SOURCE)
    return copy


@pytest.fixture(scope='module')
def environment(source):
    """Return an environment with the built wheel; all else it borrows from the running one."""
    folder = source.parent
    wheel_folder = folder / 'dist'
    build = ('--no-deps', '--no-build-isolation', '--wheel-dir', wheel_folder)
    run(sys.executable, '-m', 'pip', 'wheel', *build, source, cwd=folder)
    (wheel,) = wheel_folder.glob('*.whl')
    made = folder / 'environment'
    run(sys.executable, '-m', 'venv', '--without-pip', made, cwd=folder)
    python = made / 'bin' / 'python'
    (site_packages,) = made.glob('lib/python3*/site-packages')
    borrowed = [path for path in sys.path if Path(path).name in ('site-packages', 'dist-packages')]
    (site_packages / 'borrowed.pth').write_text(
        ''.join(f'import site; site.addsitedir({path!r})\n' for path in borrowed)
    )
    # --ignore-installed: the running environment's own installation is not to be touched.
    install = ('--no-deps', '--ignore-installed', '--no-warn-script-location', wheel)
    run(python, '-m', 'pip', 'install', *install, cwd=folder)
    return made


def evaluate(environment, program, tmp_path):
    """Run Python statements in the environment; return what they put into `answer`."""
    program = f'import json\n{program}\nprint(json.dumps(answer))'
    said = run(environment / 'bin' / 'python', '-c', program, cwd=tmp_path)
    return json.loads(said.stdout.splitlines()[-1])


def test_tool_says_what_it_does(environment, tmp_path):
    said = run(environment / 'bin' / 'sosml', '--help', cwd=tmp_path)
    for command in ('demo', 'fit', 'import', 'info'):
        assert command in said.stdout


def test_every_console_script_imports_from_this_environment(environment, tmp_path):
    modules = evaluate(
        environment,
        'import importlib.metadata, sys\n'
        'scripts = importlib.metadata.distribution("sosml_friction").entry_points\n'
        'answer = {s.name: sys.modules[s.load().__module__].__file__ for s in scripts}',
        tmp_path,
    )
    nodes = {
        f'{name}_node'
        for name in ('driver', 'emulator', 'exoskeleton', 'identifier', 'observer', 'replay')
    }
    assert set(modules) == nodes | {'sosml'}
    for name, module in modules.items():
        assert (environment / 'bin' / name).is_file()
        assert Path(module).is_relative_to(environment), module


def test_data_is_that_of_this_environment_and_complete(environment, tmp_path):
    share = Path(
        evaluate(
            environment,
            'from sosml_friction.share import share_directory\nanswer = str(share_directory())',
            tmp_path,
        )
    )
    assert share == environment / 'share' / 'sosml_friction'
    for folder, pattern in (('config', '*'), ('urdf', '*'), ('launch', '*.launch.py')):
        files = [path for path in (ROOT / folder).rglob(pattern) if path.is_file()]
        assert files
        for path in files:
            if '__pycache__' not in path.parts:
                assert (share / path.relative_to(ROOT)).read_bytes() == path.read_bytes()
    index = environment / 'share' / 'ament_index' / 'resource_index' / 'packages'
    assert (index / 'sosml_friction').is_file()
    assert (share / 'package.xml').is_file()


def test_every_file_of_the_package_is_installed(environment):
    (package,) = environment.glob('lib/python3*/site-packages/sosml_friction')

    def files(folder):
        return {
            path.relative_to(folder)
            for path in folder.rglob('*')
            if path.is_file() and '__pycache__' not in path.parts
        }

    assert files(package) == files(ROOT / 'sosml_friction')


def requirements(source, folder, environment):
    """Return what the wheel would ask pip for in this environment, the test extra left out."""
    program = (
        'import sys\n'
        'from setuptools.build_meta import prepare_metadata_for_build_wheel\n'
        'print(prepare_metadata_for_build_wheel(sys.argv[1]))'
    )
    said = run(sys.executable, '-c', program, folder, cwd=source, environment=environment)
    metadata = (folder / said.stdout.splitlines()[-1] / 'METADATA').read_text(encoding='utf-8')
    return {
        line.removeprefix('Requires-Dist: ')
        for line in metadata.splitlines()
        if line.startswith('Requires-Dist: ') and 'extra ==' not in line
    }


def test_ros_wheels_are_asked_for_only_where_no_distribution_is_sourced(source, tmp_path):
    """Wheels beside a distribution would shadow its rclpy and mix two builds of its libraries."""
    ros = tmp_path / 'ros'
    index = ros / 'share' / 'ament_index' / 'resource_index' / 'packages'
    index.mkdir(parents=True)
    (index / 'rclpy').touch()
    path = f'/nowhere{os.pathsep}{ros}'
    found = {}
    for name, distribution, prefixes in (
        ('plain', '', ''),
        ('overlay only', 'jazzy', '/nowhere'),
        ('not sourced', '', path),
        ('sourced', 'jazzy', path),
    ):
        folder = tmp_path / name
        folder.mkdir()
        shell = {'ROS_DISTRO': distribution, 'AMENT_PREFIX_PATH': prefixes}
        found[name] = requirements(source, folder, shell)
    assert found['plain'] == found['overlay only'] == found['not sourced']
    left_out = {line.split('<')[0].split('>')[0] for line in found['plain'] - found['sourced']}
    assert left_out == {'ros-jazzy-rclpy[fastrtps]', 'ros-jazzy-common-interfaces', 'pin'}
    assert found['sourced'] < found['plain']
