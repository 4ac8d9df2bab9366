# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``sosml export``."""

from pathlib import Path
from typing import Annotated

import typer

from sosml_friction.cli import options
from sosml_friction.cli.app import app, print_blocks, print_json
from sosml_friction.exceptions import ConfigurationError


@app.command()
def export(
    model: Annotated[Path, typer.Argument(metavar='MODEL', help='Model folder.')],
    to: Annotated[
        str,
        typer.Option(metavar='csv|latex|urdf', help='Which form; docs/terms.md says what fits.'),
    ],
    out: Annotated[
        Path | None,
        typer.Option(metavar='FILE', help='File to write; default: that of the target, here.'),
    ] = None,
    json: Annotated[bool, options.json_option('sentences')] = False,
) -> None:
    """
    Write a model for another program.

    What the target can hold is written; what it cannot is said. An existing file is not
    overwritten.

    Example: sosml export shoulder_fit --to urdf --out robot_with_friction.urdf
    """
    from sosml_friction.export.common.target import TARGETS
    from sosml_friction.model.model_folder import read_model

    target = TARGETS[to]()
    source = read_model(model)
    file = out or Path(target.file)
    if file.exists():
        raise ConfigurationError(f'{file} exists and is not overwritten: choose another --out')
    lost, text = target.lost(source), target.text(source)
    try:
        file.write_text(text, encoding='utf-8')
    except OSError as error:
        raise ConfigurationError(f'{file} cannot be written: {error.strerror}') from error
    if json:
        print_json({'format': 'sosml_friction/export/1', 'target': to, 'lost': lost},
                   output=str(file))  # fmt: skip
        return
    said = f'{to} cannot hold: {", ".join(lost)}.' if lost else 'Nothing was lost.'
    print_blocks([f'{file} is written.', said])
