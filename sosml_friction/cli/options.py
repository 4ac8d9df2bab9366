# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Arguments and options that several commands of ``sosml`` have."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer


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


BagArgument = Annotated[Path, typer.Argument(metavar='BAG', help='Bag folder or .mcap file.')]
BagsArgument = Annotated[
    list[Path], typer.Argument(metavar='BAG', help='Bag folder or .mcap file.')
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
