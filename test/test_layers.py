# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Imports point downward, from a layer to those below it, and no module is above itself."""

import ast
from pathlib import Path

import pytest

PACKAGE = 'sosml_friction'
ROOT = Path(__file__).resolve().parents[1] / PACKAGE

#: From the bottom up; those in one row do not know of each other. ``''`` is the package itself.
LAYERS = (
    (
        *('arrays', 'compiled', 'exceptions', 'one_thread', 'plain_document', 'plain_number'),
        *('registry', 'share', 'text_file', 'xml_text', 'yaml_text'),
    ),
    ('model',),
    ('bags',),
    ('observers',),
    ('motion',),
    ('simulation',),
    ('regression',),
    ('mujoco',),
    ('identification',),
    ('diagnosis', 'study'),
    ('actuators',),
    ('report', 'export'),
    ('api',),
    ('nodes',),
    ('cli',),
)
#: A layer that may know less than all that is below it.
ONLY = {
    'arrays': set(),
    'compiled': set(),
    'exceptions': set(),
    'one_thread': set(),
    'share': {'exceptions'},
    'registry': {'exceptions'},
    'plain_document': set(),
    'plain_number': set(),
    'text_file': {'exceptions'},
    'xml_text': set(),
    'yaml_text': {'exceptions'},
    'actuators': {'arrays', 'exceptions', 'plain_number', 'registry', 'share', 'yaml_text'}
    | {'model', 'bags', 'motion', 'simulation'},
    # Names of the API, loaded when they are used.
    '': {'api', 'bags', 'exceptions'},
}
LEVEL = {name: level for level, row in enumerate(LAYERS) for name in row} | {'': len(LAYERS)}


def modules():
    """Return the files of the package by the names of their modules."""
    found = {}
    for path in ROOT.rglob('*.py'):
        parts = path.relative_to(ROOT.parent).with_suffix('').parts
        found['.'.join(parts[:-1] if parts[-1] == '__init__' else parts)] = path
    return found


MODULES = modules()


def imports(tree, known):
    """Return the modules among ``known`` that a module imports, anywhere in it, for types too."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, 'write whole names of modules'
            # What is imported may be a module itself.
            whole = [f'{node.module}.{alias.name}' for alias in node.names]
            names = [name if name in known else node.module for name in whole]
        else:
            continue
        for name in names:
            assert name in known or name.split('.')[0] != PACKAGE, f'{name} does not exist'
            if name in known:
                found.add(name)
    return found


def layer(module):
    """Return the folder, or the file beside the folders, that a module is in."""
    return [*module.split('.'), ''][1]


def wrong_arrows(graph):
    """Return the imports that do not point downward, sentences."""
    found = []
    for module, others in graph.items():
        own = layer(module)
        allowed = ONLY.get(own, {name for name in LEVEL if LEVEL[name] < LEVEL[own]})
        for other in sorted(others):
            if layer(other) not in allowed | {own}:
                found.append(f'{module} imports {other}')
    return found


def circles(graph):
    """Return the sets of modules that import each other, by Tarjan's algorithm."""
    index, low, stack, found = {}, {}, [], []

    def visit(module):
        index[module] = low[module] = len(index)
        stack.append(module)
        for other in sorted(graph[module] - {module}):
            if other not in index:
                visit(other)
            if other in stack:
                low[module] = min(low[module], low[other])
        if low[module] == index[module]:
            circle = stack[stack.index(module) :]
            del stack[stack.index(module) :]
            if len(circle) > 1:
                found.append(' <-> '.join(sorted(circle)))

    for module in sorted(graph):
        if module not in index:
            visit(module)
    return found


@pytest.fixture(scope='module')
def graph():
    return {
        name: imports(ast.parse(path.read_text(encoding='utf-8')), MODULES)
        for name, path in MODULES.items()
    }


def test_every_folder_has_its_place_in_the_table():
    assert len(MODULES) > 100
    assert sorted({layer(name) for name in MODULES} - set(LEVEL)) == []


def test_imports_point_downward(graph):
    found = wrong_arrows(graph)
    assert not found, '\n'.join(found)


def test_no_module_imports_itself_by_way_of_others(graph):
    found = circles(graph)
    assert not found, '\n'.join(found)


def test_only_nodes_import_rclpy():
    """The messages of ROS are read and written by bags behind one function, without a node."""
    found = []
    for name, path in MODULES.items():
        tree = ast.parse(path.read_text(encoding='utf-8'))
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                names = [f'{node.module}.{alias.name}' for alias in node.names]
            else:
                continue
            ros = [x for x in names if x.split('.')[0] == 'rclpy']
            allowed = layer(name) == 'nodes' or name == f'{PACKAGE}.bags.serialization'
            found += [f'{name} imports {x}' for x in ros if not allowed]
    assert found == []


def test_an_arrow_that_points_upward_and_a_circle_are_found():
    p = PACKAGE
    assert wrong_arrows({f'{p}.model.a': {f'{p}.bags.b', f'{p}.exceptions'}}) == [
        f'{p}.model.a imports {p}.bags.b'
    ]
    assert wrong_arrows({f'{p}.study.a': {f'{p}.diagnosis.b', f'{p}.study.c'}}) == [
        f'{p}.study.a imports {p}.diagnosis.b'
    ]
    assert wrong_arrows({f'{p}.actuators.a': {f'{p}.identification.b'}}) == [
        f'{p}.actuators.a imports {p}.identification.b'
    ]
    assert circles({'a': {'b'}, 'b': {'c'}, 'c': {'a'}, 'd': {'a'}}) == ['a <-> b <-> c']
    assert circles({'a': {'b', 'c'}, 'b': {'c'}, 'c': set()}) == []


def test_imports_are_seen_wherever_they_stand():
    text = f"""
from {PACKAGE} import share
def late():
    from {PACKAGE}.model.robot import Robot
    import {PACKAGE}.exceptions
"""
    known = {f'{PACKAGE}.{x}' for x in ('share', 'model.robot', 'exceptions')} | {PACKAGE}
    assert imports(ast.parse(text), known) == known - {PACKAGE}
