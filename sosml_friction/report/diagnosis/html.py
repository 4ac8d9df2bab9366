# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The page of a diagnosis."""

from collections.abc import Mapping
from html import escape
from itertools import groupby
from typing import Any

import numpy as np

from sosml_friction.diagnosis.diagnosis import Diagnosis
from sosml_friction.diagnosis.residual.joint_residual import joint_residuals
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.report.common.figure import figures_of, pictures
from sosml_friction.report.common.html_page import heading, items, notes_box, page, result_box
from sosml_friction.report.common.number_text import words
from sosml_friction.report.diagnosis.tables import causes, controls, experiments, gain, parameters

_METHOD = (
    'Unexplained is measured effort minus that of the nominal model, whose parameters were '
    'refitted within {bounds}; both sides were low-passed alike. A cause is named '
    'if, on stretches of data left out of its fit, it removes more than it does of recordings '
    'simulated without it, if its size is physically possible, and if the forward simulation '
    'of data left out gets better. Percentages of the ranking are shares of the energy of the '
    'whitened residual. ± is half of the 95 % interval.'
)
_FORWARD = (
    'The position error is that of a simulation of data left out of the fit, driven by the '
    'measured effort and restarted from the measured state every 0.3 s.'
)


def diagnosis_title(diagnosis: Diagnosis, provenance: Mapping[str, Any]) -> str:
    """Return the verdict, and which recordings and model it is about, and when it was given."""
    bags = ', '.join(str(one['bag']) for one in provenance.get('bags', ()))
    model, date = provenance.get('model', ''), str(provenance.get('diagnosed', ''))[:10]
    about = f'{bags} with {model}' if bags and model else bags or model
    told = f'Diagnosis of {about}: ' if about else 'Diagnosis: '
    return f'{told}{words(diagnosis.verdict)}' + (f' ({date})' if date else '')


def render_diagnosis(diagnosis: Diagnosis, provenance: Mapping[str, Any] | None = None) -> str:
    """
    Return the report as one HTML document, pictures included.

    :param provenance: the bags, the model and the time, for the title.
    """
    sentences = [diagnosis.sentence]
    if diagnosis.recommendation is not None:
        sentences.append(f'Next: {diagnosis.recommendation.sentence}')
    remarks = [check.sentence for check in diagnosis.checks if check.severity != 'note']
    if diagnosis.rejected is not None:
        remarks.append(f'Not named: {rejection(diagnosis.rejected)}')
    parts = [result_box(sentences), notes_box(remarks), causes(diagnosis)]
    if diagnosis.laboratory is not None:
        parts += [gain(diagnosis), experiments(diagnosis)]
        for joint in joint_residuals(diagnosis):
            parts += [heading(joint.name), pictures('diagnosis', joint)]
        whole = figures_of('diagnosis', diagnosis)
        for title, some in groupby(whole, key=lambda figure: figure.title):
            parts += [heading(title), *(figure.html(diagnosis) for figure in some)]
        parts += [parameters(diagnosis), controls(diagnosis)]
        method = _METHOD.format(bounds=_bounds(diagnosis.laboratory.settings))
        parts.append(f'<p>{escape(method)} {escape(_FORWARD)}</p>')
    parts.append(heading('Data') + items(check.sentence for check in diagnosis.checks))
    if diagnosis.laboratory is None:
        parts.append(f'<p>Library <code>{diagnosis.library_hash}</code></p>')
    return page(diagnosis_title(diagnosis, provenance or {}), parts)


def rejection(rejected: Mapping[str, Any]) -> str:
    """Return which candidate was not named, and why."""
    return f'{words(rejected["effect"])} ({rejected["joint"]}), because ' + '; '.join(
        rejected['failed']
    )


def _bounds(settings: DiagnosisSettings) -> str:
    """Return by how much nominal parameters may be off, in words."""
    text = f'{100.0 * settings.tolerance:g} % of their values'
    told = [
        f'{words(group)} {"freely" if np.isinf(share) else f"within {100.0 * share:g} %"}'
        for group, share in settings.trust.items()
    ]
    return f'{text} ({", ".join(told)})' if told else text
