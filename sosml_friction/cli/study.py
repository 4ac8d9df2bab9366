# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``sosml study``."""

from pathlib import Path
from typing import Annotated

import typer

from sosml_friction.api.names import as_names
from sosml_friction.cli import options
from sosml_friction.cli.app import app, open_page, print_blocks, print_json, progress
from sosml_friction.exceptions import ConfigurationError

_MOST_PROCESSES = 1024

OutOption = Annotated[Path, options.folder_option('Where to write the report.')]
ObserversOption = Annotated[
    str | None, options.names_option('Observers of the study; default: all.')
]
SeedsOption = Annotated[
    int | None,
    typer.Option(metavar='N', help='Noise seeds that are scored, 1 to 100; default: 5.'),
]
TuningSeedsOption = Annotated[
    int | None,
    typer.Option(metavar='N', help='Other noise seeds, to tune on, 1 to 100; default: 2.'),
]
EvaluationsOption = Annotated[
    int | None,
    typer.Option(metavar='N', help='Gain sets tried in each tuning, 4 to 100000; default: 300.'),
]
BitsOption = Annotated[
    int, typer.Option(metavar='N', help='Resolution of the encoders per turn, 8 to 24.')
]
ProcessesOption = Annotated[
    int | None,
    typer.Option(metavar='N', help='Processes to share the work; default: one per core.'),
]
QuickOption = Annotated[
    bool,
    typer.Option(
        '--quick',
        help='A first look: 24 evaluations, 2 scoring seeds, 1 tuning seed, plant steps of '
        '200 us instead of 50 us, where nothing else is said.',
    ),
]


@app.command()
def study(
    out: OutOption = Path('study_output'),
    seeds: SeedsOption = None,
    tuning_seeds: TuningSeedsOption = None,
    evaluations: EvaluationsOption = None,
    observers: ObserversOption = None,
    motions: Annotated[str | None, options.names_option('slow, reversal; default: both.')] = None,
    conditions: Annotated[
        str | None, options.names_option('nominal, noise, mismatch; default: all.')
    ] = None,
    bits: BitsOption = 16,
    processes: ProcessesOption = None,
    quick: QuickOption = False,
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
    from sosml_friction.report.study.results import (
        check_study_destination,
        study_document,
        write_study,
    )
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
    folder = check_study_destination(out)
    with progress('starting') as step:
        result = run_study(settings, processes, step)
        step('fitting friction laws')
        document = study_document(result)
        write_study(folder, result, document, lambda name: step(f'drawing {name}'))
        write_figures(folder, 'study', {'': result}, forms)
    if open_report:
        open_page(folder / 'study.html')
    if json:
        print_json(document, output=str(folder))
    else:
        done = f'study.html, study.json and the figures are in {folder}'
        print_blocks([study_tables(result), done])
