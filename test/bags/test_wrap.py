# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Positions that wrap are made continuous, and nothing else is taken for a wrap."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.bags.wrap import unwrapped, wrap_period

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
