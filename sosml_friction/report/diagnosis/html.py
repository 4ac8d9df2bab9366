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
from sosml_friction.diagnosis.wording import describe
from sosml_friction.identification.number_text import joint_text, words
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.report.common.drawing import page_of
from sosml_friction.report.common.figure import DETAIL, METHOD, SUMMARY, figures_of, pictures
from sosml_friction.report.common.html_page import (
    box,
    facts,
    folded,
    heading,
    items,
    page,
    paragraph,
    verdict,
)
from sosml_friction.report.diagnosis import tables

_METHOD = (
    'Unexplained is measured effort minus that of the nominal model, whose parameters were '
    'refitted within {bounds}; both sides were low-passed alike. A cause is named '
    'if, on stretches of data left out of its fit, it removes more than its floor, if its size is '
    'physically possible and further from 0 than the best of all candidates gets by chance, and '
    'if the forward simulation of data left out gets no worse. Percentages of the ranking are '
    'shares of the energy of the whitened residual. ± is half of the 95 % interval. The position '
    'error is that of a simulation of data left out of the fit, driven by the measured effort and '
    'restarted from the measured state every 0.3 s.'
)


#: By verdict the colour of the badge, and its words.
_BADGES = {
    'named': ('found', 'Cause named'),
    'ambiguous': ('open', 'These data leave a choice of causes'),
    'unknown_structure': ('open', 'Something is missing that no cause of the catalogue explains'),
    'nothing_above_floor': ('good', 'Nothing is missing beyond noise'),
    'bad_data': ('bad', 'The data are too bad to tell'),
}


def _recordings(provenance: Mapping[str, Any]) -> str:
    return ', '.join(str(one['bag']) for one in provenance.get('bags', ()))


def diagnosis_title(provenance: Mapping[str, Any]) -> str:
    """Return which recordings and model the diagnosis is about."""
    bags, model = _recordings(provenance), provenance.get('model', '')
    about = f'{bags} with {model}' if bags and model else bags or model
    return f'Diagnosis of {about}' if about else 'Diagnosis'


def clauses(sentence: str) -> list[list[str]]:
    """Return the sentences of a text, each as its clauses: what brackets hold stays together."""
    found: list[list[str]] = [['']]
    depth = 0
    for k, letter in enumerate(sentence):
        depth += (letter == '(') - (letter == ')')
        ends = depth == 0 and sentence[k + 1 : k + 2] in ('', ' ')
        if letter == ';' and ends:
            found[-1].append('')
        elif letter == '.' and ends:
            found[-1][-1] += letter
            found.append([''])
        else:
            found[-1][-1] += letter
    return [[part.strip() for part in one] for one in found if any(map(str.strip, one))]


def answer(diagnosis: Diagnosis) -> list[list[str]]:
    """Return the sentence of a diagnosis in clauses, without the faults of the data in it."""
    faults = {describe(cause, diagnosis.names) for cause in diagnosis.causes if cause.is_fault}
    # The gain has a figure and a table of its own.
    gained = '' if diagnosis.gain is None else f'On {diagnosis.gain.on}:'
    text = diagnosis.sentence
    for fault in faults:
        text = text.replace(f'{fault}; ', '').replace(f'; {fault}', '')
    return [one for one in clauses(text) if not (gained and one[0].startswith(gained))]


def _answer_html(told: list[list[str]]) -> str:
    """Return sentences as paragraphs, those of several clauses as lists below their lead."""
    text = ''
    for first, *others in told:
        lead, colon, rest = first.partition(': ')
        if others and colon:
            text += f'<p>{escape(lead)}:</p>{items([rest, *others])}'
        else:
            text += f'<p>{escape("; ".join([first, *others]))}</p>'
    return text


def render_diagnosis(diagnosis: Diagnosis, provenance: Mapping[str, Any] | None = None) -> str:
    """Return the report as one HTML document, pictures included."""
    known = provenance or {}
    told = {
        'Recording': _recordings(known),
        'Model': str(known.get('model', '')),
        'Joints': ', '.join(diagnosis.names),
        'Diagnosed': str(known.get('diagnosed', ''))[:16].replace('T', ' '),
    }
    steps = [] if diagnosis.recommendation is None else [diagnosis.recommendation.sentence]
    steps += _next_steps(diagnosis)
    laboratory = diagnosis.laboratory
    if laboratory is not None:
        span = sum(float(x.time[-1] - x.time[0]) for x in laboratory.signals)
        told['Length used'] = f'{span:.1f} s'
    kind, label = _BADGES.get(diagnosis.verdict, ('open', words(diagnosis.verdict)))
    remarks = [f'Not named: {why_not}'] if (why_not := rejection(diagnosis)) else []
    severe = [check.sentence for check in diagnosis.checks if check.severity != 'note']
    minor = [check.sentence for check in diagnosis.checks if check.severity == 'note']
    parts = [
        facts(told),
        verdict(kind, label, body=_answer_html(answer(diagnosis))),
        pictures('diagnosis', diagnosis, SUMMARY),
        tables.gain(diagnosis) if laboratory is not None else '',
        tables.causes(diagnosis),
        box('What to do next', steps, 'next'),
        box('The recording', severe),
        box('What was looked at and not named', remarks),
    ]
    if laboratory is not None:
        parts.append(tables.experiments(diagnosis))
        with page_of(len(diagnosis.names)):
            for joint in joint_residuals(diagnosis):
                parts += [heading(f'Joint {joint.name}'), pictures('diagnosis', joint)]
        whole = [x for x in figures_of('diagnosis', diagnosis) if x.part == DETAIL]
        for title, some in groupby(whole, key=lambda figure: figure.title):
            parts += [heading(title), *(figure.html(diagnosis) for figure in some)]
        method = _METHOD.format(bounds=_bounds(laboratory.settings))
        parts += [
            heading('How it was done'),
            folded('What each cause removes by itself', tables.by_cause(diagnosis)),
            folded('Parameters of the nominal model', tables.parameters(diagnosis)),
            folded('What a name has to exceed', tables.floors(diagnosis)),
            folded('What this motion can tell apart', pictures('diagnosis', diagnosis, METHOD)),
            folded('Methods', paragraph(method)),
        ]
    parts.append(folded('More on the data', items(minor)))
    if laboratory is None:
        parts.append(f'<p>Library <code>{diagnosis.library_hash}</code></p>')
    return page(diagnosis_title(known), parts)


def _next_steps(diagnosis: Diagnosis) -> list[str]:
    """Return what a person does with each verdict, beside the experiment that it recommends."""
    if diagnosis.verdict == 'bad_data':
        return ['Mend what is said of the recording, and record again.']
    if any(cause.in_model for cause in diagnosis.terms):
        return [
            'The folder of this report holds the extended model: sosml simulate RECORDING --model '
            'FOLDER shows it beside a recording, best one that it was not fitted to.'
        ]
    return []


def rejection(diagnosis: Diagnosis) -> str:
    """Return which candidate was not named, and why; '' if there is none."""
    rejected = diagnosis.rejected
    if rejected is None:
        return ''
    key = rejected['effect'], rejected['joint']
    # What is a sum of waves may be named already, and only one more is not.
    further = 'a further ' if key in {cause.key for cause in diagnosis.terms} else ''
    why = '; '.join(rejected['failed'])
    return f'{further}{words(key[0])} ({joint_text(key[1])}), because {why}'


def _bounds(settings: DiagnosisSettings) -> str:
    """Return by how much nominal parameters may be off, in words."""
    text = f'{100.0 * settings.tolerance:g} % of their values'
    told = [
        f'{words(group)} {"freely" if np.isinf(share) else f"within {100.0 * share:g} %"}'
        for group, share in settings.trust.items()
    ]
    return f'{text} ({", ".join(told)})' if told else text
