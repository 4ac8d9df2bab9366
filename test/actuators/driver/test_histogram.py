# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Durations in bins."""

from __future__ import annotations

from sosml_friction.actuators.driver.histogram import Histogram


def test_an_edge_belongs_to_the_bin_below_it():
    histogram = Histogram()
    for duration_ns in (0, 20_000, 20_001, 50_000, 100_000_001):
        histogram.add(duration_ns)
    assert histogram.counts == [2, 2, *[0] * 10, 1]
    assert histogram.total == 5
    assert histogram.greatest_ns == 100_000_001
    assert histogram.text() == '<= 0.02 ms: 2, <= 0.05 ms: 2, > 100 ms: 1'


def test_nothing_counted_is_said_in_a_word():
    assert Histogram().text() == 'none'
