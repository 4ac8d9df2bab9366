# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Arguments and options that several commands of ``sosml`` have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from sosml_friction.exceptions import BagError
from sosml_friction.observers import kinds

OBSERVER_NAMES = ', '.join(kinds.NAMES)
#: What sosml import reads; written out, so that --help loads nothing.
IMPORTED = ('.csv', '.mat', '.npy', '.npz')


def json_option(instead: str) -> Any:
    """Return the option --json of a command that prints ``instead`` without it."""
    return typer.Option('--json', help=f'Print one JSON object on stdout instead of {instead}.')


def out_option(default: str) -> Any:
    """Return the option --out of a command that writes a folder named ``default`` without it."""
    return typer.Option(metavar='DIR', help=f'Where to write; default: {default} in this folder.')


def folder_option(what: str) -> Any:
    """Return an option that takes a folder."""
    return typer.Option(metavar='DIR', help=what)


def names_option(what: str) -> Any:
    """Return an option that takes names with commas between them."""
    return typer.Option(metavar='NAME,...', help=what)


def joint_values_option(what: str) -> Any:
    """Return an option that takes a number for one joint or for all, and is repeatable."""
    return typer.Option(metavar='[JOINT=]VALUE', help=what)


def parse_names(text: str | None) -> tuple[str, ...] | None:
    """Return the names of an option of :func:`names_option`, None where it was not given."""
    return None if text is None else tuple(name.strip() for name in text.split(','))


def stated(**values: Any) -> dict[str, Any]:
    """Return those options that were given."""
    return {name: value for name, value in values.items() if value is not None}


def _refuse_data_file(bag: Path) -> Path:
    if bag.suffix.lower() in IMPORTED and bag.is_file():
        raise BagError(
            f'{bag} is no bag: turn it into one first with sosml import {bag} --map MAPPING.yaml'
        )
    return bag


def _refuse_data_files(bags: list[Path]) -> list[Path]:
    return [_refuse_data_file(bag) for bag in bags]


BagArgument = Annotated[
    Path,
    typer.Argument(metavar='BAG', help='Bag folder or .mcap file.', callback=_refuse_data_file),
]
BagsArgument = Annotated[
    list[Path],
    typer.Argument(metavar='BAG', help='Bag folder or .mcap file.', callback=_refuse_data_files),
]
JsonOption = Annotated[bool, json_option('tables')]
JsonOrTableOption = Annotated[bool, json_option('a table')]
NamespaceOption = Annotated[
    str | None,
    typer.Option(help='Namespace of the robot, where a bag holds several.', metavar='NS'),
]
ModelOption = Annotated[
    Path | None,
    typer.Option(help="Model folder with the armature of the joints; default: the bag's."),
]
UrdfOption = Annotated[
    Path | None,
    typer.Option(help="URDF file; default: the bag's robot_description, then the model's."),
]
EffortHoldOption = Annotated[
    list[str] | None,
    typer.Option(
        metavar='[JOINT=]HOLD',
        help='Where in an interval a sample of effort holds: start (a command), mean, or end (a '
        "measured current); repeatable; default: the bag's, else start.",
    ),
]
