# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the low-pass of position leaves of a motion, and what of noise."""

import numpy as np
import pytest

from sosml_friction.regression.band import Band


def gain(band: Band, hertz: float) -> float:
    """Return by what a cosine is multiplied, in the middle of a long one."""
    t = (np.arange(4001) - 2000) * band.step
    return float(band.smooth(np.cos(2.0 * np.pi * hertz * t))[2000])


@pytest.mark.parametrize(
    ('cutoff', 'step'), [(12.0, 5e-4), (13.4, 1e-3), (20.0, 2e-3), (20, 5e-3)]
)
def test_motion_within_the_band_keeps_its_size_and_what_is_three_times_as_fast_is_gone(
    cutoff, step
):
    """A window of 80 dB: ripples of 1e-4, here and at standstill, to which all is scaled."""
    band = Band(cutoff, step)
    within = [gain(band, share * cutoff) for share in np.linspace(0.0, 1.0, 21)]
    assert within == pytest.approx(np.ones(21), abs=3e-4)
    beyond = [gain(band, share * cutoff) for share in np.linspace(3.0, 4.0, 11)]
    assert beyond == pytest.approx(np.zeros(11), abs=3e-4)


@pytest.mark.parametrize('rate', [50.0, 100.0, 333.0, 500.0, 1000.0])
def test_a_band_of_a_tenth_of_the_rate_keeps_one_of_three_samples(rate):
    """3 1/3 samples for each cycle of the cut-off, of ten: rounding made two of three of them."""
    assert Band(0.1 * rate, 1.0 / rate).factor == 3
