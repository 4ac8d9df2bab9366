# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``sosml demo``."""

from pathlib import Path
from typing import Annotated

import typer

from sosml_friction.cli.app import app
from sosml_friction.cli.options import JsonOption, option


@app.command()
def demo(
    out: Annotated[Path, option('DIR', 'Where to write the recording and the report.')] = Path(
        'demo_output'
    ),
    seed: Annotated[int, typer.Option(help='Seed of the noise in the emulator.')] = 0,
    json: JsonOption = False,
) -> None:
    """
    Identify an emulated exoskeleton, from CAN frames to the report.

    Starts the emulator, the driver, the observers and the identifier as processes of their own,
    and compares what they find with the friction that is in the emulator.

    Example: sosml demo --out demo_output
    """
    from sosml_friction.nodes.demo import run_demo

    raise typer.Exit(run_demo(output=out, seed=seed, json=json))
