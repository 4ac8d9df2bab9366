# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Schema text and type hash of a message type, gathered from the installed interface files."""

import importlib.util
import json
import os
import re
import sys
from functools import cache
from pathlib import Path

from sosml_friction.exceptions import BagError

#: Names of the message types that are read of bags.
JOINT_STATE = 'sensor_msgs/msg/JointState'
TEMPERATURE = 'sensor_msgs/msg/Temperature'
STRING = 'std_msgs/msg/String'
TRAJECTORY = 'trajectory_msgs/msg/JointTrajectory'
SEPARATOR = '=' * 80

_TYPE_NAME = re.compile(r'([A-Za-z]\w*)/(?:msg/)?([A-Za-z]\w*)')
_FIELD_TYPE = re.compile(r'^\s*([A-Za-z][\w/]*)(?:<=\d+)?(?:\[[^\]]*\])?\s+\w', re.MULTILINE)
_PRIMITIVE = frozenset((
    'bool', 'byte', 'char', 'float32', 'float64', 'int8', 'uint8', 'int16', 'uint16', 'int32',
    'uint32', 'int64', 'uint64', 'string', 'wstring',
))  # fmt: skip


def split_type_name(type_name: str) -> tuple[str, str]:
    """Return (package, name) of ``package/msg/Name`` or ``package/Name``, else a BagError."""
    match = _TYPE_NAME.fullmatch(type_name)
    if match is None:
        raise BagError(f'{type_name!r} is no message type: write it as sensor_msgs/msg/JointState')
    return match[1], match[2]


def _prefixes(package: str) -> list[Path]:
    """Return where the share folder of ``package`` can be, in the order it is looked for."""
    prefixes = [Path(p) for p in os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep) if p]
    prefixes.append(Path(sys.prefix))
    for module in (package, 'sensor_msgs'):
        spec = importlib.util.find_spec(module)
        for location in (spec.submodule_search_locations or ()) if spec is not None else ():
            prefixes += Path(location).resolve().parents
    return prefixes


def _interface_file(package: str, name: str, suffix: str) -> Path | None:
    """Return the installed ``share/<package>/msg/<name><suffix>``, or None."""
    for prefix in _prefixes(package):
        path = prefix / 'share' / package / 'msg' / f'{name}{suffix}'
        if path.is_file():
            return path
    return None


def _dependencies(text: str, package: str) -> list[str]:
    """Return the ``package/Name`` of each field type of a .msg text that is no primitive."""
    # A comment can look like a field; it ends at the line's end.
    code = '\n'.join(line.split('#', 1)[0] for line in text.splitlines())
    types = {match[1] for match in _FIELD_TYPE.finditer(code)} - _PRIMITIVE
    return sorted(name if '/' in name else f'{package}/{name}' for name in types)


@cache
def message_definition(type_name: str) -> str:
    """
    Return the ``ros2msg`` schema of a type: its .msg text and those it depends on, recursively.

    Each dependency is preceded by an empty line's break, a line of 80 ``=`` and a line
    ``MSG: package/Name``: the text rosbag2 writes for the same installed files.

    :raises BagError: if an interface file is not installed.
    """
    seen: set[str] = set()

    def gather(name: str) -> str:
        package, short_name = split_type_name(name)
        path = _interface_file(package, short_name, '.msg')
        if path is None:
            raise BagError(
                f'the definition of {name} (share/{package}/msg/{short_name}.msg) is not '
                'installed: source the workspace that has it or install its package'
            )
        text = path.read_text(encoding='utf-8')
        for dependency in _dependencies(text, package):
            if dependency not in seen:
                seen.add(dependency)
                text += f'\n{SEPARATOR}\nMSG: {dependency}\n{gather(dependency)}'
        return text

    return gather(type_name)


@cache
def type_hash(type_name: str) -> str:
    """Return the ``RIHS01_...`` hash installed beside the definition, else an empty text."""
    package, name = split_type_name(type_name)
    path = _interface_file(package, name, '.json')
    if path is None:
        return ''
    try:
        hashes = json.loads(path.read_text(encoding='utf-8'))['type_hashes']
        found = {entry['type_name']: entry['hash_string'] for entry in hashes}
    except (OSError, ValueError, KeyError, TypeError):
        return ''
    return str(found.get(f'{package}/msg/{name}', ''))
