# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The application that every command registers itself with, and what commands print with.

Modules that load NumPy, Pinocchio or Matplotlib are imported in the functions that need them, here
and in every command, so that --help and a misspelt option answer at once.
"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterable, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from sosml_friction.report.common.progress import Step

app = typer.Typer(
    name='sosml',
    context_settings={'help_option_names': ['-h', '--help']},
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    help='Friction of robot joints without a torque sensor, and what a model of the robot gets '
    'wrong. Begin with demo, or with fit and a recording or a table; then diagnose.',
)


def _print_version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        typer.echo(f'sosml {version("sosml_friction")}')
        raise typer.Exit


@app.callback(invoke_without_command=True)
def _sosml(
    context: typer.Context,
    _: Annotated[
        bool,
        typer.Option(
            '--version', is_eager=True, callback=_print_version, help='Print the version and exit.'
        ),
    ] = False,
) -> None:
    show_help(context)


def show_help(context: typer.Context) -> None:
    """Print the help of a group that was called without a command, and end with exit code 2."""
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
        raise typer.Exit(2)


def command_line(context: typer.Context) -> str:
    """Return what the tool was called with, for the provenance of what it writes."""
    return shlex.join(['sosml', *(context.obj or ())])


def remark(text: str) -> None:
    """Print one sentence on stderr."""
    print(f'sosml: {" ".join(text.split())}', file=sys.stderr)


def print_result(
    json: bool, document: Mapping[str, Any], blocks: Iterable[Any], **more: Any
) -> None:
    """
    Print a result on stdout: sentences, each a line as long as it is, and tables.

    :param json: print the document, with ``more`` entries at its end, as one JSON object instead.
    """
    from sosml_friction.report.common.output import to_json
    from sosml_friction.report.common.table import print_table

    if json:
        typer.echo(to_json({**document, **more}))
        return
    for block in blocks:
        if isinstance(block, str):
            typer.echo(block)
        else:
            print_table(block)


def open_page(page: Path) -> None:
    """Open a report in the browser, or say where it is where there is none."""
    import webbrowser

    if not webbrowser.open(page.absolute().as_uri()):
        remark(f'no browser could be opened: open {page} yourself')


def progress(what: str) -> AbstractContextManager[Step]:
    """Show what is done on a terminal, as :func:`sosml_friction.report.common.progress` does."""
    from sosml_friction.report.common.progress import progress as shown

    return shown(what)
