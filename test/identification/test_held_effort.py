# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Efforts that are repeated until the next one comes."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.identification.held_effort import new_efforts, with_new_efforts

#: Samples at 500 Hz.
TIME = 2e-3 * np.arange(5000)


def effort(t, noise=0.02):
    rng = np.random.default_rng(1)
    return np.sin(1.3 * t) + 0.2 * np.sin(5.0 * t) + noise * rng.standard_normal(len(t))


def held(rate, tau):
    """Return an effort of which a new one comes at ``rate`` [Hz], and when (N,)."""
    first = np.unique(np.floor(TIME * rate + 1e-9), return_index=True)[1]
    last = first[np.searchsorted(first, np.arange(len(TIME)), side='right') - 1]
    return tau[last], first


@pytest.mark.parametrize('rate', [250.0, 200.0, 125.0, 50.0, 47.0])
def test_the_samples_of_new_efforts_are_found(rate):
    tau, first = held(rate, effort(TIME))
    # Nothing tells when that of the first sample came.
    np.testing.assert_array_equal(new_efforts(tau), first[1:])


def test_a_new_effort_as_the_one_before_is_a_sample_too():
    """Steps of 0.1 of an effort that rests for 2 s; what is lost is no new one."""
    coarse = 0.1 * np.rint(effort(TIME) / 0.1)
    coarse[2000:3000] = coarse[2000]
    tau, first = held(50.0, coarse)
    tau[205] = np.nan
    own = new_efforts(tau)
    assert np.mean(np.isin(own, first)) > 0.95
    assert np.diff(own).max() <= 11


@pytest.mark.parametrize(
    'tau',
    [
        effort(TIME),
        0.1 * np.rint(effort(TIME) / 0.1),
        # Without noise: at even steps where it rises evenly, but by one count after another.
        0.01 * np.rint(effort(TIME, 0.0) / 0.01),
        0.1 * np.rint(20.0 * np.abs(TIME - 5.0) / 2.0),
        np.sign(np.sin(40.0 * TIME)) * (1.0 + TIME),
        np.zeros_like(TIME),
        np.full_like(TIME, np.nan),
    ],
)
def test_an_effort_that_is_not_held_is_left_alone(tau):
    assert new_efforts(tau) is None


def log_of(*efforts):
    tau = np.column_stack(efforts)
    t_ns = np.round(1e9 * TIME).astype(np.int64)
    return JointLog(tuple('abc'[: len(efforts)]), t_ns, 0.0 * tau, np.nan * tau, tau)


def test_a_command_that_is_held_for_long_acts_as_it_is():
    """A random sequence of four levels at 10 Hz: an effort between its steps is no old one."""
    levels = np.random.default_rng(4).integers(0, 4, 100)
    log = log_of(np.repeat(levels, 50).astype(float))
    assert with_new_efforts(log) == (log, '')


def test_what_is_not_known_of_an_effort_stays_unknown():
    """Two joints at 50 and 125 Hz, the second without effort for 2 s."""
    slow, fast = held(50.0, effort(TIME))[0], held(125.0, effort(TIME))[0]
    fast[2000:3000] = np.nan
    kept, told = with_new_efforts(log_of(slow, fast))
    assert 'of a at 50 Hz' in told
    time = 1e-9 * kept.t_ns
    unknown = (time > TIME[2000]) & (time < TIME[2999])
    assert np.isnan(kept.tau[unknown, 1]).all()
    assert np.isfinite(kept.tau[~unknown, 1]).mean() > 0.99
