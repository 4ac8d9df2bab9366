# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The one integrator against closed forms, compiled and not."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numba import njit
from numba.extending import register_jitable

from sosml_friction.simulation.integrator import runge_kutta_step

#: Of an oscillator that is damped: natural frequency [rad/s] and damping.
W, Z = 3.0, 0.1


@register_jitable
def oscillator(known, t, q, v):
    w, z = known
    return -w * w * q - 2.0 * z * w * v


@njit
def compiled(q, v, h, count):
    for _ in range(count):
        q, v = runge_kutta_step(oscillator, (W, Z), q, v, h)
    return q, v


def swung(q, v, h, count):
    for _ in range(count):
        q, v = runge_kutta_step(oscillator, (W, Z), q, v, h)
    return q, v


def closed_form(t):
    """Return displacement and velocity of an oscillator let go at 1."""
    w, fade = W * np.sqrt(1.0 - Z * Z), np.exp(-Z * W * t)
    q = fade * (np.cos(w * t) + Z * W / w * np.sin(w * t))
    return np.array([q, -fade * W * W / w * np.sin(w * t)])


def test_it_is_of_fourth_order_on_a_damped_oscillator():
    errors = []
    for h in (0.1, 0.05, 0.025):
        found = swung(1.0, 0.0, h, round(2.0 / h))
        errors.append(np.linalg.norm(found - closed_form(2.0)))
    for coarse, fine in itertools.pairwise(errors):
        assert 2**3.5 < coarse / fine < 2**4.5
    # (W h)^4 W t / 120 of a velocity of 3 rad/s.
    assert errors[-1] < 5e-6


def test_effort_that_changes_in_time_is_seen_at_the_beginning_middle_and_end():
    """q'' = 6 t from rest is t^3, which the rule has exactly."""
    q, v = runge_kutta_step(lambda _, t, q, v: 6.0 * t, None, 0.0, 0.0, 0.5)
    assert (q, v) == (pytest.approx(0.125, rel=1e-15), pytest.approx(0.75, rel=1e-15))


def test_compiled_and_interpreted_steps_are_the_same_for_numbers_and_arrays_of_any_shape():
    number = compiled(1.0, 0.0, 0.05, 40)
    for shape in ((1,), (3, 2)):
        array = swung(np.ones(shape), np.zeros(shape), 0.05, 40)
        for one, many in zip(number, array, strict=True):
            assert many.shape == shape
            np.testing.assert_array_equal(many, one)
