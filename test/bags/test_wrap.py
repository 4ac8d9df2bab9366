# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Positions that wrap are made continuous, and nothing else is taken for a wrap."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.bags.running_unwrap import RunningUnwrap
from sosml_friction.bags.wrap import near_turn, unwrapped, wrap_period

T = 0.02 * np.arange(3000)


def turning(speed=8.0) -> np.ndarray:
    """Return a shaft that turns many times to and fro."""
    return speed * 9.0 * np.sin(T / 9.0)


def wrapped(q, period):
    return np.mod(q + 0.5 * period, period) - 0.5 * period


@pytest.mark.parametrize('period', [25.0, 2.0 * np.pi, 360.0, 8.0])
def test_the_period_of_a_wrap_is_found_whatever_the_register(period):
    noise = np.random.default_rng(0).normal(0.0, 1e-3, len(T))
    assert wrap_period(T, wrapped(turning(0.6 * period) + noise, period)) == period


def test_samples_lost_at_a_wrap_do_not_hide_it():
    kept = np.random.default_rng(1).random(len(T)) > 0.1
    assert wrap_period(T[kept], wrapped(turning(), 25.0)[kept]) == 25.0


@pytest.mark.parametrize(
    'q',
    [
        turning(),
        np.where(np.arange(len(T)) == 700, 0.0, turning() + 100.0),
        np.where(T < 20.0, turning(), turning() - 40.0),
        np.sign(np.sin(T)),
        np.rint(np.sin(T)) * 1e-4,
        np.zeros(len(T)),
        np.full(len(T), np.nan),
    ],
    ids=['motion', 'outlier', 'zero_set_anew', 'square', 'two_counts', 'rest', 'unknown'],
)
def test_what_is_no_wrap_is_none(q):
    assert wrap_period(T, q) is None


@pytest.mark.parametrize('counts', [0.3, 0.5, 0.8, 1.0, 2.0])
@pytest.mark.parametrize('seed', range(2))
def test_the_noise_of_an_encoder_that_stands_is_no_wrap(counts, seed):
    """Two counts one way and three back look like a register of five."""
    q = np.rint(np.random.default_rng(seed).normal(0.0, counts, len(T))) * 2e-4
    assert wrap_period(T, q) is None
    running = RunningUnwrap(1)
    found = [running(round(t * 1e9), np.array([x]))[0] for t, x in zip(T, q, strict=True)]
    np.testing.assert_array_equal(found, q)


def test_a_wheel_that_turns_a_third_in_a_sample_is_followed():
    """24 rad/s at 15 Hz, with as much noise of the stamps as a driver has."""
    t = np.arange(600) / 15.0
    assert wrap_period(t, wrapped(24.0 * t, 2.0 * np.pi)) == 2.0 * np.pi


def test_one_bad_sample_does_not_hide_a_wrap():
    q = wrapped(turning(), 25.0)
    q[1000 + int(np.argmin(np.abs(q[1000:2000])))] += 7.0
    assert wrap_period(T, q) == 25.0


def test_on_line_a_hole_before_the_first_wrap_does_not_hide_it():
    t = 0.002 * np.arange(4000)
    q = wrapped(2.5 * t, 2.0 * np.pi)
    running = RunningUnwrap(1)
    kept = (t < 0.5) | (t > 0.9)
    found = [
        running(round(x * 1e9), np.array([y]))[0] for x, y in zip(t[kept], q[kept], strict=True)
    ]
    np.testing.assert_allclose(found, 2.5 * t[kept], atol=1e-9)


def test_noise_at_the_start_of_a_motion_is_no_wrap_on_line():
    """15 Hz and 0.1 mrad, as slow and as fine as it gets: 400 joints that stand and then move."""
    t = np.arange(100) / 15.0
    for seed in range(400):
        noise = np.random.default_rng(seed).normal(0.0, 1e-4, len(t))
        q = np.where(t < 3.0, 0.0, 0.4 * (1.0 - np.cos(t - 3.0))) + noise
        running = RunningUnwrap(1)
        for x, y in zip(t, q, strict=True):
            running(round(x * 1e9), np.array([y]))
        assert np.isnan(running.periods[0])


def test_a_bag_is_read_unwrapped_and_says_so(tmp_path):
    q = np.column_stack([turning(), np.sin(T)])
    raw = np.column_stack([wrapped(turning(), 25.0), np.sin(T)])
    t_ns = np.rint(T * 1e9).astype(np.int64)
    nothing = np.full_like(q, np.nan)
    log = JointLog(('shaft', 'arm'), t_ns, raw, nothing, nothing)
    read = Bag.open(write_joint_log(log, tmp_path / 'bag')).joint_log()
    assert read.wraps == {'shaft': 25.0}
    np.testing.assert_allclose(read.q, q, atol=1e-9)
    assert unwrapped(read) is read


@pytest.mark.parametrize('period', [25.0, 2.0 * np.pi, 8.0])
def test_sample_by_sample_a_position_becomes_the_same_as_a_recording(period):
    noise = np.random.default_rng(0).normal(0.0, 1e-3, len(T))
    raw = np.column_stack([wrapped(turning(0.6 * period) + noise, period), np.sin(T)])
    raw[[50, 900], 0] = np.nan
    t_ns = np.rint(T * 1e9).astype(np.int64)
    running = RunningUnwrap(2)
    found = np.array([running(int(t), q) for t, q in zip(t_ns, raw, strict=True)])
    nothing = np.full_like(raw, np.nan)
    np.testing.assert_allclose(
        found, unwrapped(JointLog(('a', 'b'), t_ns, raw, nothing, nothing)).q
    )
    assert running.periods[0] == period
    assert np.isnan(running.periods[1])
    # Started again it knows the period, and begins where it was measured.
    again = RunningUnwrap(2, running.periods)
    for k in range(2):
        position = np.array([(0.5 - 0.01 * k) * period * (-1) ** k, 0.0])
        assert again(k * 20_000_000, position)[0] == pytest.approx((0.5 + 0.01 * k) * period)


@pytest.mark.parametrize(
    'q',
    [
        turning(),
        np.where(np.arange(len(T)) == 700, 0.0, turning() + 100.0),
        np.sign(np.sin(T)),
        np.rint(np.sin(T)) * 1e-4,
        np.zeros(len(T)),
    ],
    ids=['motion', 'outlier', 'square', 'two_counts', 'rest'],
)
def test_sample_by_sample_what_is_no_wrap_is_none(q):
    running = RunningUnwrap(1)
    found = [running(round(t * 1e9), np.array([x]))[0] for t, x in zip(T, q, strict=True)]
    np.testing.assert_array_equal(found, q)


def test_a_reference_in_another_turn_comes_to_that_of_the_motion():
    motion = turning()
    wanted = wrapped(motion + 0.1, 25.0)
    np.testing.assert_allclose(near_turn(wanted, motion, 25.0), motion + 0.1)
