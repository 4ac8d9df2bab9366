# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The simulated arm of the study: its own equations, and what its controller must do."""

import numpy as np
import pytest

from sosml_friction.study.motion import reversal, slow
from sosml_friction.study.plant import TRUTH, simulate


def test_friction_is_the_law_at_the_true_velocity(study_runs):
    """Written out here, with the study's numbers: C .80 B .35 S .50 v_s .03 v0 .005."""
    run = study_runs['reversal']
    v = run.log.v[:, 0]
    law = (0.8 + 0.5 * np.exp(-np.abs(v) / 0.03)) * np.tanh(v / 0.005) + 0.35 * v
    np.testing.assert_allclose(run.friction[:, 0], law, atol=1e-13)
    v = run.log.v[:, 1]
    law = (0.4 + 0.25 * np.exp(-np.abs(v) / 0.03)) * np.tanh(v / 0.005) + 0.2 * v
    np.testing.assert_allclose(run.friction[:, 1], law, atol=1e-13)
    assert all(truth['bias'] == 0.0 for truth in TRUTH)


def test_on_a_plateau_friction_is_held_by_the_controllers_stiffness_alone(study_arm, study_runs):
    """q_r - q = M^-1 tau_f / 60^2; what changes slowly along the dwell leaves 1 %."""
    run = study_runs['slow']
    for t in (3.5, 9.5):
        k = round(t * 1000)
        error = slow(t).q - run.log.q[k]
        expected = np.linalg.solve(study_arm.inertia(run.log.q[k]), run.friction[k]) / 60.0**2
        assert error[0] == pytest.approx(expected[0], rel=0.01)


def test_a_finer_step_changes_nothing_that_matters(study_arm):
    """200 us against 50 us: the rule is of fourth order where tanh(v / v0) is smooth to it."""
    coarse = simulate(study_arm, reversal, 0.8, 200e-6)
    fine = simulate(study_arm, reversal, 0.8)
    assert len(fine.log) == 800
    np.testing.assert_allclose(coarse.log.q, fine.log.q, atol=1e-7)
    np.testing.assert_allclose(coarse.friction, fine.friction, atol=2e-3)


def test_effort_is_inverse_dynamics_of_reference_and_error(study_arm, study_runs):
    run, k = study_runs['reversal'], 1234
    q, v = run.log.q[k], run.log.v[k]
    wanted = reversal(k * 1e-3)
    a = wanted.a + 120.0 * (wanted.v - v) + 3600.0 * (wanted.q - q)
    tau = study_arm.inertia(q) @ a + study_arm.coriolis(q, v) @ v + study_arm.gravity(q)
    np.testing.assert_allclose(run.log.tau[k], tau, atol=1e-11)
