# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A hum above the band is told with its size, and noise is none."""

from dataclasses import replace

import numpy as np
import pytest
from known_robots import (
    SLIDER_MASS,
    SLIDER_STEP,
    recording,
    sines,
    slider_model,
    slider_recording,
    smooth_sign,
)

from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.diagnosis.tone_above_band import tone_above_band
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare


def found(hertz, size, seed=1):
    log = slider_recording(seed=seed)
    hum = size * np.sin(2.0 * np.pi * hertz * log.time + 0.4)
    return looked_at(replace(log, tau=log.tau + hum[:, None]))


def looked_at(log):
    """Return the tone above 20 Hz."""
    model = slider_model()
    signals = prepare([log], model, model.make_robot(), DiagnosisSettings(band=20.0))
    return tone_above_band(signals, 0)


@pytest.mark.parametrize('hertz', [31.3, 50.0, 83.0])
def test_a_hum_above_the_band_has_its_frequency_and_its_amplitude(hertz):
    assert hertz < 0.5 / SLIDER_STEP
    check = found(hertz, 2.0)
    assert check.values['hertz'] == pytest.approx(hertz, abs=0.02)
    # A tone between two lines of a periodogram that is four times as fine loses 5 % of its energy.
    assert check.values['size'] == pytest.approx(2.0, rel=0.05)
    assert f'a tone of {hertz:.1f} Hz' in check.sentence
    assert 'above the band of 20 Hz' in check.sentence


def test_noise_and_what_is_within_the_band_are_none():
    assert [found(50.0, 0.0, seed=seed) for seed in range(4)] == [None] * 4
    assert found(11.0, 2.0) is None


@pytest.mark.parametrize('hertz', [0.5, 1.0])
def test_friction_in_a_motion_that_repeats_is_none(hertz):
    """It turns around at the same times: its steps are tones at multiples of the motion."""
    t = SLIDER_STEP * np.arange(round(40.0 / SLIDER_STEP))
    q, v, a = sines(t, ((0.05, 2.0 * np.pi * hertz), (0.01, 4.0 * np.pi * hertz)))
    noise = np.random.default_rng(3).normal(0.0, 0.5, len(t))
    for more in (1.0, 1.5):
        # As the nominal has it, and by half as much again.
        tau = SLIDER_MASS * a + more * 20.0 * smooth_sign(q, v) + 200.0 * v + noise
        assert looked_at(recording(('slider',), t, q, tau)) is None


def test_cogging_at_constant_speed_is_none():
    t = SLIDER_STEP * np.arange(round(40.0 / SLIDER_STEP))
    q = 0.05 * t
    tau = 20.0 + 10.0 + 2.0 * np.sin(2.0 * np.pi * q / 0.05 * 60.0)
    tau += np.random.default_rng(3).normal(0.0, 0.5, len(t))
    assert looked_at(recording(('slider',), t, q, tau)) is None


@pytest.mark.parametrize('seconds', [5.0, 8.0])
def test_a_short_recording_of_noise_has_none(seconds):
    log = slider_recording(seed=1)
    short = log.rows(np.arange(round(seconds / SLIDER_STEP)))
    assert looked_at(short) is None


def test_an_effort_that_does_not_change_has_none():
    log = slider_recording(seed=1)
    assert looked_at(replace(log, tau=np.full_like(log.tau, 3.7))) is None


def test_a_diagnosis_says_that_it_does_not_look_there():
    log = slider_recording(seed=1)
    hum = 3.0 * np.sin(2.0 * np.pi * 83.0 * log.time)
    log = replace(log, tau=log.tau + hum[:, None])
    found = diagnose([log], slider_model(), settings=DiagnosisSettings(band=20.0))
    assert found.verdict == 'nothing_above_floor'
    assert [check.joint for check in found.checks if check.kind == 'tone'] == ['slider']
