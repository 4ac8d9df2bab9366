# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Stamps of receipt give way to even ones, where the positions say so, and only there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.identification.even_stamps import with_even_stamps

STEP, COUNT = 4e-3, 8000


def recorded(taken: np.ndarray, stamps: np.ndarray, quantum: float = 0.0) -> JointLog:
    """Return a log of two sines, of positions at ``taken`` under ``stamps`` [s]."""
    q = 0.4 * np.sin(1.3 * taken) + 0.1 * np.sin(4.1 * taken)
    q = q + 2e-6 * np.random.default_rng(9).standard_normal(len(q))
    q = (np.round(q / quantum) * quantum if quantum else q)[:, None]
    nothing = np.full_like(q, np.nan)
    return JointLog(('j',), np.rint(1e9 * stamps).astype(np.int64), q, nothing, np.sin(q))


def missed(log: JointLog, taken: np.ndarray) -> float:
    """Return by how much stamps scatter about the times of measurement [s]."""
    return float(np.std(1e-9 * log.t_ns - taken))


@pytest.mark.parametrize('drift', [0.0, 1e-4], ids=['one clock', 'a clock that drifts'])
@pytest.mark.parametrize('scatter', [0.05, 0.2], ids=['often', 'seldom over a period'])
def test_stamps_of_receipt_are_made_even_though_samples_are_lost(drift, scatter):
    """Exponential delays: the mean of 13 phases scatters by 1 / sqrt(13) of them, 0.28."""
    rng = np.random.default_rng(3)
    number = np.flatnonzero(rng.random(COUNT) > 0.05)
    taken = STEP * number * (1.0 + drift * number / COUNT)
    late = rng.exponential(scatter * STEP, len(taken))
    # What comes later than the next one waits for no order: a log is in that of its stamps.
    stamps = np.maximum.accumulate(taken + late) + 1e-8 * np.arange(len(taken))
    log = recorded(taken, stamps)
    assert (np.diff(log.t_ns) > 0).all()
    even, said = with_even_stamps(log)
    assert 'stamps scatter by' in said
    assert (np.diff(even.t_ns) > 0).all()
    assert missed(even, taken) < 0.35 * missed(log, taken)
    assert even.q is log.q


def test_a_sample_that_is_late_by_more_than_half_a_period_keeps_its_place_beside_a_lost_one():
    """Of half of the late ones the next even time is free, of a quarter the one before."""
    rng = np.random.default_rng(5)
    number = np.arange(COUNT)
    late = rng.exponential(0.075 * STEP, COUNT)
    slow = number[20:-20:100]
    late[slow] = 0.7 * STEP
    lost = np.concatenate([slow[1::2] + 1, slow[::4] - 1])
    number, late = np.delete(number, lost), np.delete(late, lost)
    taken = STEP * number
    log = recorded(taken, taken + late)
    # A joint of which nothing is known, and a position that is missing, have no say.
    q = np.column_stack([log.q, np.full(len(log), np.nan)])
    q[1234, 0] = np.nan
    for its in (log, replace(log, names=('j', 'k'), q=q, v=np.full_like(q, np.nan), tau=q)):
        even, _ = with_even_stamps(its)
        off = 1e-9 * even.t_ns - taken
        assert np.abs(off - np.median(off)).max() < 0.5 * STEP


@pytest.mark.parametrize('rate', [60.0, 130.0, 300.0, 450.0])
def test_stamps_in_whole_milliseconds_are_made_even(rate):
    """1 / sqrt(12) ms is what they miss; a period that is no whole number goes over all phases."""
    taken = np.arange(0.0, 20.0, 1.0 / rate)
    log = recorded(taken, np.floor(1e3 * taken) * 1e-3)
    assert missed(log, taken) == pytest.approx(1e-3 / np.sqrt(12.0), rel=0.1)
    assert missed(with_even_stamps(log)[0], taken) < 0.3 * missed(log, taken)


@pytest.mark.parametrize(
    ('uneven', 'late', 'quantum'),
    [(0.1, 0.0, 0.0), (0.0, 0.0, 0.0), (0.1, 0.0, 0.01)],
    ids=['taken unevenly', 'even', 'taken unevenly and read in steps'],
)
def test_stamps_stay_where_no_position_speaks_against_them(uneven, late, quantum):
    rng = np.random.default_rng(5)
    taken = STEP * (np.arange(COUNT) + uneven * rng.uniform(-1.0, 1.0, COUNT))
    log = recorded(taken, taken + late * STEP * rng.uniform(-1.0, 1.0, COUNT), quantum)
    even, said = with_even_stamps(log)
    assert said == ''
    assert even is log


def test_what_cannot_be_even_is_left_as_it_is():
    t = STEP * np.arange(COUNT)
    log = recorded(t, t)
    for t_ns in (log.t_ns[::-1], np.zeros_like(log.t_ns)):
        odd = replace(log, t_ns=np.ascontiguousarray(t_ns))
        assert with_even_stamps(odd)[0] is odd
    short = log.rows(np.arange(10))
    assert with_even_stamps(short)[0] is short
