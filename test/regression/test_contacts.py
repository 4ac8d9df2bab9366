# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is taken out as an impact or a push is told from what a motion is made of."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known_robots import SLIDER_MASS, recording, slider_model, slider_recording

import sosml_friction as sf
from sosml_friction.diagnosis.library import make_library
from sosml_friction.model.terms.stribeck import Stribeck
from sosml_friction.regression import library_residual as residuals
from sosml_friction.regression.band_rows import BandRows
from sosml_friction.regression.contacts import find_contacts, find_impacts
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare
from sosml_friction.regression.whitened import WhitenedRegression

STEP = 0.02


@pytest.fixture
def noise():
    """Return times [s] and noise of 0.05 Nm of one joint."""
    t = np.arange(0.0, 100.0, STEP)
    return t, np.random.default_rng(7).normal(0.0, 0.05, (len(t), 1))


def switched(t, period=2.0, share=0.5):
    """Return 1 for ``share`` of each period, from the middle of the first on, else 0."""
    return ((np.mod(t - 0.5 * period, period) < share * period) & (t > 0.5 * period)).astype(float)


@pytest.mark.parametrize(('changes', 'found'), [(0.05, True), (1.5, False)])
def test_what_would_spoil_most_of_a_motion_is_no_impact(noise, changes, found):
    """Energy after each change of the load; at 1.5 Hz the 0.15 s around the changes are all."""
    t, e = noise
    load = np.sin(2.0 * np.pi * changes * t)[:, None]
    since = np.mod(t, 0.5 / changes)
    e[since < min(0.06, 0.2 / changes), 0] += 0.5
    impacts, spoiled = find_impacts(e, load, STEP, np.ones(e.shape, dtype=bool))
    assert bool(impacts) is found
    assert spoiled.any() == found
    assert spoiled.mean() < 0.5


def test_where_a_joint_rests_no_impact_is_missed(noise):
    """Half of the changes of the load are at rest, where rows are zero: they say nothing."""
    t, e = noise
    load = np.sin(2.0 * np.pi * 0.05 * t)[:, None]
    rests = np.mod(t + 5.0, 20.0) < 10.0
    e[np.mod(t, 10.0) < 0.06, 0] += 0.5
    e[rests] = 0.0
    (impacts,), _ = find_impacts(e, load, STEP, ~rests[:, None])
    assert impacts.share > 0.9
    assert impacts.changes == 5


@pytest.mark.parametrize('fast_hits', [True, False])
def test_impacts_are_asked_where_the_load_goes_far_and_not_where_it_hardly_changes(
    noise, fast_hits
):
    """A body crosses a gap with a momentum that grows with the rate of its load."""
    t, e = noise
    # One slow change of the load, with 0.05 Nm/s, after three fast ones with 3 Nm/s.
    phase = np.mod(t, 10.0)
    load = np.select([phase < 2.0, phase < 4.0], [np.sin(np.pi * phase), 0.05 * (3.0 - phase)],
                     -0.05 + 0.0 * phase)  # fmt: skip
    hit = (np.abs(np.mod(phase, 1.0) - 0.03) < 0.05) & (phase < 2.5)
    e[hit if fast_hits else np.abs(phase - 3.03) < 0.05, 0] += 0.5
    impacts, _ = find_impacts(e, load[:, None], STEP, np.ones(e.shape, dtype=bool))
    assert bool(impacts) is fast_hits
    if fast_hits:
        assert impacts[0].share > 0.9


def test_a_push_that_is_on_as_often_as_off_is_found_by_its_levels(noise):
    t, e = noise
    on = switched(t)
    push = 3.0 * on[:, None]
    # The refit of a bias centres what is left; the nominal model still knows which level is off.
    found = find_contacts(e + push - push.mean(), t, STEP, expected=e + push, reach=3)
    assert {x.joint for x in found.contacts} == {0}
    assert len(found.contacts) == np.count_nonzero(np.diff(on) > 0.0)
    assert found.contacts[0].level == pytest.approx(3.0, rel=0.02)
    assert found.contacts[0].start_s == pytest.approx(1.0, abs=2.0 * STEP)
    # All of it, and what a filter spreads of its ends.
    assert found.mask[on > 0.0, 0].all()
    assert 0.5 < found.mask.mean() < 0.6


def test_two_levels_that_change_with_every_other_sample_are_no_push(noise):
    t, e = noise
    fast = 3.0 * switched(t, period=4.0 * STEP)[:, None]
    assert not find_contacts(e + fast, t, STEP).mask.any()


def test_noise_has_no_two_levels(noise):
    t, e = noise
    assert not find_contacts(e, t, STEP).mask.any()


def test_what_a_model_may_be_wrong_by_is_no_push_and_more_than_that_is(noise):
    t, e = noise
    fast = ((t > 40.0) & (t < 41.0)).astype(float)[:, None]

    def found(push):
        wrong = 0.0012 * 100.0 * fast
        return bool(find_contacts(e + push * fast, t, STEP, wrong=wrong).contacts)

    assert not found(0.5)
    assert found(3.0)
    assert find_contacts(e + 0.5 * fast, t, STEP).contacts


def test_a_joint_that_rests_most_of_the_time_is_not_pushed_as_it_moves():
    """What it leaves at rest is taken for friction, and nothing is no usual size to divide by."""
    step, dwell = 4e-3, 700
    s = np.linspace(0.0, 1.0, 300)
    move = 0.1 * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    q = np.tile(np.concatenate([move, np.full(dwell, 0.1), 0.1 - move, np.zeros(dwell)]), 15)
    v = np.gradient(q, step)
    moved = np.where(np.abs(v) > 1e-9, np.arange(len(q)), 0)
    sign = np.sign(v[np.maximum.accumulate(moved)])
    tau = SLIDER_MASS * np.gradient(v, step) + 20.0 * sign + 200.0 * v
    rng = np.random.default_rng(3)
    tau += np.where(np.abs(v) > 1e-9, rng.normal(0.0, 0.5, len(q)), 0.0)
    # Motion differs a little from one time to another, as no model has it.
    tau += 1.0 * (rng.normal(0.0, 1.0, 30).repeat(300 + dwell)) * (np.abs(v) > 0.05)
    log, model = (
        recording(('slider',), step * np.arange(len(q)), q, tau),
        slider_model(20.0, 200.0),
    )
    settings = DiagnosisSettings()
    signals = prepare([log], model, model.make_robot(), settings)
    contacts = WhitenedRegression.make(signals, {'stribeck': Stribeck()}, settings).contacts
    assert contacts.contacts == ()


def test_a_push_on_a_residual_that_is_nothing_else_is_told(noise):
    """A joint that says nothing most of the time has no usual size to divide by."""
    t, e = noise
    e[:], e[1000:1030] = 0.0, 1.0
    found = find_contacts(e, t, STEP)
    assert [c.joint for c in found.contacts] == [0]


@pytest.mark.parametrize('push', [0.0, 60.0])
@pytest.mark.parametrize('seed', [1, 2])
def test_where_a_coarse_position_turns_around_is_no_push(seed, push):
    """Counts of 1.5 mm at 100 Hz: the 200 N that friction turns by come a sample early or late."""
    step, rng = 0.01, np.random.default_rng(seed)
    t = np.arange(0.0, 120.0, step)
    w = 2.0 * np.pi * np.array([0.05, 0.11, 0.17, 0.29])
    size, phase = np.array([0.15, 0.1, 0.075, 0.1]), rng.uniform(0.0, 2.0 * np.pi, 4)
    u = np.outer(t, w) + phase
    q, v, a = np.sin(u) @ size, np.cos(u) @ (size * w), -np.sin(u) @ (size * w**2)
    tau = SLIDER_MASS * a + 100.0 * np.sign(v) + 200.0 * v + rng.normal(0.0, 1.0, len(t))
    tau[(t > 60.0) & (t < 61.0)] += push
    q = 1.5e-3 * np.round(q / 1.5e-3)
    log, model = recording(('slider',), t, q, tau), slider_model(100.0, 200.0)
    settings = DiagnosisSettings()
    signals = prepare([log], model, model.make_robot(), settings)
    contacts = WhitenedRegression.make(signals, {'stribeck': Stribeck()}, settings).contacts
    starts = [each.start_s for each in contacts.contacts]
    assert any(59.9 < start < 61.0 for start in starts) if push else not starts


def test_two_pushes_bend_no_fit_and_hide_no_rest():
    """Pushes of 200 N: at each rest effort is another one within the 20 N of friction."""
    step, pause, rng = 4e-3, 150, np.random.default_rng(5)
    rise = 0.5 - 0.5 * np.cos(np.pi * np.linspace(0.0, 1.0, 350))
    out = np.concatenate([rise, np.ones(pause), 1.0 - rise, np.zeros(pause)])
    q = np.concatenate([size * out for size in rng.uniform(0.05, 0.4, 15)])
    v = np.gradient(q, step)
    tau = SLIDER_MASS * np.gradient(v, step) + 20.0 * np.sign(v) + 200.0 * v
    t = step * np.arange(len(q))
    rests = rng.uniform(-20.0, 20.0, len(q) // 350).repeat(350)
    tau += rng.normal(0.0, 1.0, len(q)) + np.where(v == 0.0, np.resize(rests, len(q)), 0.0)
    for start in (20.0, 41.0):
        tau[(t > start) & (t < start + 0.6)] += 200.0
    log, model = recording(('slider',), t, q, tau), slider_model(20.0, 200.0)
    settings = DiagnosisSettings()
    signals = prepare([log], model, model.make_robot(), settings)
    found = WhitenedRegression.make(signals, make_library(()), settings)
    assert [round(each.start_s) for each in found.contacts.contacts] == [20, 41]
    assert found.whitening.standstill is not None


def test_after_a_push_of_one_joint_no_other_is_looked_at(noise):
    """Two levels in the second joint, which a fit with the push did not show."""
    t, e = noise
    push = 3.0 * switched(t)
    both = np.column_stack([e[:, 0], e[:, 0] + push - push.mean()])
    before = np.zeros(both.shape, dtype=bool)
    before[1000:1030, 0] = True
    both[1000:1030, 0] += 3.0
    expected = both + np.array([0.0, push.mean()])
    found, all_found = (
        find_contacts(both, t, STEP, expected=expected, reach=3, before=own)
        for own in (before, None)
    )
    assert {c.joint for c in found.contacts} == {0}
    assert {c.joint for c in all_found.contacts} == {0, 1}


@pytest.mark.parametrize('friction', [False, True])
def test_rows_that_say_nothing_change_no_step_in_time(monkeypatch, friction):
    """30 N from the middle on; most of it was left to the noise where half was pushed."""
    log = slider_recording(duration=60.0)
    size = 30.0 * np.sign(np.gradient(log.q, axis=0)) if friction else 30.0
    tau = log.tau + np.where(log.time[:, None] > 30.0, size, 0.0)
    settings, model = DiagnosisSettings(), slider_model(20.0, 200.0)
    signals = prepare([replace(log, tau=tau)], model, model.make_robot(), settings)
    rows = BandRows.make(signals, {'stribeck': Stribeck()}, settings)
    find, steps = residuals._step, []

    def noted(*given):
        found = find(*given)
        steps.append((found[0], found[2]))
        return found

    monkeypatch.setattr(residuals, '_step', noted)
    turns = np.arange(len(rows.residual[0])) // 50 % 20
    for share in (0.0, 0.25, 0.5, 0.75):
        residuals.library_residual(rows, (turns < 20 * share)[:, None])
    # Each time that of effort is tried, and that of friction.
    heights = [max(two)[1] for two in zip(steps[::2], steps[1::2], strict=True)]
    assert heights == pytest.approx(4 * [30.0], rel=0.02)


def test_what_another_joint_does_to_one_at_rest_is_no_push(make_serial_arm):
    """Two links under gravity: the shoulder holds, and the elbow moves what it carries."""
    urdf, step = make_serial_arm(['revolute'] * 2), 4e-3
    model = sf.Model.from_urdf(urdf, {'j1': 0.01, 'j2': 0.01}).content
    robot = model.make_robot()
    s = np.linspace(0.0, 1.0, 250)
    move = 0.5 * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    one = np.concatenate([move, np.full(600, 0.5), 0.5 - move, np.zeros(600)])
    t = step * np.arange(8 * len(one))
    q = np.column_stack([np.tile(one, 8), 0.6 * np.sin(2.0 * np.pi * 0.4 * t)])
    v = np.gradient(q, step, axis=0)
    a = np.gradient(v, step, axis=0)
    moved = np.where(np.abs(v) > 1e-9, np.arange(len(t))[:, None], 0)
    last = np.sign(np.take_along_axis(v, np.maximum.accumulate(moved), axis=0))
    held = np.array([robot.inverse_dynamics(*each) for each in zip(q, v, a, strict=True)])
    carried = np.ptp(held[:, 0])
    rng = np.random.default_rng(2)
    tau = held + 0.02 * carried * last + 0.01 * carried * rng.standard_normal(q.shape)
    q += 2e-5 * rng.standard_normal(q.shape)
    t_ns = np.rint(1e9 * t).astype(np.int64)
    log = sf.JointLog(('j1', 'j2'), t_ns, q, np.full_like(q, np.nan), tau)
    settings = DiagnosisSettings()
    found = WhitenedRegression.make(
        prepare([log], model, robot, settings), {'stribeck': Stribeck()}, settings
    )
    assert any(rest.joint == 0 for rest in found.signals[0].rests)
    assert not found.contacts.contacts
