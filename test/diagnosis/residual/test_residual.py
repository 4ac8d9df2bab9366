# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is computed of a rest is what is known of made-up signals."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.diagnosis.residual.joint_residual import way_since_reversal
from sosml_friction.diagnosis.residual.position_spectrum import position_spectrum
from sosml_friction.diagnosis.residual.timing import autocorrelation, lowest, shifted_error
from sosml_friction.diagnosis.residual.variance_steps import noise_variance
from sosml_friction.regression.noise_model import ORDER, NoiseModel


def test_a_line_in_position_has_its_size_and_place():
    rng = np.random.default_rng(2)
    q = np.cumsum(rng.uniform(0.0, 0.004, 5000))
    effort = 0.3 * np.cos(40.0 * q + 1.0) + 2.0
    nothing, size = position_spectrum(q, np.column_stack([0.0 * q, effort]), 20.0, 0.5, 100)
    assert nothing == pytest.approx(0.0)
    assert int(np.argmax(size)) == 40
    # 0.5 %: the mean that is taken off is not quite that of the line's whole periods.
    assert size[40] == pytest.approx(0.3, rel=5e-3)
    assert np.median(size) < 0.03


def test_the_way_since_a_reversal_starts_at_the_turn_and_noise_is_no_turn():
    q = np.concatenate([np.linspace(0.0, 1.0, 101), np.linspace(0.99, 0.5, 50)])
    way = way_since_reversal(q, 0.005)
    assert way[:101] == pytest.approx(q[:101], abs=1e-12)
    assert way[101:] == pytest.approx(1.0 - q[101:], abs=1e-12)
    noisy = q[:101] + 1e-3 * np.where(np.arange(101) % 2, 1.0, -1.0)
    assert way_since_reversal(noisy, 0.05)[-1] == pytest.approx(1.0, abs=3e-3)
    # A rest is not a motion.
    assert way_since_reversal(np.zeros(5), 0.01) == pytest.approx(0.0)


def test_the_autocorrelation_is_that_of_numpy():
    e = np.random.default_rng(3).normal(size=300)
    full = np.correlate(e, e, 'full')[299:]
    assert autocorrelation(e, 20) == pytest.approx(full[:21] / full[0], abs=1e-12)


def test_the_error_is_least_where_a_late_effort_is_shifted_back():
    step = 7e-3
    t = step * np.arange(3000)
    signal = np.sin(3.0 * t) + 0.4 * np.sin(11.0 * t)
    late = np.sin(3.0 * (t - 4e-3)) + 0.4 * np.sin(11.0 * (t - 4e-3))
    shifts = np.linspace(-0.02, 0.02, 41)
    error = shifted_error(late, late - signal, step, shifts, (1000,))
    place, least = lowest(shifts, error)
    assert place == pytest.approx(4e-3, abs=2e-4)
    assert least < 0.01
    # Without a shift it is the error itself.
    inner = slice(10, -10)
    usual = float(np.sqrt(np.mean((late - signal)[inner] ** 2)))
    assert error[20] == pytest.approx(usual, rel=0.02)


def test_the_lowest_point_is_that_of_the_parabola():
    x = np.linspace(-1.0, 1.0, 9)
    assert lowest(x, 2.0 + 3.0 * (x - 0.1) ** 2) == pytest.approx((0.1, 2.0))


def test_the_variance_of_an_autoregression_is_the_closed_form():
    coefficients = np.zeros(ORDER)
    coefficients[0] = 0.9
    noise = NoiseModel(coefficients, 0.5)
    assert noise_variance(noise) == pytest.approx(0.25 / (1.0 - 0.81), rel=1e-9)
