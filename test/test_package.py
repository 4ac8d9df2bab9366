# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the package says of itself agrees: package.xml, setup.py, change log, launch files."""

import ast
import importlib
import re
import sys
import types
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import ClassVar

import pytest

ROOT = Path(__file__).resolve().parents[1]
LAUNCH_FILES = sorted((ROOT / 'launch').glob('*.launch.py'))
PYTHON_FILES = sorted(
    [ROOT / 'setup.py']
    + [
        path
        for folder in ('sosml_friction', 'launch', 'test', 'benchmarks', 'examples')
        for path in (ROOT / folder).rglob('*.py')
    ]
)


@pytest.fixture(scope='module')
def package_xml():
    return ElementTree.parse(ROOT / 'package.xml').getroot()


@pytest.fixture
def setup_py(monkeypatch):
    """Return what setup.py tells setuptools, without building anything."""
    monkeypatch.chdir(ROOT)
    importlib.import_module('setuptools')  # brings distutils where Python has none
    return importlib.import_module('distutils.core').run_setup('setup.py', stop_after='init')


def console_scripts(distribution):
    scripts = dict(
        re.split(r'\s*=\s*', entry) for entry in distribution.entry_points['console_scripts']
    )
    assert scripts
    return scripts


def test_package_xml_is_format_3_and_ament_python(package_xml):
    assert package_xml.get('format') == '3'
    assert package_xml.findtext('name') == 'sosml_friction'
    assert package_xml.findtext('export/build_type') == 'ament_python'


def test_version_name_and_licence_agree(package_xml, setup_py):
    assert setup_py.get_version() == package_xml.findtext('version')
    assert setup_py.get_name() == package_xml.findtext('name')
    assert setup_py.get_license() == package_xml.findtext('license') == 'Apache-2.0'
    assert setup_py.get_maintainer_email() == package_xml.find('maintainer').get('email')
    assert 'Apache License' in (ROOT / package_xml.find('license').get('file')).read_text()


def test_newest_section_of_the_changelog_is_of_the_version(package_xml):
    version = package_xml.findtext('version')
    sections = re.findall(
        r'^(.+)\n-{3,}\n((?:(?!^.+\n-{3,}$).*\n)*)',
        (ROOT / 'CHANGELOG.rst').read_text(),
        re.MULTILINE,
    )
    heading, text = sections[0]
    assert heading.startswith(f'{version} (') or (heading == 'Forthcoming' and version in text)


def test_every_console_script_can_be_imported_and_called(setup_py):
    for script, target in console_scripts(setup_py).items():
        module, function = target.split(':')
        assert callable(getattr(importlib.import_module(module), function)), script


def test_every_file_of_the_share_folder_is_installed_in_its_subfolder(setup_py):
    installed = {
        f'{folder}/{Path(name).name}': name
        for folder, names in setup_py.data_files
        for name in names
    }
    wanted = [
        path.relative_to(ROOT).as_posix()
        for pattern in ('config/**/*', 'urdf/**/*', 'launch/*.launch.py', 'package.xml')
        for path in ROOT.glob(pattern)
        if path.is_file() and '__pycache__' not in path.parts
    ]
    assert 'config/exoskeleton/model.yaml' in wanted
    for name in wanted:
        assert installed[f'share/sosml_friction/{name}'] == name
    marker = 'share/ament_index/resource_index/packages/sosml_friction'
    assert installed[marker] == 'resource/sosml_friction'


def test_no_data_file_is_a_hidden_or_compiled_one(setup_py):
    names = [name for _, names in setup_py.data_files for name in names]
    assert not [name for name in names if '/.' in name or name.endswith('.pyc')]


def test_there_are_python_and_launch_files_to_check():
    assert len(PYTHON_FILES) > 10
    names = ['exoskeleton.launch.py', 'observe.launch.py', 'replay.launch.py']
    assert [path.name for path in LAUNCH_FILES] == names


@pytest.mark.parametrize('path', PYTHON_FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_python_file_has_licence_header_and_docstring(path):
    text = path.read_text(encoding='utf-8')
    header = text.splitlines()[:2]
    assert header == [
        '# Copyright 2026 the sosml_friction authors',
        '# SPDX-License-Identifier: Apache-2.0',
    ]
    assert ast.get_docstring(ast.parse(text))


@pytest.mark.parametrize('path', LAUNCH_FILES, ids=lambda path: path.name)
def test_launch_file_imports_only_what_every_ros_2_machine_has(path):
    tree = ast.parse(path.read_text(encoding='utf-8'))
    imported = {
        (node.module if isinstance(node, ast.ImportFrom) else alias.name).split('.')[0]
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
        for alias in node.names
    }
    assert imported <= {'launch', 'launch_ros'}


class Recorded:
    """Stands in for every class of launch and launch_ros: keeps what it was made with."""

    made: ClassVar[list['Recorded']] = []

    def __init__(self, *args, **kwargs):
        self.args, self.kwargs = args, kwargs
        Recorded.made.append(self)


@pytest.fixture
def recorded_launch(monkeypatch):
    """Give launch files recorders for the launch system, which is not on PyPI."""
    Recorded.made = []
    kinds = {
        'launch': ['LaunchDescription'],
        'launch.actions': ['DeclareLaunchArgument', 'Shutdown'],
        'launch.conditions': ['IfCondition', 'UnlessCondition'],
        'launch.substitutions': [
            'EnvironmentVariable',
            'LaunchConfiguration',
            'PathJoinSubstitution',
        ],
        'launch_ros': [],
        'launch_ros.actions': ['LifecycleNode', 'Node'],
        'launch_ros.parameter_descriptions': ['ParameterFile', 'ParameterValue'],
        'launch_ros.substitutions': ['FindPackageShare'],
    }
    for name, classes in kinds.items():
        module = types.ModuleType(name)
        for kind in classes:
            setattr(module, kind, type(kind, (Recorded,), {}))
        monkeypatch.setitem(sys.modules, name, module)

    def launch(path):
        namespace = {}
        exec(compile(path.read_text(encoding='utf-8'), str(path), 'exec'), namespace)
        namespace['generate_launch_description']()
        return {
            kind: [made for made in Recorded.made if type(made).__name__ == kind]
            for kind in {type(made).__name__ for made in Recorded.made}
        }

    return launch


@pytest.mark.parametrize('path', LAUNCH_FILES, ids=lambda path: path.name)
def test_launch_file_starts_only_executables_of_the_package(path, recorded_launch, setup_py):
    made = recorded_launch(path)
    nodes = made.get('Node', []) + made.get('LifecycleNode', [])
    assert nodes
    for node in nodes:
        assert node.kwargs['package'] == 'sosml_friction'
        assert node.kwargs['executable'] in console_scripts(setup_py)


@pytest.mark.parametrize('path', LAUNCH_FILES, ids=lambda path: path.name)
def test_launch_file_declares_and_describes_every_argument_it_reads(path, recorded_launch):
    made = recorded_launch(path)
    declared = {argument.args[0]: argument.kwargs for argument in made['DeclareLaunchArgument']}
    assert {read.args[0] for read in made['LaunchConfiguration']} == set(declared)
    assert all(argument['description'] for argument in declared.values())


@pytest.mark.parametrize('path', LAUNCH_FILES, ids=lambda path: path.name)
def test_launch_file_names_only_parameters_that_the_node_has(path, recorded_launch):
    made = recorded_launch(path)
    for node in made.get('Node', []) + made.get('LifecycleNode', []):
        module = importlib.import_module(f'sosml_friction.nodes.{node.kwargs["executable"]}')
        known = {spec.name for spec in module.PARAMETERS} | {'use_sim_time'}
        given = [given for given in node.kwargs['parameters'] if isinstance(given, dict)]
        assert {name for names in given for name in names} <= known


@pytest.mark.parametrize('path', LAUNCH_FILES, ids=lambda path: path.name)
def test_launch_file_is_found_by_this_machine_alone_unless_told_otherwise(path, recorded_launch):
    made = recorded_launch(path)
    for node in made.get('Node', []) + made.get('LifecycleNode', []):
        ((name, value),) = node.kwargs['additional_env'].items()
        assert (name, value.args) == ('ROS_AUTOMATIC_DISCOVERY_RANGE', ('discovery',))
    (before,) = made['EnvironmentVariable']
    assert before.args == ('ROS_AUTOMATIC_DISCOVERY_RANGE',)
    assert before.kwargs == {'default_value': 'LOCALHOST'}


def test_a_replay_ends_with_its_bag(recorded_launch):
    made = recorded_launch(ROOT / 'launch' / 'replay.launch.py')
    ends = [node.kwargs['executable'] for node in made['Node'] if 'on_exit' in node.kwargs]
    assert ends == ['replay_node']
    assert made['Shutdown']


@pytest.mark.parametrize('path', LAUNCH_FILES, ids=lambda path: path.name)
def test_launch_file_names_only_data_that_exists(path, recorded_launch):
    for joined in recorded_launch(path).get('PathJoinSubstitution', []):
        share, *names = joined.args[0]
        assert share.args == ('sosml_friction',)
        assert ROOT.joinpath(*names).is_file()
