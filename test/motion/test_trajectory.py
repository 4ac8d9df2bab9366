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


def test_without_velocities_it_goes_on_straight_lines_and_one_point_is_a_place():
    t, q = np.array([0.0, 1.0, 3.0]), np.array([[0.0], [1.0], [0.0]])
    spline = Trajectory(('a',), t, q).spline()
    np.testing.assert_allclose(spline([0.5, 2.0])[:, 0], [0.5, 0.5])
    np.testing.assert_allclose(spline([0.5, 2.0], 1)[:, 0], [1.0, -0.5])
    held = Trajectory(('a',), np.zeros(1), np.full((1, 1), 0.3)).spline()
    np.testing.assert_array_equal(held([0.0, 7.0])[:, 0], [0.3, 0.3])


def test_joints_in_another_order_and_less_of_them_keep_their_columns():
    q = np.arange(6.0).reshape(2, 3)
    found = Trajectory(('a', 'b', 'c'), np.array([0.0, 1.0]), q, -q).ordered(['c', 'a'])
    assert found.names == ('c', 'a')
    np.testing.assert_array_equal(found.q, q[:, [2, 0]])
    np.testing.assert_array_equal(found.v, -q[:, [2, 0]])


@pytest.mark.parametrize(
    ('t', 'q', 'v', 'words'),
    [
        ([0.0, 1.0], [[0.0]], [[0.0], [0.0]], 'positions .* have shape'),
        ([0.0, 1.0], [[0.0, 1.0]] * 2, [[0.0]] * 2, 'positions .* have shape'),
        ([0.0, 1.0], [[0.0]] * 2, [[0.0]], 'velocities .* have shape'),
        ([0.0, 1.0], [[0.0], [np.nan]], [[0.0]] * 2, 'point 1 .* positions that are not finite'),
        ([0.0, 1.0], [[0.0]] * 2, [[np.inf], [0.0]], 'point 0 .* velocities that are not finite'),
        ([0.0, np.nan], [[0.0]] * 2, [[0.0]] * 2, 'times .* must be finite'),
        ([0.0, 1.0, 0.5], [[0.0]] * 3, [[0.0]] * 3, 'point 2 .* at 0.5 s, not after 1 s'),
        ([0.0, 0.0], [[0.0]] * 2, [[0.0]] * 2, 'point 1 .* let the times increase'),
    ],
)
def test_a_trajectory_that_cannot_be_followed_is_refused(t, q, v, words):
    with pytest.raises(TrajectoryError, match=words):
        Trajectory(('a',), np.array(t), np.array(q), np.array(v))
