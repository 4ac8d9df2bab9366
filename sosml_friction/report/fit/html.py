# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The report: one HTML file that needs nothing else."""

from collections.abc import Callable, Mapping
from html import escape
from typing import Any

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.log_analysis import BagAnalysis
from sosml_friction.identification.several.bags_analysis import BagsAnalysis
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.report.common.drawing import page_of
from sosml_friction.report.common.figure import pictures
from sosml_friction.report.common.html_page import (
    box,
    cards,
    facts,
    folded,
    heading,
    items,
    page,
    verdict,
)
from sosml_friction.report.common.labels import observer_label
from sosml_friction.report.fit.consolidation_view import (
    BagsJoint,
    bag_name,
    bags_answers,
    bags_joints,
    consolidated_remarks,
    consolidated_table,
    model_table,
)
from sosml_friction.report.fit.findings import (
    data_remarks,
    joint_sentence,
    notes,
    sampling_text,
    simulation_lines,
)
from sosml_friction.report.fit.inverse_view import inverse_section
from sosml_friction.report.fit.joint_section import joint_section, open_section, parameter_table
from sosml_friction.report.fit.joint_view import JointView, joint_views
from sosml_friction.report.fit.segment_rows import segment_table
from sosml_friction.report.fit.summary import (
    fit_verdict,
    joint_card,
    moment,
    next_steps,
    plain_table,
    recording_facts,
)

#: How it was done, in sentences.
METHOD = (
    'The observers (FO: first order; SOSML: second-order sliding mode with linear terms) compute '
    'from position, velocity and effort the torque that the rigid-body model does not explain; '
    'that is the friction τ_f.',
    'Sign: τ_f is positive for positive velocity, the torque the actuator spends on friction, so '
    'that adding it to a command compensates it: M q″ + C q′ + g = τ − τ_f.',
    'Fitted is the law τ_f = sgn(v) (C + S exp(−|v| / v_s)) + B v + bias, with C, B and S not '
    'negative, either to the levels of windows of steady motion (segments) or to every sample in '
    'motion with the law passed through the observer’s own lag (samples). A law by direction has '
    'B ± D_B, S ± D_S and C ± bias.',
    'The weak form, where it is shown, uses no observer: position and effort are averaged under '
    'short test functions, integrated by parts so that position is not differentiated twice, and '
    'the law is fitted to these means.',
    'The velocity of a window is its position difference over its duration.',
    'Standard errors come from leaving out one window, or one stretch of time, after the other; '
    'the 95 % interval follows by Student’s t, that of v_s from its profile likelihood. The band '
    'about a curve is the 95 % interval of the law at that speed, if the law is of that form.',
    'The Stribeck term (S, v_s) is kept only if it explains more than chance would; what the '
    'motion cannot tell is called not identifiable and given as a range, not as a number. Its '
    'curve is the best fit, known at the speeds of the data and nowhere else.',
)


def render_report(
    analysis: BagAnalysis,
    truth: RobotModelFile | None = None,
    extra: Mapping[str, str] | None = None,
    progress: Callable[[str], None] = lambda step: None,
) -> str:
    """
    Return the report of an analysis as one HTML document, pictures included.

    :raises ConfigurationError: if ``truth`` has the friction of none of the joints.
    """
    views = joint_views(analysis, truth)
    summaries, sections = [], []
    with page_of(len(views)):
        for view in views:
            progress(view.name)
            summaries.append(joint_card(view))
            sections.append(joint_section(view))
    if analysis.inverse is not None:
        sections.append(inverse_section(analysis, analysis.inverse))
    rows = recording_rows(analysis) | method_rows(analysis, truth) | dict(extra or {})
    bag = str(analysis.model.provenance.get('bag', ''))
    parts = [
        facts(recording_facts(analysis)),
        verdict(*fit_verdict(views), map(joint_sentence, views)),
        cards(summaries),
        box('Before you use the numbers', notes(views, beside=False)),
        box('The recording', [f'{sampling_text(analysis.log)}.', *data_remarks(analysis)]),
        box('What to do next', next_steps(views, bag), 'next'),
        *sections,
        items((f'{line}.' for line in simulation_lines(analysis)), heading('Simulated forwards')),
        heading('How it was done'),
        folded('Methods and signs', items(METHOD)),
        folded('Provenance', provenance_table(rows)),
    ]
    return page(f'Friction of {analysis.model.name}' + (f' from {bag}' if bag else ''), parts)


_SEVERAL = (
    'Each recording is fitted alone first. The rule of the paper takes C and B from the speed '
    'ladder and the slow ladder (T1, T3), S and v_s from the reversals (T2), the bias from the '
    'slow ladder (T3). The joint fit is one regression over all recordings, each weighted by its '
    'own noise, so that each counts by what it knows.',
)
_BAGS_NEXT = (
    'Where recordings differ beyond their intervals, find out what differed: warmth, load, wear.',
    'Ask what the model still lacks: sosml diagnose RECORDING --model FOLDER, with the folder '
    'that this report is in.',
)


def render_bags_report(
    analysis: BagsAnalysis,
    truth: RobotModelFile | None = None,
    extra: Mapping[str, str] | None = None,
    progress: Callable[[str], None] = lambda step: None,
) -> str:
    """Return the report of several recordings as one HTML document, pictures included."""
    consolidation, joints = analysis.consolidation, analysis.model.joint_names
    if truth is not None and not any(j in joints and x.friction for j, x in truth.joints.items()):
        raise ConfigurationError(
            f'the truth {truth.name} has the friction of none of {", ".join(joints)}: give a '
            'model of the same joints'
        )
    views = bags_joints(analysis, truth)
    recordings = ''.join(
        f'<li><code>{escape(bag_name(consolidation, bag))}</code>, {sampling_text(one.log)}'
        f'{f": {escape(reason)}" if reason else ""}</li>'
        for bag, one in analysis.bags.items()
        for reason in [consolidation.roles[bag].reason]
    )
    remarks, sections, summaries = [], [], []
    for joint, view in views.items():
        remarks += consolidated_remarks(view)
        progress(joint)
        summaries.append(heading(joint, 3) + plain_table(view.entry.parameters, view.known))
        sections.append(_joint_section(view))
    with page_of(len(analysis.bags) * len(joints)):
        for bag, one in analysis.bags.items():
            progress(bag)
            sections.append(_bag_section(bag_name(consolidation, bag), one, truth))
    first = next(iter(analysis.bags.values()))
    provenance = ''.join(
        heading(bag, 3) + provenance_table(recording_rows(one))
        for bag, one in analysis.bags.items()
    )
    provenance += heading('All recordings', 3)
    provenance += provenance_table(method_rows(first, truth) | dict(extra or {}))
    badge = 'good', f'Friction fitted to {len(analysis.bags)} recordings'
    if len(views) < len(joints):
        badge = 'open', f'Fitted for {len(views)} of {len(joints)} joints'
    if not views:
        badge = 'bad', 'No friction could be fitted'
    spans = ', '.join(f'{float(one.log.time[-1]):.1f} s' for one in analysis.bags.values())
    parts = [
        facts(
            recording_facts(first)
            | {'Recording': ', '.join(map(str, analysis.bags)), 'Length': spans}
        ),
        verdict(*badge, bags_answers(analysis)),
        cards(summaries),
        box('Before you use the numbers', remarks),
        f'<div class="box"><h3>The recordings</h3><ul>{recordings}</ul></div>',
        box('What to do next', _BAGS_NEXT, 'next'),
        *sections,
        heading('How it was done'),
        folded('Methods and signs', items((*_SEVERAL, *METHOD))),
        folded('Provenance', provenance),
    ]
    names = ', '.join(map(str, analysis.bags))
    return page(f'Friction of {analysis.model.name} from {names}', parts)


def _joint_section(view: BagsJoint) -> str:
    entry = view.entry
    others = ''.join(
        heading(observer_label(observer), 3)
        + consolidated_table(view._replace(entry=other, truth=None))
        for observer, other in view.consolidation.joints[entry.joint].items()
        if observer != entry.observer
    )
    return (
        heading(f'Joint {entry.joint}, all recordings')
        + model_table(view)
        + pictures('bags', view)
        + folded('Numbers of the picture', consolidated_table(view))
        + folded('Other observers', others)
    )


def _bag_section(name: str, analysis: BagAnalysis, truth: RobotModelFile | None) -> str:
    """Return one recording in short: its sentence, its numbers, its overview, its windows."""
    views = joint_views(analysis, truth)
    texts = [*map(joint_sentence, views), *data_remarks(analysis), *notes(views)]
    return items(texts, heading(f'Recording {name}')) + ''.join(map(_bag_joint, views))


def _bag_joint(view: JointView) -> str:
    shown = heading(f'Joint {view.name}', 3) + pictures('bags', view)
    if view.preferred is None:
        return shown
    numbers = parameter_table(view.fits, view) + open_section(view)
    return (
        shown
        + folded('Parameters from this recording alone', numbers)
        + folded('Windows of steady motion', segment_table(view))
    )


#: Entries of the provenance that are shown otherwise.
_ELSEWHERE = frozenset(
    {'bag', 'sha256', 'start_ns', 'end_ns', 'samples', 'recovered', 'fitted', 'versions',
     'observers', 'fits', 'unavailable', 'consolidation', 'bags'}
)  # fmt: skip


def recording_rows(analysis: BagAnalysis) -> dict[str, str]:
    """Return what identifies the recording, heading to text."""
    known = analysis.model.provenance
    rows = {
        'recording': str(known.get('bag', '')),
        'SHA-256': str(known.get('sha256', '')),
        'first and last stamp [ns]': f'{known.get("start_ns")} to {known.get("end_ns")}',
        'recorded': f'{moment(known.get("start_ns"))} to {moment(known.get("end_ns"))}',
        'samples': str(known.get('samples', '')),
        'cut off or damaged': 'yes' if known.get('recovered') else 'no',
    }
    rows.update({f'condition {key}': str(value) for key, value in analysis.log.tags.items()})
    return rows


def method_rows(analysis: BagAnalysis, truth: RobotModelFile | None) -> dict[str, str]:
    """Return what was done with it, by which software, and the truth, heading to text."""
    known = analysis.model.provenance
    rows = {
        'fitted': str(known.get('fitted', '')),
        'versions': _pairs(known.get('versions', {})),
        'model': analysis.model.name,
        'velocity of the observers': analysis.configuration.velocity_source.replace('_', ' '),
    }
    joints = analysis.configuration.joints
    order = f' ({", ".join(joints)})' if len(joints) > 1 else ''
    for observer, gains in known.get('observers', {}).items():
        rows[f'gains of {observer_label(observer)}{order}'] = '; '.join(
            f'{gain} ' + ', '.join(f'{value:.4g}' for value in values)
            for gain, values in gains.items()
        )
    rows |= {
        str(key): _pairs(value, '; ') if isinstance(value, Mapping) else str(value)
        for key, value in known.items()
        if key not in _ELSEWHERE
    }
    return rows | ({} if truth is None else {'truth': truth.name})


def provenance_table(rows: Mapping[str, str]) -> str:
    """Return headings and texts as HTML."""
    body = ''.join(
        f'<tr><th>{escape(key)}</th><td><code>{escape(value)}</code></td></tr>'
        for key, value in rows.items()
    )
    return f'<div class="wide"><table><tbody>{body}</tbody></table></div>'


def _pairs(values: Mapping[str, Any], separator: str = ', ') -> str:
    return separator.join(
        f'{key} ({_pairs(value)})' if isinstance(value, Mapping) else f'{key} {value}'
        for key, value in values.items()
        if value is not None
    )
