# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``sosml study``."""

from pathlib import Path
from typing import Annotated

import typer

from sosml_friction.api.names import as_names
from sosml_friction.cli import options
from sosml_friction.cli.app import app, open_page, print_result, progress
from sosml_friction.exceptions import ConfigurationError

_MOST_PROCESSES = 1024


@app.command()
def study(
    out: Annotated[Path, options.option('DIR', 'Where to write the report.')] = Path(
        'study_output'
    ),
    seeds: Annotated[
        int | None, options.option('N', 'Noise seeds that are scored, 1 to 100; default: 5.')
    ] = None,
    tuning_seeds: Annotated[
        int | None, options.option('N', 'Other noise seeds, to tune on, 1 to 100; default: 2.')
    ] = None,
    evaluations: Annotated[
        int | None,
        options.option('N', 'Gain sets tried in each tuning, 4 to 100000; default: 300.'),
    ] = None,
    observers: Annotated[
        str | None, options.option('NAME,...', 'Observers of the study; default: all.')
    ] = None,
    motions: Annotated[
        str | None, options.option('NAME,...', 'slow, reversal; default: both.')
    ] = None,
    conditions: Annotated[
        str | None, options.option('NAME,...', 'nominal, noise, mismatch; default: all.')
    ] = None,
    bits: Annotated[
        int, options.option('N', 'Resolution of the encoders per turn, 8 to 24.')
    ] = 16,
    processes: Annotated[
        int | None, options.option('N', 'Processes to share the work; default: one per core.')
    ] = None,
    quick: Annotated[
        bool,
        typer.Option(
            '--quick',
            help='A first look: 24 evaluations, 2 scoring seeds, 1 tuning seed, plant steps of '
            '200 us instead of 50 us, where nothing else is said.',
        ),
    ] = False,
    figures: options.FiguresOption = None,
    open_report: options.OpenOption = False,
    json: options.JsonOption = False,
) -> None:
    """
    Compare the observers in simulation, as the paper does, with all tuned equally well.

    Slow S-shape and reversal; exact signals, encoder noise, wrong model. Every observer is tuned
    with the same number of evaluations, on other noise than it is scored on: once for each motion
    and condition, and once for both noisy motions together. Writes study.html, study.json and the
    figures. An earlier study in the same place is replaced, anything else is not touched.

    Takes some minutes on two cores; the result does not depend on how many there are.

    Example: sosml study --quick --observers first_order,sosml,kalman --out study_output
    """
    from sosml_friction.report.common.figure_files import write_figures
    from sosml_friction.report.common.output import check_output_folder
    from sosml_friction.report.study import results as view
    from sosml_friction.report.study.tables import study_tables
    from sosml_friction.study.run import QUICK, StudySettings, run_study

    given = options.stated(
        seeds=seeds,
        tuning_seeds=tuning_seeds,
        evaluations=evaluations,
        observers=as_names(observers),
        motions=as_names(motions),
        conditions=as_names(conditions),
    )
    settings = StudySettings(**{**(QUICK if quick else {}), **given}, bits=bits)
    if processes is not None and not 1 <= processes <= _MOST_PROCESSES:
        raise ConfigurationError(
            f'the number of processes is {processes}: use 1 to {_MOST_PROCESSES}'
        )
    forms = options.parse_forms(figures)
    folder = check_output_folder(out, view.study_kind())
    with progress('starting') as step:
        result = run_study(settings, processes, step)
        step('fitting friction laws')
        document = view.study_document(result)
        view.write_study(folder, result, document, lambda name: step(f'drawing {name}'))
        write_figures(folder, 'study', {'': result}, forms)
    if open_report:
        open_page(folder / 'study.html')
    done = f'study.html, study.json and the figures are in {folder}'
    print_result(json, document, [study_tables(result), done], output=str(folder))
