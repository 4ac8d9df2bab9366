# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Tables in the place of bags, and robots without files, for the commands that read bags."""

from __future__ import annotations

import functools
import gc
import inspect
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sosml_friction.api.names import as_names
from sosml_friction.bags.tables.file_kind import SUFFIXES, is_table, table_name
from sosml_friction.cli.app import remark
from sosml_friction.cli.options import option, parse_numbers
from sosml_friction.exceptions import ConfigurationError, SosmlFrictionError
from sosml_friction.text_file import read_text

if TYPE_CHECKING:
    from sosml_friction.bags.tables.data_file import DataFile
    from sosml_friction.model.model_folder import RobotModelFile


def _columns_option(what: str) -> Any:
    return typer.Option(metavar='COLUMN[:UNIT]', help=what, rich_help_panel='Tables')


#: What a command that reads bags has beside for tables, and for a robot without files.
_TABLE_OPTIONS: dict[str, Any] = {
    'mapping': Annotated[
        Path | None,
        typer.Option(
            '--map', metavar='MAPPING.yaml', help='What is what in a table; docs/import.md.'
        ),
    ],
    'position': Annotated[
        str | None,
        _columns_option(
            'Column of position in a table, by name or by number from 0, with its unit if that is '
            'not plain, such as q:deg; several joints with commas, here and below, and which '
            'joint of the URDF it is before it: elbow=q2.'
        ),
    ],
    'velocity': Annotated[str | None, _columns_option('Column of velocity.')],
    'effort': Annotated[
        str | None, _columns_option('Column of effort: Nm, or :N, :mNm, :A, :V, :percent.')
    ],
    'current': Annotated[str | None, _columns_option('Column of current [A], with --kt.')],
    'kt': Annotated[
        str | None,
        option('VALUE', 'Nm (or N) at the joint per A, or per V, percent or count of --effort.'),
    ],
    'time': Annotated[
        str | None, _columns_option('Column of time; default: that which grows all the time.')
    ],
    'rate': Annotated[
        float | None, option('HZ', 'Samples per second of a table without a column of time.')
    ],
    'counts_per_turn': Annotated[
        float | None, option('N', 'Counts per turn of a position in counts.')
    ],
    'pendulum': Annotated[
        str | None,
        option(
            'KG,M[,KG_M2]',
            'The robot is a pendulum: mass, length to its centre, inertia about that.',
        ),
    ],
    'axis': Annotated[
        float | None, option('KG', 'The robot is this mass on a level slide, with the motor.')
    ],
    'free': Annotated[
        float | None, option('KG_M2', 'The robot is a shaft of this inertia, with the rotor.')
    ],
}
_ROBOTS = ('pendulum', 'axis', 'free')
_SERIES = ('position', 'velocity', 'effort', 'current', 'time')
_COLUMNS = (*_SERIES, 'rate', 'counts_per_turn', 'kt')


def takes_tables(command: Callable[..., None]) -> Callable[..., None]:
    """
    Let a command that reads bags read tables too, and give it options that stand for a robot.

    Its ``bags``, or its ``bag``, and ``holdout`` may be tables: they are made bags of, in a place
    that is removed when the command ends. A command with ``model`` has ``urdf`` and ``armature``
    too; one without needs no robot. One with ``recording`` is told there the path of its ``bag``
    as it was given.
    """
    parameters = inspect.signature(command).parameters
    names = [name for name in _TABLE_OPTIONS if 'model' in parameters or name not in _ROBOTS]
    name, kind = ('bags', list[Path]) if 'bags' in parameters else ('bag', Path)
    argument = typer.Argument(metavar='BAG', help='Bag (folder or file), or table.')

    def run(given: dict[str, Any], said: dict[str, Any]) -> None:
        if 'recording' in parameters:
            given['recording'] = given['bag']
        with _uncollected(), tempfile.TemporaryDirectory(prefix='sosml_') as place:
            bags = _made_bags(given, said, Path(place))
            try:
                command(**given)
            except SosmlFrictionError as error:
                text = str(error)
                for table, bag in bags.items():
                    text = text.replace(str(bag), str(table))
                raise SosmlFrictionError(text) from error

    return _with_options(command, names, run, 'recording', {name: Annotated[kind, argument]})


@contextmanager
def _uncollected() -> Iterator[None]:
    """
    Look for no garbage within: a command ends soon, and what it makes goes with it.

    Most of what the looks would go through are imports. Arrays are freed without them; figures
    that are drawn to files are not, and are looked for there.
    """
    before = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if before:
            gc.enable()


def takes_columns(command: Callable[..., None]) -> Callable[..., None]:
    """
    Give a command the options that say what the columns of a table are.

    It gets them as ``said``, by name, the mapping among them.
    """
    names = [name for name in _TABLE_OPTIONS if name not in _ROBOTS]
    return _with_options(command, names, lambda given, said: command(**given, said=said), 'said')


def _with_options(
    command: Callable[..., None],
    names: list[str],
    run: Callable[[dict[str, Any], dict[str, Any]], None],
    hidden: str,
    changed: dict[str, Any] | None = None,
) -> Callable[..., None]:
    """
    Return a command with some of the options of tables, as typer sees it.

    :param run: gets the arguments of ``command``, and all options of tables by name.
    :param hidden: parameter of ``command`` that is no option.
    :param changed: annotations of parameters in the place of the command's.
    """
    # Not typing.get_type_hints: on Python 3.10 a default of None hides the option from typer.
    own = inspect.signature(command, eval_str=True).parameters
    hints = {name: p.annotation for name, p in own.items() if name != hidden} | (changed or {})
    hints |= {name: _TABLE_OPTIONS[name] for name in names}

    @functools.wraps(command)
    def with_options(**given: Any) -> None:
        said = dict.fromkeys(_TABLE_OPTIONS) | {name: given.pop(name) for name in names}
        run(given, said)

    vars(with_options)['__signature__'] = inspect.Signature([
        inspect.Parameter(
            name, inspect.Parameter.KEYWORD_ONLY, annotation=hint,
            default=own[name].default if name in own else None,
        )
        for name, hint in hints.items()
    ])  # fmt: skip
    with_options.__annotations__ = hints
    return with_options


def _made_bags(given: dict[str, Any], said: dict[str, Any], place: Path) -> dict[Path, Path]:
    """
    Put a bag in the place of each table and a folder in that of the model.

    :param given: the arguments of the command, which are changed.
    :return: the bag that was made of each table.
    """
    places = [name for name in ('bags', 'bag', 'holdout') if given.get(name)]
    paths = [path for name in places for path in _as_list(given[name])]
    tables = [path for path in dict.fromkeys(paths) if is_table(path)]
    stated_columns = [f'--{n.replace("_", "-")}' for n in _COLUMNS if said[n] is not None]
    if stated_columns and not tables:
        raise ConfigurationError(_no_table(paths[0], stated_columns[0]))
    simple = _simple_model(said, paths[0])
    if simple is not None:
        if given['model'] is not None or given['urdf'] is not None:
            raise ConfigurationError(
                '--pendulum, --axis and --free are whole models: leave out --model and --urdf'
            )
        simple.write(place / 'model')
        given['model'] = place / 'model'
        # A bag's own robot_description would come first.
        given['urdf'] = None if len(tables) == len(paths) else place / 'model' / 'robot.urdf'
        for sentence in simple.provenance.get('assumed', ()):
            remark(f'assumed: {sentence}')
    named = [given.get(name) for name in ('model', 'urdf', 'mjcf')]
    no_robot = 'model' in given and simple is None and all(name is None for name in named)
    if tables and no_robot and said['mapping'] is None:
        raise ConfigurationError(
            f'{tables[0]} says nothing of the robot: give --pendulum MASS,LENGTH, --axis MASS, '
            '--free INERTIA, --urdf FILE or --model'
        )
    urdf = None if simple is None else simple.urdf
    if tables and simple is None:
        urdf = urdf_text(given.get('urdf'), given.get('model'), given.get('mjcf'))
        if given.get('bags') == tables:
            given['bags'] = tables = _one_of_joints(tables, said, urdf, place)
    bags = {path: place / str(k) / table_name(path) for k, path in enumerate(tables)}
    for path in tables:
        make_bag(path, bags[path], said, urdf)
    for name in places:
        own = [bags.get(path, path) for path in _as_list(given[name])]
        given[name] = own if name == 'bags' else own[0]
    return bags


def _one_of_joints(
    tables: list[Path], said: dict[str, Any], urdf: str | None, place: Path
) -> list[Path]:
    """Return one table of those that have one joint each of a robot of as many joints."""
    from sosml_friction.bags.tables.joined_tables import join_tables
    from sosml_friction.model.urdf_joints import read_joints

    known = {} if urdf is None else read_joints(urdf).joints
    joints = [name for name, joint in known.items() if joint.is_single and joint.mimic is None]
    position = said['position'] or ','
    if len(tables) < 2 or len(joints) != len(tables) or ',' in position or '=' in position:
        return tables
    columns = {name: said[name] for name in _SERIES if said[name] is not None}
    table, order, whole = join_tables(tables, joints, place, columns)
    said.update(whole)
    pairs = zip(order, tables, strict=True)
    remark(f'put side by side: {", ".join(f"{joint} of {path.name}" for joint, path in pairs)}')
    return [table]


def _no_table(path: Path, option: str) -> str:
    """Return why a recording with an option of columns is no table, and what to do."""
    if not path.exists():
        return f'{path} does not exist: give the path of a table or a bag'
    if path.is_dir() and any(is_table(file) for file in path.iterdir()):
        return (
            f'{path} is a folder of tables: name the files, or let sosml fleet fit {path} take '
            'each by itself'
        )
    if path.is_dir() or path.suffix in ('.mcap', '.db3', '.bag'):
        return f'{option} is of a table, and {path} is a bag: leave it out'
    return (
        f'{path} is neither a table nor a bag: give a table of the kind {", ".join(SUFFIXES)}, or '
        'a bag'
    )


def _as_list(paths: Path | list[Path]) -> list[Path]:
    return [paths] if isinstance(paths, Path) else paths


def urdf_text(
    urdf: Path | None, model: Path | None = None, mjcf: Path | None = None
) -> str | None:
    """
    Return a URDF, else that of a model folder or of an MJCF, None if none is given.

    :raises ConfigurationError: if it cannot be read.
    """
    from sosml_friction.model.model_folder import read_model

    if urdf is None and mjcf is not None:
        from sosml_friction.mujoco.reading import read_mjcf

        return read_mjcf(mjcf).urdf
    if urdf is None:
        return None if model is None else read_model(model).urdf
    return read_text(urdf, 'URDF')


def _simple_model(said: dict[str, Any], recording: Path) -> RobotModelFile | None:
    chosen = [name for name in _ROBOTS if said[name] is not None]
    if not chosen:
        return None
    if len(chosen) > 1:
        raise ConfigurationError(f'--{chosen[0]} and --{chosen[1]} are two robots: give one')
    from sosml_friction.model.simple_models import axis_model, free_model, pendulum_model

    joint = 'joint' if is_table(recording) else _only_joint(recording)
    if chosen == ['axis']:
        return axis_model(said['axis'], joint)
    if chosen == ['free']:
        return free_model(said['free'], joint)
    numbers = parse_numbers('--pendulum', said['pendulum'])
    if len(numbers) not in (2, 3):
        raise ConfigurationError(
            f'--pendulum {said["pendulum"]} has {len(numbers)} numbers: give mass,length in kg '
            'and m, and the inertia about the centre of mass behind them if it is known'
        )
    inertia = numbers[2] if len(numbers) == 3 else None
    return pendulum_model(numbers[0], numbers[1], inertia, joint=joint)


def _only_joint(bag: Path) -> str:
    from sosml_friction.bags.bag import Bag

    names = Bag.open(bag).joint_log().names
    if len(names) != 1:
        raise ConfigurationError(
            f'{bag} has the joints {", ".join(names)}, and --pendulum, --axis and --free are for '
            'one: make its model with sosml model pendulum --joint NAME, and give it as --model'
        )
    return names[0]


def make_bag(
    table: Path, bag: Path, said: dict[str, Any], urdf: str | None, urdf_file: Path | None = None
) -> None:
    """
    Write a table as a bag, and say what was assumed on the way.

    :param urdf: names and kinds of the joints; ``urdf_file``: goes into the bag.
    :raises ConfigurationError: if a mapping and columns are stated, or neither.
    """
    from sosml_friction.bags.tables.importer import import_recording
    from sosml_friction.bags.tables.mapping import parse_mapping, read_mapping

    if said['mapping'] is not None:
        columns = [n for n in _COLUMNS if said[n] is not None and n != 'rate']
        if columns:
            raise ConfigurationError(
                f'--map and --{columns[0].replace("_", "-")} both say what is in {table}: give one'
            )
        import_recording(table, read_mapping(said['mapping'], said['rate']), bag, remark)
        return
    content, assumed = stated_mapping(table, said, urdf)
    for sentence in assumed:
        remark(f'{table.name}: {sentence}')
    if urdf_file is not None:
        content['urdf'] = str(urdf_file.absolute())
    import_recording(table, parse_mapping(content, table), bag, remark)


def stated_mapping(
    table: Path, said: dict[str, Any], urdf: str | None
) -> tuple[dict[str, Any], list[str]]:
    """
    Return the mapping that the options of columns make, and sentences on what was assumed.

    :raises ConfigurationError: if they do not say what is needed.
    """
    from sosml_friction.bags.tables.data_file import DataFile
    from sosml_friction.bags.tables.mapping import NO_POSITION
    from sosml_friction.bags.tables.stated_columns import Columns, map_columns

    if said['position'] is None and said['velocity'] is not None:
        raise ConfigurationError(f'{table}: {NO_POSITION.format(said["velocity"])}')
    if said['position'] is None:
        raise ConfigurationError(
            f'{table} is a table, which does not say what is what: name its columns, as '
            f'--position q --effort tau, or look at sosml import {table} --guess'
        )
    if said['current'] is not None and said['effort'] is not None:
        raise ConfigurationError('--current and --effort are both the effort: give one')
    data = DataFile(table)
    entries = {name: as_names(said[name]) for name in ('position', 'velocity', 'effort')}
    if said['current'] is not None:
        current = as_names(said['current']) or ()
        entries['effort'] = tuple(_with_unit(data, x) for x in current)
    quantities = {name: own for name, own in entries.items() if own is not None}
    scales = [] if said['kt'] is None else parse_numbers('--kt', said['kt'])
    columns = Columns(
        quantities, said['time'] or '', scales, said['counts_per_turn'], said['rate']
    )
    guess = map_columns(data, columns, urdf)
    return guess.content, [*guess.sentences(), *guess.remarks]


def _with_unit(data: DataFile, current: str) -> str:
    """Return a column of current with its unit: as stated, as its header says, else A."""
    from sosml_friction.bags.tables.header_words import read_headers

    if ':' in current:
        return current
    joint, _, name = current.rpartition('=')
    (word,) = read_headers([data.find(name) or name], [joint]).values()
    # What its header has in the place of a unit counts more than the name of the option.
    return current if word.is_unit_written or word.strange else f'{current}:A'
