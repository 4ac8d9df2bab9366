# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``sosml doctor``."""

import typer

from sosml_friction.cli.app import app, print_result
from sosml_friction.cli.options import JsonOrTableOption


@app.command()
def doctor(json: JsonOrTableOption = False) -> None:
    """
    Look at this machine, and say what to do about what is missing.

    Versions, the cache of compiled code, ROS 2 and its middleware, CAN interfaces, the permission
    to run in real time, and the optional libraries. Nothing is changed and no bus is opened.

    Exit code 1 if something is missing that every command needs.

    Example: sosml doctor --json
    """
    from sosml_friction.report.plan import machine

    found = machine.examine()
    blocks = [machine.machine_table(found), machine.machine_sentence(found)]
    document = machine.machine_document(found)
    print_result(json, document, blocks)
    if not document['ready']:
        raise typer.Exit(1)
