# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The commands ``sosml model``: a model folder of what is known of a robot."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sosml_friction.api.names import as_names
from sosml_friction.cli import options
from sosml_friction.cli.app import app, command_line, print_result, show_help

if TYPE_CHECKING:
    from sosml_friction.model.model_folder import RobotModelFile

model_app = typer.Typer(
    name='model', help='Make a model folder, which every other command and node takes.'
)
model_app.callback(invoke_without_command=True)(show_help)
app.add_typer(model_app)

JointOption = Annotated[str, typer.Option(help='Name of the joint, that in the recording.')]
MassOption = Annotated[float, options.option('KG', 'All that moves.')]
JsonOption = Annotated[bool, options.json_option('sentences')]
ForceOption = Annotated[
    bool, typer.Option('--force', help='Overwrite an earlier model even if you changed it since.')
]


@model_app.command()
def new(
    context: typer.Context,
    source: Annotated[
        Path, typer.Argument(metavar='URDF', help='URDF file, or a bag that holds one.')
    ],
    armature: Annotated[
        list[str] | None,
        options.option(
            '[JOINT=]VALUE',
            'Inertia of the rotor at the joint, J N^2 [kg m2 or kg], 0 where the bodies of the '
            'URDF have it; default: not known. Repeatable.',
        ),
    ] = None,
    joints: Annotated[
        str | None,
        options.option(
            'NAME,...',
            'Joints of the model; default: all that move by themselves, of a bag those that its '
            'joint_states name.',
        ),
    ] = None,
    locked: Annotated[
        list[str] | None,
        options.option(
            'JOINT=POSITION',
            'A joint that does not move, and where it stands [rad or m]; repeatable.',
        ),
    ] = None,
    out: Annotated[Path | None, options.out_option('<name of the robot>_model')] = None,
    namespace: options.NamespaceOption = None,
    force: ForceOption = False,
    json: JsonOption = False,
) -> None:
    """
    Make the model of a URDF, and say what the URDF leaves open.

    What is not stated is marked as not known in model.yaml, with the reason, and never guessed.
    Joints that are not in the model are held still, at 0 or as --locked says; one that mimics a
    joint follows it. Meshes, transmissions and plugins do not matter.

    Example: sosml model new robot.urdf --armature 0.0 --locked finger=0.02 --out arm
    """
    from sosml_friction.model.simple_models import skeleton_model

    text, recorded = _read(source, namespace)
    chosen = as_names(joints)
    found = skeleton_model(text, recorded if chosen is None else chosen, chosen is not None)
    found = found.with_armature(options.parse_values('--armature', armature or []))
    found = found.with_locked(options.parse_values('--locked', locked or []))
    _finish(context, found, out or Path(f'{found.name}_model'), force, json)


@model_app.command()
def pendulum(
    context: typer.Context,
    mass: MassOption,
    length: Annotated[float, options.option('M', 'From the axis to the centre of mass.')],
    inertia: Annotated[
        float | None,
        options.option('KG_M2', 'About the centre of mass; default: all mass is in one point.'),
    ] = None,
    armature: Annotated[
        float | None,
        options.option('KG_M2', 'Of the rotor at the joint, J N^2; default: not known.'),
    ] = None,
    joint: JointOption = 'joint',
    out: Annotated[Path, options.out_option('pendulum')] = Path('pendulum'),
    force: ForceOption = False,
    json: JsonOption = False,
) -> None:
    """
    Make the model of a body that hangs below a level axis, straight down at position 0.

    Example: sosml model pendulum --mass 1 --length 0.25 --armature 0.002
    """
    from sosml_friction.model.simple_models import pendulum_model

    _finish(context, pendulum_model(mass, length, inertia, armature, joint), out, force, json)


@model_app.command()
def axis(
    context: typer.Context,
    mass: MassOption,
    joint: JointOption = 'joint',
    out: Annotated[Path, options.out_option('axis')] = Path('axis'),
    force: ForceOption = False,
    json: JsonOption = False,
) -> None:
    """
    Make the model of a mass on a level slide, the motor's inertia seen at the slide included.

    Example: sosml model axis --mass 95 --joint slider
    """
    from sosml_friction.model.simple_models import axis_model

    _finish(context, axis_model(mass, joint), out, force, json)


@model_app.command()
def free(
    context: typer.Context,
    inertia: Annotated[float, options.option('KG_M2', 'All that turns, seen at the shaft.')],
    joint: JointOption = 'joint',
    out: Annotated[Path, options.out_option('shaft')] = Path('shaft'),
    force: ForceOption = False,
    json: JsonOption = False,
) -> None:
    """
    Make the model of a shaft that gravity does not turn.

    Example: sosml model free --inertia 0.0566 --joint motor
    """
    from sosml_friction.model.simple_models import free_model

    _finish(context, free_model(inertia, joint), out, force, json)


def _read(source: Path, namespace: str | None) -> tuple[str, tuple[str, ...] | None]:
    """Return a URDF, and of a bag the joints that were recorded."""
    from sosml_friction.bags.bag import Bag
    from sosml_friction.exceptions import ConfigurationError
    from sosml_friction.model.urdf_joints import read_joints
    from sosml_friction.text_file import read_text

    if source.is_dir() or source.suffix == '.mcap':
        bag = Bag.open(source, namespace)
        text = bag.text('robot_description')
        if text is None:
            raise ConfigurationError(
                f'bag {source} has no robot_description: give the URDF of the robot'
            )
        return text, bag.joint_log().reported_together(read_joints(text).joints)
    return read_text(source, 'URDF'), None


def _finish(
    context: typer.Context, model: RobotModelFile, out: Path, force: bool, json: bool
) -> None:
    from dataclasses import replace

    from sosml_friction.report.plan import model_view as view

    # With rotors of no inertia where they are not known.
    robot = model.with_armature({'*': 0.0}).make_robot()
    view.check_model_folder(out, force)
    made = {'command': command_line(context), **model.provenance}
    view.with_hashes(replace(model, provenance=made)).write(out)
    blocks = [*view.model_sentences(model, robot, out), view.model_table(model, robot)]
    print_result(json, view.model_document(model, robot), blocks, output=str(out))
