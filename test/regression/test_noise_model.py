# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the model of noise says of noise whose power is known."""

from itertools import pairwise

import numpy as np
import pytest

from sosml_friction.regression.band import Band
from sosml_friction.regression.noise_model import fit_noise


def powers(noise, band, model):
    """Return the power of whitened noise in six parts of the band."""
    e = model.whiten(noise)
    power = np.abs(np.fft.rfft(e)) ** 2 / len(e)
    at = np.fft.rfftfreq(len(e), band.output_step) / band.cutoff
    ends = (0.0, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0)
    return [power[(at >= a) & (at < b)].mean() for a, b in pairwise(ends)]


@pytest.mark.parametrize(('cutoff', 'step'), [(13.8, 0.004), (20.0, 0.001), (3.0, 0.002)])
def test_flat_noise_is_flat_in_the_whole_band(cutoff, step):
    """
    An autoregression of so low an order is bent by the edge of the band: without white noise it
    says 0.65 where noise is slow. Of 1000 frequencies, those of the narrowest part, power is off
    by 3 %; the rest is what the order leaves.
    """
    band = Band(cutoff, step)
    drawn = np.random.default_rng(0).standard_normal((70_000 * band.factor, 1))
    noise = band.apply(drawn)[:, 0]
    assert powers(noise, band, fit_noise([noise], 0.0)) == pytest.approx([1.0] * 6, abs=0.18)
