# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A recording in memory: its shapes, its samples, its joints."""

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import DataError


def log_of(*, warm=True, **changes):
    """Return three samples of joints a, b and c; 10 * sample + joint tells where a value is."""
    where = 10.0 * np.arange(3)[:, None] + np.arange(3)
    values = {
        'names': tuple('abc'),
        't_ns': np.array([2, 5, 9], dtype=np.int64) * 500_000_000,
        'q': where,
        'v': where + 0.1,
        'tau': where + 0.2,
        'temperature': where + 0.3 if warm else None,
        'tags': {'worn': 'yes'},
    }
    return JointLog(**{**values, **changes})


def test_time_counts_seconds_from_the_first_sample():
    assert log_of().time == pytest.approx([0.0, 1.5, 3.5], abs=1e-12)
    assert len(log_of()) == 3
    assert repr(log_of()) == '<JointLog; a, b, c; 3 samples over 3.5 s>'


@pytest.mark.parametrize(('samples', 'joints'), [(0, 3), (3, 0)])
def test_a_recording_without_samples_or_joints_is_refused(samples, joints):
    nothing = np.zeros((samples, joints))
    with pytest.raises(DataError, match=f'has {samples} samples of {joints} joints: no data'):
        JointLog(tuple('abc'[:joints]), np.arange(samples), nothing, nothing, nothing)


@pytest.mark.parametrize('what', ['q', 'v', 'tau', 'temperature'])
def test_an_array_of_another_shape_is_refused_by_its_name(what):
    with pytest.raises(DataError, match=rf'^{what} has shape \(3, 2\) where \(3, 3\) is needed'):
        log_of(**{what: np.zeros((3, 2))})


def test_only_a_recording_without_any_effort_is_refused():
    log_of().require_effort()
    tau = np.full((3, 3), np.nan)
    with pytest.raises(DataError, match='no effort for a, b, c: let the driver'):
        log_of(tau=tau).require_effort()
    tau[1, 2] = 0.0
    log_of(tau=tau).require_effort()


@pytest.mark.parametrize('temperature', [True, False])
@pytest.mark.parametrize('rows', [np.array([2, 0]), np.array([True, False, True])])
def test_rows_are_those_samples_of_all_joints(rows, temperature):
    log = log_of(warm=temperature)
    part = log.rows(rows)
    assert (part.names, part.tags) == (log.names, log.tags)
    assert (part.temperature is None) == (log.temperature is None)
    for what in ('t_ns', 'q', 'v', 'tau', *(['temperature'] if temperature else [])):
        assert getattr(part, what).tolist() == getattr(log, what)[rows].tolist()


@pytest.mark.parametrize('temperature', [True, False])
def test_joints_are_selected_in_the_order_asked_for(temperature):
    log = log_of(warm=temperature)
    part = log.select(['c', 'a'])
    assert (part.names, part.tags) == (('c', 'a'), log.tags)
    assert part.t_ns.tolist() == log.t_ns.tolist()
    assert (part.temperature is None) == (log.temperature is None)
    for what in ('q', 'v', 'tau', *(['temperature'] if temperature else [])):
        assert getattr(part, what).tolist() == getattr(log, what)[:, [2, 0]].tolist()


def test_a_joint_that_is_not_recorded_is_refused_by_name():
    with pytest.raises(DataError, match='joint d is not in the recording, which has a, b, c'):
        log_of().select(['a', 'd'])


@pytest.mark.parametrize('said', ['q', 'v', 'tau'])
def test_samples_that_speak_of_other_joints_only_are_no_samples_of_these(said):
    """Joint a in all three samples; b in the second only by one quantity, in the third not."""
    arrays = {what: getattr(log_of(), what).copy() for what in ('q', 'v', 'tau')}
    for what, array in arrays.items():
        array[2, 1] = np.nan
        if what != said:
            array[1, 1] = np.nan
    log = log_of(**arrays)
    assert log.select(['b']).t_ns.tolist() == log.t_ns[:2].tolist()
    assert log.select(['b', 'a']).t_ns.tolist() == log.t_ns.tolist()


def test_a_sample_that_says_nothing_at_all_stays():
    arrays = {what: getattr(log_of(), what).copy() for what in ('q', 'v', 'tau')}
    for array in arrays.values():
        array[1] = np.nan
    assert len(log_of(**arrays).select(['b'])) == 3


def test_seconds_are_no_stamps_and_lists_no_samples():
    with pytest.raises(DataError, match='t_ns are no whole numbers: give nanoseconds'):
        log_of(t_ns=np.array([0.0, 0.1, 0.2]))
    with pytest.raises(DataError, match='tau is no array: give one of NumPy'):
        log_of(tau=[[0.0] * 3] * 3)
    with pytest.raises(DataError, match='t_ns is no array'):
        log_of(t_ns=None)
