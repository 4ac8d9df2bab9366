# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``sosml diagnose``."""

from pathlib import Path
from typing import Annotated

import typer

from sosml_friction.api.names import as_names
from sosml_friction.cli import options
from sosml_friction.cli.app import app, open_page, print_result, progress, remark
from sosml_friction.cli.tables import takes_tables


@app.command()
@takes_tables
def diagnose(
    bags: list[Path],
    model: Annotated[
        Path | None,
        options.option(
            'DIR',
            "Model folder that is put to the test, with its own URDF; default: the bag's own "
            'model and robot_description.',
        ),
    ] = None,
    armature: options.ArmatureOption = None,
    holdout: Annotated[
        Path | None,
        options.option(
            'BAG',
            'Another recording, on which the gain is measured; default: stretches of the '
            'bags that are left out in turn.',
        ),
    ] = None,
    out: Annotated[Path | None, options.out_option('<name of the first bag>_diagnosis')] = None,
    without: Annotated[str | None, options.option('EFFECT,...', 'Causes not to look for.')] = None,
    trust: Annotated[
        str | None,
        options.option(
            'GROUP=SHARE,...',
            'How far nominal parameters may be off and be refitted without being a cause, as '
            'a share of themselves or inf: masses, armature, friction, terms (springs and what '
            'else the model states beside friction), torque_constant; default 0.035 each. A '
            'friction that is a guess: friction=inf.',
        ),
    ] = None,
    keep_all: Annotated[
        bool,
        typer.Option(
            '--keep-all',
            help='Keep causes in the extended model that do not carry over to the --holdout.',
        ),
    ] = False,
    urdf: Annotated[
        Path | None, typer.Option(help='URDF file instead of that of the model.')
    ] = None,
    mjcf: Annotated[
        Path | None,
        options.mjcf_option(
            'Its friction is taken for a guess (--trust friction=inf), and the gain is measured '
            'in MuJoCo.'
        ),
    ] = None,
    namespace: options.NamespaceOption = None,
    figures: options.FiguresOption = None,
    open_report: options.OpenOption = False,
    json: Annotated[bool, options.json_option('sentences')] = False,
) -> None:
    """
    Say what a model gets wrong about recordings, name the cause, and measure the gain.

    Checks the data, refits the nominal parameters within 3.5 %, and looks in what is left for the
    causes of the catalogue. A cause is named if it predicts data that it was not fitted to, has a
    size that is possible and more than chance, and does not make the forward simulation worse;
    causes that the data cannot separate come as a set, with the experiment that would separate
    them. Where more is left than noise and the model's own uncertainty make, the verdict is
    unknown_structure: the catalogue lacks what is missing. Writes diagnosis.json, report.html and,
    with a cause that a model can have, the extended model. docs/diagnosis.md has the effects and
    the gates.

    With --mjcf the model is that of a simulation in MuJoCo; robot.xml is the extended one.

    Exit code 1 if the data are too bad to tell.

    Example: sosml diagnose recording --model config/exoskeleton --out why
    """
    from sosml_friction.bags.source import bag_name
    from sosml_friction.diagnosis.bag_diagnosis import diagnose_bags
    from sosml_friction.diagnosis.trust import parse_trust
    from sosml_friction.export.diagnosed import trust_of_a_simulation, with_simulator
    from sosml_friction.regression.settings import DiagnosisSettings
    from sosml_friction.report.common.figure_files import write_figures
    from sosml_friction.report.common.output import check_output_folder
    from sosml_friction.report.diagnosis import document as view

    forms = options.parse_forms(figures)
    folder = check_output_folder(out or Path(f'{bag_name(bags[0])}_diagnosis'), view.KIND)
    leave = as_names(without or None) or ()
    told = parse_trust(as_names(trust or None) or ())
    if mjcf is not None:
        told = trust_of_a_simulation(told)
    with progress(f'reading {bags[0]}') as step:
        source = options.stated_model(bags[0], model, armature, urdf, namespace, mjcf)
        found = diagnose_bags(
            bags,
            source,
            urdf,
            namespace,
            holdout,
            leave,
            DiagnosisSettings(trust=told),
            step,
            keep_all,
        )
        if mjcf is not None:
            step('running MuJoCo before and after')
            found = with_simulator(found, mjcf)
        diagnosis, provenance = found.diagnosis, found.provenance
        view.write_diagnosis(folder, diagnosis, found.nominal, provenance, step)
        write_figures(folder, 'diagnosis', view.figure_views(diagnosis), forms)
    document = view.diagnosis_document(diagnosis, provenance)
    done = f'diagnosis.json and report.html are in {folder}'
    print_result(json, document, [*view.diagnosis_lines(diagnosis), done], output=str(folder))
    if open_report:
        open_page(folder / 'report.html')
    if diagnosis.verdict == 'bad_data':
        remark(diagnosis.sentence)
        raise typer.Exit(1)
