# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``sosml repair``."""

from pathlib import Path
from typing import Annotated

import typer

from sosml_friction.cli.app import app, print_result, progress
from sosml_friction.cli.options import BagArgument, JsonOption


@app.command()
def repair(
    bag: BagArgument,
    out: Annotated[
        Path | None,
        typer.Option(
            help='The new bag, which must not exist; default: <name of the bag>_repaired.'
        ),
    ] = None,
    json: JsonOption = False,
) -> None:
    """
    Save what is whole of a damaged bag into a new one.

    Other commands read a damaged bag up to the first damaged place. This one reads behind it too:
    every part that a checksum shows to be whole. It makes index, statistics and metadata anew,
    never touches the bag itself, and says what was saved and what is lost. A saved recording may
    have holes: look at it with sosml info.

    Example: sosml repair recording --out saved
    """
    from sosml_friction.bags.repair import repair_bag
    from sosml_friction.bags.source import bag_name
    from sosml_friction.report.common.bag_view import repair_blocks

    with progress(f'reading {bag}'):
        document = repair_bag(bag, out or Path(f'{bag_name(bag)}_repaired'))
    print_result(json, document, repair_blocks(document))
