# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that wanders is told from slow noise by what is there before and after a reversal."""

import numpy as np
import pytest

from sosml_friction.regression.wandering_friction import wandering_friction

#: Rows of the band, 10 ms apart; a motion of 0.17 Hz with strokes of 3 s.
T = 0.01 * np.arange(6000)
SIGN = np.tanh(20.0 * np.sin(2.0 * np.pi * 0.17 * T))
ALL, MOST = np.ones(len(T)), 40
RNG = np.random.default_rng(6)
WHITE = RNG.normal(0.0, 0.1, len(T))
SLOW = 0.5 * np.sin(2.0 * np.pi * 0.11 * T + 1.0)


def found(residual, told=ALL, counts=(6000,)):
    return wandering_friction(residual, SIGN, told, counts, MOST)


@pytest.mark.parametrize('counts', [(6000,), (2500, 3500)], ids=['one stretch', 'two stretches'])
def test_a_level_of_friction_is_followed_across_reversals(counts):
    """
    The line between means of 0.4 s is off by 0.4^2 w^2 / 12 of a sine, 0.6 %, more where it turns.

    Noise is that of a mean of 40 rows, a sixth.
    """
    left = SIGN * SLOW - found(SIGN * SLOW + WHITE, counts=counts)
    assert np.std(left) < 0.01 * np.std(SLOW) + np.std(WHITE) / 6.0


def test_slow_noise_of_effort_and_white_noise_are_none():
    assert not found(SLOW + WHITE).any()
    assert not found(WHITE).any()


def test_rows_that_say_nothing_have_no_part():
    told = ALL.copy()
    told[2000:2400] = 0.0
    pushed = SIGN * SLOW + WHITE + np.where(told == 0.0, 50.0, 0.0)
    assert np.abs(found(pushed, told)).max() < 1.0


def test_a_joint_that_does_not_turn_around_has_none():
    still = wandering_friction(SLOW + WHITE, ALL, ALL, (6000,), MOST)
    assert not still.any()
    assert not wandering_friction(WHITE, np.zeros(len(T)), ALL, (6000,), MOST).any()
