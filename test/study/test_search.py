# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Where gains are searched: for every observer, and only where it accepts them."""

import numpy as np
import pytest

from sosml_friction.observers.registry import OBSERVERS
from sosml_friction.study.search import SEARCH


def test_every_observer_takes_part():
    assert {entry.observer for entry in SEARCH.values()} == set(OBSERVERS)


@pytest.mark.parametrize('name', SEARCH)
def test_the_whole_range_is_accepted_and_covered(name):
    entry = SEARCH[name]
    count = len(entry.ranges)
    for low, high in ((0.0, 1.0), (1.0, 0.0), (0.5, 0.5)):
        gains = entry.gains(np.array([np.full(count, low), np.full(count, high)]), 1e-5)
        assert entry.make(gains).n == 2
        assert set(gains) == set(OBSERVERS[entry.observer].gain_units)
        for gain, span in entry.ranges.items():
            for joint, u in enumerate((low, high)):
                base = gains[span.of][joint] ** span.power if span.of else 1.0
                expected = span.low ** (1.0 - u) * span.high**u * base
                assert gains[gain][joint] == pytest.approx(expected)
        if 'position_noise' in gains:
            assert gains['position_noise'] == [1e-5, 1e-5]


@pytest.mark.parametrize('name', SEARCH)
def test_a_faster_observer_keeps_the_ratios_of_its_gains(name):
    entry = SEARCH[name]
    gain, power = entry.sweep
    gains = entry.gains(np.full((2, len(entry.ranges)), 0.5), 1e-5)
    faster = entry.faster(gains, 2.0)
    assert faster[gain] == pytest.approx([2.0**power * x for x in gains[gain]])
    for other, span in entry.ranges.items():
        scale = 2.0 ** (power * span.power) if span.of == gain else 1.0
        if other != gain:
            assert faster[other] == pytest.approx([scale * x for x in gains[other]])
    assert entry.faster(gains, 1.0) == gains


def test_the_capped_observer_is_the_first_order_one_with_a_slow_pole():
    assert SEARCH['first_order_capped'].ranges['cutoff'].high == 300.0
    assert SEARCH['first_order_capped'].observer == 'first_order'
