# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is a leap of position, and what only looks like one."""

import numpy as np
import pytest

from sosml_friction.identification.position_leaps import position_leaps

COUNT, DT = 2.0 * np.pi / 2**16, 2e-3


def moved(noise=0.0):
    t = DT * np.arange(10_000)
    q = np.sin(2.0 * np.pi * 0.3 * t) + 0.2 * np.sin(2.0 * np.pi * 1.7 * t)
    q += noise * np.random.default_rng(1).standard_normal(len(t))
    return t, COUNT * np.round(q / COUNT)


@pytest.mark.parametrize('noise', [0.0, 1e-4])
def test_rows_that_were_lost_behind_even_stamps_are_leaps(noise):
    t, q = moved(noise)
    assert position_leaps(t, q, COUNT, noise) == 0
    kept = np.ones(len(t), dtype=bool)
    lost = np.arange(200, 9800, 80)
    for k in range(2):
        kept[lost + k] = False
    found = position_leaps(DT * np.arange(kept.sum()), q[kept], COUNT, noise)
    # Where it is slow, or turns around, a step says nothing.
    assert 0.6 * len(lost) < found <= len(lost)
    assert position_leaps(t[kept], q[kept], COUNT, noise) == 0


def test_late_stamps_held_positions_and_a_wrong_sample_are_no_leaps():
    t, q = moved()
    late = t.copy()
    late[::10] += 0.8 * DT
    assert position_leaps(late, q, COUNT, 0.0) == 0
    held = q[(np.arange(len(q)) // 5) * 5]
    assert position_leaps(t, held, COUNT, 0.0) == 0
    wrong = q.copy()
    wrong[500:9000:500] += 0.05
    assert position_leaps(t, wrong, COUNT, 0.0) == 0


def test_a_stop_that_is_run_into_is_no_leap():
    t = DT * np.arange(4000)
    q = COUNT * np.round(np.minimum(t, 5.0) / COUNT)
    assert position_leaps(t, q, COUNT, 0.0) == 0
