# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``sosml simulate``."""

from pathlib import Path
from typing import Annotated

import typer

from sosml_friction.cli import options
from sosml_friction.cli.app import app, open_page, print_result, progress
from sosml_friction.cli.tables import takes_tables


@app.command()
@takes_tables
def simulate(
    bag: Path,
    model: Annotated[
        Path | None, options.option('DIR', "Model folder to simulate; default: the bag's own.")
    ] = None,
    armature: options.ArmatureOption = None,
    horizon: Annotated[
        float | None,
        options.option(
            'S',
            'Simulate windows of this length, begun anew from the measured state; default: '
            'the closed loop from end to end where the bag holds its controller, else 0.5.',
        ),
    ] = None,
    out: Annotated[Path | None, options.out_option('<name of the bag>_simulation')] = None,
    urdf: Annotated[
        Path | None,
        typer.Option(
            help="URDF file; default: that of --model, else the bag's robot_description."
        ),
    ] = None,
    mjcf: options.MjcfOption = None,
    namespace: options.NamespaceOption = None,
    figures: options.FiguresOption = None,
    open_report: options.OpenOption = False,
    json: options.JsonOrTableOption = False,
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
    from sosml_friction.bags.source import bag_name
    from sosml_friction.diagnosis.bag_simulation import simulate_bag
    from sosml_friction.report.common.figure_files import write_figures
    from sosml_friction.report.common.output import check_output_folder
    from sosml_friction.report.simulation import document as view

    forms = options.parse_forms(figures)
    folder = check_output_folder(out or Path(f'{bag_name(bag)}_simulation'), view.KIND)
    with progress(f'reading {bag}') as step:
        source = options.stated_model(bag, model, armature, urdf, namespace, mjcf)
        found, nominal, provenance = simulate_bag(bag, source, urdf, namespace, horizon, step)
        step('drawing the report')
        view.write_simulation(folder, found, nominal, provenance)
        write_figures(folder, 'simulation', view.figure_views(found), forms)
    if open_report:
        open_page(folder / 'report.html')
    document = view.simulation_document(found, nominal, provenance)
    done = f'simulation.json and report.html are in {folder}'
    print_result(json, document, [*view.simulation_blocks(found), done], output=str(folder))
