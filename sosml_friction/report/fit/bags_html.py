# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The report of several recordings: what they say together first, then each of them in short."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from html import escape
from pathlib import Path

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.bag_analysis import BagAnalysis
from sosml_friction.identification.several.bags_analysis import BagsAnalysis
from sosml_friction.identification.several.consolidation import Consolidated
from sosml_friction.model.model_folder import FrictionParameters, RobotModelFile
from sosml_friction.report.common.drawing import to_png
from sosml_friction.report.common.html_page import page, picture
from sosml_friction.report.common.labels import observer_label
from sosml_friction.report.common.provenance_view import (
    method_rows,
    provenance_table,
    recording_rows,
)
from sosml_friction.report.fit.bags_figure import bags_figure
from sosml_friction.report.fit.consolidation_view import (
    bag_name,
    consolidated_remarks,
    consolidated_rows,
    consolidated_sentence,
    consolidated_table,
    model_entry,
    model_table,
)
from sosml_friction.report.fit.findings import data_remarks, joint_sentence, notes, sampling_text
from sosml_friction.report.fit.html import METHOD, notes_box, sentence_line, write_page
from sosml_friction.report.fit.joint_section import open_section, parameter_table
from sosml_friction.report.fit.joint_view import JointView, joint_views
from sosml_friction.report.fit.overview_figure import overview_figure
from sosml_friction.report.fit.parameter_figure import parameter_figure
from sosml_friction.report.fit.segment_rows import segment_table

_METHOD = (
    'Each recording is fitted alone first. The rule of the paper takes C and B from the speed '
    'ladder and the slow ladder (T1, T3), S and v_s from the reversals (T2), the bias from the '
    'slow ladder (T3). The joint fit is one regression over all recordings, each weighted by its '
    'own noise, so that each counts by what it knows.',
)


def write_bags_report(
    path: str | Path,
    analysis: BagsAnalysis,
    truth: RobotModelFile | None = None,
    extra: Mapping[str, str] | None = None,
    progress: Callable[[str], None] = lambda step: None,
) -> Path:
    """
    Write the report of several recordings as one HTML file, pictures included; return its path.

    :param truth: a model whose friction is known to be that of the robot.
    :param extra: more rows of provenance, heading to text.
    :param progress: called with what is drawn next.
    :raises ConfigurationError: if ``truth`` has the friction of none of the joints, or the file
        cannot be written.
    """
    return write_page(Path(path), render_bags_report(analysis, truth, extra, progress))


def render_bags_report(
    analysis: BagsAnalysis,
    truth: RobotModelFile | None = None,
    extra: Mapping[str, str] | None = None,
    progress: Callable[[str], None] = lambda step: None,
) -> str:
    """
    Return the document that :func:`write_bags_report` writes.

    :raises ConfigurationError: if ``truth`` has the friction of none of the joints.
    """
    _check_truth(analysis, truth)
    consolidation = analysis.consolidation
    title = f'Friction of {analysis.model.name}'
    recordings = ''.join(
        f'<li><code>{escape(bag_name(consolidation, bag))}</code>, {sampling_text(one.log)}'
        f'{_role(analysis, bag)}</li>'
        for bag, one in analysis.bags.items()
    )
    sentences, remarks, sections = [], [], []
    for joint in analysis.model.joint_names:
        entry = model_entry(consolidation, joint)
        if entry is None:
            why = consolidation.unavailable.get(joint, 'no recording has an estimate of it')
            sentences.append(f'{joint}: its friction is not available, because {why}.')
            continue
        sentences.append(consolidated_sentence(entry))
        remarks += consolidated_remarks(entry, _known(truth, joint))
        progress(joint)
        sections.append(_joint_section(analysis, entry, truth))
    parts = [
        f'<h1>{escape(title)}</h1>',
        f'<p>From {len(analysis.bags)} recordings:</p><ul>{recordings}</ul>',
        f'<div class="result">{"".join(map(sentence_line, sentences))}</div>',
        notes_box(remarks),
        *sections,
    ]
    for bag, one in analysis.bags.items():
        progress(bag)
        parts.append(_bag_section(bag_name(consolidation, bag), one, truth))
    method = ''.join(f'<li>{escape(sentence)}</li>' for sentence in (*_METHOD, *METHOD))
    parts += [
        '<h2>How it was done</h2>',
        f'<ul>{method}</ul>',
        '<h2>Provenance</h2>',
        *(
            f'<h3>{escape(bag)}</h3>{provenance_table(recording_rows(one), None, {})}'
            for bag, one in analysis.bags.items()
        ),
        '<h3>All recordings</h3>',
        provenance_table(method_rows(next(iter(analysis.bags.values()))), truth, extra or {}),
    ]
    return page(title, parts)


def _check_truth(analysis: BagsAnalysis, truth: RobotModelFile | None) -> None:
    joints = analysis.model.joint_names
    if truth is not None and not any(
        name in joints and joint.friction for name, joint in truth.joints.items()
    ):
        raise ConfigurationError(
            f'the truth {truth.name} has the friction of none of {", ".join(joints)}: give a '
            'model of the same joints'
        )


def _known(truth: RobotModelFile | None, joint: str) -> FrictionParameters | None:
    model = None if truth is None else truth.joints.get(joint)
    return None if model is None else model.friction


def _role(analysis: BagsAnalysis, bag: str) -> str:
    role = analysis.consolidation.roles.get(bag)
    return '' if role is None or not role.reason else f': {escape(role.reason)}'


def _joint_section(
    analysis: BagsAnalysis, entry: Consolidated, truth: RobotModelFile | None
) -> str:
    known = _known(truth, entry.joint)
    consolidation = analysis.consolidation
    fits = {bag: one.fit for bag, one in analysis.bags.items()}
    figure = bags_figure(consolidation, entry, fits, known)
    law = ''
    if figure is not None:
        law = picture(
            to_png(figure),
            f'Joint {entry.joint}, {observer_label(entry.observer)}: what each recording says of '
            'friction (levels of windows, or means in bins of speed with their standard '
            'deviation) and the law of the model; right against the logarithm of speed, both '
            'directions over one another; below, what the law leaves.',
        )
    return ''.join(
        (
            f'<h2>Joint {escape(entry.joint)}, all recordings</h2>',
            model_table(entry, known),
            law,
            picture(
                to_png(
                    parameter_figure(
                        consolidated_rows(consolidation, entry),
                        None if known is None else known.parameters,
                    )
                ),
                f'Parameters of joint {entry.joint} with their 95 % intervals: each recording '
                'alone, the rule of the paper, the joint fit. What is not identifiable is a bare '
                'range, with an arrow where it is open.',
            ),
            '<details><summary>Numbers of the picture</summary>'
            f'{consolidated_table(consolidation, entry, known)}</details>',
            _others(analysis, entry),
        )
    )


def _others(analysis: BagsAnalysis, entry: Consolidated) -> str:
    """Return what the other observers make of the same recordings."""
    consolidation = analysis.consolidation
    others = ''.join(
        f'<h3>{escape(observer_label(observer))}</h3>'
        f'{consolidated_table(consolidation, other, None)}'
        for observer, other in consolidation.joints[entry.joint].items()
        if observer != entry.observer
    )
    return f'<details><summary>Other observers</summary>{others}</details>' if others else ''


def _bag_section(name: str, analysis: BagAnalysis, truth: RobotModelFile | None) -> str:
    """Return one recording in short: its sentence, its numbers, its overview, its windows."""
    views = joint_views(analysis, truth)
    sentences = ''.join(f'<li>{escape(joint_sentence(view))}</li>' for view in views)
    remarks = ''.join(
        f'<li>{escape(remark)}</li>' for remark in [*data_remarks(analysis), *notes(views)]
    )
    return f'<h2>Recording {escape(name)}</h2><ul>{sentences}{remarks}</ul>' + ''.join(
        map(_bag_joint, views)
    )


def _bag_joint(view: JointView) -> str:
    overview = picture(
        to_png(overview_figure(view)),
        f'Overview of joint {view.name}: shaded windows are used, hatched ones are not; their '
        'numbers are those of the table of windows.',
    )
    if view.preferred is None:
        return f'<h3>Joint {escape(view.name)}</h3>{overview}'
    return (
        f'<h3>Joint {escape(view.name)}</h3>{overview}'
        f'<details><summary>Parameters from this recording alone</summary>'
        f'{parameter_table(view.fits, view)}{open_section(view)}</details>'
        f'<details><summary>Windows of steady motion</summary>{segment_table(view)}</details>'
    )
