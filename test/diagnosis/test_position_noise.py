# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Noise of position passes for a function of acceleration where the motion has none."""

from __future__ import annotations

import numpy as np

from sosml_friction.diagnosis.band import Band
from sosml_friction.diagnosis.position_noise import PositionNoise

STEP, QUANTUM = 2e-3, 2.0 * np.pi / 65536
BAND = Band(28.0, STEP)


def share(q):
    """Return the share for one joint of 0.3 kg m2 with 50 mNm of noise in each sample."""
    noise = PositionNoise(
        q[:, None], np.array([QUANTUM]), np.zeros(1), np.array([0.05]), np.array([[0.3]])
    )
    return noise.share(BAND)


def test_steps_of_an_encoder_look_like_inertia_at_constant_speed_and_not_in_fast_motion():
    """
    At 0.05 rad/s the steps make a line at 0.05 / quantum = 521 Hz, seen at 500 Hz as 21 Hz.

    M e'' of that line is 0.3 (2 pi 21)^2 quantum / (sqrt(2) pi) = 0.11 Nm, in the band, and the
    motion has no acceleration beside it; the sine's is 10 rad/s2.
    """
    t = np.arange(0.0, 60.0, STEP)
    slow, fast = share(0.05 * t), share(0.4 * np.sin(5.0 * t))
    assert slow > 0.3
    assert fast < 0.01
