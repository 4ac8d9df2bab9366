# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Noise and resolution of signals: compiled for on line as the others off line."""

import numpy as np
import pytest

from sosml_friction.observers.signal_noise import (
    counts_of,
    difference_noise,
    seen_noise,
    signal_noise,
)


@pytest.mark.parametrize('lost', [0.0, 0.3])
def test_compiled_noise_and_quantum_are_the_others(lost):
    rng = np.random.default_rng(0)
    signals = np.cumsum(rng.normal(size=(200, 5)), axis=0) + rng.normal(size=(200, 5))
    signals[:, 1] = np.round(signals[:, 1] / 0.3) * 0.3
    signals[:, 2] = 4.0
    signals[rng.random(signals.shape) < lost] = np.nan
    signals[:, 3] = np.nan
    step, noise = seen_noise(signals)
    for i, x in enumerate(signals.T):
        bent = np.diff(x, 2)
        bent = bent[np.isfinite(bent)]
        if not len(bent):
            assert (step[i], np.isnan(noise[i])) == (np.inf, True)
            continue
        np.testing.assert_allclose(step[i], signal_noise(x)[0] or np.inf, rtol=1e-12)
        np.testing.assert_allclose(noise[i], difference_noise(bent, 2), rtol=1e-12, atol=1e-15)


def strokes(speeds=(0.02, 0.05, 0.1, 0.2, 0.5, 1.0)):
    """Return a motion of 500 Hz to and fro at constant speeds [rad], with ramps between."""
    goals = np.repeat([speed * side for speed in speeds for side in (1, -1)], 1000)
    return 0.3 + np.cumsum(np.convolve(goals, np.hanning(101) / 50.0, 'same')) * 2e-3


COUNT = 2.0 * np.pi / 2**16


@pytest.mark.parametrize(
    ('bits', 'unit', 'decimals'),
    [
        (16, 1.0, 16),
        (16, 1.0, 6),
        (16, 1.0, 5),
        (16, np.degrees(1.0), 4),
        (14, np.degrees(1.0), 3),
        (12, np.degrees(1.0), 2),
    ],
)
def test_the_count_of_positions_in_a_few_decimals_is_that_of_the_encoder(bits, unit, decimals):
    count = 2.0 * np.pi / 2**bits
    q = np.round(count * np.round(strokes() / count) * unit, decimals) / unit
    assert counts_of(q) == pytest.approx(count, rel=2e-4)
    assert signal_noise(q)[0] == counts_of(q)


def test_means_of_two_counts_have_half_of_one():
    q = COUNT * np.round(strokes() / COUNT)
    assert counts_of(0.5 * (q[1:] + q[:-1])) == pytest.approx(0.5 * COUNT, rel=1e-9)


@pytest.mark.parametrize('noise', [0.0, 1e-6, 1e-4])
def test_positions_that_are_no_counts_have_none(noise):
    q = strokes() + noise * np.random.default_rng(0).standard_normal(len(strokes()))
    assert counts_of(q) == 0.0
    assert signal_noise(q)[0] > 0.0


def test_two_steps_far_from_each_other_have_no_count():
    """Between them is what the smallest steps are: nothing is near it, and the search ends."""
    assert counts_of(np.array([0.0, 1.0, 1001.0])) == 0.0
