# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``sosml compare``."""

from pathlib import Path
from typing import Annotated

import typer

from sosml_friction.cli.app import app, print_result
from sosml_friction.cli.options import JsonOrTableOption

FolderArgument = Annotated[
    Path, typer.Argument(metavar='MODEL', help='Model folder, such as one that sosml fit wrote.')
]


@app.command()
def compare(
    first: FolderArgument, second: FolderArgument, json: JsonOrTableOption = False
) -> None:
    """
    Show two fits or models side by side, and where they differ beyond their intervals.

    The estimates are taken for independent: a difference is beyond them if it is larger than the
    root of the sum of the squares of both halves of the 95 % intervals. A number without an
    interval is taken for exact.

    Example: sosml compare monday_fit friday_fit
    """
    from sosml_friction.model.model_folder import read_model
    from sosml_friction.report.comparison import comparison as view

    names = [str(path) for path in (first, second)]
    pairs = view.compare_models(read_model(first), read_model(second))
    blocks = [view.comparison_table(pairs, *names), view.comparison_sentence(pairs)]
    print_result(json, view.comparison_document(pairs, *names), blocks)
