# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the figures and tables of a diagnosis draw is what the numbers say."""

from __future__ import annotations

import dataclasses
import itertools
import re

import numpy as np
import pytest
from known_robots import SLIDER_STEP

from sosml_friction.diagnosis.decision.cause import Cause
from sosml_friction.diagnosis.decision.confusability import Confusability
from sosml_friction.diagnosis.residual.lookalikes import ambiguous_pairs, most_alike
from sosml_friction.diagnosis.residual.variance_steps import variance_steps
from sosml_friction.diagnosis.wording import describe
from sosml_friction.identification.number_text import words
from sosml_friction.model.parameter import Parameter
from sosml_friction.report.diagnosis.html import (
    answer,
    clauses,
    rejection,
    render_diagnosis,
)
from sosml_friction.report.diagnosis.tables import experiments, floors, parameters
from sosml_friction.report.figures.diagnosis.confusability_map import MOST, ConfusabilityMap
from sosml_friction.report.figures.diagnosis.timing import milliseconds


def test_the_cascade_of_variance_falls_from_all_to_the_noise(diagnosis):
    steps = variance_steps(diagnosis, 0)
    assert (steps[0].low, steps[0].high) == (0.0, 100.0)
    assert [step.label for step in steps[-2:]] == ['unexplained', 'noise']
    for above, below in itertools.pairwise(steps[1:]):
        assert above.low == pytest.approx(below.high)
    assert steps[1].high == pytest.approx(100.0)
    assert steps[-1].low == 0.0
    # The noise of 1 N at 250 Hz is 2 f_band / 250 of its variance in the band.
    left = diagnosis.stages[0]['relative_error_percent']['slider']
    band = np.sqrt(2.0 * diagnosis.band_hz * SLIDER_STEP)
    tau = diagnosis.laboratory.signals[0].band.apply(diagnosis.laboratory.signals[0].tau)
    wanted = 100.0 * band / float(np.sqrt(np.mean(tau**2)))
    assert np.sqrt(steps[-1].high / 100.0) * left == pytest.approx(wanted, rel=0.2)


def test_the_set_that_is_left_open_is_marked_in_the_map(diagnosis):
    assert diagnosis.verdict == 'ambiguous'
    pairs = ambiguous_pairs(diagnosis)
    names = {effect for pair in pairs for effect, _ in pair}
    assert {'effort_bias', 'asymmetric_friction'} <= names
    figure = ConfusabilityMap().draw(diagnosis)
    boxes = figure.axes[0].patches
    # Both directions of each pair whose two causes were candidates.
    assert len(boxes) == 2 * len(pairs)
    for box in boxes:
        column, row = round(box.get_x() + 0.5), round(box.get_y() + 0.5)
        labels = [label.get_text() for label in figure.axes[0].get_yticklabels()]
        one, other = (
            (label.partition(',')[0].replace(' ', '_'), 'slider')
            for label in (labels[row], labels[column])
        )
        assert (one, other) in pairs or (other, one) in pairs


def test_a_map_too_large_keeps_what_was_named_and_the_most_alike():
    m = 90
    share = np.eye(m)
    share[7, 80] = share[80, 7] = 0.9
    joints = tuple('*' if k == 0 else f'joint_{k % 3}' for k in range(m))
    found = Confusability(tuple(f'effect_{k}' for k in range(m)), joints, share, np.zeros(m))
    kept = most_alike(found, {('effect_33', 'joint_0')}, MOST)
    assert len(kept) < m
    assert {7, 80, 33} <= set(kept.tolist())
    assert list(dict.fromkeys(joints[k] for k in kept))[-1] == '*'
    assert len(set(kept.tolist())) == len(kept)


def test_the_tables_say_what_to_do_what_changed_and_what_a_name_exceeds(diagnosis):
    text = experiments(diagnosis)
    assert 'free hanging hold' in text
    assert text.index('these data') < text.index('multisine')
    rows = re.findall(r'<tr><td>(slider [a-z]+)</td>', parameters(diagnosis))
    assert rows == ['slider coulomb', 'slider viscous', 'slider bias', 'slider armature']
    text = floors(diagnosis)
    assert diagnosis.library_hash in text
    assert 'at least 0.5 % of data left out' in text
    finding = diagnosis.selection.accepted[0]
    assert f'{100.0 * finding.floor:.2f} %' in text
    assert f'{100.0 * finding.score.cv_gain:.2f} %' in text


def test_the_page_starts_with_the_verdict_and_its_sentence(diagnosis):
    text = render_diagnosis(diagnosis)
    body = text[text.index('<body>') :]
    assert body.index('These data leave a choice') < body.index('<svg')
    assert body.index('class="result open"') < body.index('<table')
    assert text.count('<svg') == 8
    bare = dataclasses.replace(
        diagnosis, laboratory=None, selection=None, confusability=None, gain=None, causes=(),
        recommendation=None, rejected=None,
    )  # fmt: skip
    assert '<svg' not in render_diagnosis(bare)


def test_the_page_says_what_it_is_about(diagnosis):
    provenance = {
        'bags': [{'bag': 'T1'}, {'bag': 'T<2>'}],
        'model': 'exoskeleton',
        'diagnosed': '2026-11-22T18:15:56+00:00',
    }
    text = render_diagnosis(dataclasses.replace(diagnosis, laboratory=None), provenance)
    title = 'Diagnosis of T1, T&lt;2&gt; with exoskeleton'
    assert f'<title>{title}</title>' in text
    assert f'<h1>{title}</h1>' in text
    told = dict(re.findall(r'<dt>(.*?)</dt><dd>(.*?)</dd>', text))
    assert told['Recording'] == 'T1, T&lt;2&gt;'
    assert told['Diagnosed'] == '2026-11-22 18:15'


def test_a_sentence_is_parted_where_brackets_are_closed():
    text = 'Named: a: x (1; 2.5 Nm. So); b: y. On folds: a 0.5 -> 0.3 Nm.'
    assert clauses(text) == [
        ['Named: a: x (1; 2.5 Nm. So)', 'b: y.'],
        ['On folds: a 0.5 -> 0.3 Nm.'],
    ]


def test_faults_of_the_data_are_told_of_the_recording_and_not_as_causes(diagnosis):
    fault = Cause('velocity_lag', 'slider', {'lag_s': Parameter(0.01, 's')}, {})
    sentence = f'Named: {describe(fault)}; {describe(diagnosis.causes[0])}. On data: nothing.'
    found = dataclasses.replace(
        diagnosis, sentence=sentence, causes=(fault, *diagnosis.causes), gain=None
    )
    text = ' '.join(part for one in answer(found) for part in one)
    assert 'lag' not in text
    assert describe(diagnosis.causes[0]) in text


def test_a_rival_of_another_joint_is_named_in_words():
    assert words('payload@*') == 'payload (all joints)'
    assert words('joint_elasticity@left_arm') == 'joint elasticity (left_arm)'


@pytest.mark.parametrize(
    ('seconds', 'text'),
    [(-1e-5, '0.0 ms'), (0.0, '0.0 ms'), (-4e-4, '-0.4 ms'), (0.01, '10.0 ms')],
)
def test_a_time_that_is_nothing_has_no_sign(seconds, text):
    assert milliseconds(seconds) == text


def test_one_more_wave_of_what_is_named_is_said_to_be_a_further_one(diagnosis):
    named = diagnosis.causes[0]
    more = {'effect': named.effect, 'joint': named.joint, 'failed': ['it is small']}
    found = dataclasses.replace(diagnosis, rejected=more)
    words = named.effect.replace('_', ' ')
    assert rejection(found) == f'a further {words} (slider), because it is small'
    other = dataclasses.replace(diagnosis, rejected={**more, 'effect': 'backlash'})
    assert rejection(other) == 'backlash (slider), because it is small'
    assert rejection(dataclasses.replace(diagnosis, rejected=None)) == ''
