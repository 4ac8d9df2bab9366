# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Durations in bins."""

from __future__ import annotations

from sosml_friction.actuators.driver.histogram import Histogram


def test_an_edge_belongs_to_the_bin_below_it():
    histogram = Histogram((1.0, 2.0))
    for duration_ns in (0, 1_000_000, 1_000_001, 2_000_000, 2_000_001):
        histogram.add(duration_ns)
    assert histogram.counts == [2, 2, 1]
    assert histogram.total == 5
    assert histogram.greatest_ns == 2_000_001
    assert histogram.text() == '<= 1 ms: 2, <= 2 ms: 2, > 2 ms: 1'


def test_nothing_counted_is_said_in_a_word():
    assert Histogram().text() == 'none'
