# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Every import is covered in each way to install: rosdep key or pip line, and PyPI requirement."""

import ast
import re
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGE = 'docs/install.md'
SECTION = 'On a machine with ROS 2 Jazzy'

# Import -> rosdep key, each looked up in ros/rosdistro.
ROSDEP = {
    'builtin_interfaces': 'builtin_interfaces',
    'can': 'python3-can',
    'diagnostic_msgs': 'diagnostic_msgs',
    'launch': 'launch',
    'launch_ros': 'launch_ros',
    'lifecycle_msgs': 'lifecycle_msgs',
    'matplotlib': 'python3-matplotlib',
    'numpy': 'python3-numpy',
    'pinocchio': 'pinocchio',
    'rcl_interfaces': 'rcl_interfaces',
    'rclpy': 'rclpy',
    'rich': 'python3-rich',
    'rosgraph_msgs': 'rosgraph_msgs',
    'scipy': 'python3-scipy',
    'sensor_msgs': 'sensor_msgs',
    'serial': 'python3-serial',
    'std_msgs': 'std_msgs',
    'std_srvs': 'std_srvs',
    'trajectory_msgs': 'trajectory_msgs',
    'typing_extensions': 'python3-typing-extensions',
    'yaml': 'python3-yaml',
}
# Import -> name on PyPI, for what rosdep cannot give on Ubuntu 24.04.
PIP = {
    'cantools': 'cantools',
    'lz4': 'lz4',
    'mcap': 'mcap',
    'numba': 'numba',
    'threadpoolctl': 'threadpoolctl',
    'typer': 'typer',
    'zstandard': 'zstandard',
}
# Optional extras of setup.py: without one, a sentence says what to install.
OPTIONAL = ('control_msgs', 'distributed', 'h5py', 'mujoco', 'openpyxl', 'pyarrow', 'rosbags')
# Import -> what brings it into a plain environment, where the name differs.
PYPI = {
    'can': 'python-can',
    'pinocchio': 'pin',
    'rclpy': 'ros-jazzy-rclpy',
    'serial': 'pyserial',
    'yaml': 'PyYAML',
    **dict.fromkeys(
        ('lifecycle_msgs', 'rcl_interfaces', 'rosgraph_msgs', 'builtin_interfaces'),
        'ros-jazzy-rclpy',
    ),
    **dict.fromkeys(
        ('diagnostic_msgs', 'sensor_msgs', 'std_msgs', 'std_srvs', 'trajectory_msgs'),
        'ros-jazzy-common-interfaces',
    ),
}


def third_party_imports(folder):
    """Return {top-level module: files that import it} of the Python files below a folder."""
    found = {}
    for path in sorted(folder.rglob('*.py')):
        names = set()
        for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
            if isinstance(node, ast.Import):
                names |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                names.add('sosml_friction' if node.level else node.module)
            elif isinstance(node, ast.Call) and node.args:
                function = getattr(node.func, 'attr', getattr(node.func, 'id', ''))
                name = getattr(node.args[0], 'value', None)
                if function in ('import_module', '__import__') and isinstance(name, str):
                    names.add(name)
        for name in {name.split('.')[0] for name in names}:
            if name not in (*sys.stdlib_module_names, *OPTIONAL, 'sosml_friction'):
                found.setdefault(name, []).append(path.relative_to(folder.parent).as_posix())
    return found


def rosdep_keys(package_xml):
    return {
        element.text
        for element in ElementTree.parse(package_xml).getroot()
        if element.tag in ('depend', 'exec_depend')
    }


def pip_line(page):
    """Return what the pip line of the page's section asks for, quotes removed."""
    section = page.split(SECTION, 1)[1].split('\n#', 1)[0].replace('\\\n', ' ')
    line = next(line for line in section.splitlines() if 'pip install' in line)
    words = line.split('pip install', 1)[1].replace("'", '').replace('"', '').split()
    return [word for word in words if not word.startswith('-')]


def name_of(requirement):
    return re.match(r'[A-Za-z0-9._-]+', requirement).group().lower()


def uncovered(imports, keys, pip_names):
    """Return one sentence per import that a machine with ROS 2 Jazzy would not have."""
    return [
        f'{name} (in {", ".join(files)}) has neither a rosdep key in package.xml nor a place in '
        f'the pip line of {PAGE}'
        for name, files in sorted(imports.items())
        if ROSDEP.get(name) not in keys and PIP.get(name) not in pip_names
    ]


def required_by_setup_py():
    """Return the requirement strings in setup.py for a plain environment."""
    tree = ast.parse((ROOT / 'setup.py').read_text(encoding='utf-8'))
    lists = [
        ast.literal_eval(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign)
        and node.targets[0].id in ('REQUIREMENTS', 'ROS_REQUIREMENTS')
    ]
    assert len(lists) == 2
    return [requirement for names in lists for requirement in names]


@pytest.fixture(scope='module')
def imports():
    return {**third_party_imports(ROOT / 'sosml_friction'), **third_party_imports(ROOT / 'launch')}


@pytest.fixture(scope='module')
def pip_requirements():
    return pip_line((ROOT / PAGE).read_text(encoding='utf-8'))


def test_every_import_is_there_on_a_machine_with_ros_2(imports, pip_requirements):
    keys = rosdep_keys(ROOT / 'package.xml')
    names = {name_of(requirement) for requirement in pip_requirements}
    assert {'numpy', 'rclpy'} <= set(imports)
    assert uncovered(imports, keys, names) == []


def test_every_import_is_there_in_a_plain_environment(imports):
    required = {name_of(requirement) for requirement in required_by_setup_py()}
    missing = {
        name: files
        for name, files in imports.items()
        if name not in ('launch', 'launch_ros') and PYPI.get(name, name).lower() not in required
    }
    assert missing == {}


def test_only_launch_files_import_launch(imports):
    """PyPI's project of that name is another one."""
    for name in ('launch', 'launch_ros'):
        assert all(path.startswith('launch/') for path in imports[name])


def test_package_xml_asks_for_nothing_that_no_one_imports(imports):
    used = {ROSDEP.get(name) for name in imports}
    # python-can imports pyserial for slcan, rclpy the messages of the lifecycle driver's services.
    indirect = {'python3-serial', 'lifecycle_msgs'}
    assert rosdep_keys(ROOT / 'package.xml') - used - indirect == set()


def test_pip_line_stays_inside_the_bounds_of_setup_py(pip_requirements):
    """What the pip line installs, setup.py accepts: else `make install` would replace it."""
    from packaging.requirements import Requirement

    bounds = {
        name_of(requirement): Requirement(requirement).specifier
        for requirement in required_by_setup_py()
    }
    for requirement in map(Requirement, pip_requirements):
        lower = [bound for bound in requirement.specifier if bound.operator == '>=']
        assert all(bounds[requirement.name].contains(bound.version) for bound in lower)


def test_pip_line_keeps_the_numpy_of_the_distribution(pip_requirements):
    """Its messages and SciPy are compiled against NumPy 1."""
    assert 'numpy<2' in pip_requirements


def test_an_import_nobody_thought_of_is_named(tmp_path):
    package = tmp_path / 'package'
    package.mkdir()
    (package / 'one.py').write_text('import os\nimport numpy as np\nfrom frobnicate.x import y\n')
    (package / 'two.py').write_text('def f():\n    importlib.import_module("mcap.reader")\n')
    found = third_party_imports(package)
    assert set(found) == {'numpy', 'frobnicate', 'mcap'}
    assert uncovered(found, {'python3-numpy'}, {'mcap'}) == [
        'frobnicate (in package/one.py) has neither a rosdep key in package.xml nor a place in '
        f'the pip line of {PAGE}'
    ]
    assert len(uncovered(found, set(), set())) == 3
