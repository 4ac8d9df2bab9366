# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction of bristles: a knee that is crossed within their own length is told all the same."""

import numpy as np
import pytest
from full_runs import in_full

from sosml_friction.identification.law.friction_memory import followed
from sosml_friction.identification.law.law_rows import LawRows
from sosml_friction.identification.velocity_smoother import repeats

TRUTH = {'coulomb': 0.7, 'viscous': 0.4, 'stribeck': 0.5, 'stribeck_velocity': 0.05}
#: Between samples [s].
STEP = 1e-3


def strokes(rng):
    """Return velocities of strokes there and back, in each of which v_s is crossed in 20 ms."""
    t, v = np.arange(0.0, 1.0, STEP), []
    for k in range(40):
        size, w = rng.uniform(0.2, 0.8), 2.0 * np.pi * rng.integers(3, 7)
        v.append((-1.0) ** k * (0.01 + 0.5 * size * (1.0 - np.cos(w * t))))
    return np.concatenate(v)


def bristles(v, stiffness, alike):
    """
    Return friction with F' = |v| (sign(v) f - F) / x, f = C + S e, solved over each step.

    x = f / s_0 is LuGre's without damping; ``alike``: f at v_s / s_0 at all speeds.
    """
    speed, C, S = np.abs(v), TRUTH['coulomb'], TRUTH['stribeck']
    f = C + S * np.exp(-speed / TRUTH['stribeck_velocity'])
    if stiffness is None:
        return np.sign(v) * f
    x = (C + S / np.e if alike else f) / stiffness
    friction, level, left = np.empty_like(v), 0.0, np.exp(-speed * STEP / x)
    for k, (aim, part) in enumerate(zip((np.sign(v) * f).tolist(), left.tolist(), strict=True)):
        # Mean over the step, and what it ends with.
        moved = speed[k] * STEP / x if alike else speed[k] * STEP / x[k]
        mean = (1.0 - part) / moved if moved > 0.0 else 1.0
        friction[k] = aim + (level - aim) * mean
        level = aim + (level - aim) * part
    return friction


def rows(stiffness, seed, alike=True):
    """Return rows of friction with noise, and what follows a column over a distance."""
    rng = np.random.default_rng(seed)
    v = strokes(rng)
    y = bristles(v, stiffness, alike) + TRUTH['viscous'] * v + rng.normal(0.0, 0.02, len(v))
    first = np.zeros(len(v), dtype=bool)
    found = LawRows(
        v,
        y,
        (STEP * np.arange(len(v))).astype(np.int64),
        np.ones(len(v), dtype=bool),
        v,
        lambda column: column,
    )

    def following(column, distance):
        if not (distance > 0.0).all():
            return column
        return followed(column, np.abs(v) * STEP / distance, first)

    return found, following


def held(fit):
    """Return of how many parameters the interval holds the truth."""
    ends = {name: fit.parameters[name].interval for name in TRUTH}
    return sum(low < TRUTH[name] < high for name, (low, high) in ends.items())


@pytest.mark.parametrize('seed', [1, in_full(2)])
def test_a_knee_that_is_crossed_within_the_distance_is_told(seed):
    """The distance is 0.25 mrad; v_s is crossed within some 0.5 mrad."""
    at_once, following = rows(3500.0, seed)
    memory = at_once.memory(following)
    assert memory.shown
    assert memory.distance == pytest.approx((0.7 + 0.5 / np.e) / 3500.0, rel=0.1)
    assert held(at_once.fit('Nm')) < 4
    fit = at_once.with_memory(memory).fit('Nm').parameters
    for name, value in TRUTH.items():
        assert abs(fit[name].value - value) < 3.0 * fit[name].std_error
    assert fit['stribeck'].std_error < 0.1 * TRUTH['stribeck']


def test_of_bristles_a_third_of_the_error_is_left():
    """Their distance goes with friction: one that does not is nearer than none."""
    at_once, following = rows(3500.0, 1, alike=False)
    before = at_once.fit('Nm').parameters['stribeck']
    after = at_once.with_memory(at_once.memory(following)).fit('Nm').parameters['stribeck']
    assert abs(after.value - 0.5) < 0.4 * abs(before.value - 0.5)
    assert after.std_error > before.std_error


@pytest.mark.parametrize('seed', [1, 2])
def test_friction_that_follows_at_once_has_no_memory(seed):
    at_once, following = rows(None, seed)
    memory = at_once.memory(following)
    assert memory is None or not memory.shown
    fit = at_once.fit('Nm')
    assert held(fit) >= 3
    if memory is not None:
        # What may be is in the errors, and moves no number.
        wide = at_once.with_memory(memory).fit('Nm').parameters['stribeck']
        assert wide.value == fit.parameters['stribeck'].value
        assert wide.std_error >= fit.parameters['stribeck'].std_error


def test_a_position_that_is_read_again_is_one_reading():
    np.testing.assert_array_equal(repeats(np.array([1.0, 1, 1, 2, 1, 1])), [3, 3, 3, 1, 2, 2])


def test_what_follows_a_step_is_an_exponential_of_the_distance():
    moved = np.full(400, 0.01)
    column, first = np.ones(400), np.zeros(400, dtype=bool)
    column[0], first[0] = 0.0, True
    x = np.cumsum(moved) - moved[0]
    ends = np.exp(-np.append(0.0, x[1:]))
    means = (ends[:-1] - ends[1:]) / moved[1:]
    np.testing.assert_allclose(followed(column, moved, first)[1:], 1.0 - means, atol=1e-12)
    first[200] = True
    np.testing.assert_array_equal(followed(column, moved, first)[200:], 1.0)
    np.testing.assert_allclose(followed(column, 1e9 * moved, first), column, atol=1e-6)
