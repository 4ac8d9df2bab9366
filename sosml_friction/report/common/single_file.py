# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A result of one file: nothing foreign is overwritten, nothing is left half written."""

from pathlib import Path

from sosml_friction.exceptions import ConfigurationError


def check_file(path: Path, option: str, suffix: str, begins: bytes) -> Path:
    """
    Return ``path`` if a file of this kind may be written there, in place of another of its kind.

    :param begins: how a file of this kind begins.
    :raises ConfigurationError: if its name or its folder does not fit, or another file is there.
    """
    if path.suffix.lower() != suffix:
        raise ConfigurationError(f'{option} {path} does not end in {suffix}: name it so')
    if not path.parent.is_dir():
        raise ConfigurationError(f'{path.parent} is no folder: choose another place with {option}')
    try:
        foreign = path.exists() and not path.read_bytes().startswith(begins)
    except OSError as error:
        raise ConfigurationError(
            f'{path} cannot be read: choose another place with {option}'
        ) from error
    if foreign:
        raise ConfigurationError(
            f'{path} exists and is something else, so it is not overwritten: choose another place '
            f'with {option}'
        )
    return path


def write_file(path: Path, content: bytes) -> None:
    """Write a file so that it is there whole or not at all."""
    beside = path.with_name(f'.{path.name}.part')
    beside.write_bytes(content)
    beside.replace(path)
