# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``sosml trajectory``."""

from pathlib import Path
from typing import Annotated

import typer

from sosml_friction.cli.app import app, print_result, remark
from sosml_friction.cli.options import JsonOption, option


@app.command()
def trajectory(
    name: Annotated[
        str,
        typer.Argument(
            metavar='NAME',
            help='speed_ladder (or T1), symmetric_reversals (T2), slow_ladder (T3), slow_s_shape, '
            'reversal, multisine or rich.',
        ),
    ],
    model: Annotated[Path | None, option('DIR', 'Model folder; default: the exoskeleton.')] = None,
    urdf: Annotated[Path | None, option('FILE', "URDF file; default: the model's.")] = None,
    stated: Annotated[
        list[str] | None,
        typer.Option(
            '--set',
            metavar='KEY=VALUE',
            help='An option of the trajectory, a list with commas; repeatable. All have centre, '
            'start, scale, effort_margin and acceleration_limit; docs/parameters.md has the rest.',
        ),
    ] = None,
    plot: Annotated[Path | None, option('FILE.png', 'Picture to draw.')] = None,
    out: Annotated[
        Path | None, option('FILE.csv', 'Samples every 10 ms, if it is within all limits.')
    ] = None,
    json: JsonOption = False,
) -> None:
    """
    Show an identification trajectory and whether a robot can do it.

    Prints how long it lasts and what it asks of each joint, beside the limits of the URDF: the
    effort is that of the rigid body, with an allowance for friction. Options that are not set are
    those of identifier_node in the parameter file beside the model folder (DIR.yaml), or defaults.

    Exit code 1 if it is beyond a limit.

    Example: sosml trajectory multisine --set amplitude=0.2 --plot multisine.png
    """
    from sosml_friction.motion.plan import plan_trajectory
    from sosml_friction.report.common.output import check_file, write_file
    from sosml_friction.report.plan import trajectory_view as view

    if plot is not None:
        check_file(plot, '--plot', '.png', b'\x89PNG')
    if out is not None:
        check_file(out, '--out', '.csv', b'time [s],')
    planned = plan_trajectory(name, model, urdf, stated or [])
    if plot is not None:
        from sosml_friction.report.common.drawing import to_png
        from sosml_friction.report.plan.trajectory_figure import trajectory_figure

        write_file(plot, to_png(trajectory_figure(planned)))
    written = None if planned.beyond else out
    if written is not None:
        write_file(written, view.trajectory_csv(planned).encode())
    paths = {'plot': plot, 'output': written}
    told = {key: None if path is None else str(path) for key, path in paths.items()}
    document, table = view.trajectory_document(planned), view.trajectory_table(planned)
    print_result(json, document, [table], **told)
    if planned.beyond:
        if out is not None:
            remark(f'{out} is not written: the trajectory is beyond a limit')
        raise typer.Exit(1)
