# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The command ``sosml fit``."""

from collections.abc import Iterable
from itertools import chain
from pathlib import Path
from typing import Annotated, Any

import typer

from sosml_friction.api.names import as_names
from sosml_friction.cli import options
from sosml_friction.cli.app import app, command_line, open_page, print_result, progress, remark
from sosml_friction.cli.tables import takes_tables


@app.command()
@takes_tables
def fit(
    context: typer.Context,
    bags: list[Path],
    model: options.ModelOption = None,
    armature: options.ArmatureOption = None,
    urdf: options.UrdfOption = None,
    mjcf: Annotated[
        Path | None,
        options.mjcf_option(
            'Its friction is not used, and an armature of 0, which is the default there, is '
            'fitted; --armature JOINT=0 where the bodies have the rotor.'
        ),
    ] = None,
    method: Annotated[
        str,
        options.option(
            'auto|segments|samples|weak|output_error',
            'auto: a regression on position and effort without an observer (weak form), '
            'which becomes the model, and beside it the estimate of each observer, by segments '
            '(levels of steady windows) where plateaus reach down to a fifth of the top speed, '
            'else by samples (all in motion); weak: the same. segments, samples: the observers '
            'alone. output_error adds a simulation fitted to the motion, under the recorded '
            'controller or by the measured effort.',
        ),
    ] = 'auto',
    law: Annotated[
        str,
        options.option(
            'auto|coulomb_viscous|stribeck|m1..m6',
            'Law to fit; auto adds the Stribeck term where the data show it. m1 to m6, the '
            'extended friction models for servo actuators, are lists of terms, as for --terms.',
        ),
    ] = 'auto',
    terms: Annotated[
        str | None,
        options.option(
            'NAME,...',
            'Terms to fit instead of a law, such as coulomb,viscous,load_dependent_friction, with '
            'TERM@JOINT for one joint alone: by the regression that sosml diagnose uses. What is '
            'listed is free; what the model has besides stays within its tolerance of 3.5 %. '
            'docs/terms.md has all of them.',
        ),
    ] = None,
    symmetric: Annotated[
        bool,
        typer.Option(
            '--symmetric/--asymmetric', help='Whether friction is the same in both directions.'
        ),
    ] = True,
    alpha: Annotated[
        float | None,
        options.option(
            'NUMBER',
            'Exponent of the Stribeck term, 1 or 2 mostly; default: 1 unless data show another.',
        ),
    ] = None,
    zero_band: Annotated[
        float | None,
        options.option('SPEED', 'Slower is standstill [rad/s or m/s]; default: 0.001.'),
    ] = None,
    window: Annotated[
        float | None,
        options.option('S', 'Over what steadiness of speed is judged; default: 0.05.'),
    ] = None,
    trim: Annotated[
        float | None,
        options.option(
            'S', 'Least that is cut off the beginning of a steady window; default: 0.15.'
        ),
    ] = None,
    role: Annotated[
        list[str] | None,
        options.option(
            'BAG=ROLE',
            "Which of the paper's trajectories a bag is: T1 (speed ladder), T2 (symmetric "
            'reversals), T3 (slow ladder) or other; repeatable. Default: as recorded, else by '
            'its motion.',
        ),
    ] = None,
    own_bias: Annotated[
        bool | None,
        typer.Option(
            '--own-bias/--common-bias',
            help='Whether each bag has a bias of its own in the joint fit; default: where the '
            'bags differ in it.',
        ),
    ] = None,
    refit_inertia: Annotated[
        bool,
        typer.Option(
            '--refit-inertia',
            help='Fit inertia too, by the inverse model and by the weak form. It is reported; the '
            'model keeps its own. Where the bag holds its controller, the closed loop is '
            'simulated with what was found.',
        ),
    ] = False,
    body_tolerance: Annotated[
        float | None,
        options.option(
            'SHARE',
            'How far each number of the rigid body (masses, first moments, inertias, rotors) may '
            'be off, as a share of itself: it is refitted beside friction. 0: the URDF is exact. '
            'Default: as the data say, which leaves a URDF alone that fits within 3.5 %.',
        ),
    ] = None,
    bandwidth: Annotated[
        float | None,
        options.option('RAD_S', "Bandwidth of the observers; default: the bag's own gains."),
    ] = None,
    observers: Annotated[
        str | None,
        options.option(
            'NAME,...',
            'Observers to run, with gains as sosml tune proposes them; SOSML, else the first '
            f'one, makes the model. Default: those of the bag. Known: {options.OBSERVER_NAMES}.',
        ),
    ] = None,
    effort_hold: options.EffortHoldOption = None,
    namespace: options.NamespaceOption = None,
    out: Annotated[Path | None, options.out_option('<name of the first bag>_fit')] = None,
    truth: Annotated[
        Path | None, options.option('DIR', 'Model folder whose friction is known to be the truth.')
    ] = None,
    figures: options.FiguresOption = None,
    open_report: options.OpenOption = False,
    json: options.JsonOption = False,
) -> None:
    """
    Fit the friction of every joint of one or several recordings.

    Fits the law of friction to position and effort (weak form) and to what the observers say,
    prints the parameters with their standard errors, and writes a model folder (robot.urdf,
    model.yaml) with report.html, fit.json and segments.csv. An earlier fit in the same place is
    replaced, anything else is not touched.

    Several bags of the same robot are fitted each alone, then together: by the paper's rule (C and
    B from T1 and T3, S and v_s from T2, the bias from T3) and by one fit to all of them, and it is
    said which to prefer and in what the bags disagree.

    With --terms, or --law m1 to m6, any terms are fitted together, with one covariance, and the
    model folder (default: <name of the first bag>_terms) has them.

    Exit code 1 if a joint that reports effort could not be fitted, or a term could not be.

    Example: sosml fit t1 t2 t3 --role t2=T2 --out shoulder_fit
    """
    from sosml_friction.model.laws import TERM_LISTS

    source = options.stated_model(
        bags[0], model, armature, urdf, namespace, mjcf, free_rotors=True
    )
    forms = options.parse_forms(figures)
    wanted = as_names(terms) or ([law] if law in TERM_LISTS else None)
    if wanted is not None:
        from sosml_friction.bags.source import bag_name
        from sosml_friction.identification.bag_terms import fit_bag_terms
        from sosml_friction.report.common.figure_files import write_figures
        from sosml_friction.report.common.output import check_output_folder
        from sosml_friction.report.terms import document as view

        folder = check_output_folder(out or Path(f'{bag_name(bags[0])}_terms'), view.KIND)
        with progress(f'reading {bags[0]}') as step:
            found = fit_bag_terms(
                bags, wanted, source, urdf, namespace, command_line(context), step, body_tolerance
            )
            terms_fit, provenance = found
            view.write_term_fit(folder, terms_fit, provenance, step)
            write_figures(folder, 'terms', view.figure_views(terms_fit), forms)
        blocks: Iterable[Any] = [
            *view.term_blocks(terms_fit),
            f'Model, report.html and fit.json are in {folder}',
        ]
        document = view.term_fit_document(terms_fit, provenance)
        remarks, is_no = iter(found.remarks), bool(terms_fit.left)
    else:
        from sosml_friction.identification.friction_fit import FitSettings
        from sosml_friction.identification.law.law_form import LawForm
        from sosml_friction.identification.segments import SegmentSettings
        from sosml_friction.report.fit.outcome import run_fit

        segments = options.stated(zero_band=zero_band, window_s=window, trim_s=trim)
        settings = FitSettings(
            method=method,
            segments=SegmentSettings(**segments),
            refit_inertia=refit_inertia,
            form=LawForm(law, symmetric, alpha),
            body_tolerance=body_tolerance,
        )
        with progress(f'reading and fitting {bags[0]}') as step:
            done = run_fit(
                bags, out, truth, effort_hold or (), namespace, role or (), own_bias, step,
                model=source, urdf=urdf, settings=settings, bandwidth=bandwidth,
                observers=as_names(observers), command=command_line(context), figures=forms,
            )  # fmt: skip
        folder, document, remarks, is_no = done.folder, done.document, done.remarks(), done.is_no
        blocks = chain(done.blocks(), () if effort_hold else done.hold_remark(namespace))
    print_result(json, document, blocks, output=str(folder))
    for sentence in remarks:
        remark(sentence)
    if open_report:
        open_page(folder / 'report.html')
    if is_no:
        raise typer.Exit(1)
