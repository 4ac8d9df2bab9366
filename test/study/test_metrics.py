# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The figures of merit on signals of which they are known."""

import numpy as np
import pytest

from sosml_friction.study.condition import Observation
from sosml_friction.study.metrics import (
    is_steady,
    loop_width,
    reversals,
    score,
    settle_time,
)

TIME = np.arange(1, 12001) * 1e-3
VELOCITY = np.sin(np.pi * (TIME - 0.3005))
TRUTH = 1.2 * np.sign(VELOCITY)


def decaying(rate, size=2.4):
    """Return the error of a first-order observer after each jump of the truth."""
    since = (TIME - 0.3005) % 1.0
    return -np.sign(VELOCITY) * size * np.exp(-rate * since)


def observation():
    columns = [np.column_stack([x]) for x in (VELOCITY, TRUTH, np.zeros_like(TIME))]
    return Observation(TIME, *columns, np.zeros(1), None)


@pytest.mark.parametrize('rate', [10.0, 37.0, 120.0])
def test_an_exponential_settles_to_a_tenth_after_ln_10_time_constants(rate):
    """The samples lie half a step beside the crossing: one step of 1 ms is the resolution."""
    found = settle_time(TIME, VELOCITY, TRUTH, decaying(rate))
    assert found == pytest.approx(np.log(10.0) / rate, abs=1.1e-3)


def test_an_offset_of_less_than_a_tenth_does_not_delay_for_ever():
    """With up and down in turn an offset leaves the average over both directions."""
    error = decaying(50.0) + 0.2
    assert settle_time(TIME, VELOCITY, TRUTH, error) < 0.06


@pytest.mark.parametrize(
    'error', [np.sign(VELOCITY) * 0.3, np.full(len(TIME), np.nan), decaying(1.0)]
)
def test_what_does_not_settle_has_no_settle_time(error):
    assert np.isnan(settle_time(TIME, VELOCITY, TRUTH, error))


def test_noise_that_hides_the_mean_error_is_not_taken_for_settling():
    """10 reversals count: the limit of 0.24 Nm is hidden from 0.06 Nm sqrt(10) = 0.19 Nm on."""
    assert len(reversals(TIME, VELOCITY)) == 11
    error = decaying(30.0)
    assert np.isfinite(settle_time(TIME, VELOCITY, TRUTH, error, 0.17))
    assert np.isnan(settle_time(TIME, VELOCITY, TRUTH, error, 0.22))


def test_a_motion_without_reversal_has_neither_settle_time_nor_width():
    still = np.ones_like(TIME)
    assert np.isnan(settle_time(TIME, still, TRUTH, decaying(10.0)))
    assert np.isnan(loop_width(TIME, still, decaying(10.0)))


def test_a_reversal_at_a_sample_counts_once():
    velocity = np.sin(np.pi * (TIME - 0.3))
    velocity[np.abs(velocity) < 1e-12] = 0.0
    assert (velocity == 0.0).sum() >= 10
    found = reversals(TIME, velocity)
    assert len(found) == 11
    touching = np.where(np.abs(TIME - 5.0) < 1e-9, 0.0, 1.0)
    assert len(reversals(TIME, touching)) == 0


#: Of the eight reversals in here as many go up as down.
EVEN = TIME <= 9.0


@pytest.mark.parametrize('lag', [0.2, -0.1])
def test_the_width_is_what_lies_between_the_branches(lag):
    """An estimate that is late by a constant effort: -lag on the way up, +lag on the way down."""
    rising = np.cos(np.pi * (TIME - 0.3005)) > 0.0
    error = np.where(rising, -lag, lag)
    t, v = TIME[EVEN], VELOCITY[EVEN]
    assert len(reversals(t, v)) == 8
    assert loop_width(t, v, error[EVEN]) == pytest.approx(2.0 * lag)
    assert loop_width(t, v, error[EVEN] + 0.5) == pytest.approx(2.0 * lag)


def test_the_width_of_a_single_crossing_takes_the_other_branch_for_its_mirror():
    """The mean of the error, here zero over whole half-cycles, is no width."""
    part = TIME <= 2.5
    t, v = TIME[part], VELOCITY[part]
    assert len(reversals(t, v)) == 2
    part = (TIME > 0.4) & (TIME <= 2.0)
    t, v = TIME[part], VELOCITY[part]
    assert len(reversals(t, v)) == 1
    error = np.where(np.abs(t - 1.3005) < 0.01, 0.2, 0.0)
    # On the way down: +0.2 of an estimate that lags; 20 samples of 1500 make the mean.
    expected = 2.0 * (0.2 - error[t > 0.5].mean())
    assert loop_width(t, v, error) == pytest.approx(expected)
    assert loop_width(t, v, error + 0.7) == pytest.approx(expected)


def test_the_width_is_read_where_the_velocity_is_zero_between_samples():
    """At the sample before it, 0.5 ms away, the error would be 3 pi 0.0005 = 4.7 mNm."""
    error = 3.0 * VELOCITY
    assert loop_width(TIME[EVEN], VELOCITY[EVEN], error[EVEN]) == pytest.approx(0.0, abs=1e-12)


def test_steady_means_steady_for_a_quarter_of_a_second():
    steady = is_steady(TIME, TRUTH)
    since = (TIME - 0.3005) % 1.0
    inside = TIME > 0.6
    assert steady[inside & (since > 0.252)].all()
    assert not steady[inside & (since < 0.249)].any()


def test_noise_and_rmse_of_an_ensemble():
    """64 seeds: the noise is known to 1 %; an offset is error but not noise."""
    rng = np.random.default_rng(0)
    seen = observation()
    noise = 0.05 * rng.normal(size=(64, len(TIME)))
    estimates = [(TRUTH + 0.12 + x)[:, None] for x in noise]
    found = score([seen] * 64, estimates, 0, noisy=True)
    assert found.noise_std == pytest.approx(0.05, rel=0.01)
    assert found.rmse.shape == (64,)
    np.testing.assert_allclose(found.rmse, np.hypot(0.12, 0.05), rtol=0.05)
    assert np.isnan(score([seen] * 64, estimates, 0, noisy=False).noise_std)
    assert np.isnan(score([seen], estimates[:1], 0, noisy=True).noise_std)


def test_the_first_half_second_is_not_scored():
    seen = observation()
    estimate = TRUTH + np.where(TIME <= 0.5, 100.0, 0.01)
    found = score([seen], [estimate[:, None]], 0, noisy=False)
    np.testing.assert_allclose(found.rmse, 0.01)
