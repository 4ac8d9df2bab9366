# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the observers are given: exact signals, or those of an encoder."""

import numpy as np
import pytest

from sosml_friction.study.condition import (
    encoder_noise,
    encoder_step,
    observe,
    read_by_encoder,
)


@pytest.mark.parametrize('bits', [14, 16, 19])
def test_encoder_noise_is_half_a_step_and_rounding(study_runs, bits):
    """Of 40000 readings the standard deviation is known to 0.4 %, the mean to 0.3 % of it."""
    log = study_runs['reversal'].log
    read = read_by_encoder(log, bits, 1)
    step = encoder_step(bits)
    assert step == pytest.approx(2.0 * np.pi / 2**bits)
    counts = read.q / step
    np.testing.assert_allclose(counts, np.round(counts), atol=1e-6)
    error = read.q - log.q
    sigma = encoder_noise(bits)
    assert sigma == pytest.approx(step * np.sqrt(0.25 + 1.0 / 12.0))
    assert error.std() == pytest.approx(sigma, rel=0.02)
    assert abs(error.mean()) < 0.02 * sigma
    # White: neighbours have nothing in common.
    assert abs(np.mean(error[1:] * error[:-1])) < 0.03 * sigma**2


def test_noise_is_that_of_its_seed(study_runs):
    log = study_runs['slow'].log
    one, again, other = (read_by_encoder(log, 16, seed).q for seed in (1, 1, 2))
    np.testing.assert_array_equal(one, again)
    assert abs(np.corrcoef((one - log.q)[:, 0], (other - log.q)[:, 0])[0, 1]) < 0.05


def test_with_noise_the_velocity_is_the_backward_difference(study_arm, study_runs):
    run = study_runs['slow']
    (seen,) = observe(run, study_arm, 'noise', 16, [3])
    q = read_by_encoder(run.log, 16, 3).q
    for k in (0, 1, 5000):
        # The first sample has no velocity, the second starts the observers.
        v = (q[k + 2] - q[k + 1]) / 1e-3
        np.testing.assert_allclose(seen.samples.p[k], study_arm.inertia(q[k + 2]) @ v, atol=1e-10)
        assert seen.time[k] == pytest.approx((k + 2) * 1e-3)
        np.testing.assert_array_equal(seen.friction[k], run.friction[k + 2])
    # The step of 16 bit, differentiated, is above the whole speed of the motion.
    assert np.std(seen.samples.p[:, 0]) / study_arm.inertia(q[0])[0, 0] > 0.052


def test_nominal_signals_are_exact_and_the_effort_is_held(study_arm, study_runs):
    run = study_runs['reversal']
    (seen,) = observe(run, study_arm, 'nominal', 16, [])
    k = 777
    p, drift, M = study_arm.momentum_terms(run.log.q[k + 1], run.log.v[k + 1])
    before = study_arm.momentum_terms(run.log.q[k], run.log.v[k])[1]
    np.testing.assert_array_equal(seen.samples.p[k], p)
    np.testing.assert_allclose(
        seen.samples.forcing[k], run.log.tau[k] + 0.5 * (before + drift), atol=1e-13
    )
    np.testing.assert_array_equal(seen.samples.inertia[k], M)
    assert not seen.floor.any()
