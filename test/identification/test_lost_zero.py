# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Positions that leap and stay there: an encoder that lost its zero."""

from __future__ import annotations

import numpy as np
import pytest
from known_robots import recording

from sosml_friction.identification.clean_samples import CleanSamples
from sosml_friction.identification.data_finding import LEFT_OUT
from sosml_friction.identification.lost_zero import LOST_ZERO, leaps

#: Samples at 100 Hz, in counts of 12 bits; at most 2.1 rad/s, 21 mrad from one to the next.
TIME = 0.01 * np.arange(3000)
COUNT = 2.0 * np.pi / 2**12


def motion(seed=0):
    """Return sines as an encoder reads them, with noise of less than a count."""
    noise = 0.4 * COUNT * np.random.default_rng(seed).standard_normal(len(TIME))
    q = 1.2 * np.sin(1.3 * TIME) + 0.15 * np.sin(4.0 * TIME) + noise
    return COUNT * np.rint(q / COUNT)


@pytest.mark.parametrize('leap', [0.05, -0.45, 2.0 * np.pi])
@pytest.mark.parametrize('at', [1, 1700, 2999])
def test_a_leap_that_stays_is_found(leap, at):
    q = motion()
    q[at:] += leap
    assert leaps(TIME, q).tolist() == [at]


def test_the_longest_stretch_of_all_joints_is_kept_and_each_leap_told():
    a, b = motion(1), motion(2)
    a[2600:] += 0.5
    b[300:] -= 0.2
    q = np.column_stack([a, b])
    clean = CleanSamples.of(recording(('a', 'b'), TIME, q, np.cos(q) + 1e-3 * TIME[:, None]))
    assert len(clean.log) == 2300
    said = {f.joint: f for f in clean.findings if f.check == LOST_ZERO}
    assert set(said) == {'a', 'b'}
    assert said['a'].level == LEFT_OUT
    for words in ('by 0.48', 'at 26 s', '700 of 3000 samples'):
        assert words in said['a'].sentence


@pytest.mark.parametrize('seed', range(5))
def test_motion_noise_and_holes_leap_nowhere(seed):
    q = motion(seed)
    # Someone moves it in the first hole.
    q[740:] += 3.0
    kept = np.ones(len(q), dtype=bool)
    kept[700:740] = kept[2000:2003] = False
    assert not len(leaps(TIME[kept], q[kept]))


def test_a_joint_that_sticks_and_slips_leaps_nowhere():
    """A servo that moves in leaps of its dead band, each in one sample."""
    q = 0.05 * np.rint(motion() / 0.05)
    assert not len(leaps(TIME, q))


def test_a_joint_that_is_knocked_leaps_nowhere():
    """It is faster than ever for a moment, and needs more than one sample for it."""
    q = motion()
    since = np.clip(TIME - 12.0, 0.0, None)
    q += 0.3 * (1.0 - np.exp(-since / 0.02) * (1.0 + since / 0.02))
    assert not len(leaps(TIME, q))
