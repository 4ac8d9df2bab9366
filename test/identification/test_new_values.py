# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Values that are repeated until the next one comes, or instead of one that was lost."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.identification.new_values import (
    new_positions,
    new_values,
    repeated_samples,
    with_new_values,
)

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
    np.testing.assert_array_equal(new_values(tau), first[1:])


def test_a_new_effort_as_the_one_before_is_a_sample_too():
    """Steps of 0.1 of an effort that rests for 2 s; what is lost is no new one."""
    coarse = 0.1 * np.rint(effort(TIME) / 0.1)
    coarse[2000:3000] = coarse[2000]
    tau, first = held(50.0, coarse)
    tau[205] = np.nan
    own = new_values(tau)
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
    assert new_values(tau) is None


def log_of(*efforts):
    tau = np.column_stack(efforts)
    t_ns = np.round(1e9 * TIME).astype(np.int64)
    return JointLog(tuple('abc'[: len(efforts)]), t_ns, 0.0 * tau, np.nan * tau, tau)


def test_a_command_that_is_held_for_long_acts_as_it_is():
    """A random sequence of four levels at 10 Hz: an effort between its steps is no old one."""
    levels = np.random.default_rng(4).integers(0, 4, 100)
    log = log_of(np.repeat(levels, 50).astype(float))
    assert with_new_values(log) == (log, [])


def test_what_is_not_known_of_an_effort_stays_unknown():
    """Two joints at 50 and 125 Hz, the second without effort for 2 s."""
    slow, fast = held(50.0, effort(TIME))[0], held(125.0, effort(TIME))[0]
    fast[2000:3000] = np.nan
    kept, told = with_new_values(log_of(slow, fast))
    (said,) = told
    assert said.check == 'held_effort'
    assert 'of a at 50 Hz' in said.sentence
    time = 1e-9 * kept.t_ns
    unknown = (time > TIME[2000]) & (time < TIME[2999])
    assert np.isnan(kept.tau[unknown, 1]).all()
    assert np.isfinite(kept.tau[~unknown, 1]).mean() > 0.99


#: Resolution of 14 bit [rad].
COUNT = 2.0 * np.pi / 2**14


def position(t, speed=1.0):
    return COUNT * np.rint((np.sin(speed * t) + 0.2 * np.sin(3.1 * speed * t)) / COUNT)


@pytest.mark.parametrize('rate', [250.0, 125.0, 50.0])
def test_the_samples_of_new_positions_are_found(rate):
    q, first = held(rate, position(TIME))
    assert np.mean(np.isin(new_positions(q), first)) > 0.99
    assert np.median(np.diff(new_positions(q))) == round(500.0 / rate)


@pytest.mark.parametrize(
    'q',
    [
        position(TIME),
        position(TIME, 0.01),
        # Speeds of which one is twice the other: a count in every 10 samples, or in every 5.
        COUNT * np.floor(np.where(TIME < 5.0, 0.1, 0.2) * np.arange(len(TIME))),
        np.zeros_like(TIME),
    ],
)
def test_a_position_that_moves_by_a_count_at_a_time_is_no_repeated_one(q):
    assert new_positions(q) is None


def test_of_repeated_positions_and_efforts_the_slowest_tells_the_samples():
    """Positions at 50 Hz beside efforts at 125 Hz, which are then on the line."""
    q, first = held(50.0, position(TIME))
    log = replace(log_of(held(125.0, effort(TIME))[0]), q=q[:, None])
    kept, told = with_new_values(log)
    assert [each.check for each in told] == ['held_position', 'held_effort']
    assert 'of a at 50 Hz: 4' in told[0].sentence
    time = 1e-9 * kept.t_ns
    assert np.mean(np.isin(np.rint(time / 2e-3), first)) > 0.99
    line = np.interp(time, TIME[::4], effort(TIME)[::4])
    assert kept.tau[1:-1, 0] == pytest.approx(line[1:-1])


def with_holds(log, length, share):
    """Return a log with whole samples repeated, and where (N,)."""
    rng, repeated = np.random.default_rng(7), np.zeros(len(log), dtype=bool)
    q, tau = log.q.copy(), log.tau.copy()
    apart = length + 5
    places = rng.choice(len(log) // apart - 1, round(share * len(log) / length), replace=False)
    for k in apart * places:
        q[k : k + length + 1], tau[k : k + length + 1] = q[k], tau[k]
        repeated[k + 1 : k + length + 1] = True
    return replace(log, q=q, tau=tau), repeated


@pytest.mark.parametrize('length', [1, 3, 5, 20])
def test_samples_that_repeat_the_one_before_are_found_however_many_they_are(length):
    log = replace(log_of(effort(TIME)), q=position(TIME, 5.0)[:, None])
    held_log, repeated = with_holds(log, length, 0.02)
    found = repeated_samples(held_log)
    assert not found[~repeated].any()
    # Where the joint turns around, a repeat is as good as a sample.
    assert np.mean(found[repeated]) > 0.85


@pytest.mark.parametrize('speed', [0.02, 1.0])
def test_equal_samples_of_coarse_values_are_no_repeats(speed):
    """An effort of steps of 0.5 Nm: 80 % of the samples are as the ones before at first."""
    coarse = 0.5 * np.rint(effort(TIME) / 0.5)
    log = replace(log_of(coarse), q=position(TIME, speed)[:, None])
    assert not repeated_samples(log).any()


def test_zeros_of_a_driver_that_is_not_yet_up_are_repeats_however_many():
    """8 s of zeros, then the joint is where it is: in counts it went slowly, but at once."""
    t = 1e-3 * np.arange(20000)
    q = 2e-5 * np.rint((0.3 + 0.2 * np.sin(2.0 * t)) / 2e-5)
    tau = np.cos(2.0 * t)
    q[:8000], tau[:8000] = 0.0, 0.0
    log = JointLog(('j',), np.rint(t * 1e9).astype(np.int64), q[:, None], np.nan * q[:, None],
                   tau[:, None])  # fmt: skip
    assert np.flatnonzero(repeated_samples(log)).tolist() == list(range(1, 8000))
    # A joint that rests for as long, and then starts, repeats nothing.
    rest = np.where(t < 8.0, q[8000], q)
    tau[:8000] = tau[8000]
    assert not repeated_samples(replace(log, q=rest[:, None], tau=tau[:, None])).any()


def test_equal_samples_at_uneven_stamps_are_no_repeats():
    """A driver on a busy machine: a joint that goes a count a sample goes two in a long one."""
    rng = np.random.default_rng(8)
    t = np.cumsum(rng.choice([1_000_000, 2_000_000, 3_000_000], 4000))
    count = 2.0 * np.pi / 36000.0
    q = count * np.rint(np.sin(1e-9 * t) * 0.11 / count)
    log = JointLog(
        ('a',), t, q[:, None], np.full((len(t), 1), np.nan), np.full((len(t), 1), 2.5875)
    )
    assert (np.diff(q) == 0.0).any()
    assert (np.abs(np.diff(q)) > 1.5 * count).any()
    assert not repeated_samples(log).any()
