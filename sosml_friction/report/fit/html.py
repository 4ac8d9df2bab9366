# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The report: one HTML file that needs nothing else."""

from collections.abc import Callable, Mapping
from html import escape

from sosml_friction.identification.log_analysis import BagAnalysis
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.report.common.html_page import heading, items, joints_box, notes_box, page
from sosml_friction.report.common.provenance_view import (
    method_rows,
    provenance_table,
    recording_rows,
)
from sosml_friction.report.fit.findings import (
    data_remarks,
    joint_sentence,
    notes,
    sampling_text,
    simulation_lines,
)
from sosml_friction.report.fit.inverse_view import inverse_section
from sosml_friction.report.fit.joint_section import joint_section
from sosml_friction.report.fit.joint_view import joint_views

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

    :param truth: a model whose friction is known to be that of the robot.
    :param extra: more rows of provenance, heading to text.
    :param progress: called with the name of each joint before its pictures are drawn.
    :raises ConfigurationError: if ``truth`` has the friction of none of the joints.
    """
    views = joint_views(analysis, truth)
    bag = escape(str(analysis.model.provenance.get('bag', '')))
    parts = [
        f'<p>From the recording <code>{bag}</code>, {sampling_text(analysis.log)}.</p>',
        joints_box(map(joint_sentence, views)),
        notes_box([*data_remarks(analysis), *notes(views)]),
    ]
    for view in views:
        progress(view.name)
        parts.append(joint_section(view))
    if analysis.inverse is not None:
        parts.append(inverse_section(analysis, analysis.inverse))
    parts += [
        items((f'{line}.' for line in simulation_lines(analysis)), heading('Simulated forwards')),
        items(METHOD, heading('How it was done')),
        heading('Provenance'),
        provenance_table(recording_rows(analysis) | method_rows(analysis), truth, extra or {}),
    ]
    return page(f'Friction of {analysis.model.name}', parts)
