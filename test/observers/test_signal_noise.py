# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Noise and resolution of signals: compiled for on line as the others off line."""

import numpy as np
import pytest

from sosml_friction.observers.signal_noise import difference_noise, seen_noise, signal_noise


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
