# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The trajectory type refuses what cannot be followed."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.exceptions import TrajectoryError
from sosml_friction.motion.trajectory import Trajectory


def test_the_spline_passes_its_knots_at_their_velocities():
    rng = np.random.default_rng(0)
    t = np.cumsum(rng.uniform(0.1, 1.0, 8)) - 0.1
    q, v = rng.normal(size=(8, 2)), rng.normal(size=(8, 2))
    trajectory = Trajectory(('a', 'b'), t, q, v)
    spline = trajectory.spline()
    np.testing.assert_allclose(spline(t), q, atol=1e-12)
    np.testing.assert_allclose(spline(t, 1), v, atol=1e-11)
    assert trajectory.duration == t[-1]


@pytest.mark.parametrize(
    ('t', 'q', 'v', 'words'),
    [
        ([0.0], [[0.0]], [[0.0]], 'two or more times'),
        ([0.0, 1.0], [[0.0]], [[0.0], [0.0]], 'give each joint both'),
        ([0.0, 1.0], [[0.0, 1.0]] * 2, [[0.0]] * 2, 'give each joint both'),
        ([0.0, 1.0], [[0.0], [np.nan]], [[0.0]] * 2, 'holds a q that is not finite'),
        ([0.0, 1.0], [[0.0]] * 2, [[np.inf], [0.0]], 'holds a v that is not finite'),
        ([0.0, np.nan], [[0.0]] * 2, [[0.0]] * 2, 'holds a t that is not finite'),
        ([0.0, 1.0, 0.5], [[0.0]] * 3, [[0.0]] * 3, r'back in time at point 2 \(0.5 s\)'),
        ([0.0, 0.0], [[0.0]] * 2, [[0.0]] * 2, 'back in time at point 1'),
    ],
)
def test_a_trajectory_that_cannot_be_followed_is_refused(t, q, v, words):
    with pytest.raises(TrajectoryError, match=words):
        Trajectory(('a',), np.array(t), np.array(q), np.array(v))
