# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Which samples of a recording are measurements."""

from dataclasses import replace

import numpy as np
import pytest
from known_robots import slider_recording

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import DataError
from sosml_friction.identification.clean_samples import CleanSamples


@pytest.fixture(scope='module')
def both():
    """Return two joints, of which the second goes where the first does, from its end on."""
    log = slider_recording()
    columns = (getattr(log, what)[:, 0] for what in ('q', 'v', 'tau'))
    return JointLog(('a', 'b'), log.t_ns, *(np.column_stack([x, x[::-1]]) for x in columns))


def rows_of(log, rows, joint):
    """Return samples with the values of one joint alone."""
    part = log.rows(rows)
    return part.mapped(lambda x: np.where(np.arange(2) == joint, x, np.nan), t_ns=part.t_ns)


def joined(*parts):
    """Return samples of several parts in the order of their stamps."""
    order = np.argsort(np.concatenate([p.t_ns for p in parts]), kind='stable')
    t_ns, *columns = (
        np.concatenate([getattr(p, what) for p in parts])[order]
        for what in ('t_ns', 'q', 'v', 'tau')
    )
    return JointLog(parts[0].names, t_ns, *columns)


def test_joints_in_messages_of_their_own_with_one_stamp_are_one_sample(both):
    every = np.arange(len(both))
    clean = CleanSamples.of(joined(rows_of(both, every, 0), rows_of(both, every, 1)))
    for what in ('t_ns', 'q', 'v', 'tau'):
        np.testing.assert_array_equal(getattr(clean.log, what), getattr(both, what))
    assert clean.repeated_stamps == 0
    assert clean.lost_share == 0.0
    assert clean.findings == ()


def test_joints_that_are_asked_in_turn_are_taken_where_the_slower_one_was(both):
    """The second at a third of the rate; the first is interpolated to it."""
    every = np.arange(len(both))
    fast, slow = every[every % 3 != 1], every[every % 3 == 1]
    clean = CleanSamples.of(joined(rows_of(both, fast, 0), rows_of(both, slow, 1)))
    np.testing.assert_array_equal(clean.log.t_ns, both.t_ns[slow])
    np.testing.assert_array_equal(clean.log.q[:, 1], both.q[slow, 1])
    # A cubic between samples h to each side is off by 9/384 (2 h)^4 of the fourth derivative, and
    # noise of both is its own.
    noise = float(np.std(np.diff(both.q[:, 0], 3))) / np.sqrt(20.0)
    off = clean.log.q[1:-1, 0] - both.q[slow[1:-1], 0]
    assert np.sqrt(np.mean(off**2)) < 2.0 * noise
    between = 0.5 * (both.tau[slow - 1] + both.tau[np.minimum(slow + 1, len(both) - 1)])
    assert clean.log.tau[1:-1, 0] == pytest.approx(between[1:-1, 0])
    assert {f.check for f in clean.findings} >= {'sparse_position', 'sparse_effort'}


def test_what_lacks_for_longer_stays_a_hole(both):
    q, tau = both.q.copy(), both.tau.copy()
    q[100:103, 0], tau[200:203, 1], q[300:320, 0], tau[400:420, 1] = np.nan, np.nan, np.nan, np.nan
    clean = CleanSamples.of(replace(both, q=q, tau=tau))
    kept = np.flatnonzero(np.isin(both.t_ns, clean.log.t_ns))
    np.testing.assert_array_equal(np.setdiff1d(np.arange(len(both)), kept), np.arange(300, 320))
    unknown = kept[np.isnan(clean.log.tau[:, 1])]
    np.testing.assert_array_equal(unknown, np.arange(400, 420))
    assert clean.incomplete_samples == 20


def test_a_joint_that_is_off_for_a_while_leaves_out_nothing_of_the_other(both):
    """Its effort comes in every second sample of the first fifth, and then never again."""
    count, tau = len(both), both.tau.copy()
    tau[count // 5 :, 1] = tau[1::2, 1] = np.nan
    clean = CleanSamples.of(replace(both, tau=tau))
    first = np.arange(count) < count // 5
    kept = np.isin(both.t_ns, clean.log.t_ns)
    # Behind its last effort nothing says that one is due.
    kept[count // 5 - 1] = False
    np.testing.assert_array_equal(kept, ~first | (np.arange(count) % 2 == 0))
    assert np.isfinite(clean.log.tau[:, 0]).all()


def test_a_glitch_of_a_joint_that_is_asked_in_turn_does_not_spread(both):
    q = both.q.copy()
    q[501, 1] += 1.0
    off = replace(both, q=q)
    every = np.arange(len(both))
    clean = CleanSamples.of(joined(rows_of(off, every[::2], 0), rows_of(off, every[1::2], 1)))
    (said,) = (f for f in clean.findings if f.check == 'glitch')
    assert 'in 1 single samples' in said.sentence
    near = np.abs(clean.log.t_ns - both.t_ns[501]) < 100_000_000
    true = both.q[np.isin(both.t_ns, clean.log.t_ns[near]), 1]
    assert np.abs(clean.log.q[near, 1] - true).max() < 1e-4


def test_stamps_that_repeat_with_other_values_are_told(both):
    rows = np.sort(np.r_[np.arange(len(both)), np.arange(0, len(both), 10)])
    again = both.rows(rows)
    q = again.q.copy()
    repeats = np.flatnonzero(np.diff(again.t_ns) == 0) + 1
    q[repeats] += 1e-3
    clean = CleanSamples.of(replace(again, q=q))
    np.testing.assert_array_equal(clean.log.q, both.q)
    assert clean.repeated_stamps == len(repeats)


def test_temperatures_come_as_often_as_the_rest(both):
    every = np.arange(len(both))
    warm = replace(both, temperature=np.column_stack([20.0 + both.time, 30.0 + both.time]))
    parts = [rows_of(warm, every[k::2], k) for k in (0, 1)]
    temperature = np.concatenate([part.temperature for part in parts])
    order = np.argsort(np.concatenate([part.t_ns for part in parts]), kind='stable')
    clean = CleanSamples.of(replace(joined(*parts), temperature=temperature[order]))
    time = 1e-9 * (clean.log.t_ns - both.t_ns[0])
    inner = (clean.log.temperature - 20.0 - time[:, None])[1:-1]
    assert inner == pytest.approx(np.tile([0.0, 10.0], (len(inner), 1)), abs=1e-6)


def test_positions_and_efforts_of_other_times_are_refused(both):
    q, tau = both.q.copy(), both.tau.copy()
    q[len(both) // 2 :], tau[: len(both) // 2] = np.nan, np.nan
    with pytest.raises(DataError, match='no sample has both a position and an effort'):
        CleanSamples.of(replace(both, q=q, tau=tau))
