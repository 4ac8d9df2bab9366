# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What all candidates together leave is noise, but for what changes once."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from known_robots import (
    SLIDER_MASS,
    SLIDER_STEP,
    recording,
    slider_model,
    slider_recording,
)

from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.diagnosis.library import make_library
from sosml_friction.model.terms.spring import Spring
from sosml_friction.regression.band_rows import BandRows
from sosml_friction.regression.library_residual import library_residual
from sosml_friction.regression.noise_model import fit_noise
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare

MODEL, SETTINGS = slider_model(20.0, 200.0), DiagnosisSettings()


def slider(step=0.0, slow=0.0, duration=60.0):
    """Return the slider with a step of effort [N] in mid-record, and slow noise [N]."""
    log = slider_recording(duration=duration)
    e = np.random.default_rng(8).normal(0.0, 1.0, len(log))
    for k in range(1, len(e)):
        # A correlation of 1 s.
        e[k] = e[k - 1] + (e[k] * np.sqrt(2.0 * SLIDER_STEP) - e[k - 1] * SLIDER_STEP)
    tau = log.tau[:, 0] + step * (log.time > 0.4 * duration) + slow * e
    return recording(('slider',), log.time, log.q, tau)


def spread(log):
    """Return the standard deviation of what is left, and of the same without a step [N]."""
    signals = prepare([log], MODEL, MODEL.make_robot(), SETTINGS)
    found = library_residual(BandRows.make(signals, {'spring': Spring()}, SETTINGS))
    return tuple(float(np.std(np.concatenate(own[0]))) for own in (found.left, found.steady))


def test_a_step_of_effort_is_no_noise():
    _, noise = spread(slider())
    left, steady = spread(slider(step=3.0))
    assert left > 1.3 * noise
    assert steady == pytest.approx(noise, rel=0.02)


@pytest.mark.parametrize('slow', [0.0, 1.0])
def test_noise_has_no_step_slow_as_it_may_be(slow):
    left, steady = spread(slider(slow=slow))
    assert steady == left


def test_a_step_of_effort_is_no_noise_to_the_diagnosis():
    found = diagnose([slider(step=3.0)], MODEL, settings=SETTINGS)
    assert found.verdict == 'unknown_structure', found.sentence
    assert any(x.axis == 'time' for x in found.selection.remainder.beyond_chance)


def far_once(ripple):
    """Return the slider with a ripple of effort [N]: it goes far at first, and then no more."""
    t = SLIDER_STEP * np.arange(round(60.0 / SLIDER_STEP))
    size = 0.06 + 0.14 * np.exp(-((t / 6.0) ** 2))
    q = size * np.sin(2.0 * np.pi * (0.15 * t + 0.004 * t**2))
    v = np.gradient(q, SLIDER_STEP)
    tau = SLIDER_MASS * np.gradient(v, SLIDER_STEP) + 20.0 * np.sign(v) + 200.0 * v
    tau += ripple * np.cos(130.0 * q + 0.4) + np.random.default_rng(4).normal(0.0, 1.0, len(t))
    return recording(('slider',), t, q, tau)


def test_a_ripple_is_no_noise_where_a_position_is_come_to_once():
    """
    It was left where curves of position have few knots, 9 times the noise, and was a push.

    Its frequency is between two points of the grid, and an eighth of the noise is more than what
    16 lines and their curves can take of chance.
    """
    left = []
    for ripple in (0.0, 30.0):
        signals = prepare([far_once(ripple)], MODEL, MODEL.make_robot(), SETTINGS)
        found = library_residual(BandRows.make(signals, make_library(), SETTINGS))
        left.append(float(np.std(np.concatenate(found.left[0]))))
    assert left[1] == pytest.approx(left[0], rel=0.125)


def test_flat_noise_is_flat_where_the_library_takes_all_of_it():
    """
    Of 10 s of the slider it takes all of the noise below 1 Hz. Begun with what is left, the model
    had a third of the power there. Of seven parts of the band the narrowest has 250 frequencies,
    and the model seven numbers of 680 rows: 1.5 is beyond the scatter of draws.
    """
    log = slider_recording(duration=10.0)
    signals = prepare([log], MODEL, MODEL.make_robot(), SETTINGS)
    found = library_residual(BandRows.make(signals, make_library(), SETTINGS))
    model, band = found.noise(0, list, 1e-9), signals[0].band
    drawn = np.random.default_rng(0).standard_normal((20 * len(log), 1))
    e = model.whiten(band.apply(drawn)[:, 0])
    power = np.abs(np.fft.rfft(e)) ** 2 / len(e)
    at = np.fft.rfftfreq(len(e), band.output_step) / band.cutoff
    ends = np.array([0.0, 0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0])
    parts = [power[(at >= a) & (at < b)].mean() for a, b in pairwise(ends)]
    assert np.log(parts) == pytest.approx(np.zeros(7), abs=np.log(1.5))


def test_noise_is_as_small_as_it_is_in_whatever_unit():
    """A model of noise knows no size but the least that it is told."""
    log = slider_recording(duration=10.0)
    signals = prepare([log], MODEL, MODEL.make_robot(), SETTINGS)
    found = library_residual(BandRows.make(signals, make_library(), SETTINGS))
    small = replace(found, steady=[[1e-7 * x for x in own] for own in found.steady])
    usual, tiny = (each.noise(0, list, 1e-12) for each in (found, small))
    assert tiny.sigma == pytest.approx(1e-7 * usual.sigma, rel=1e-9)
    assert tiny.coefficients == pytest.approx(usual.coefficients, abs=1e-9)


def test_slow_noise_is_known_though_the_library_takes_most_of_it():
    """
    Of noise below 0.5 Hz the library takes half of 30 s of the slider: the power of what is left
    is whitened to 1.6 times that of the noise itself, and with what was taken put back to 0.9.
    """
    log = slider_recording(duration=30.0)
    signals = prepare([log], MODEL, MODEL.make_robot(), SETTINGS)
    found = library_residual(BandRows.make(signals, make_library(), SETTINGS))
    drawn = np.random.default_rng(0).normal(0.0, 1.0, (len(log), 1))
    noise = fit_noise([signals[0].band.apply(drawn)[:, 0]], 1e-9)
    left = fit_noise(found.steady[0], 1e-9)
    filled = found.noise(0, list, 1e-9)

    def slow(model):
        """Return the power that the filter of a model gives to 0 Hz."""
        return float(model.whitening.sum()) ** 2

    assert slow(left) > 1.4 * slow(noise)
    assert slow(filled) == pytest.approx(slow(noise), rel=0.2)
