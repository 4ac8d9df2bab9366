# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Noise of position leaves the acceleration where the motion is smooth, and edges stay."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.model.finite_differences import second_derivative
from sosml_friction.regression.band import Band
from sosml_friction.regression.steady_acceleration import largest_of, steady_accelerations

STEP = 4e-3
BAND = Band(20.0, STEP)
TIME = np.arange(0.0, 60.0, STEP)


def noise(seed: int) -> np.ndarray:
    """Return what 20 urad of white noise of position are in acceleration, (N, 1)."""
    e = 2e-5 * np.random.default_rng(seed).standard_normal((len(TIME), 1))
    return second_derivative(BAND.smooth(e), STEP)


def test_a_slow_sine_loses_its_noise():
    """
    Noise of acceleration below f is in proportion to f^2.5, and the sine is far below.

    A low-pass at 20 Hz / 2^3 leaves (1 / 16)^2.5 = 0.1 % of the noise below 40 Hz; 5 % of it are
    left if 0.3 % of the samples keep all.
    """
    true = np.sin(2.0 * np.pi * 0.2 * TIME)[:, None]
    added = noise(1)
    error = (
        steady_accelerations(true + added, noise(2), np.ones_like(true), BAND, (3.0,))[0] - true
    )
    inner = slice(500, -500)
    assert np.std(error[inner]) < 0.06 * np.std(added)


@pytest.mark.parametrize('dither', [0.05, 0.1])
def test_the_line_of_an_encoders_steps_is_no_motion(dither):
    """
    19 bits at 1 kHz and 0.06 rad/s: 5006.6 counts a second are seen as 6.6, with all harmonics.

    Their power is a twelfth of the squared count, as that of white noise, and all in the band.
    """
    step, count = 1e-3, 2.0 * np.pi / 2**19
    time, band = np.arange(0.0, 30.0, step), Band(60.0, step)
    # Elsewhere it is faster and the noise is white.
    speed = np.where(np.abs(time - 15.0) < 2.0, 0.06, 0.25 + 0.05 * np.sin(time))
    q = np.cumsum(speed) * step + dither * count * np.random.default_rng(0).standard_normal(
        len(time)
    )
    errors = [count * np.rint((q + x) / count) - q - x for x in (0.0, 0.3 * count)]
    slow = np.abs(time - 15.0) < 1.5
    own, other = (second_derivative(band.smooth(e[:, None]), step) for e in errors)
    loose, left = steady_accelerations(
        own, other, np.ones_like(own), band, (3.0, largest_of(len(time)))
    )
    assert np.std(left[slow]) < 0.01 * np.std(own[slow])
    assert np.std(loose[slow]) > 0.03 * np.std(own[slow])


def test_a_jump_keeps_its_edge():
    """All intervals of 3 sigma share a point: nothing is further than 6 sigma off what is read."""
    true = BAND.smooth(np.where(TIME % 10.0 < 5.0, 1.0, -1.0)[:, None])
    added = noise(1)
    sigma = np.std(noise(2))
    result = steady_accelerations(true + added, noise(2), np.ones_like(true), BAND, (3.0,))[0]
    edge = np.abs(np.gradient(true[:, 0])) > 0.01
    assert np.abs(result - true - added).max() <= 6.0 * sigma
    assert np.abs(result - true)[~edge].std() < 0.5 * sigma


def test_what_has_no_noise_stays_as_it_is():
    true = np.cumsum(np.random.default_rng(1).standard_normal((len(TIME), 2)), axis=0)
    assert steady_accelerations(true, np.zeros_like(true), np.ones_like(true), BAND, (3.0,))[
        0
    ] == pytest.approx(true, abs=0.0)


def test_noise_that_grows_with_speed_leaves_where_it_is_large():
    """Five times the noise in the middle third: of it as much is left as of that beside it."""
    scale = np.where(np.abs(TIME - 30.0) < 10.0, 5.0, 1.0)[:, None]
    left = steady_accelerations(scale * noise(1), noise(2), scale, BAND, (4.5,))[0]
    blind = steady_accelerations(scale * noise(1), noise(2), np.ones_like(scale), BAND, (4.5,))[0]
    inner = np.abs(TIME - 30.0) < 9.0
    assert np.std(left[inner]) < 0.3 * np.std(noise(1))
    assert np.std(blind[inner]) > 3.0 * np.std(noise(1))
