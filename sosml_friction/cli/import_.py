# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``sosml import``."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

import typer

from sosml_friction.cli.app import app, print_json, progress, remark
from sosml_friction.cli.options import JsonOption
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.share import share_directory

FORMAT = 'sosml_friction/import/1'


@app.command('import')
def import_(
    file: Annotated[
        Path, typer.Argument(metavar='FILE', help='Recording: .mat, .csv, .npz or .npy.')
    ],
    mapping: Annotated[
        Path | None,
        typer.Option(
            '--map',
            metavar='MAPPING.yaml',
            help='Which variable is what, in which unit; default: the shipped mapping that is '
            'named in the file name.',
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar='BAG', help='Bag to make; default: the name of the file, in this folder.'
        ),
    ] = None,
    json: JsonOption = False,
) -> None:
    """
    Turn a recording of another format into a bag.

    An existing bag is not overwritten. The URDF and model that the mapping names go into the bag,
    so that sosml fit needs nothing else.

    Example: sosml import DATA_EMPS.mat --map config/import/emps.yaml --out emps
    """
    from sosml_friction.bags.bag import Bag
    from sosml_friction.bags.bag_information import bag_information
    from sosml_friction.bags.importer import import_recording

    if not file.is_file():
        raise DataError(f'{file} does not exist: give the file to import')
    if mapping is None:
        mapping = _shipped_mapping(file)
        remark(f'using the shipped mapping {mapping}')
    with progress(f'importing {file}') as step:
        path = import_recording(file, mapping, out if out is not None else Path(file.stem))
        step('reading the bag back')
        information = bag_information(Bag.open(path))
    motion, duration = information['joint_states'], information['duration_s']
    if json:
        document = {'format': FORMAT, 'file': str(file), 'mapping': str(mapping), 'bag': str(path)}
        kept = ('duration_s', 'joint_states', 'descriptions')
        print_json(document, **{key: information[key] for key in kept})
        return
    measured = '; '.join(f'{joint} ({", ".join(x)})' for joint, x in motion['measured'].items())
    typer.echo(f'{path}: {motion["samples"]} samples over {duration:.2f} s of {measured}')


def _shipped_mapping(file: Path) -> Path:
    """
    Return the mapping in config/import whose name is a word of the file's name.

    :raises ConfigurationError: if none or several are; the sentence lists those that exist.
    """
    folder = share_directory() / 'config' / 'import'
    shipped = sorted(folder.glob('*.yaml'))
    words = {file.stem.lower(), *re.split(r'[^a-z0-9]+', file.stem.lower())}
    found = [path for path in shipped if path.stem.lower() in words]
    if len(found) != 1:
        names = ', '.join(path.stem for path in shipped) or 'none'
        raise ConfigurationError(
            f'the name {file.name} says not which mapping to use: give one with --map (shipped '
            f'are {names}, in {folder})'
        )
    return found[0]
