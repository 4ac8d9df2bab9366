# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Single positions that no motion goes to."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.identification.glitches import glitches, without_glitches

#: Samples at 200 Hz.
TIME = 5e-3 * np.arange(8000)
COUNT = 2.0 * np.pi / 2**16


def motion(noise=0.0, seed=1):
    rng = np.random.default_rng(seed)
    q = np.sin(TIME) + 0.1 * np.sin(7.0 * TIME) + noise * rng.standard_normal(len(TIME))
    return COUNT * np.rint(q / COUNT)


def with_glitches(q, size):
    rng, off = np.random.default_rng(3), np.zeros(len(q), dtype=bool)
    off[rng.choice(len(q) // 2 - 1, 12, replace=False) * 2 + 1] = True
    return q + off * size * rng.choice([-1.0, 1.0], len(q)), off


@pytest.mark.parametrize('size', [3.0, 0.1])
@pytest.mark.parametrize('noise', [0.0, 1e-3])
def test_glitches_are_found_and_nothing_else(size, noise):
    """0.1 rad is 20 rad/s, ten times what the joint does."""
    q, off = with_glitches(motion(noise), size)
    np.testing.assert_array_equal(glitches(TIME, q), off)


@pytest.mark.parametrize(
    'q',
    [
        motion(),
        motion(3e-3),
        np.random.default_rng(2).normal(size=len(TIME)),
        # At rest with a bit that flickers now and then.
        COUNT * (np.random.default_rng(4).random(len(TIME)) < 0.01),
        # A square wave, and stops: jumps that stay.
        np.sign(np.sin(3.0 * TIME)),
        np.full_like(TIME, np.nan),
    ],
)
def test_motion_noise_and_jumps_that_stay_are_no_glitches(q):
    assert not glitches(TIME, q).any()


def test_few_recordings_of_noise_have_a_glitch():
    """The limit is that of a thousandth."""
    count = sum(glitches(TIME, motion(2e-2, seed)).any() for seed in range(100))
    assert count <= 1


def test_a_hole_in_time_is_no_speed_and_what_is_unknown_no_glitch():
    kept = np.random.default_rng(5).random(len(TIME)) < 0.1
    assert not glitches(TIME[kept], motion()[kept]).any()
    q = motion()
    q[::7] = np.nan
    assert not glitches(TIME, q).any()


def test_samples_with_a_glitch_of_any_joint_are_left_out_and_told_of_it():
    q, off = with_glitches(motion(), 3.0)
    both = np.column_stack([motion(), q])
    t_ns = np.rint(1e9 * TIME).astype(np.int64)
    kept, told = without_glitches(JointLog(('a', 'b'), t_ns, both, 0.0 * both, 0.0 * both))
    assert list(told) == ['b']
    assert 'joint b is off by up to 3 in 12 single samples' in told['b']
    np.testing.assert_array_equal(kept.t_ns, t_ns[~off])
