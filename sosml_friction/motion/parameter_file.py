# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""ROS parameter files, read without ROS."""

from pathlib import Path
from typing import Any

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.yaml_text import read_yaml


def node_parameters(path: Path, node: str, what: str = 'parameter file') -> dict[str, Any]:
    """
    Return the parameters of ``node``, flat, those for any node included; none if it is not there.

    :raises ConfigurationError: if the file cannot be read or holds something else.
    """
    document = read_yaml(path, what)
    result: dict[str, Any] = {}
    try:
        # A node's own come after those for any.
        for key, entry in sorted((document or {}).items(), key=lambda item: item[0] != '/**'):
            if key == '/**' or str(key).rpartition('/')[2] == node:
                result |= _flat(entry.get('ros__parameters') or {})
    except AttributeError as error:
        raise ConfigurationError(
            f'{what} {path} cannot be read: it has no nodes with ros__parameters'
        ) from error
    return result


def _flat(values: dict[str, Any], prefix: str = '') -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for key, value in values.items():
        name = f'{prefix}{key}'
        flat |= _flat(value, f'{name}.') if isinstance(value, dict) else {name: value}
    return flat
