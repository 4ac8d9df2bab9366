# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One joint of one recording as a part of the report."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

from sosml_friction.identification.friction_fit import JointFit
from sosml_friction.report.common.drawing import to_png
from sosml_friction.report.common.html_page import number_cell, picture
from sosml_friction.report.common.labels import observer_label, symbols_of
from sosml_friction.report.common.number_text import (
    UNKNOWN,
    error_text,
    format_number,
    interval_text,
    value_text,
)
from sosml_friction.report.fit.findings import derived_sentence, methods_disagree, open_questions
from sosml_friction.report.fit.joint_view import JointView
from sosml_friction.report.fit.overview_figure import overview_figure, shown_estimates
from sosml_friction.report.fit.parameter_figure import parameter_figure, parameter_rows, row_label
from sosml_friction.report.fit.profile_figure import profile_figure
from sosml_friction.report.fit.residual_figure import residual_figure
from sosml_friction.report.fit.s_shape_figure import any_band, s_shape_figure
from sosml_friction.report.fit.segment_rows import segment_table

#: What a method calls the pairs it fits to.
_PAIRS = {
    'segments': 'levels',
    'samples': 'samples',
    'weak': 'means',
    'output_error': 'simulated samples',
}


def joint_section(view: JointView, head: str = 'h2') -> str:
    """
    Return what there is to show of a joint, HTML.

    :param head: element of the heading.
    """
    title = f'<{head}>Joint {escape(view.name)}</{head}>'
    if view.preferred is None:
        return f'{title}<p>Not available: {escape(view.unavailable)}.</p>' + picture(
            to_png(overview_figure(view)), f'What was recorded of joint {view.name}.'
        )
    # What one joint shows is drawn, encoded and forgotten before the next.
    return ''.join(
        (
            title,
            parameter_table(view.fits, view),
            open_section(view),
            checks_section(view),
            picture(to_png(s_shape_figure(view)), _s_shape_caption(view)),
            picture(to_png(overview_figure(view)), _overview_caption(view)),
            picture(
                to_png(
                    parameter_figure(
                        parameter_rows(view), None if view.truth is None else view.truth.parameters
                    )
                ),
                f'Parameters of joint {view.name} with their 95 % intervals. What is not '
                'identifiable is a bare range, with an arrow where it is open.',
            ),
            _residuals(view),
            _profiles(view),
            _alternatives(view),
            '<h3>Windows of steady motion</h3>',
            segment_table(view),
        )
    )


def _s_shape_caption(view: JointView) -> str:
    certainty = ' with its 95 % band' if any_band(view) else ''
    return (
        f'S-shape of joint {view.name}: samples (thinned), levels of steady windows with the '
        f'standard deviation within each, the fitted law{certainty}, for each observer. Below, '
        'both directions over one another against the logarithm of speed: a knee is extra '
        'friction at low speed (Stribeck), triangles apart are friction that is not symmetric. '
        'Loops between plateaus are the observers’ lag while velocity changes.'
    )


def _overview_caption(view: JointView) -> str:
    text = (
        f'Overview of joint {view.name}: shaded windows are used, hatched ones are not; their '
        'numbers are those of the table of windows. The dashed line is the fitted law at the '
        'measured velocity, without the observers’ lag.'
    )
    shown = shown_estimates(view)
    if len(shown) < len(view.estimates):
        text += f' Shown of {len(view.estimates)} estimates: {_labels(shown)}.'
    return text


def _labels(observers: list[str]) -> str:
    return ', '.join(observer_label(observer) for observer in observers)


def _residuals(view: JointView) -> str:
    figure = residual_figure(view)
    if figure is None:
        return ''
    return picture(
        to_png(figure),
        f'What the law leaves of friction of joint {view.name}. A pattern over velocity is '
        'friction that the law does not have, one over position is gravity, cogging or wear, one '
        'over time is warming or drift. Autocorrelation that outlasts the observer’s own lag (for '
        'the weak form, its test functions) says that the samples are not independent.',
    )


def _profiles(view: JointView) -> str:
    figure = profile_figure(view)
    if figure is None:
        return ''
    return picture(
        to_png(figure),
        f'Profile likelihood of joint {view.name}: how much worse the best law with this v_s (or '
        'this S) fits. Below the line it is within the 95 % interval; a curve that stays below it '
        'to an edge is a parameter that the data leave open on that side.',
    )


def parameter_table(fits: Mapping[str, JointFit], view: JointView) -> str:
    """Return the parameters of some fits of a joint, side by side, with the truth if known."""
    with_truth = view.truth is not None
    truth_head = '<th rowspan="2" class="n">truth</th>' if with_truth else ''
    groups = ''.join(
        f'<th class="g l" colspan="3">{escape(row_label(observer, fit.method))}</th>'
        for observer, fit in fits.items()
    )
    columns = (
        '<th class="n l">value</th><th class="n">standard error</th>'
        '<th class="n">95 % interval</th>'
    ) * len(fits)
    rows = []
    for name, symbol in symbols_of(*(fit.fit.parameters for fit in fits.values())).items():
        unit = next(
            fit.fit.parameters[name].unit for fit in fits.values() if name in fit.fit.parameters
        )
        cells = f'{name_cell(name, symbol)}<td class="w">{escape(unit)}</td>'
        known = None if view.truth is None else view.truth.parameters.get(name)
        if with_truth:
            cells += number_cell(UNKNOWN if known is None else f'{known.value:.4g}')
        for fit in fits.values():
            parameter = fit.fit.parameters.get(name)
            texts = [UNKNOWN] * 3
            if parameter is not None:
                texts = [value_text(name, parameter), error_text(parameter),
                         interval_text(parameter)]  # fmt: skip
            cells += number_cell(texts[0], 'n l') + ''.join(map(number_cell, texts[1:]))
        rows.append(f'<tr>{cells}<td class="l">{escape(_flags(fits, name))}</td></tr>')
    quality = '; '.join(
        f'{observer_label(observer)}: residual {_two_digits(fit.fit.residual_std)} {fit.unit} '
        f'({_two_digits(fit.fit.relative_error)} %) over {fit.fit.pairs} '
        f'{_PAIRS[fit.method]} in {fit.fit.clusters} '
        'independent pieces'
        for observer, fit in fits.items()
    )
    return (
        f'<div class="wide"><table><caption>{escape(quality)}</caption><thead><tr>'
        f'<th rowspan="2">parameter</th><th rowspan="2">unit</th>{truth_head}{groups}'
        '<th rowspan="2" class="l">flags</th></tr>'
        f'<tr>{columns}</tr></thead><tbody>{"".join(rows)}</tbody></table></div>'
    )


def name_cell(name: str, symbol: str) -> str:
    """Return the cell that names a parameter."""
    return f'<td class="w">{name if name == symbol else f"{name} ({symbol})"}</td>'


def _flags(fits: Mapping[str, JointFit], name: str) -> str:
    """Return the flags of a parameter, by observer where observers differ."""
    flags = {
        observer: ', '.join(flag.replace('_', ' ') for flag in fit.fit.parameters[name].flags)
        for observer, fit in fits.items()
        if name in fit.fit.parameters
    }
    if len(set(flags.values())) == 1:
        return next(iter(flags.values()))
    return '; '.join(f'{observer_label(o)}: {text}' for o, text in flags.items() if text)


def open_section(view: JointView) -> str:
    """Return why parameters are flagged, and what to record, as a list."""
    items = ''.join(f'<li>{escape(sentence)}</li>' for sentence in open_questions(view))
    return f'<h3>What this recording leaves open</h3><ul>{items}</ul>' if items else ''


def checks_section(view: JointView) -> str:
    """Return the checks of the model's law, and what the data tell beside its parameters."""
    if view.preferred is None:
        return ''
    fit = view.fits[view.preferred].fit
    sentences = [check.sentence for check in fit.checks]
    sentences += [derived_sentence(fit, name) for name in fit.derived]
    items = ''.join(f'<li>{escape(sentence)}</li>' for sentence in sentences)
    return f'<h3>Is it friction?</h3><ul>{items}</ul>' if items else ''


def _alternatives(view: JointView) -> str:
    if not view.alternatives:
        return '<h3>The other method</h3><p>It could not be used on this recording.</p>'
    verdict = (
        'The two methods differ by more than their 95 % intervals: see the note at the top.'
        if methods_disagree(view)
        else 'The two methods agree within their 95 % intervals.'
    )
    return (
        f'<h3>The other method</h3><p>{verdict}</p><details><summary>Its parameters</summary>'
        f'{parameter_table(view.alternatives, view)}</details>'
    )


def _two_digits(value: float) -> str:
    return format_number(value, value)
