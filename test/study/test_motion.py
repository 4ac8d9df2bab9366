# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The reference motions: smooth, and as the paper describes them."""

import numpy as np
import pytest

from sosml_friction.study.motion import MOTIONS, reversal, slow

TIMES = np.arange(0.0, 24.0, 1e-3)


def sampled(reference, times=TIMES):
    """Return q, v, a of joint 1 and of joint 2, each (N, 2)."""
    return np.array([reference(t) for t in times]).transpose(1, 0, 2)


@pytest.mark.parametrize('reference', [slow, reversal])
def test_velocity_and_acceleration_are_derivatives_of_the_position(reference):
    """Central differences at 1 ms are off by h^2 / 6 times a third derivative of at most 11."""
    q, v, a = sampled(reference)
    np.testing.assert_allclose((q[2:] - q[:-2]) / 2e-3, v[1:-1], atol=2e-6)
    np.testing.assert_allclose((v[2:] - v[:-2]) / 2e-3, a[1:-1], atol=1e-5)


@pytest.mark.parametrize('reference', [slow, reversal])
def test_joint_2_is_held_at_65_degrees(reference):
    q, v, a = sampled(reference)
    np.testing.assert_array_equal(q[:, 1], np.deg2rad(65.0))
    assert not v[:, 1].any()
    assert not a[:, 1].any()


def test_slow_dwells_three_seconds_each_way_and_rests_at_both_ends():
    times = np.arange(0.0, MOTIONS['slow'].duration, 1e-3)
    v = sampled(slow, times)[1]
    v = v[:, 0]
    assert np.abs(v).max() == pytest.approx(0.052)
    for way in (1.0, -1.0):
        assert np.sum(np.abs(v - way * 0.052) < 1e-9) == pytest.approx(3000, abs=40)
    assert slow(0.0).v[0] == pytest.approx(0.0, abs=1e-15)
    end = slow(MOTIONS['slow'].duration)
    assert end.v[0] == pytest.approx(0.0, abs=1e-15)
    np.testing.assert_allclose(end.q, slow(0.0).q, atol=1e-15)
    # Half a quintic from rest to the dwell: by the middle of it, u = 3/4, 10u^3-15u^4+6u^5.
    share = 10 * 0.75**3 - 15 * 0.75**4 + 6 * 0.75**5
    assert slow(0.75).v[0] == pytest.approx(0.052 * (2 * share - 1))


def test_reversal_is_a_sinusoid_about_minus_50_degrees():
    q, v, _ = sampled(reversal)
    t = np.arange(len(q)) * 1e-3
    expected = np.deg2rad(-50.0) + 0.35 * np.sin(2 * np.pi * 0.5 * t)
    np.testing.assert_allclose(q[:, 0], expected, atol=1e-12)
    assert np.abs(v[:, 0]).max() == pytest.approx(0.35 * np.pi)
    assert MOTIONS['reversal'].duration == 20.0
