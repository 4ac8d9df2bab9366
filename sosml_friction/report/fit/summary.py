# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The first screen of a fit: what was recorded, the answer, the model, what next."""

from collections.abc import Mapping, Sequence
from typing import Any

from sosml_friction.identification.friction_fit import REGRESSION
from sosml_friction.identification.log_analysis import BagAnalysis
from sosml_friction.identification.number_text import number_text, rounded, truth_text
from sosml_friction.identification.parameter_interval import half_width
from sosml_friction.model.parameter import Parameter
from sosml_friction.report.common.figure import SUMMARY, pictures
from sosml_friction.report.common.html_page import heading, paragraph
from sosml_friction.report.common.labels import (
    PLAIN,
    observer_label,
    pairs_text,
    recorded_at,
    symbols_of,
)
from sosml_friction.report.common.table import html_table
from sosml_friction.report.fit.findings import model_questions
from sosml_friction.report.fit.joint_view import JointView


def moment(stamp_ns: Any) -> str:
    """Return a stamp as a date, where it can be one and not a time since some start."""
    known = recorded_at(stamp_ns)
    if known is not None:
        return known.isoformat(timespec='seconds')
    return f'{1e-9 * stamp_ns:.3f} s' if isinstance(stamp_ns, int) else 'unknown'


def recording_facts(analysis: BagAnalysis) -> dict[str, str]:
    """Return what was recorded, in short."""
    known, log = analysis.model.provenance, analysis.log
    began = recorded_at(known.get('start_ns'))
    span = float(log.time[-1]) if len(log) else 0.0
    length = f'{span:.1f} s, {len(log)} samples'
    if span > 0.0:
        length += f' at {(len(log) - 1) / span:.4g} Hz'
    return {
        'Recording': str(known.get('bag', '')),
        'Robot': f'{analysis.model.name} ({", ".join(log.names)})',
        'Recorded': '' if began is None else f'{began:%Y-%m-%d %H:%M} UTC',
        'Length': length,
    }


def fit_verdict(views: Sequence[JointView]) -> tuple[str, str]:
    """Return the kind of the badge, and its words."""
    fitted = [view for view in views if view.model is not None]
    if not fitted:
        return 'bad', 'No friction could be fitted'
    checks = [check for view in fitted if view.model for check in view.model.fit.checks]
    if not all(check.passed for check in checks):
        return 'open', 'Fitted, but a check says that the law does not hold as it stands'
    if len(fitted) < len(views):
        return 'open', f'Fitted for {len(fitted)} of {len(views)} joints'
    if any(map(model_questions, fitted)):
        return 'found', 'Friction fitted; the recording leaves some of it open'
    return 'good', 'Friction fitted'


def plain_table(
    parameters: Mapping[str, Parameter],
    known: Mapping[str, Parameter],
    load: Parameter | None = None,
) -> str:
    """Return a model in plain words: what, how much with half of its 95 % interval, unit."""
    columns = {'': '', 'value ± 95 %': 'n', 'unit': 'w'} | ({'truth': 'n'} if known else {})
    rows = []
    for name in symbols_of(parameters):
        if (p := parameters.get(name)) is not None:
            row = [PLAIN[name], number_text(name, p), p.unit]
            rows.append(row + ([truth_text(known, name)] if known else []))
    if load is not None:
        low, high = load.interval or (load.value - half_width(load), load.value + half_width(load))
        share = Parameter(100.0 * load.value, '%', 100.0 * load.std_error, (1e2 * low, 1e2 * high))
        row = ['share of the load besides', number_text('load_coefficient', share), '%']
        rows.append(row + ([''] if known else []))
    return html_table(columns, rows)


def joint_card(view: JointView) -> str:
    """Return a joint on the first screen: its model, its curve, and what is left."""
    if view.model is None or view.preferred is None:
        return heading(view.name, 3) + paragraph(f'Not available: {view.unavailable}.')
    fit = view.model
    load = view.load if view.preferred == REGRESSION else None
    told = pairs_text(fit.method, fit.fit.pairs)
    left = (
        f'Fitted to {told} ({observer_label(view.preferred)}); the law leaves '
        f'{rounded(fit.fit.residual_std)} {fit.unit} of them, {rounded(fit.fit.relative_error)} % '
        'of friction.'
    )
    return (
        heading(view.name, 3)
        + plain_table(fit.fit.parameters, view.known, load)
        + pictures('fit', view, SUMMARY)
        + paragraph(left)
    )


def next_steps(views: Sequence[JointView], bag: str) -> list[str]:
    """Return what to do with the fit, first of all what to record where something is open."""
    steps = [f'{view.name}: {text}' for view in views for text in model_questions(view)]
    if any(view.model is not None for view in views):
        steps += [
            f'Ask what the model still lacks: sosml diagnose {bag} --model FOLDER, the folder of '
            'this report.',
            'Take it to a simulator or controller: sosml export FOLDER --help lists the forms.',
        ]
    else:
        steps.append(f'See what the recording holds: sosml info {bag}.')
    return steps
