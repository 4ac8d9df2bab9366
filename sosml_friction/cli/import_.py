# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``sosml import``."""

import os
import re
from pathlib import Path
from shlex import quote
from typing import Annotated, Any

import typer

from sosml_friction.bags.tables.file_kind import table_name
from sosml_friction.cli.app import app, print_result, progress, remark
from sosml_friction.cli.options import JsonOption, option
from sosml_friction.cli.tables import make_bag, takes_columns, urdf_text
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.share import share_directory

FORMAT = 'sosml_friction/import/1'
GUESS_FORMAT = 'sosml_friction/import_guess/1'


@app.command('import')
@takes_columns
def import_(
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar='FILE',
            help='Table (CSV, JSON, packed or not, MAT, HDF5, Excel, NPZ, NPY, Parquet) or bag.',
        ),
    ],
    said: dict[str, Any],
    guess: Annotated[
        bool,
        typer.Option(
            '--guess', help='Look at the data, propose a mapping with reasons, and write it.'
        ),
    ] = False,
    urdf: Annotated[
        Path | None, typer.Option(help='URDF of the joints, for --guess and named columns.')
    ] = None,
    out: Annotated[
        Path | None,
        option(
            'PATH',
            'Bag to make, of several files the folder of the bags, with --guess the mapping; '
            'default: the name of the file, in this folder.',
        ),
    ] = None,
    json: JsonOption = False,
) -> None:
    """
    Turn recordings of other formats into bags.

    What is what in a table say the columns, or a mapping (docs/import.md); without both it is the
    shipped mapping that is named in the file name. An existing bag is not overwritten. The URDF
    and model that the mapping names go into the bag, so that sosml fit needs nothing else. A bag
    of rosbag2 in SQLite, or of ROS 1, needs no mapping.

    Example: sosml import DATA_EMPS.mat --map config/import/emps.yaml --out emps
    """
    from sosml_friction.bags.other_bag import is_other_bag

    for file in files:
        if not file.exists():
            raise DataError(f'{file} does not exist: give the file to import')
        if file.suffix == '.mcap' or (file.is_dir() and not is_other_bag(file)):
            raise DataError(f'{file} is a bag, or a folder: a bag of MCAP is used as it is')
    columns = [name for name, value in said.items() if value is not None and name != 'rate']
    if guess and (len(files) > 1 or columns):
        raise ConfigurationError(
            '--guess looks at one file and finds out what is what: give one file, and no --map or '
            'column'
        )
    if guess:
        _guess(files[0], urdf, said['rate'], out, json)
        return
    places = {file: _place(file, out, len(files)) for file in files}
    if len(set(places.values())) < len(files):
        raise ConfigurationError('two files have the same name: import them one after the other')
    documents = [_import(file, place, dict(said), urdf, json) for file, place in places.items()]
    one = documents[0] if len(documents) == 1 else {'imports': documents}
    bag = documents[0]['bag']
    told = [f'Next: sosml info {bag}, then sosml fit {bag}']
    print_result(json, {'format': FORMAT, **one}, told)


def _place(file: Path, out: Path | None, count: int) -> Path:
    if out is None:
        return Path(table_name(file))
    return out if count == 1 else out / table_name(file)


def _import(
    file: Path, place: Path, said: dict[str, Any], urdf: Path | None, json: bool
) -> dict[str, Any]:
    """Make one bag, say what is in it, and return that."""
    from sosml_friction.bags.bag import Bag
    from sosml_friction.bags.bag_information import bag_information, constant_sentences
    from sosml_friction.bags.other_bag import copy_bag, is_other_bag

    stated = [name for name, value in said.items() if value is not None]
    if is_other_bag(file) and stated:
        raise ConfigurationError(
            f'{file} is a bag, which says itself what it holds: leave out '
            f'--{"map" if stated[0] == "mapping" else stated[0].replace("_", "-")}'
        )
    if urdf is not None and (is_other_bag(file) or set(stated) <= {'mapping', 'rate'}):
        raise ConfigurationError(
            '--urdf is for --guess and for columns that are named: a mapping names its own as '
            'urdf, and a bag holds one'
        )
    if not is_other_bag(file) and set(stated) <= {'rate'}:
        said['mapping'] = _shipped_mapping(file)
        remark(f'using the shipped mapping {said["mapping"]}')
    with progress(f'importing {file}') as step:
        if is_other_bag(file):
            copy_bag(file, place)
        else:
            make_bag(file, place, said, urdf_text(urdf), urdf)
        step('reading the bag back')
        information = bag_information(Bag.open(place))
    motion, duration = information['joint_states'], information['duration_s']
    if motion is None:
        remark(f'{place} has no motion: {information["joint_states_problem"]}')
    else:
        for sentence in constant_sentences(motion):
            remark(sentence)
    if motion is not None and not json:
        measured = '; '.join(
            f'{joint} ({", ".join(x)})' for joint, x in motion['measured'].items()
        )
        typer.echo(f'{place}: {motion["samples"]} samples over {duration:.2f} s of {measured}')
    kept = ('duration_s', 'joint_states', 'descriptions')
    named = {'file': str(file), 'mapping': str(said['mapping'] or ''), 'bag': str(place)}
    return {**named, **{key: information[key] for key in kept}}


def _guess(
    file: Path, urdf: Path | None, rate: float | None, out: Path | None, json: bool
) -> None:
    """Write the mapping that a file speaks for."""
    from sosml_friction.bags.tables.data_file import DataFile
    from sosml_friction.bags.tables.guess import guess_mapping

    path = out if out is not None else Path(f'{table_name(file)}.yaml')
    if path.exists():
        raise ConfigurationError(f'{path} exists and is not overwritten: choose another --out')
    with progress(f'looking at {file}'):
        found = guess_mapping(DataFile(file), urdf_text(urdf), rate)
    if urdf is not None:
        found.content['urdf'] = os.path.relpath(urdf.absolute(), path.absolute().parent)
    try:
        text = found.to_yaml(f'Proposed for {file.name}: look through it.')
        path.write_text(text, encoding='utf-8')
    except OSError as error:
        raise ConfigurationError(f'{path} cannot be written: {error.strerror}') from error
    command = f'sosml import {quote(str(file))} --map {quote(str(path))}'
    document = {
        'format': GUESS_FORMAT, 'file': str(file), 'mapping': str(path), 'content': found.content,
        'reasons': found.reasons, 'remarks': found.remarks, 'left_open': found.left_open,
        'next': command,
    }  # fmt: skip
    told, fill = [*found.sentences(), *found.remarks], 'Look through'
    if found.left_open:
        told.append(f'Left open, as nothing in the file tells it: {", ".join(found.left_open)}')
        fill = 'Fill in what is left open in'
    print_result(json, document, [*told, f'{fill} {path}, then: {command}'])


def _shipped_mapping(file: Path) -> Path:
    """
    Return the mapping in config/import whose name is a word of the file's name.

    :raises ConfigurationError: if none is, or several are; the sentence lists those that exist.
    """
    folder = share_directory() / 'config' / 'import'
    shipped = sorted(folder.glob('*.yaml'), key=lambda path: -len(path.stem))
    words = re.sub(r'[^a-z0-9]+', '_', table_name(file).lower())
    found = [path for path in shipped if f'_{path.stem}_' in f'_{words}_']
    # "emps_pulses" has "emps" in it, and is the one that is meant.
    if not found or any(path.stem not in found[0].stem for path in found):
        names = ', '.join(sorted(path.stem for path in shipped)) or 'none'
        raise ConfigurationError(
            f'the name {file.name} says not which mapping to use: let sosml import {file} --guess '
            'propose one, name its columns, as --position q, or give one with --map (shipped are '
            f'{names}, in {folder})'
        )
    return found[0]
