# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Fit one or several recordings and write the results: all of ``sosml fit`` but its options."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.source import bag_name
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.bag_analysis import analyse_bag
from sosml_friction.identification.log_analysis import BagAnalysis
from sosml_friction.identification.several.bags_analysis import BagsAnalysis, analyse_bags
from sosml_friction.model.model_folder import read_model
from sosml_friction.report.common.figure_files import write_figures
from sosml_friction.report.common.tables import parameter_table
from sosml_friction.report.fit import results
from sosml_friction.report.fit.consolidation_view import bags_answers, bags_table
from sosml_friction.report.fit.findings import answers, caveats
from sosml_friction.report.fit.joint_view import joint_views
from sosml_friction.report.fit.outcome import FitOutcome
from sosml_friction.study.gain_proposal import parse_effort_hold


def run_fit(
    bags: Sequence[Path],
    out: Path | None = None,
    truth: Path | None = None,
    effort_hold: Sequence[str] = (),
    namespace: str | None = None,
    roles: Sequence[str] = (),
    own_bias: bool | None = None,
    step: Callable[[str], None] = lambda what: None,
    figures: Sequence[str] = (),
    **how: Any,
) -> FitOutcome:
    """
    Fit friction to recordings and write a model folder with its report.

    :param out: folder of the results; None: the name of the first bag and ``_fit``.
    :param truth: model folder whose friction is known to be that of the robot.
    :param effort_hold: ``HOLD`` or ``JOINT=HOLD``.
    :param roles: ``BAG=ROLE``, of several bags.
    :param own_bias: whether each of several bags has a bias of its own.
    :param step: called with what is done next.
    :param figures: forms in which the figures are written as files too.
    :param how: the other arguments of
        :func:`~sosml_friction.identification.bag_analysis.analyse_bag`.
    :raises SosmlFrictionError: as that function, or if ``out`` holds something else.
    """
    several = len(bags) > 1
    if not several and (roles or own_bias is not None):
        raise ConfigurationError(
            f'{"--role" if roles else "--own-bias"} says how several bags are put together, and '
            'one is given: give the others too, or leave it out'
        )
    folder = results.check_destination(out or Path(f'{bag_name(bags[0])}_fit'))
    known = None if truth is None else read_model(truth)
    names = Bag.open(bags[0], namespace).joint_log().names if effort_hold else ()
    how |= {'namespace': namespace, 'effort_hold': parse_effort_hold(effort_hold, names)}
    analysis = (
        analyse_bags(bags, roles=roles, own_bias=own_bias, progress=step, **how)
        if several
        else analyse_bag(bags[0], progress=step, **how)
    )
    document = results.fit_document(analysis, known)
    step('drawing the report')
    results.write_results(folder, analysis, known, None, lambda what: step(f'drawing {what}'))
    for report, drawn in results.figure_views(analysis, known):
        write_figures(folder, report, drawn, figures)
    if isinstance(analysis, BagsAnalysis):
        apart = analysis.consolidation
        without = [n for n, joint in analysis.model.joints.items() if joint.friction is None]
        return FitOutcome(
            folder,
            dict(zip(bags, analysis.bags.values(), strict=True)),
            document,
            found=[*bags_answers(analysis), *_body_sentences(next(iter(analysis.bags.values())))],
            table=bags_table(analysis, known),
            open_ends=(),
            failed=[*apart.unavailable, *(n for n in apart.joints if n in without)],
        )
    views, fit = joint_views(analysis, known), analysis.fit
    return FitOutcome(
        folder,
        {bags[0]: analysis},
        document,
        found=[*answers(views), *_body_sentences(analysis)],
        table=parameter_table(analysis, known),
        open_ends=caveats(views),
        failed=[j for j in fit.unavailable if j not in fit.joints] + list(analysis.unmodelled),
    )


def _body_sentences(analysis: BagAnalysis) -> list[str]:
    if analysis.body is None:
        return []
    return [f'{text[:1].upper()}{text[1:]}.' for text in analysis.body.sentences()]
