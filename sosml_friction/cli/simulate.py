# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``sosml simulate``."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from sosml_friction.cli.options import (
    BagArgument,
    JsonOrTableOption,
    NamespaceOption,
    folder_option,
    out_option,
)


def simulate(
    bag: BagArgument,
    model: Annotated[
        Path | None, folder_option("Model folder to simulate; default: the bag's own.")
    ] = None,
    horizon: Annotated[
        float | None,
        typer.Option(
            metavar='S',
            help='Simulate windows of this length, begun anew from the measured state; default: '
            'the closed loop from end to end where the bag holds its controller, else 0.5.',
        ),
    ] = None,
    out: Annotated[Path | None, out_option('<name of the bag>_simulation')] = None,
    urdf: Annotated[
        Path | None,
        typer.Option(
            help="URDF file; default: that of --model, else the bag's robot_description."
        ),
    ] = None,
    namespace: NamespaceOption = None,
    json: JsonOrTableOption = False,
) -> None:
    """
    Simulate a recording from a model folder, and show where the two differ.

    With the bag's own controller and wanted position the whole experiment is simulated in closed
    loop. Without them the measured effort drives the model, in windows that begin anew from the
    measured state. The model's friction sticks, and the effects in its model.yaml take part.
    Prints the error of position, velocity and effort of each joint, and writes simulation.json and
    report.html.

    Example: sosml simulate recording --model recording_diagnosis --out again
    """
    from sosml_friction.bags.recorded_robot import read_recorded_robot
    from sosml_friction.bags.source import bag_hash, bag_name
    from sosml_friction.identification.output_error.fits import recorded_controllers
    from sosml_friction.report.common.output import check_output_folder, require_writable, to_json
    from sosml_friction.report.common.progress import progress
    from sosml_friction.report.common.tables import print_table
    from sosml_friction.report.simulation.document import (
        KIND,
        simulation_document,
        write_simulation,
    )
    from sosml_friction.report.simulation.rows import error_table, simulation_sentences
    from sosml_friction.simulation.recorded.recorded_loop import recorded_loop
    from sosml_friction.simulation.recorded.recorded_simulation import simulate_recording

    folder = check_output_folder(out or Path(f'{bag_name(bag)}_simulation'), KIND)
    require_writable(folder)
    with progress(f'reading {bag}') as step:
        recorded = read_recorded_robot(bag, model, urdf, namespace, own_urdf=model is not None)
        controlled = recorded_controllers(recorded.bag, recorded.log)
        loop = recorded_loop(recorded.bag, bag, recorded.log)
        found = simulate_recording(recorded.log, recorded.nominal, controlled, horizon, step, loop)
        if recorded.bag.recovery:
            found = replace(found, remarks=(recorded.bag.recovery, *found.remarks))
        provenance = {
            'bag': bag.name,
            'sha256': bag_hash(bag),
            'model': recorded.nominal.name if model is None else str(model),
        }
        step('drawing the report')
        write_simulation(folder, found, recorded.nominal, provenance)
    if json:
        document = simulation_document(found, recorded.nominal, provenance)
        typer.echo(to_json({**document, 'output': str(folder)}))
        return
    for sentence in simulation_sentences(found):
        typer.echo(sentence)
    print_table(error_table(found))
    for remark in found.remarks:
        typer.echo(f'{remark}.')
    typer.echo(f'simulation.json and report.html are in {folder}')
