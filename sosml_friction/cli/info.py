# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``sosml info``."""

from pathlib import Path

from sosml_friction.cli.app import app, print_result, progress
from sosml_friction.cli.options import JsonOption, NamespaceOption
from sosml_friction.cli.tables import takes_tables


@app.command()
@takes_tables
def info(
    bag: Path,
    namespace: NamespaceOption = None,
    json: JsonOption = False,
    recording: Path | None = None,
) -> None:
    """
    Say what a recording holds and whether its motion is complete.

    Topics and messages, joints and what was measured of them, gaps, repeated and backward stamps,
    and how much of a cut-off recording could be read.

    Example: sosml info recording --json
    """
    from sosml_friction.bags.bag import Bag
    from sosml_friction.bags.bag_information import bag_information
    from sosml_friction.bags.tables.file_kind import is_table
    from sosml_friction.report.common.bag_view import information_blocks

    with progress(f'reading {bag}'):
        information = bag_information(Bag.open(bag, namespace))
    given = recording or bag
    information['path'] = str(given)
    print_result(json, information, information_blocks(information, is_table(given)))
