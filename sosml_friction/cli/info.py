# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``sosml info``."""

from sosml_friction.cli.app import app, print_blocks, print_json, progress
from sosml_friction.cli.options import BagArgument, JsonOption, NamespaceOption


@app.command()
def info(bag: BagArgument, namespace: NamespaceOption = None, json: JsonOption = False) -> None:
    """
    Say what a bag holds and whether its motion is complete.

    Topics and messages, joints and what was measured of them, gaps, repeated and backward stamps,
    and how much of a cut-off recording could be read.

    Example: sosml info recording --json
    """
    from sosml_friction.bags.bag import Bag
    from sosml_friction.bags.bag_information import bag_information
    from sosml_friction.report.common.bag_view import information_blocks

    with progress(f'reading {bag}'):
        information = bag_information(Bag.open(bag, namespace))
    if json:
        print_json(information)
    else:
        print_blocks(information_blocks(information))
