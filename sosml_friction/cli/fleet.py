# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The commands ``sosml fleet``: one fit or diagnosis for each recording of a folder."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from sosml_friction.bags.bag_metadata import METADATA
from sosml_friction.bags.tables.file_kind import is_table
from sosml_friction.cli.app import app, print_result, progress, remark, show_help
from sosml_friction.cli.options import JsonOption, option
from sosml_friction.exceptions import ConfigurationError, SosmlFrictionError

if TYPE_CHECKING:
    from sosml_friction.report.fleet.rows import FleetRow

#: The result of a command, in the folder of each recording.
_RESULTS = {'fit': 'fit.json', 'diagnose': 'diagnosis.json'}
#: The one table of all.
_TABLE = 'fleet.csv'
#: How often Dask begins a recording again whose worker died.
_RETRIES = 3

fleet = typer.Typer(name='fleet', help='Fit or diagnose every recording of a folder.')
fleet.callback(invoke_without_command=True)(show_help)
app.add_typer(fleet)

#: The commands, which do the same with another command of sosml, and the help of each.
_HELP = {
    'fit': """
    Fit the friction of every recording by itself, and put all into one table.

    Every other option is handed to sosml fit as it is. Writes a folder with the results of each
    recording, and fleet.csv: robot, joint, date and parameter with its 95 % interval. With three
    recordings of a joint or more it is told by how much a parameter changes per day. A recording
    whose result is there already is not fitted again: to go on, call it once more.

    Exit code 1 if a recording could not be fitted.

    Example: sosml fleet fit recordings --model arm --effort-hold end
    """,
    'diagnose': """
    Diagnose every recording by itself, and put all verdicts and causes into one table.

    Every other option is handed to sosml diagnose as it is; the rest is as for sosml fleet fit.

    Exit code 1 if the data of a recording are too bad to tell.

    Example: sosml fleet diagnose recordings --model arm
    """,
}


class Done(NamedTuple):
    """Hold how a command ended: its exit code, and what it said on stderr last."""

    code: int
    said: str


def _run(
    context: typer.Context,
    folder: Annotated[
        Path, typer.Argument(metavar='FOLDER', help='Folder of bags or tables, at any depth.')
    ],
    out: Annotated[
        Path | None, option('DIR', 'Where to write; default: <name of the folder>_fleet here.')
    ] = None,
    jobs: Annotated[
        int | None,
        typer.Option(metavar='N', min=1, help='Recordings at a time; default: one for each core.'),
    ] = None,
    scheduler: Annotated[
        str | None,
        option(
            'ADDRESS',
            'Dask scheduler, such as tcp://host:8786, whose workers do the work; they see the '
            'recordings and the results under the same paths. Needs the extra '
            'sosml_friction[dask].',
        ),
    ] = None,
    json: JsonOption = False,
) -> None:
    from sosml_friction.report.common.output import require_writable
    from sosml_friction.report.fleet.rows import failed_row, rows_csv

    command = str(context.info_name)
    folder, options = split_words(command, [str(folder), *context.args])
    out = (out or Path(f'{folder.resolve().name}_fleet')).resolve()
    recordings = find_recordings(folder, out)
    require_writable(out)
    places = {name: out / name for name in recordings}
    for other, result in _RESULTS.items():
        if other != command and any((place / result).is_file() for place in places.values()):
            raise ConfigurationError(
                f'{out} holds the results of sosml fleet {other}: choose another place with --out'
            )
    out.mkdir(parents=True, exist_ok=True)
    waiting = [name for name in recordings if not (places[name] / _RESULTS[command]).is_file()]
    failed: dict[str, str] = {}
    count, ready = len(recordings), len(recordings) - len(waiting)
    if ready:
        remark(
            f'{ready} of {count} recordings have a result in {out}, which stays as it is, '
            'whatever the options: remove it to begin anew'
        )
    here = str(Path.cwd())
    with progress(f'{ready} of {count} recordings') as step, _executor(scheduler, jobs) as pool:
        # By its arguments alone, so that Dask may begin it again elsewhere.
        futures = {
            pool.submit(
                run_one,
                command,
                str(recordings[name].absolute()),
                str(places[name]),
                options,
                here,
            ): name
            for name in waiting
        }
        for number, future in enumerate(as_completed(futures), ready + 1):
            name = futures[future]
            why = why_not(command, future)
            if not (places[name] / _RESULTS[command]).is_file():
                failed[name] = why
                remark(f'{name}: {why}')
            step(f'{number} of {count} recordings')
    rows: list[FleetRow] = []
    for name, place in places.items():
        if name not in failed:
            try:
                rows += read_rows(command, place)
                continue
            except (OSError, ValueError, KeyError, SosmlFrictionError):
                failed[name] = f'its result cannot be read: remove {place} to begin anew'
                remark(f'{name}: {failed[name]}')
        rows.append(failed_row(name, failed[name]))
    (out / _TABLE).write_text(rows_csv(rows), encoding='utf-8')
    _show(command, rows, out, json)
    bad = any(row.told.startswith('bad_data') for row in rows)
    if failed or bad:
        raise typer.Exit(1)


_FORWARDS = {'allow_extra_args': True, 'ignore_unknown_options': True}
for _name, _text in _HELP.items():
    fleet.command(_name, help=_text, context_settings=_FORWARDS)(_run)


def split_words(command: str, words: Sequence[str]) -> tuple[Path, list[str]]:
    """
    Return the folder among the words after a command of the fleet, and what is handed on.

    :raises ConfigurationError: if there is not one folder, or an option is the fleet's.
    """
    known: Any = typer.main.get_command(app)
    known = known.commands[command]
    # A misspelt option ends it here, and not every recording by itself.
    parser = known.make_parser(known.context_class(known, info_name=f'sosml {command}'))
    values = parser.parse_args(args=list(words))[0]
    for name in ('out', 'json'):
        if name in values:
            raise ConfigurationError(
                f'--{name} is an option of the fleet: put it behind the folder'
            )
    (argument,) = (each.name for each in known.params if each.param_type_name == 'argument')
    folders = list(values.get(argument) or ())
    if len(folders) != 1:
        raise ConfigurationError(
            f'give one folder of recordings: {" and ".join(folders)} are {len(folders)}'
            if folders
            else 'give the folder of the recordings'
        )
    options = list(words)
    # Behind options its name may be the value of one, too: it is the last.
    first = not words[0].startswith('-')
    del options[0 if first else len(words) - 1 - options[::-1].index(folders[0])]
    return Path(folders[0]), options


def why_not(command: str, future: Future[Done]) -> str:
    """Return why a command has left no result."""
    try:
        done = future.result()
    except Exception as error:  # of the cluster: whatever it is, it ends one recording alone
        return f'{type(error).__name__}: {error}'
    if done.code < 0:
        return f'sosml {command} was ended by signal {-done.code}'
    return done.said or f'sosml {command} ended with {done.code}'


def run_one(command: str, recording: str, out: str, options: Sequence[str], folder: str) -> Done:
    """
    Run one command in a process of its own, so that what breaks it breaks nothing else.

    :param folder: where paths among the options begin, if it is there.
    """
    asked = [sys.executable, '-m', 'sosml_friction.cli.main', command, recording, '--out', out]
    Path(out).parent.mkdir(parents=True, exist_ok=True)
    ended = subprocess.run(
        [*asked, *options],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        cwd=folder if Path(folder).is_dir() else None,
        check=False,
    )
    lines = ended.stderr.decode(errors='replace').strip().splitlines()
    return Done(ended.returncode, lines[-1].removeprefix('sosml: ') if lines else '')


@contextmanager
def _executor(scheduler: str | None, jobs: int | None) -> Iterator[Executor]:
    """Yield what runs the recordings: threads that wait for processes, or a Dask cluster."""
    if scheduler is None:
        with ThreadPoolExecutor(jobs or os.cpu_count()) as pool:
            try:
                yield pool
            except BaseException:
                pool.shutdown(wait=True, cancel_futures=True)
                raise
        return
    if jobs is not None:
        raise ConfigurationError('--jobs is for this machine: the workers of Dask say it there')
    try:
        from distributed import Client
    except ImportError as error:
        raise ConfigurationError(
            '--scheduler needs Dask: install it with pip install "sosml_friction[dask]"'
        ) from error
    try:
        client = Client(scheduler, timeout='5s')
    except (OSError, ValueError) as error:
        raise ConfigurationError(
            f'no Dask scheduler answers at {scheduler}: start one with dask scheduler, and '
            'workers with dask worker'
        ) from error
    with client, client.get_executor(retries=_RETRIES, pure=False) as executor:
        try:
            yield executor
        except BaseException:
            # Its own end would wait for every recording.
            executor.shutdown(wait=False)
            raise


def find_recordings(folder: Path, out: Path) -> dict[str, Path]:
    """
    Return the recordings below a folder by a name of each: bags, tables, and bags of others.

    :param out: results, which are no recordings.
    :raises ConfigurationError: if there is none.
    """
    from sosml_friction.bags.other_bag import is_other_bag

    if not folder.is_dir():
        raise ConfigurationError(f'{folder} is no folder: give one that holds recordings')
    found: list[Path] = []

    def look(place: Path) -> None:
        result = any((place / name).is_file() for name in _RESULTS.values())
        for path in sorted(place.iterdir()):
            if path.name.startswith('.') or path.resolve() == out:
                continue
            if path.is_dir():
                if is_bag_folder(path):
                    found.append(path)
                elif not (result and path.name == 'figures'):
                    look(path)
            else:
                table = is_table(path) and not result and path.name != _TABLE
                if table or path.suffix == '.mcap' or is_other_bag(path):
                    found.append(path)

    if (folder / METADATA).is_file() and is_bag_folder(folder):
        found.append(folder)
    else:
        look(folder)
    if not found:
        raise ConfigurationError(
            f'there is no bag and no table in {folder}: give a folder of them'
        )
    root = folder.parent if found == [folder] else folder
    paths = [path.relative_to(root) for path in found]
    # The last way tells a/b from a_b.
    ways: list[Callable[[Path], str]] = [
        lambda path: '_'.join(path.with_suffix('').parts),
        lambda path: '_'.join(path.parts),
        lambda path: '_'.join(part.replace('_', '__') for part in path.parts),
    ]
    taken = [Counter(map(way, paths)) for way in ways[:-1]]
    names = []
    for path in paths:
        one = (k for k, way in enumerate(ways[:-1]) if taken[k][way(path)] == 1)
        names.append(ways[next(one, -1)](path))
    if len(set(names)) < len(names):
        double = next(name for name in names if names.count(name) > 1)
        raise ConfigurationError(f'two recordings would both be called {double}: rename one')
    return dict(zip(names, found, strict=True))


def is_bag_folder(folder: Path) -> bool:
    """Tell whether a folder is one bag, and not a folder of several."""
    from sosml_friction.bags.other_bag import is_other_bag

    names = [path.name for path in folder.iterdir()]
    files = [name for name in names if name.endswith(('.mcap', '.mcap.zstd'))]
    own = re.compile(re.escape(folder.resolve().name) + r'_\d+\.mcap(\.zstd)?')
    of_one = len(files) == 1 or METADATA in names or all(map(own.fullmatch, files))
    return bool(files and of_one) or is_other_bag(folder)


def read_rows(command: str, place: Path) -> list[FleetRow]:
    """Return the rows of one result."""
    import json

    from sosml_friction.report.fleet.rows import diagnosis_rows, fit_rows, term_rows

    document = json.loads((place / _RESULTS[command]).read_text(encoding='utf-8'))
    if command == 'diagnose':
        return diagnosis_rows(place.name, document['provenance']['model'], document)
    from sosml_friction.model.model_folder import read_model
    from sosml_friction.report.terms.document import FORMAT

    rows = term_rows if document['format'] == FORMAT else fit_rows
    return rows(place.name, read_model(place).name, document)


def _show(command: str, rows: Sequence[FleetRow], out: Path, json: bool) -> None:
    from sosml_friction.identification.number_text import plus_minus
    from sosml_friction.report.common.table import terminal_table
    from sosml_friction.report.fleet.rows import FORMAT, SHOWN, drifts, joint_tables

    found = drifts(rows)
    document = {
        'format': FORMAT,
        'command': command,
        'rows': [row.to_dict() for row in rows],
        'drifts': [
            {
                **dict(zip(('robot', 'joint', 'quantity', 'unit'), key, strict=True)),
                'per_day': drift.slope,
                'half_width': drift.half_width,
                'scatter': drift.scatter,
                'recordings': drift.count,
                'shown': drift.is_shown,
            }
            for key, drift in found.items()
        ],
    }
    blocks: list[Any] = []
    for (robot, joint), lines in joint_tables(rows).items():
        blocks += [f'{robot} {joint}'.strip(), terminal_table(SHOWN, lines, sections=True)]
    for (robot, joint, quantity, unit), drift in found.items():
        if drift.is_shown:
            change = plus_minus(drift.slope, drift.half_width, unit)
            blocks.append(
                f'{robot} {joint}: {quantity} changes by {change} per day, over {drift.count} '
                'recordings.'
            )
    if found and not any(drift.is_shown for drift in found.values()):
        blocks.append('No parameter changes over the dates beyond its 95 % interval.')
    blocks.append(f'fleet.csv and the results of each recording are in {out}')
    print_result(json, document, blocks, output=str(out))
