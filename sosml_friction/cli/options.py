# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Arguments and options that several commands of ``sosml`` have."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sosml_friction.api.names import as_names
from sosml_friction.bags.tables.file_kind import is_table
from sosml_friction.exceptions import BagError, ConfigurationError
from sosml_friction.observers import kinds

if TYPE_CHECKING:
    from sosml_friction.bags.recorded_robot import ModelSource

OBSERVER_NAMES = ', '.join(kinds.NAMES)


def json_option(instead: str) -> Any:
    """Return the option --json of a command that prints ``instead`` without it."""
    return typer.Option('--json', help=f'Print one JSON object on stdout instead of {instead}.')


def out_option(default: str) -> Any:
    """Return the option --out of a command that writes a folder named ``default`` without it."""
    return option('DIR', f'Where to write; default: {default} in this folder.')


def option(metavar: str, what: str) -> Any:
    """Return an option that takes a value."""
    return typer.Option(metavar=metavar, help=what)


def mjcf_option(what: str = '') -> Any:
    """Return an option that takes MuJoCo's model of a robot."""
    text = "MuJoCo's model (MJCF), in the place of --model and --urdf."
    return option('FILE', f'{text} {what}'.strip())


def parse_forms(text: str | None) -> tuple[str, ...]:
    """
    Return the forms of ``--figures``, none where it was not given.

    :raises ConfigurationError: if one is not known.
    """
    names = as_names(text or None)
    if names is None:
        return ()
    from sosml_friction.report.common.figure_files import check_forms

    return check_forms(names)


def stated(**values: Any) -> dict[str, Any]:
    """Return those options that were given."""
    return {name: value for name, value in values.items() if value is not None}


def parse_numbers(option: str, text: str) -> list[float]:
    """
    Read numbers with commas between them.

    :raises ConfigurationError: if one is none.
    """
    try:
        return [float(part) for part in text.split(',')]
    except ValueError:
        raise ConfigurationError(f'{option} {text} is no number: give numbers') from None


def parse_values(option: str, entries: list[str]) -> dict[str, float]:
    """
    Read entries ``JOINT=VALUE``, or ``VALUE``, which is that of '*', all others.

    :raises ConfigurationError: if one is neither.
    """
    stated = {}
    for entry in entries:
        joint, _, text = entry.rpartition('=')
        try:
            stated[joint or '*'] = float(text)
        except ValueError as error:
            raise ConfigurationError(
                f'{option} {entry} has no number: write {option} JOINT=VALUE'
            ) from error
    return stated


def stated_model(
    bag: Path,
    model: Path | None,
    armature: list[str] | None,
    urdf: Path | None = None,
    namespace: str | None = None,
    mjcf: Path | None = None,
    free_rotors: bool = False,
) -> ModelSource:
    """
    Return ``model``, or what it and the bag say with the armature that was stated, or ``mjcf``.

    :param free_rotors: whether an armature of 0 in ``mjcf`` is one that is not known.
    :raises ConfigurationError: if ``mjcf`` is not the only model.
    """
    known = parse_values('--armature', armature or [])
    if mjcf is not None:
        if model is not None or urdf is not None or (known and not free_rotors):
            other = '--model, --urdf' + ('' if free_rotors else ', --armature')
            raise ConfigurationError(f'--mjcf is the model: leave out {other}')
        from sosml_friction.mujoco.reading import read_mjcf

        return read_mjcf(mjcf, free_rotors).with_armature(known, 'stated with the recording')
    if not known:
        return model
    from sosml_friction.bags.bag import Bag
    from sosml_friction.bags.recorded_robot import stated_armature

    return stated_armature(Bag.open(bag, namespace), bag, model, urdf, known)


def _refuse_data_file(bag: Path) -> Path:
    if is_table(bag):
        raise BagError(
            f'{bag} is a table and no bag: sosml import {bag} --guess says what is in it, and the '
            'command that it prints last makes a bag of it'
        )
    return bag


BagArgument = Annotated[
    Path, typer.Argument(metavar='BAG', help='Bag folder or file.', callback=_refuse_data_file)
]
JsonOption = Annotated[bool, json_option('tables')]
JsonOrTableOption = Annotated[bool, json_option('a table')]
NamespaceOption = Annotated[
    str | None, option('NS', 'Namespace of the robot, where a bag holds several.')
]
ModelOption = Annotated[
    Path | None,
    typer.Option(help="Model folder with the armature of the joints; default: the bag's."),
]
ArmatureOption = Annotated[
    list[str] | None,
    option(
        '[JOINT=]VALUE',
        'Inertia of the rotor at the joint, J N^2 [kg m2 or kg], where the model does not know '
        'it; 0 where the bodies of the URDF have it. With it a bag needs no model: its '
        'robot_description is enough. Repeatable.',
    ),
]
UrdfOption = Annotated[
    Path | None,
    typer.Option(help="URDF file; default: the bag's robot_description, then the model's."),
]
MjcfOption = Annotated[Path | None, mjcf_option()]
FiguresOption = Annotated[
    str | None,
    option(
        'FORM,...',
        'Write each figure of the report as files too, into figures/: png, pdf, svg, csv.',
    ),
]
OpenOption = Annotated[
    bool, typer.Option('--open', help='Open the report in the browser when it is written.')
]
EffortHoldOption = Annotated[
    list[str] | None,
    option(
        '[JOINT=]HOLD',
        'Where in an interval a sample of effort holds: start (a command that is held), mean (a '
        'value measured at its stamp), or end (a mean since the sample before); repeatable; '
        "default: the bag's, else start.",
    ),
]
