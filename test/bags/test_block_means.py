# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Long recordings as means: what is averaged, and over what time."""

import numpy as np
import pytest

from sosml_friction.bags.block_means import block_means
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import DataError


def recording(count=12, step_ns=1_000_000):
    t = np.arange(count) * step_ns
    q = np.column_stack([np.arange(count) * 1.0, np.arange(count) * -2.0])
    return JointLog(('a', 'b'), t, q, np.ones((count, 2)), 10.0 * q)


def test_a_recording_of_no_more_samples_stays_as_it_is():
    log = recording()
    assert block_means(log, most=12) == (log, 1)


def test_positions_stamps_and_efforts_are_means_over_the_same_time():
    log, count = block_means(recording(), most=4)
    assert count == 3
    np.testing.assert_array_equal(log.t_ns, np.array([1, 4, 7, 10]) * 1_000_000)
    np.testing.assert_allclose(log.q[:, 0], [1.0, 4.0, 7.0, 10.0])
    np.testing.assert_allclose(log.tau, 10.0 * log.q)


@pytest.mark.parametrize(('hold', 'early'), [('start', -0.5), ('mean', 0.0), ('end', 0.5)])
def test_an_effort_is_the_mean_of_what_acts_in_the_time_of_its_block(hold, early):
    # The effort grows by 10 a sample: held from its sample on, half of the one before acts.
    log, _ = block_means(recording(), (hold, 'mean'), most=4)
    np.testing.assert_allclose(log.tau[1:-1, 0], 10.0 * (log.q[1:-1, 0] + early))
    np.testing.assert_allclose(log.tau[:, 1], 10.0 * log.q[:, 1])


def test_no_block_reaches_over_a_hole():
    whole = recording(12)
    stamps = whole.t_ns.copy()
    stamps[5:] += 1_000_000_000
    log, count = block_means(JointLog(whole.names, stamps, whole.q, whole.v, whole.tau), most=4)
    # Five samples before the hole make one block of three, seven after it two.
    assert count == 3
    np.testing.assert_allclose(log.q[:, 0], [1.0, 6.0, 9.0])


def test_what_is_not_known_is_left_out_of_a_mean():
    whole = recording()
    whole.tau[4, 0] = np.nan
    whole.tau[:, 1] = np.nan
    whole.q[9, 0] = np.nan
    log, _ = block_means(whole, most=4)
    np.testing.assert_allclose(log.q[:, 0], [1.0, 4.0, 7.0])
    np.testing.assert_allclose(log.tau[:, 0], [10.0, 40.0, 70.0])
    assert np.isnan(log.tau[:, 1]).all()


@pytest.mark.parametrize(
    ('spoil', 'told'),
    [
        (
            lambda t, q: np.copyto(q, np.nan, where=np.indices(q.shape).sum(0) % 2 > 0),
            'every joint',
        ),
        (lambda t, q: t.fill(0), 'every joint'),
        (lambda t, q: t.__imul__(-1), 'forwards'),
    ],
)
def test_a_recording_without_two_blocks_is_refused_in_a_sentence(spoil, told):
    log = recording()
    spoil(log.t_ns, log.q)
    with pytest.raises(DataError, match=told):
        block_means(log, most=4)


def test_of_two_samples_of_one_stamp_the_one_with_positions_is_kept():
    whole = recording()
    stamps = np.repeat(whole.t_ns[:6], 2)
    whole.q[::2] = np.nan
    log, _ = block_means(JointLog(whole.names, stamps, whole.q, whole.v, whole.tau), most=6)
    np.testing.assert_allclose(log.q[:, 0], [2.0, 6.0, 10.0])


def test_means_are_no_slower_than_150_hz():
    log = recording(count=100, step_ns=4_000_000)
    assert block_means(log, most=10) == (log, 1)
    # 1 kHz: six of a block are 167 Hz, seven would be 143 Hz.
    assert block_means(recording(count=100), most=2)[1] == 6
