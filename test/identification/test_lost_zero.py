# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Positions that leap and stay there: an encoder that lost its zero."""

from __future__ import annotations

import numpy as np
import pytest
from known_robots import recording

from sosml_friction.exceptions import DataError
from sosml_friction.identification.clean_samples import CleanSamples
from sosml_friction.identification.data_finding import LEFT_OUT
from sosml_friction.identification.lost_zero import LOST_ZERO, leaps

#: Samples at 100 Hz, in counts of 12 bits; at most 2.1 rad/s, 21 mrad from one to the next.
TIME = 0.01 * np.arange(3000)
COUNT = 2.0 * np.pi / 2**12


def motion(seed=0, time=TIME):
    """Return sines as an encoder reads them, with noise of less than a count."""
    noise = 0.4 * COUNT * np.random.default_rng(seed).standard_normal(len(time))
    q = 1.2 * np.sin(1.3 * time) + 0.15 * np.sin(4.0 * time) + noise
    return COUNT * np.rint(q / COUNT)


def cleaned(**joints):
    q = np.column_stack(list(joints.values()))
    return CleanSamples.of(recording(tuple(joints), TIME, q, np.cos(q) + 1e-3 * TIME[:, None]))


def said(clean):
    return {f.joint: f for f in clean.findings if f.check == LOST_ZERO}


@pytest.mark.parametrize('leap', [0.08, -0.45, 2.0 * np.pi])
@pytest.mark.parametrize('at', [10, 1700, 2990])
def test_a_leap_that_stays_is_found_with_its_size(leap, at):
    q = motion()
    q[at:] += leap
    ((found, size),) = leaps(TIME, q).items()
    assert found == at
    # Lines over 0.07 s of at most 4 rad/s^2 are off by 10 mrad.
    assert size == pytest.approx(leap, abs=0.01)


def test_the_zero_of_most_samples_is_kept_and_each_joint_s_leaps_are_told():
    a, b = motion(1), motion(2)
    a[2600:] += 0.5
    b[300:] -= 0.2
    clean = cleaned(a=a, b=b)
    assert len(clean.log) == 2300
    assert set(said(clean)) == {'a', 'b'}
    assert said(clean)['a'].level == LEFT_OUT
    for words in ('leaps 1 time, by up to 0.50', 'at 26 s', '400 of 3000 samples'):
        assert words in said(clean)['a'].sentence


def test_what_leaps_there_and_back_loses_what_is_between():
    q = motion()
    q[1500:1540] += 0.5
    clean = cleaned(a=q)
    assert len(clean.log) == 2960
    assert 'leaps 2 times' in said(clean)['a'].sentence


def test_where_all_joints_leap_at_once_rows_are_missing():
    """Of stamps that were made even afterwards: no encoder did it."""
    kept = np.r_[:1000, 1100:3000]
    a, b = motion(1)[kept], -0.7 * motion(2)[kept]
    time = TIME[: len(kept)]
    assert set(leaps(time, a)) == set(leaps(time, b)) == {1000}
    q = np.column_stack([a, b])
    assert not said(CleanSamples.of(recording(('a', 'b'), time, q, np.cos(q))))


def test_what_is_too_short_is_refused_with_what_was_left_out():
    joints = {}
    for i in range(4):
        joints[f'j{i}'] = motion(i)
        for k in range(5):
            joints[f'j{i}'][600 * k + 140 * i + 20 :] += 0.3
    with pytest.raises(DataError, match='j3 leaps 5 times'):
        cleaned(**joints)


@pytest.mark.parametrize('length', [2, 4])
def test_a_position_that_is_held_for_some_samples_leaps_nowhere(length):
    q = motion()
    q[1450 : 1450 + length] = q[1449]
    assert not leaps(TIME, q)


def test_a_sample_that_was_stamped_before_it_was_read_leaps_nowhere():
    """The driver is blocked for four periods between the stamp and the reading."""
    time = np.delete(TIME, np.arange(1451, 1455))
    q = motion()
    q[1450] = q[1454]
    assert not leaps(time, np.delete(q, np.arange(1451, 1455)))


@pytest.mark.parametrize('seed', range(5))
def test_across_a_hole_a_joint_may_have_been_moved(seed):
    q = motion(seed)
    q[740:] += 3.0
    kept = np.ones(len(q), dtype=bool)
    kept[700:740] = kept[2000:2003] = False
    assert not leaps(TIME[kept], q[kept])


def test_a_joint_that_slips_often_leaps_nowhere():
    """Of six leaps, each of which alone would be one."""
    q = motion()
    for k in range(6):
        q[200 + 400 * k :] += 0.3
    assert not leaps(TIME, q)
    assert len(leaps(TIME[:2100], q[:2100])) == 5


def test_a_quick_step_at_a_low_rate_is_no_leap():
    """A servo that goes 50 mrad in 10 ms: at 20 Hz it is elsewhere from one sample to the next."""
    time = 0.05 * np.arange(600)
    since = np.clip(time - 12.01, 0.0, None) / 0.01
    q = 0.05 * np.sin(0.5 * time) + 0.05 * (1.0 - np.exp(-since) * (1.0 + since))
    assert not leaps(time, q)
    assert len(leaps(0.2 * time, q)) == 1


def test_a_joint_that_is_knocked_leaps_nowhere():
    """It is faster than ever, for three samples."""
    q = motion()
    since = np.clip(TIME - 12.0, 0.0, None) / 0.02
    q += 0.3 * (1.0 - np.exp(-since) * (1.0 + since))
    assert not leaps(TIME, q)
