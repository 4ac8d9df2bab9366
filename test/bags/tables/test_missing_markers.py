# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Numbers that no motion reaches stand for missing values; real limits of efforts stay."""

import numpy as np
import pytest

from sosml_friction.bags.tables.data_file import DataFile
from sosml_friction.bags.tables.guess import guess_mapping
from sosml_friction.bags.tables.importer import read_recording
from sosml_friction.bags.tables.mapping import parse_mapping
from sosml_friction.bags.tables.missing_markers import missing_markers

T = np.arange(2000) / 200.0
Q = np.sin(T)
#: Places of missing values: alone, and several in a row.
PLACES = np.r_[100:1900:180, 505:509]


def marked(series, *values):
    series = series.astype(np.float64)
    for k, value in enumerate(values):
        series[PLACES + 20 * k] = value
    return series


@pytest.mark.parametrize('quantity', ['position', 'velocity', 'effort'])
@pytest.mark.parametrize(
    'value', [-999.0, -9999.0, 9999.0, -99.99, 1e30, 3.4028235e38, 32767.0, -(2.0**31), 2.0**63]
)
def test_a_number_written_for_a_missing_value_is_found(quantity, value):
    assert missing_markers(marked(Q, value), quantity) == [value]
    assert missing_markers(Q, quantity) == []


def test_the_least_integer_is_found_among_integers():
    counts = np.rint(1000.0 * Q).astype(np.int64)
    counts[PLACES] = -(2**63)
    assert missing_markers(counts, 'position') == [-(2.0**63)]


def test_two_numbers_are_found_in_one_series():
    assert missing_markers(marked(Q, -9999.0, 9999.0), 'position') == [-9999.0, 9999.0]


def test_degrees_are_told_from_999_by_the_gap_between():
    assert missing_markers(marked(180.0 * Q, -999.0), 'position') == [-999.0]
    # A shaft that turns on goes through 999 too.
    assert missing_markers(np.rint(720.0 * T), 'position') == []
    assert missing_markers(np.minimum(720.0 * T, 999.0), 'position') == []


@pytest.mark.parametrize('limit', [40.0, 100.0, 1000.0, 999.0, 32767.0])
def test_a_saturated_effort_stays(limit):
    # Per mille, or counts, of which the motion takes a tenth and more.
    assert missing_markers(marked(0.1 * limit * Q, limit, -limit), 'effort') == []


def test_an_effort_that_jumps_between_two_values_stays():
    assert missing_markers(np.where(Q > 0.9, 9999.0, 0.0), 'effort') == []


def test_one_effort_alone_is_no_marker():
    effort = Q.copy()
    effort[700] = 9999.0
    assert missing_markers(effort, 'effort') == []
    assert missing_markers(effort, 'position') == [9999.0]


def test_a_position_that_falls_to_one_far_place_is_missing_there():
    held = 1000.0 + 5.0 * Q
    assert missing_markers(marked(held, 0.0), 'position') == [0.0]
    # A velocity or an effort of 0 is that of a joint that rests.
    assert missing_markers(marked(held, 0.0), 'velocity') == []
    assert missing_markers(marked(held, 0.0), 'effort') == []
    # It begins there, and goes away once: it was driven.
    assert missing_markers(np.where(T < 1.0, 0.0, held), 'position') == []


def test_a_marker_is_missing_in_the_log_and_told_and_no_matter_to_the_guess(tmp_path):
    v, tau = np.cos(T), 2.0 * np.tanh(50.0 * np.cos(T)) + 0.3 * Q
    columns = [T, marked(Q, -9999.0), marked(v, 1e30), marked(tau, -9999.0)]
    path = tmp_path / 'x.csv'
    np.savetxt(path, np.column_stack(columns), delimiter=',', header='t,q,dq,tau', comments='')
    content = guess_mapping(DataFile(path)).content
    told = []
    log = read_recording(path, parse_mapping(content, path), told.append)
    assert content['joints']['joint']['velocity']['unit'] == 'rad/s'
    for values, clean in ((log.q, Q), (log.v, v), (log.tau, tau)):
        assert np.flatnonzero(np.isnan(values[:, 0])).tolist() == sorted(PLACES)
        np.testing.assert_allclose(np.delete(values[:, 0], PLACES), np.delete(clean, PLACES))
    assert [sentence.partition(': the ')[2] for sentence in told] == [
        'position of joint is -9999 in 14 of 2000 samples, far from all others: taken as missing',
        'velocity of joint is 1e+30 in 14 of 2000 samples, far from all others: taken as missing',
        'effort of joint is -9999 in 14 of 2000 samples, far from all others: taken as missing',
    ]


def test_a_series_without_numbers_has_no_markers():
    for values in (np.array([]), np.full(5, np.nan), np.full(5, 9999.0)):
        assert missing_markers(values, 'position') == []
