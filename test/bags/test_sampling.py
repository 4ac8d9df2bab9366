# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Lost samples are counted, and stamps that are off are none."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.bags.sampling import (
    held_share,
    lost_samples,
    lost_share,
    pauses,
    pauses_text,
)


def test_samples_taken_out_are_counted():
    rng = np.random.default_rng(0)
    kept = rng.random(20_000) > 0.03
    kept[[0, -1]] = True
    time = (0.004 * np.arange(20_000) + rng.normal(0.0, 1e-4, 20_000))[kept]
    # Two holes beside each other are hardly told from one: 3 % of 3 % of them.
    assert lost_samples(time) == pytest.approx(np.sum(~kept), rel=0.1)
    assert lost_share(time) == pytest.approx(0.03, rel=0.15)


def test_stamps_in_multiples_of_a_controllers_cycle_lost_nothing():
    """A third of the steps of a robot's 500 Hz clock take 12 ms, the others 10."""
    steps = np.random.default_rng(1).choice([0.010, 0.012], 5000, p=[2 / 3, 1 / 3])
    assert lost_samples(np.cumsum(steps)) == 0


def test_a_stamp_that_came_late_lost_nothing():
    time = 0.01 * np.arange(1000)
    time[100::50] += 0.008
    assert lost_samples(time) == 0


def test_a_hole_counts_what_is_missing_in_it():
    time = 0.01 * np.arange(1000)
    time[500:] += 0.37
    assert lost_samples(time) == 37


def test_a_pause_has_lost_nothing():
    time = 0.01 * np.arange(1000)
    time[300:] += 0.02
    time[500:] += 3600.0
    assert lost_samples(time) == 2
    assert pauses(time) == pytest.approx([3600.01])
    assert pauses_text(time) == 'a pause of 3600 s'
    assert pauses_text(time[:500]) == ''


def test_of_the_steps_in_which_samples_were_lost_effort_holds_for_a_period():
    time = np.delete(0.01 * np.arange(1000) + 1e-4 * np.sin(np.arange(1000.0)), [300, 500, 501])
    held = held_share(time)
    assert held[[299, 498]] == pytest.approx([1.0 / 2.0, 1.0 / 3.0])
    assert np.sum(held != 1.0) == 2


@pytest.mark.parametrize('scatter', [0.05, 0.1, 0.12])
def test_of_stamps_that_scatter_on_an_even_clock_effort_holds_for_a_period(scatter):
    """Of one step in 100 nobody knows how many are lost. A hole of half a second has no say."""
    rng = np.random.default_rng(4)
    kept = rng.random(20_000) > 0.05
    kept[7000:7050] = False
    time = (0.01 * (np.arange(20_000) + scatter * rng.standard_normal(20_000)))[kept]
    periods = np.diff(np.flatnonzero(kept))
    assert np.mean(held_share(time) == 1.0 / periods) > 0.98


def test_for_the_steps_of_a_loop_that_took_longer_effort_holds_as_long():
    time = np.cumsum(0.004 + np.random.default_rng(2).exponential(0.006, 1000))
    assert (held_share(time) == 1.0).all()


def test_of_samples_without_a_rising_stamp_nothing_is_lost():
    assert held_share(np.zeros(4)).tolist() == [1.0, 1.0, 1.0]
