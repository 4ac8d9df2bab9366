# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The commands ``sosml fleet``: one fit or diagnosis for each recording of a folder."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from sosml_friction.cli.app import app, print_blocks, print_json, progress, remark, show_help
from sosml_friction.cli.options import JsonOption, is_table
from sosml_friction.exceptions import ConfigurationError

if TYPE_CHECKING:
    from sosml_friction.report.fleet.rows import FleetRow

#: The result of a command, in the folder of each recording.
_RESULTS = {'fit': 'fit.json', 'diagnose': 'diagnosis.json'}
#: How often Dask begins a recording again whose worker died.
_RETRIES = 3

fleet = typer.Typer(invoke_without_command=True, callback=show_help)
app.add_typer(fleet, name='fleet', help='Fit or diagnose every recording of a folder.')

FolderArgument = Annotated[
    Path, typer.Argument(metavar='FOLDER', help='Folder of bags or tables, at any depth.')
]
OutOption = Annotated[
    Path | None,
    typer.Option(metavar='DIR', help='Where to write; default: <name of the folder>_fleet here.'),
]
JobsOption = Annotated[
    int | None,
    typer.Option(metavar='N', min=1, help='Recordings at a time; default: one for each core.'),
]
SchedulerOption = Annotated[
    str | None,
    typer.Option(
        metavar='ADDRESS',
        help='Dask scheduler, such as tcp://host:8786, whose workers do the work; they see the '
        'recordings and the results under the same paths. Needs the extra sosml_friction[dask].',
    ),
]
_FORWARDS = {'allow_extra_args': True, 'ignore_unknown_options': True}


class Done(NamedTuple):
    """Hold how a command ended: its exit code, and what it said on stderr last."""

    code: int
    said: str


@fleet.command(context_settings=_FORWARDS)
def fit(
    context: typer.Context,
    folder: FolderArgument,
    out: OutOption = None,
    jobs: JobsOption = None,
    scheduler: SchedulerOption = None,
    json: JsonOption = False,
) -> None:
    """
    Fit the friction of every recording by itself, and put all into one table.

    Every other option is handed to sosml fit as it is. Writes a folder with the results of each
    recording, and fleet.csv: robot, joint, date and parameter with its 95 % interval. With three
    recordings of a joint or more it is told by how much a parameter changes per day. A recording
    whose result is there already is not fitted again: to go on, call it once more.

    Exit code 1 if a recording could not be fitted.

    Example: sosml fleet fit recordings --model arm --effort-hold end
    """
    _run('fit', context, folder, out, jobs, scheduler, json)


@fleet.command(context_settings=_FORWARDS)
def diagnose(
    context: typer.Context,
    folder: FolderArgument,
    out: OutOption = None,
    jobs: JobsOption = None,
    scheduler: SchedulerOption = None,
    json: JsonOption = False,
) -> None:
    """
    Diagnose every recording by itself, and put all verdicts and causes into one table.

    Every other option is handed to sosml diagnose as it is; the rest is as for sosml fleet fit.

    Exit code 1 if the data of a recording are too bad to tell.

    Example: sosml fleet diagnose recordings --model arm
    """
    _run('diagnose', context, folder, out, jobs, scheduler, json)


def _run(
    command: str,
    context: typer.Context,
    folder: Path,
    out: Path | None,
    jobs: int | None,
    scheduler: str | None,
    json: bool,
) -> None:
    from sosml_friction.report.common.output import require_writable
    from sosml_friction.report.fleet.rows import failed_row, rows_csv

    out = (out or Path(f'{folder.resolve().name}_fleet')).resolve()
    recordings = find_recordings(folder, out)
    require_writable(out)
    options = [*context.args]
    for given in options:
        if given.split('=')[0] in ('--out', '--json'):
            raise ConfigurationError(
                f'{given} is an option of the fleet: put it behind the folder'
            )
    places = {name: out / name for name in recordings}
    waiting = [name for name in recordings if not (places[name] / _RESULTS[command]).is_file()]
    failed: dict[str, str] = {}
    count, ready = len(recordings), len(recordings) - len(waiting)
    with progress(f'{ready} of {count} recordings') as step, _executor(scheduler, jobs) as pool:
        # By its arguments alone, so that Dask may begin it again elsewhere.
        futures = {
            pool.submit(run_one, command, str(recordings[name]), str(places[name]), options): name
            for name in waiting
        }
        for number, future in enumerate(as_completed(futures), ready + 1):
            name = futures[future]
            done = future.result()
            if not (places[name] / _RESULTS[command]).is_file():
                failed[name] = done.said or f'sosml {command} ended with {done.code}'
                remark(f'{name}: {failed[name]}')
            step(f'{number} of {count} recordings')
    rows: list[FleetRow] = []
    for name, place in places.items():
        rows += [failed_row(name, failed[name])] if name in failed else read_rows(command, place)
    (out / 'fleet.csv').write_text(rows_csv(rows), encoding='utf-8')
    _show(command, rows, out, json)
    bad = any(row.told.startswith('bad_data') for row in rows)
    if failed or bad:
        raise typer.Exit(1)


def run_one(command: str, recording: str, out: str, options: Sequence[str]) -> Done:
    """Run one command in a process of its own, so that what breaks it breaks nothing else."""
    asked = [sys.executable, '-m', 'sosml_friction.cli.main', command, recording, '--out', out]
    Path(out).parent.mkdir(parents=True, exist_ok=True)
    ended = subprocess.run(
        [*asked, *options],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        # One thread of BLAS each: the recordings are what is done at a time.
        env={**os.environ, 'OPENBLAS_NUM_THREADS': '1'},
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
        yield executor


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
        for path in sorted(place.iterdir()):
            if path.name.startswith('.') or path.resolve() == out:
                continue
            if path.is_dir():
                if any(path.glob('*.mcap')) or is_other_bag(path):
                    found.append(path)
                else:
                    look(path)
            elif path.suffix == '.mcap' or is_table(path) or is_other_bag(path):
                found.append(path)

    look(folder)
    if not found:
        raise ConfigurationError(
            f'there is no bag and no table in {folder}: give a folder of them'
        )
    stems = ['_'.join(path.relative_to(folder).with_suffix('').parts) for path in found]
    names = [
        stem if stems.count(stem) == 1 else '_'.join(path.relative_to(folder).parts)
        for stem, path in zip(stems, found, strict=True)
    ]
    return dict(zip(names, found, strict=True))


def read_rows(command: str, place: Path) -> list[FleetRow]:
    """Return the rows of one result."""
    import json

    from sosml_friction.report.fleet.rows import diagnosis_rows, fit_rows

    document = json.loads((place / _RESULTS[command]).read_text(encoding='utf-8'))
    if command == 'diagnose':
        return diagnosis_rows(place.name, document['provenance']['model'], document)
    from sosml_friction.model.model_folder import read_model

    return fit_rows(place.name, read_model(place).name, document)


def _show(command: str, rows: Sequence[FleetRow], out: Path, json: bool) -> None:
    from sosml_friction.report.common.table import terminal_table
    from sosml_friction.report.fleet.rows import FORMAT, SHOWN, drifts, joint_tables

    found = drifts(rows)
    if json:
        print_json(
            {
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
            },
            output=str(out),
        )
        return
    blocks: list[Any] = []
    for (robot, joint), lines in joint_tables(rows).items():
        blocks += [f'{robot} {joint}'.strip(), terminal_table(SHOWN, lines, sections=True)]
    for (robot, joint, quantity, unit), drift in found.items():
        if drift.is_shown:
            blocks.append(
                f'{robot} {joint}: {quantity} changes by {drift.slope:.2g} ± '
                f'{drift.half_width:.1g} {unit} per day, over {drift.count} recordings.'
            )
    if found and not any(drift.is_shown for drift in found.values()):
        blocks.append('No parameter changes over the dates beyond its 95 % interval.')
    blocks.append(f'fleet.csv and the results of each recording are in {out}')
    print_blocks(blocks)
