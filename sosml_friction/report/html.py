# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The report: one HTML file that needs nothing else."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.bag_analysis import BagAnalysis
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.report.drawing import to_png
from sosml_friction.report.figures import parameter_bars, residuals, s_curve, time_traces
from sosml_friction.report.findings import joint_sentence, methods_disagree, notes, sampling_text
from sosml_friction.report.html_page import number_cell, page, picture
from sosml_friction.report.inverse_view import inverse_section
from sosml_friction.report.joint_view import JointView, joint_views
from sosml_friction.report.labels import SYMBOLS, observer_label
from sosml_friction.report.number_text import (
    UNKNOWN,
    error_text,
    format_number,
    interval_text,
    value_text,
)

#: What a method calls the pairs it fits to.
_PAIRS = {'segments': 'levels', 'samples': 'samples', 'weak': 'means'}
#: Rows of windows not used that a report lists; the others are counted.
_REJECTED_ROWS = 40

_METHOD = (
    'The observers (FO: first order; SOSML: second-order sliding mode with linear terms) compute '
    'from position, velocity and effort the torque that the rigid-body model does not explain; '
    'that is the friction τ_f.',
    'Sign: τ_f is positive for positive velocity, the torque the actuator spends on friction, so '
    'that adding it to a command compensates it: M q″ + C q′ + g = τ − τ_f.',
    'Fitted is the law τ_f = sgn(v) (C + S exp(−|v| / v_s)) + B v + bias, with C, B and S not '
    'negative, either to the levels of windows of steady motion (segments) or to every sample in '
    'motion with the law passed through the observer’s own lag (samples).',
    'The weak form, where it is shown, uses no observer: position and effort are averaged under '
    'short test functions, integrated by parts so that position is not differentiated twice, and '
    'the law is fitted to these means.',
    'Standard errors come from leaving out one window, or one stretch of time, after the other; '
    'the 95 % interval follows by Student’s t, that of v_s from its profile likelihood.',
    'The Stribeck term (S, v_s) is kept only if it explains more than chance would; what the '
    'motion cannot tell is called not identifiable and given as a range, not as a number.',
)


def write_report(
    path: str | Path,
    analysis: BagAnalysis,
    truth: RobotModelFile | None = None,
    extra: Mapping[str, str] | None = None,
    progress: Callable[[str], None] = lambda step: None,
) -> Path:
    """
    Write the report of an analysis as one HTML file, pictures included, and return its path.

    The file appears when it is complete, in place of an older one.

    :param truth: a model whose friction is known to be that of the robot.
    :param extra: more rows of provenance, heading to text.
    :param progress: called with the name of each joint before its pictures are drawn.
    :raises ConfigurationError: if ``truth`` has the friction of none of the joints, or the file
        cannot be written.
    """
    path = Path(path)
    text = render_report(analysis, truth, extra, progress)
    temporary = path.with_name(f'.{path.name}.{os.getpid()}')
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            temporary.write_text(text, encoding='utf-8')
            os.replace(temporary, path)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise ConfigurationError(
            f'the report {path} cannot be written: {error.strerror}: choose another place'
        ) from error
    return path


def render_report(
    analysis: BagAnalysis,
    truth: RobotModelFile | None = None,
    extra: Mapping[str, str] | None = None,
    progress: Callable[[str], None] = lambda step: None,
) -> str:
    """
    Return the document that :func:`write_report` writes.

    :raises ConfigurationError: if ``truth`` has the friction of none of the joints.
    """
    views = joint_views(analysis, truth)
    provenance = analysis.model.provenance
    bag = str(provenance.get('bag', ''))
    title = f'Friction of {analysis.model.name}'
    sentences = ''.join(f'<p>{_sentence(view)}</p>' for view in views)
    remarks = notes(views)
    if provenance.get('recovered'):
        remarks.insert(0, 'The recording is cut off or damaged: only its readable part was used.')
    parts = [
        f'<h1>{escape(title)}</h1>',
        f'<p>From the recording <code>{escape(bag)}</code>, {sampling_text(analysis.log)}.</p>',
        f'<div class="result">{sentences}</div>',
        _notes(remarks),
    ]
    for view in views:
        progress(view.name)
        parts.append(_joint_section(view))
    if analysis.inverse is not None:
        parts.append(inverse_section(analysis, analysis.inverse))
    parts += [
        '<h2>How it was done</h2>',
        '<ul>' + ''.join(f'<li>{escape(sentence)}</li>' for sentence in _METHOD) + '</ul>',
        '<h2>Provenance</h2>',
        _provenance(analysis, truth, extra or {}),
    ]
    return page(title, parts)


def _sentence(view: JointView) -> str:
    name, _, rest = joint_sentence(view).partition(':')
    return f'<strong>{escape(name)}</strong>:{escape(rest)}'


def _notes(remarks: Sequence[str]) -> str:
    if not remarks:
        return ''
    items = ''.join(f'<li>{escape(remark)}</li>' for remark in remarks)
    return f'<div class="note"><ul>{items}</ul></div>'


def _joint_section(view: JointView) -> str:
    head = f'<h2>Joint {escape(view.name)}</h2>'
    if view.preferred is None:
        return f'{head}<p>Not available: {escape(view.unavailable)}.</p>' + picture(
            to_png(time_traces(view)), f'What was recorded of joint {view.name}.'
        )
    # What one joint shows is drawn, encoded and forgotten before the next.
    return ''.join(
        (
            head,
            _parameter_table(view),
            picture(
                to_png(s_curve(view)),
                'S-curve: samples of the observers (thinned), levels of steady windows, fitted '
                'laws. Loops between plateaus are the observers’ lag while velocity '
                'changes.',
            ),
            picture(
                to_png(time_traces(view)),
                'Time traces: green windows are used, red ones are not. The dashed line is the '
                'fitted law at the measured velocity, without the observers’ lag.',
            ),
            picture(
                to_png(parameter_bars(view)),
                'Parameters with their 95 % intervals; filled: the fit in use, hollow: the other '
                'method.',
            ),
            picture(
                to_png(residuals(view)),
                'What the law leaves of the levels. A pattern over velocity is friction that the '
                'law does not have.',
            ),
            '<h3>The other method</h3>',
            _alternatives(view),
            '<h3>Windows of steady motion</h3>',
            _segment_table(view),
        )
    )


def _parameter_table(view: JointView) -> str:
    with_truth = view.truth is not None
    truth_head = '<th rowspan="2" class="n">truth</th>' if with_truth else ''
    groups = ''.join(
        f'<th class="g l" colspan="3">{escape(observer_label(observer))} ({fit.method})</th>'
        for observer, fit in view.fits.items()
    )
    columns = (
        '<th class="n l">value</th><th class="n">standard error</th>'
        '<th class="n">95 % interval</th>'
    ) * len(view.fits)
    rows = []
    for name, symbol in SYMBOLS.items():
        unit = next(iter(view.fits.values())).fit.parameters[name].unit
        cells = f'{_name(name, symbol)}<td class="w">{escape(unit)}</td>'
        known = None if view.truth is None else view.truth.parameters.get(name)
        if with_truth:
            cells += number_cell(UNKNOWN if known is None else f'{known.value:.4g}')
        for fit in view.fits.values():
            parameter = fit.fit.parameters[name]
            cells += (
                number_cell(value_text(name, parameter), 'n l')
                + number_cell(error_text(parameter))
                + number_cell(interval_text(parameter))
            )
        rows.append(f'<tr>{cells}<td class="l">{escape(_flags(view, name))}</td></tr>')
    quality = '; '.join(
        f'{observer_label(observer)}: residual {_two_digits(fit.fit.residual_std)} {fit.unit} '
        f'({_two_digits(fit.fit.relative_error)} %) over {fit.fit.pairs} '
        f'{_PAIRS[fit.method]} in {fit.fit.clusters} '
        'independent pieces'
        for observer, fit in view.fits.items()
    )
    return (
        f'<div class="wide"><table><caption>{escape(quality)}</caption><thead><tr>'
        f'<th rowspan="2">parameter</th><th rowspan="2">unit</th>{truth_head}{groups}'
        '<th rowspan="2" class="l">flags</th></tr>'
        f'<tr>{columns}</tr></thead><tbody>{"".join(rows)}</tbody></table></div>'
    )


def _flags(view: JointView, name: str) -> str:
    """Return the flags of a parameter, by observer where observers differ."""
    flags = {
        observer: ', '.join(flag.replace('_', ' ') for flag in fit.fit.parameters[name].flags)
        for observer, fit in view.fits.items()
    }
    if len(set(flags.values())) == 1:
        return next(iter(flags.values()))
    return '; '.join(f'{observer_label(o)}: {text}' for o, text in flags.items() if text)


def _alternatives(view: JointView) -> str:
    if not view.alternatives:
        return '<p>The other method could not be used on this recording.</p>'
    verdict = (
        'The two methods differ by more than their 95 % intervals: see the note at the top.'
        if methods_disagree(view)
        else 'The two methods agree within their 95 % intervals.'
    )
    head = ''.join(
        f'<th class="n l">{escape(observer_label(o))}, {f.method}</th>'
        '<th class="n">standard error</th><th class="n">95 % interval</th>'
        for o, f in view.alternatives.items()
    )
    rows = []
    for name, symbol in SYMBOLS.items():
        cells = _name(name, symbol)
        unit = ''
        for fit in view.alternatives.values():
            parameter = fit.fit.parameters[name]
            unit = parameter.unit
            cells += (
                number_cell(value_text(name, parameter), 'n l')
                + number_cell(error_text(parameter))
                + number_cell(interval_text(parameter))
            )
        rows.append(f'<tr>{cells}<td class="w">{escape(unit)}</td></tr>')
    return (
        f'<p>{verdict}</p><div class="wide"><table><thead><tr><th>parameter</th>{head}'
        f'<th>unit</th></tr></thead><tbody>{"".join(rows)}</tbody></table></div>'
    )


def _segment_table(view: JointView) -> str:
    order = sorted(
        range(len(view.segments)),
        key=lambda k: view.segments[k].start_s - view.segments[k].end_s,
    )
    rejected = [k for k in order if view.segments[k].rejected]
    hidden = set(rejected[_REJECTED_ROWS:])
    head = ''.join(
        f'<th class="n">level {escape(observer_label(observer))} [{view.effort_unit}]</th>'
        for observer in view.fits
    )
    rows = []
    for k, segment in enumerate(view.segments):
        if k in hidden:
            continue
        cells = (
            number_cell(f'{segment.start_s:.2f}')
            + number_cell(f'{segment.end_s:.2f}')
            + number_cell(format_number(segment.velocity))
        )
        levels = [float(fit.levels[k]) for fit in view.fits.values()]
        cells += ''.join(number_cell(format_number(level)) for level in levels)
        reason = segment.rejected
        if not reason and not all(np.isfinite(levels)):
            reason = 'the observer had not started'
        style = ' class="no"' if reason else ''
        rows.append(f'<tr{style}>{cells}<td>{escape(reason)}</td></tr>')
    more = ''
    if hidden:
        more = f'<p>{len(hidden)} shorter windows, not used either, are left out here.</p>'
    return (
        '<div class="wide"><table><thead><tr><th class="n">start [s]</th><th class="n">end [s]'
        f'</th><th class="n">velocity [{view.velocity_unit}]</th>{head}<th>not used because</th>'
        f'</tr></thead><tbody>{"".join(rows)}</tbody></table></div>{more}'
    )


def _provenance(
    analysis: BagAnalysis, truth: RobotModelFile | None, extra: Mapping[str, str]
) -> str:
    known = analysis.model.provenance
    rows: dict[str, str] = {
        'recording': str(known.get('bag', '')),
        'SHA-256': str(known.get('sha256', '')),
        'first and last stamp [ns]': f'{known.get("start_ns")} to {known.get("end_ns")}',
        'samples': str(known.get('samples', '')),
        'cut off or damaged': 'yes' if known.get('recovered') else 'no',
        'fitted': str(known.get('fitted', '')),
        'versions': _pairs(known.get('versions', {})),
        'model': analysis.model.name,
        'velocity of the observers': analysis.configuration.velocity_source.replace('_', ' '),
    }
    rows.update({f'condition {key}': str(value) for key, value in analysis.log.tags.items()})
    joints = analysis.configuration.joints
    order = f' ({", ".join(joints)})' if len(joints) > 1 else ''
    for observer, gains in known.get('observers', {}).items():
        rows[f'gains of {observer_label(observer)}{order}'] = '; '.join(
            f'{gain} ' + ', '.join(f'{value:.4g}' for value in values)
            for gain, values in gains.items()
        )
    if truth is not None:
        rows['truth'] = truth.name
    rows.update(extra)
    body = ''.join(
        f'<tr><th>{escape(key)}</th><td><code>{escape(value)}</code></td></tr>'
        for key, value in rows.items()
    )
    return f'<table><tbody>{body}</tbody></table>'


def _pairs(values: Mapping[str, Any]) -> str:
    return ', '.join(f'{key} {value}' for key, value in values.items())


def _name(name: str, symbol: str) -> str:
    return f'<td class="w">{name if name == symbol else f"{name} ({symbol})"}</td>'


def _two_digits(value: float) -> str:
    return format_number(value, value)
