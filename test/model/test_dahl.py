# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction along a path: against bristles that are integrated by another's solver."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sosml_friction.model.dahl import SHARE, dahl_path, following_path

X = 2e-3
STEP = 1e-3


def motion(t):
    """Return position and velocity that turn around at many speeds [rad, rad/s]."""
    q = 0.02 * np.sin(3.1 * t) + 0.009 * np.sin(7.7 * t + 0.4)
    return q, 0.062 * np.cos(3.1 * t) + 0.0693 * np.cos(7.7 * t + 0.4)


def level(v):
    return np.exp(-((np.abs(v) / 0.04) ** 1.5))


def bristles(t, more):
    """Return LuGre's F / C along the motion, with s_0 = C / X and g = C (1 + more l(v))."""

    def slope(at, force):
        v = motion(at)[1]
        return (v - np.abs(v) * force / (1.0 + more * level(v))) / X

    found = solve_ivp(slope, (t[0], t[-1]), [0.0], t_eval=t, max_step=2e-4, rtol=1e-9, atol=1e-11)
    return found.y[0]


def test_one_way_both_are_what_the_equations_say():
    """z = 1 - e^-u and, at a level of 1, f = g (1 - e^(-u / g)) after u displacements."""
    u, g = np.linspace(0.0, 6.0, 201), 1.0 + SHARE
    z = 1.0 - np.exp(-u)
    assert dahl_path(u * X, X) == pytest.approx(z, abs=1e-12)
    y = following_path(u * X, X, np.ones_like(u))
    assert y == pytest.approx((g * (1.0 - np.exp(-u / g)) - z) / SHARE, abs=1e-12)


def test_what_follows_is_what_bristles_have_more_for_a_stribeck_term():
    t = STEP * np.arange(4000)
    q, v = motion(t)
    more = (bristles(t, SHARE) - bristles(t, 0.0)) / SHARE
    y = following_path(q, X, level(v))
    # Samples are 1 ms apart: the path turns within them by a parabola.
    assert np.abs(y - more).max() < 0.01
    at_once = dahl_path(q, X) * level(v)
    assert np.abs(at_once - more).max() > 0.15


def test_over_no_distance_it_is_the_sign_times_the_level():
    t = STEP * np.arange(4000)
    q, v = motion(t)
    moving = np.abs(v) > 5e-3
    y = following_path(q, 1e-8, level(v))
    assert y[moving] == pytest.approx((np.sign(v) * level(v))[moving], abs=0.01)


def test_at_rest_it_stays():
    q = np.concatenate([np.linspace(0.0, 1e-3, 50), np.full(50, 1e-3)])
    v = np.concatenate([np.full(50, 0.02), np.zeros(50)])
    y = following_path(q, X, level(v))
    assert (y[50:] == y[50]).all()


def test_steps_of_rounding_move_nothing_however_the_level_changes():
    rng = np.random.default_rng(0)
    q = 1e-18 * rng.integers(-2, 3, 1000).cumsum()
    y = following_path(q, X, rng.uniform(0.0, 1.0, 1000))
    assert np.abs(y).max() < 1e-9
