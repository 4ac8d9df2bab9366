# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Recordings in a few sines are those of their model, and nothing is said to be missing."""

import mujoco
import numpy as np
import pytest

from validation import sines


@pytest.mark.parametrize('count', [1, 6])
def test_effort_without_noise_is_that_of_mujoco(count, monkeypatch):
    monkeypatch.setattr(sines, 'EFFORT_NOISE', 0.0)
    monkeypatch.setattr(sines, 'POSITION_NOISE', 0.0)
    log = sines.recording(count, seed=3)
    model = mujoco.MjModel.from_xml_string(sines.MJCF)
    # The inverse of a friction that sticks is a constraint: it is added here.
    model.dof_frictionloss[:] = 0.0
    data, h = mujoco.MjData(model), 1.0 / sines.RATE
    q, tau = log.q[:, 0], log.tau[:, 0]
    for k in range(10, 2000, 37):
        v, a = (q[k + 1] - q[k - 1]) / (2.0 * h), (q[k + 1] - 2.0 * q[k] + q[k - 1]) / h**2
        data.qpos[0], data.qvel[0], data.qacc[0] = q[k], v, a
        mujoco.mj_inverse(model, data)
        friction = sines.COULOMB * np.sign(v)
        # Differences are off by (w h)^2 / 12 and / 6 of themselves, of six sines at most 3e-4 Nm.
        assert data.qfrc_inverse[0] + friction == pytest.approx(tau[k], abs=5e-4)


def test_nothing_is_missing_in_two_sines():
    """Acceleration is then nearly a function of position and direction, and so is its noise."""
    assert sines.said(2, [1]) == ['nothing_above_floor']
