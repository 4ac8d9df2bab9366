# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``sosml export``."""

from pathlib import Path
from typing import Annotated

import typer

from sosml_friction.cli import options
from sosml_friction.cli.app import app, print_result
from sosml_friction.exceptions import ConfigurationError


@app.command()
def export(
    model: Annotated[Path, typer.Argument(metavar='MODEL', help='Model folder.')],
    to: Annotated[
        str,
        options.option(
            'csv|isaaclab|json|latex|mjcf|ros2-control|sdf|urdf|usd',
            'Which form; docs/export.md says what fits.',
        ),
    ],
    out: Annotated[
        Path | None, options.option('FILE', 'File to write; default: that of the target, here.')
    ] = None,
    bag: Annotated[
        Path | None,
        options.option(
            'BAG',
            'Recorded motion on which constants stand in for what the target cannot hold, '
            "and the error is measured; default: the velocities of the model's fit.",
        ),
    ] = None,
    mjcf: Annotated[
        Path | None,
        options.option(
            'FILE',
            "With --to mjcf: the file whose joints get the model; default: the model's URDF "
            'as MuJoCo reads it.',
        ),
    ] = None,
    json: Annotated[bool, options.json_option('sentences')] = False,
) -> None:
    """
    Write a model for another program.

    What the target can hold is written, with its 95 % intervals in comments. What it cannot is
    said there and here, with the error of effort that it costs on the recorded motion, where
    Coulomb and viscous friction are refitted to stand in for it. An existing file is not
    overwritten.

    Example: sosml export shoulder_fit --to mjcf --bag recording --out robot.xml
    """
    from sosml_friction.export.common.motion import assumed_motion, recorded_motion
    from sosml_friction.export.common.target import TARGETS
    from sosml_friction.model.model_folder import read_model

    kind = TARGETS[to]
    source = read_model(model)
    motion = assumed_motion(source, model) if bag is None else recorded_motion(source, bag)
    target = kind(motion, mjcf)
    file = out or Path(target.file)
    if file.exists():
        raise ConfigurationError(f'{file} exists and is not overwritten: choose another --out')
    lost, losses, text = target.lost(source), target.losses(source), target.text(source)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding='utf-8')
    except OSError as error:
        raise ConfigurationError(f'{file} cannot be written: {error.strerror}') from error
    document = {'format': 'sosml_friction/export/1', 'target': to, 'lost': lost, 'losses': losses}
    said = f'{to} cannot hold: {", ".join(lost)}.' if lost else 'Nothing was lost.'
    blocks = [f'{file} is written.', said, *(f'{one}.' for one in losses)]
    print_result(json, document, blocks, output=str(file))
