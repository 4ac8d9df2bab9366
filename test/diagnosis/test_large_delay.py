# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Effort that is late by several samples is told, and nothing else is found for it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from known_robots import SLIDER_STEP, recording, slider_model, slider_recording

from sosml_friction.diagnosis.diagnosis import diagnose, later_leaves_less
from sosml_friction.diagnosis.large_delay import checks_of, large_delay
from sosml_friction.diagnosis.recordings import Recordings
from sosml_friction.identification.body_comparison import BodyComparison
from sosml_friction.identification.late_effort import LateEffort


def late(samples, seed=0):
    """Return the slider's recording with effort reported ``samples`` late."""
    log = slider_recording(duration=40.0, seed=seed)
    kept = np.arange(abs(samples), len(log) - abs(samples))
    return replace(log.rows(kept), tau=log.tau[kept - samples])


@pytest.fixture(scope='module')
def model():
    """Return the slider as it is."""
    return slider_model(20.0, 200.0)


def test_a_delay_beyond_a_radian_of_the_band_is_named_with_its_size(model):
    found = diagnose([late(3)], model)
    assert (found.verdict, [x.key for x in found.causes]) == ('named', [('effort_delay', '*')])
    delay = found.causes[0].parameters['delay']
    # Between two samples, effort may act at either: what a sample stands for is half of one.
    assert delay.value == pytest.approx(3.0 * SLIDER_STEP, abs=0.5 * SLIDER_STEP)
    assert found.sentence.startswith('Named, of the data: all joints: effort delay')
    assert [check.kind for check in found.checks if 'taken' in check.sentence] == ['effort_delay']


@pytest.mark.parametrize(
    ('delay', 'left', 'taken'), [(6e-3, 1.8, True), (6e-3, 4.5, False), (-6e-3, 1.8, False)]
)
def test_beside_something_unknown_late_effort_is_taken_sooner_where_that_leaves_less(
    delay, left, taken
):
    def leaves(percent):
        return SimpleNamespace(gain=SimpleNamespace(relative_after=np.array([percent, np.nan])))

    late = {'j': LateEffort(delay, 1e-5, 2e-3, round(delay / 2e-3))}
    assert later_leaves_less(late, leaves(left), leaves(4.4)) is taken


def test_a_recording_left_out_is_as_late(model):
    found = diagnose([late(4)], model, holdout=late(4, seed=1))
    assert found.gain.relative_before[0] < 5.0


def test_effort_that_is_in_time_is_not_late(model):
    found = diagnose([late(0)], model)
    assert (found.verdict, found.causes) == ('nothing_above_floor', ())


def test_where_no_delay_is_to_be_looked_for_none_is_told(model):
    found = diagnose([late(4)], model, without=('effort_delay',))
    assert 'effort_delay' not in [check.kind for check in found.checks]


@pytest.mark.parametrize(
    ('delay', 'error', 'large'), [(1e-3, 1e-5, False), (4e-3, 0.5e-3, True), (4e-3, 1e-3, False)]
)
def test_a_delay_is_large_where_its_column_is_further_off_than_its_error(
    monkeypatch, delay, error, large
):
    """Of 30 Hz, 4 ms come out as 3.63 ms: sin(w d) / w."""
    if large:
        turn = 2.0 * np.pi * 30.0
        assert delay - np.sin(turn * delay) / turn == pytest.approx(0.37e-3, rel=0.01)
    late = {'j': LateEffort(delay, error, 2e-3, 2)}
    found = SimpleNamespace(late=late)
    monkeypatch.setattr(BodyComparison, 'of', lambda *_, **__: found)
    band = SimpleNamespace(cutoff=30.0)
    design = SimpleNamespace(library=('effort_delay',), signals=(SimpleNamespace(band=band),))
    assert large_delay(design, SimpleNamespace(logs=()), None, print) == (late if large else {})


def test_a_delay_is_told_by_joint_unless_all_have_it():
    late, other = LateEffort(8e-3, 1e-3, 2e-3, 4), LateEffort(4e-3, 1e-3, 2e-3, 2)
    names = ('shoulder', 'elbow')
    (of_all,) = checks_of({'shoulder': late, 'elbow': late}, names)
    assert of_all.joint == '*'
    assert of_all.sentence.startswith('effort is reported 8.0 ')
    assert [c.joint for c in checks_of({'shoulder': late, 'elbow': other}, names)] == [*names]
    (of_one,) = checks_of({'elbow': other}, names)
    assert (of_one.joint, of_one.severity) == ('elbow', 'warning')
    assert of_one.sentence.startswith('effort of elbow is reported 4.0 ')
    assert of_one.values == {'delay_s': 4e-3, 'delay_std_error_s': 1e-3}


def test_effort_of_one_joint_is_taken_sooner_in_that_joint_alone():
    t = 2e-3 * np.arange(50)
    log = recording(('shoulder', 'elbow'), t, np.zeros((50, 2)), np.column_stack([t, t]))
    late = {'elbow': LateEffort(4e-3, 1e-3, 2e-3, 2)}
    (found,) = Recordings((log,), ()).undone(late, ()).logs
    assert found.time == pytest.approx(t[:-2])
    assert found.tau == pytest.approx(np.column_stack([t[:-2], t[2:]]))
