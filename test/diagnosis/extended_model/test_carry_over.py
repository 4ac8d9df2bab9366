# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What one cause removes on another recording, and what does not carry over to it."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from known_robots import SLIDER_MASS, recording, sines, slider_model, smooth_sign

from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.diagnosis.extended_model import carry_over
from sosml_friction.diagnosis.extended_model.extension import extended_model
from sosml_friction.diagnosis.extended_model.uncertain import Uncertain
from sosml_friction.model.terms.cogging import Cogging
from sosml_friction.report.diagnosis.document import diagnosis_lines

#: Periods of a screw of 20 mm [rad/m], and its size [N].
FREQUENCY, SIZE = 2.0 * np.pi / 0.02, 8.0
MODEL = slider_model(20.0, 200.0)
#: Of the search: what the tests do not ask for takes time.
WITHOUT = ('stribeck', 'thermal_drift', 'backlash', 'joint_elasticity', 'encoder_eccentricity',
           'presliding_hysteresis', 'spring')  # fmt: skip


def screw(seed, phase=0.0, drag=60.0, size=SIZE):
    """Return the slider with a ripple of its screw, and a drag that differs by direction."""
    t = np.arange(0.0, 24.0, 5e-3)
    q, v, a = sines(t, ((0.08, 0.9), (0.02, 2.1, 0.3 * seed)))
    tau = SLIDER_MASS * a + 20.0 * smooth_sign(q, v) + 200.0 * v + drag * np.abs(v)
    tau += size * np.cos(FREQUENCY * q + phase)
    tau += np.random.default_rng(seed).normal(0.0, 1.0, len(t))
    return recording(('slider',), t, q, tau)


@lru_cache
def found(phase, size=SIZE, keep_all=False):
    other = screw(1, phase, size=size)
    return diagnose([screw(0)], MODEL, other, without=WITHOUT, keep_all=keep_all)


def named(diagnosis):
    return {cause.effect: cause for cause in diagnosis.causes}


def test_a_cause_that_is_there_again_carries_over_and_removes_what_it_is():
    diagnosis = found(0.0)
    causes = named(diagnosis)
    assert set(causes) == {'cogging', 'asymmetric_friction'}
    gain = causes['cogging'].gain
    assert all(cause.in_model and cause.gain.carries_over for cause in diagnosis.causes)
    assert gain.recurs.value == pytest.approx(1.0, abs=4.0 * gain.recurs.std_error + 0.05)
    # The energies of what is independent add up: without it, the ripple's is left as well.
    ripple = np.sqrt(gain.without[0] ** 2 - gain.with_it[0] ** 2)
    assert ripple == pytest.approx(SIZE / np.sqrt(2.0), rel=0.1)
    assert gain.removed[0].value == pytest.approx(gain.without[0] - gain.with_it[0])
    assert diagnosis.gain.inverse_after[0] == pytest.approx(gain.with_it[0])


def test_a_ripple_with_another_zero_is_told_and_left_out_of_the_model():
    """Its amplitude recurs, its phase is off by 150 degrees."""
    diagnosis = found(np.radians(150.0))
    causes = named(diagnosis)
    gain = causes['cogging'].gain
    assert not gain.carries_over
    assert not causes['cogging'].in_model
    assert causes['asymmetric_friction'].in_model
    assert gain.removed[0].value < 0.0
    assert gain.size.value == pytest.approx(1.0, abs=0.1)
    assert gain.phase == pytest.approx(150.0, abs=5.0)
    assert [t.effect for t in extended_model(MODEL, diagnosis, {}).effects] == [
        'asymmetric_friction'
    ]
    text = '\n'.join(diagnosis_lines(diagnosis))
    assert 'Cogging (slider) does not carry over' in text
    assert 'its amplitude recurs' in text
    assert 'its phase does not' in text
    # Without it the other recording is predicted better than with it.
    assert diagnosis.gain.inverse_after[0] == pytest.approx(gain.without[0])


def test_all_is_kept_where_that_is_asked_for():
    diagnosis = found(np.radians(150.0), keep_all=True)
    cogging = named(diagnosis)['cogging']
    assert cogging.in_model
    assert not cogging.gain.carries_over
    assert diagnosis.gain.inverse_after[0] == pytest.approx(cogging.gain.with_it[0])


def test_what_is_gone_does_not_recur_in_any_phase():
    diagnosis = found(0.0, size=0.0)
    gain = named(diagnosis)['cogging'].gain
    assert not gain.carries_over
    # As above: what a reversal leaves has some of any ripple.
    assert gain.recurs.value == pytest.approx(0.0, abs=4.0 * gain.recurs.std_error + 0.05)
    assert not gain.size_recurs or gain.size.value < 0.1


@pytest.mark.parametrize(('size', 'stretches'), [(0.5, 14), (10.0, 14), (30.0, 2)])
def test_what_is_removed_is_as_sure_as_it_scatters(size, stretches):
    """Of 300 draws of noise beside an effect that acts in all stretches, or in two of them."""
    rng = np.random.default_rng(0)
    rows = 1400
    effect = size * np.sin(0.3 * np.arange(rows)) * (np.arange(rows) < rows * stretches / 14)
    drawn = []
    for _ in range(300):
        e = rng.normal(size=rows)
        # What was fitted to other data is a little off.
        d = effect * (1.0 + 0.02 * rng.normal())
        drawn.append(carry_over.removed(effect + e, effect + e - d, 14))
    scatter = np.std([x.value for x in drawn])
    assert np.mean([x.std_error for x in drawn]) == pytest.approx(scatter, rel=0.25)


def test_what_acts_in_fast_motion_alone_is_there_beyond_chance():
    """Of six stretches two are fast: by stretch, what an inertia removes is 0 to all of it."""
    t = np.arange(0.0, 48.0, 5e-3)
    fast = 0.08 + 0.92 * np.clip(np.minimum(np.abs(t - 20.0), np.abs(t - 40.0)) < 4.0, 0, 1)
    fast = np.convolve(fast, np.hanning(401) / np.hanning(401).sum(), mode='same')
    q = (0.08 * np.sin(0.9 * t) + 0.02 * np.sin(5.1 * t)) * fast
    v = np.gradient(q, t)
    a = np.gradient(v, t)
    tau = 1.15 * SLIDER_MASS * a + 20.0 * smooth_sign(q, v) + 200.0 * v
    tau += np.random.default_rng(5).normal(0.0, 1.0, len(t))
    diagnosis = diagnose([recording(('slider',), t, q, tau)], MODEL, without=WITHOUT)
    (gain,) = (cause.gain for cause in diagnosis.causes if cause.effect == 'inertia')
    (removed,) = gain.removed
    assert gain.shown
    assert removed.std_error < 0.1 * removed.value


@pytest.fixture
def cogging_by_chance(monkeypatch):
    """Of an amplitude of 1.0 times a column that its folds do not have, 0.2 +- 0.19 recurs."""
    gains = carry_over.cause_gains

    def chance(laboratory, selection, held):
        own = gains(laboratory, selection, held)
        return {
            key: replace(gain, recurs=Uncertain(0.2, 0.19)) if key[0] == 'cogging' else gain
            for key, gain in own.items()
        }

    monkeypatch.setattr(carry_over, 'cause_gains', chance)


@pytest.mark.usefixtures('cogging_by_chance')
def test_what_is_not_there_on_folds_left_out_is_taken_back():
    diagnosis = diagnose([screw(0)], MODEL, without=WITHOUT)
    assert set(named(diagnosis)) == {'asymmetric_friction'}
    assert diagnosis.selection.rejected.failed == (carry_over.NOT_RECURRING,)
    # The ripple is left, and what is left is judged anew without the cause.
    assert diagnosis.verdict == 'unknown_structure'
    assert diagnosis.selection.remainder.beyond_chance


@pytest.mark.usefixtures('cogging_by_chance')
def test_what_is_tolerated_is_a_refit_and_needs_not_recur(monkeypatch):
    """As the half of an interval by which a held command acts later."""
    monkeypatch.setattr(Cogging, 'tolerated', lambda self, fit, tolerance: True)
    diagnosis = diagnose([screw(0)], MODEL, without=WITHOUT)
    assert set(named(diagnosis)) == {'asymmetric_friction'}
    assert [cause.effect for cause in diagnosis.tolerated] == ['cogging']
    assert diagnosis.verdict == 'named'


def test_a_cause_that_is_taken_back_does_not_hide_a_tone():
    selection = found(0.0).selection
    cause = selection.accepted[0]
    hum = replace(cause, instead='a tone of 6.3 Hz', failed=('a tone of 6.3 Hz explains more',))
    gone = replace(cause, failed=(carry_over.NOT_RECURRING,))
    assert replace(selection, rejected=hum).taken_back(gone).rejected is hum
    assert replace(selection, rejected=None).taken_back(gone).rejected is gone


def test_the_values_of_the_model_are_those_fitted_without_what_was_left_out():
    with_all, fewer = found(0.0), found(np.radians(150.0))
    drag = [
        named(x)['asymmetric_friction'].parameters['viscous_asymmetry'] for x in (with_all, fewer)
    ]
    assert drag[0].value != drag[1].value
    # Beside its ripple; without, the ripple takes part of the drag in this motion.
    assert drag[0].value == pytest.approx(60.0, abs=3.0 * drag[0].std_error)
    law = extended_model(MODEL, fewer, {}).joints['slider'].friction.parameters
    assert law['viscous'].value == pytest.approx(200.0 + fewer.refit['slider viscous'])
