# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The windowed slope against its closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.motion.velocity import WindowedSlope, lag

PERIOD_NS = 2_000_000
GAP_NS = 22_000_000


def run(slope: WindowedSlope, t_ns, q):
    return np.array([slope.update(int(t), float(x)) for t, x in zip(t_ns, q, strict=True)])


@pytest.mark.parametrize('window', [2, 5, 11, 50])
def test_the_lag_at_constant_acceleration_is_half_the_window(window):
    slope = WindowedSlope(window, 10 * GAP_NS)
    t_ns = np.arange(200) * PERIOD_NS
    t = t_ns * 1e-9
    a, v0 = 3.0, -0.2
    v = run(slope, t_ns, 0.5 * a * t * t + v0 * t)
    half = (window - 1) / 2 * PERIOD_NS * 1e-9
    full = slice(window - 1, None)
    np.testing.assert_allclose(v[full], v0 + a * (t[full] - half), rtol=0, atol=1e-11)
    assert lag(window, 2e-3) == pytest.approx(half)


@pytest.mark.parametrize('window', [5, 11, 21])
def test_the_noise_is_that_of_a_least_squares_slope(window):
    rng = np.random.default_rng(1)
    sigma = 1e-4
    slope = WindowedSlope(window, GAP_NS)
    n = 40_000
    v = run(slope, np.arange(n) * PERIOD_NS, sigma * rng.standard_normal(n))[window - 1 :]
    expected = sigma * math.sqrt(12 / (window * (window**2 - 1))) / 2e-3
    # n / window independent windows: the ratio's standard error is below 1.2 %.
    assert v.std() == pytest.approx(expected, rel=0.06)


def test_uneven_stamps_are_used_as_they_are():
    rng = np.random.default_rng(2)
    t_ns = np.cumsum(rng.integers(1_000_000, 4_000_000, 100))
    v = run(WindowedSlope(11, GAP_NS), t_ns, 0.7 * t_ns * 1e-9)
    np.testing.assert_allclose(v[10:], 0.7, rtol=1e-9)


def test_it_is_the_slope_numpy_fits():
    rng = np.random.default_rng(3)
    t_ns = np.cumsum(rng.integers(1_000_000, 4_000_000, 11))
    q = rng.standard_normal(11)
    v = run(WindowedSlope(11, GAP_NS), t_ns, q)[-1]
    assert v == pytest.approx(np.polyfit((t_ns - t_ns[0]) * 1e-9, q, 1)[0])


def test_nothing_is_said_before_the_window_is_full():
    v = run(WindowedSlope(11, GAP_NS), np.arange(11) * PERIOD_NS, np.zeros(11))
    assert np.isnan(v[:10]).all()
    assert v[10] == 0.0


@pytest.mark.parametrize('jump', [GAP_NS + 1, 0, -PERIOD_NS])
def test_a_gap_and_a_stamp_that_does_not_increase_start_a_new_window(jump):
    t_ns = np.arange(40) * PERIOD_NS
    t_ns[20:] += jump - PERIOD_NS
    v = run(WindowedSlope(11, GAP_NS), t_ns, np.ones(40))
    assert np.isnan(v[20:30]).all()
    assert np.isfinite(v[10:20]).all()
    assert np.isfinite(v[30:]).all()


def test_nan_starts_a_new_window():
    q = np.ones(40)
    q[20] = math.nan
    v = run(WindowedSlope(11, GAP_NS), np.arange(40) * PERIOD_NS, q)
    assert np.isnan(v[20:31]).all()
    assert np.isfinite(v[31:]).all()


@pytest.mark.parametrize(('window', 'gap'), [(1, GAP_NS), (11, 0)])
def test_a_window_that_gives_no_slope_is_refused(window, gap):
    with pytest.raises(ConfigurationError):
        WindowedSlope(window, gap)
