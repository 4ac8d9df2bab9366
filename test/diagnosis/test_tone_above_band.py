# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A hum above the band is told with its size, and noise is none."""

from dataclasses import replace

import numpy as np
import pytest
from known_robots import SLIDER_STEP, slider_model, slider_recording

from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.diagnosis.tone_above_band import tone_above_band
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare


def found(hertz, size, seed=1, band=20.0):
    log = slider_recording(seed=seed)
    hum = size * np.sin(2.0 * np.pi * hertz * log.time + 0.4)
    log = replace(log, tau=log.tau + hum[:, None])
    model = slider_model()
    signals = prepare([log], model, model.make_robot(), DiagnosisSettings(band=band))
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


def test_a_diagnosis_says_that_it_does_not_look_there():
    log = slider_recording(seed=1)
    hum = 3.0 * np.sin(2.0 * np.pi * 83.0 * log.time)
    log = replace(log, tau=log.tau + hum[:, None])
    found = diagnose([log], slider_model(), settings=DiagnosisSettings(band=20.0))
    assert found.verdict == 'nothing_above_floor'
    assert [check.joint for check in found.checks if check.kind == 'tone'] == ['slider']
