# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The steps of a diagnosis: each can be looked at alone, and none changes the one before."""

from __future__ import annotations

from dataclasses import FrozenInstanceError, fields, replace

import numpy as np
import pytest
from known_robots import SLIDER_MASS, recording, sines, slider_model, smooth_sign

from sosml_friction.diagnosis.design import Design
from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.diagnosis.judgement import Judgement
from sosml_friction.diagnosis.library import searched_terms
from sosml_friction.diagnosis.recordings import Recordings
from sosml_friction.diagnosis.search import Search
from sosml_friction.exceptions import DataError
from sosml_friction.model.terms.effort_bias import EffortBias
from sosml_friction.model.terms.spring import Spring
from sosml_friction.regression.settings import DiagnosisSettings

MODEL, SETTINGS = slider_model(20.0, 200.0), DiagnosisSettings()
LIBRARY = {'effort_bias': EffortBias(), 'spring': Spring()}
#: Spring that the model lacks [N/m].
SPRING = 100.0


def log(tau=None):
    """Return a slider with a spring that its model lacks."""
    t = np.arange(0.0, 24.0, 5e-3)
    q, v, a = sines(t, ((0.08, 0.9), (0.02, 2.1)))
    effort = SLIDER_MASS * a + 20.0 * smooth_sign(q, v) + 200.0 * v + SPRING * q
    effort += np.random.default_rng(5).normal(0.0, 1.0, len(t))
    return recording(('slider',), t, q, effort if tau is None else tau + 0.0 * t)


def silent(text):
    """Do not say what is being done."""


@pytest.fixture(scope='module')
def search():
    """Return what is found of the slider in a library of two terms."""
    robot = MODEL.make_robot()
    recordings = Recordings.checked([log()], robot).in_means()
    design = Design.make(recordings, MODEL, robot, None, LIBRARY, SETTINGS, silent)
    return Search.run(design, silent)


def test_each_step_holds_its_result_frozen(search):
    judged = Judgement.of(search, MODEL, keep_all=False)
    for step in (search.design, search, search.selection, judged):
        for field in fields(step):
            with pytest.raises(FrozenInstanceError):
                setattr(step, field.name, None)


def test_a_step_leaves_those_before_it_as_they_are(search):
    """Searched and judged again, the same design gives the same numbers to the bit."""
    first = Judgement.of(search, MODEL, keep_all=False)
    second = Judgement.of(Search.run(search.design, silent), MODEL, keep_all=False)
    assert [f.effect.identifier for f in first.selection.accepted] == ['spring']
    np.testing.assert_array_equal(first.selection.after.x, second.selection.after.x)
    np.testing.assert_array_equal(first.gain.inverse_after, second.gain.inverse_after)


def test_the_steps_by_hand_are_the_diagnosis(search):
    others = tuple({*searched_terms()} - {*LIBRARY})
    whole = diagnose([log()], MODEL, settings=SETTINGS, without=others)
    judged = Judgement.of(search, MODEL, keep_all=False)
    assert whole.verdict == 'named'
    np.testing.assert_array_equal(whole.selection.after.x, judged.selection.after.x)


def test_an_effort_that_is_repeated_is_taken_where_a_new_one_came():
    """At a fifth of the rate; the others are of an earlier time, and would read as a cause."""
    whole = log()
    held = replace(whole, tau=whole.tau[np.arange(len(whole)) // 5 * 5])
    recordings = Recordings.checked([held], MODEL.make_robot())
    (said,) = [check for check in recordings.checks if check.kind == 'held_effort']
    assert 'at 40 Hz' in said.sentence
    (kept,) = recordings.logs
    np.testing.assert_array_equal(kept.tau, whole.tau[5::5])
    np.testing.assert_array_equal(kept.q, whole.q[5::5])


def test_repeated_samples_glitches_and_repeated_positions_are_left_out_and_told():
    whole = log()
    k = np.arange(len(whole))
    last = np.where(k % 100 < 4, k - k % 100, k)
    filled = replace(whole, q=whole.q[last], tau=whole.tau[last])
    recordings = Recordings.checked([filled], MODEL.make_robot())
    (said,) = [check for check in recordings.checks if check.kind == 'dropped_samples']
    assert said.values['lost_share'] == pytest.approx(0.03, abs=0.003)
    (told,) = [check for check in recordings.checks if check.kind == 'repeated_samples']
    assert 'repeat all of the one before' in told.sentence
    np.testing.assert_array_equal(recordings.logs[0].q, whole.q[last == k])

    off = replace(whole, q=whole.q + 0.5 * (k == 777)[:, None])
    recordings = Recordings.checked([off], MODEL.make_robot())
    assert [c.kind for c in recordings.checks if c.severity == 'warning'] == ['glitch']
    np.testing.assert_array_equal(recordings.logs[0].q, whole.q[k != 777])

    slow = replace(whole, q=whole.q[k // 5 * 5])
    recordings = Recordings.checked([slow], MODEL.make_robot())
    assert [c.kind for c in recordings.checks if c.severity == 'warning'] == ['held_position']
    np.testing.assert_array_equal(recordings.logs[0].q, whole.q[5::5])


def test_a_coarse_encoder_at_a_low_rate_repeats_no_samples():
    """12 bit at 50 Hz and an effort of few counts: neighbours are equal more often than others."""
    whole = log()
    rows = np.arange(0, len(whole), 4)
    count, step = 2e-3, 8.0
    coarse = replace(
        whole.rows(rows),
        q=count * np.rint(whole.q[rows] / count),
        tau=step * np.rint(whole.tau[rows] / step),
    )
    recordings = Recordings.checked([coarse], MODEL.make_robot())
    assert not [check for check in recordings.checks if check.kind == 'dropped_samples']


def test_data_of_no_use_are_refused_by_their_own_step():
    checked = Recordings.checked([log(tau=np.nan)], MODEL.make_robot())
    with pytest.raises(DataError, match='effort'):
        checked.refuse_bad()
