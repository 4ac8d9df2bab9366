# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Where gains are searched: for every observer, and only where it accepts them."""

import numpy as np
import pytest

from sosml_friction.observers.registry import OBSERVERS
from sosml_friction.study.search import study_variants

VARIANTS = study_variants()


def test_every_observer_takes_part_under_names_of_its_own():
    assert {variant.observer for variant in VARIANTS.values()} == set(OBSERVERS.values())
    assert len(VARIANTS) == sum(len(observer.study) for observer in OBSERVERS.values())
    assert len({variant.label for variant in VARIANTS.values()}) == len(VARIANTS)


@pytest.mark.parametrize('name', VARIANTS)
def test_the_whole_range_is_accepted_and_covered(name):
    observer, space = variant = VARIANTS[name]
    count = len(space.ranges)
    for low, high in ((0.0, 1.0), (1.0, 0.0), (0.5, 0.5)):
        gains = variant.gains(np.array([np.full(count, low), np.full(count, high)]), 1e-5)
        assert observer(gains).n == 2
        assert list(gains) == list(observer.gain_units)
        for gain, span in space.ranges.items():
            for joint, u in enumerate((low, high)):
                base = gains[span.of][joint] ** span.power if span.of else 1.0
                expected = span.low ** (1.0 - u) * span.high**u * base
                assert gains[gain][joint] == pytest.approx(expected)
        if 'position_noise' in gains:
            assert gains['position_noise'] == [1e-5, 1e-5]


@pytest.mark.parametrize('name', VARIANTS)
def test_a_faster_observer_keeps_the_ratios_of_its_gains(name):
    variant = VARIANTS[name]
    space = variant.space
    gain, power = space.sweep
    gains = variant.gains(np.full((2, len(space.ranges)), 0.5), 1e-5)
    faster = space.faster(gains, 2.0)
    assert faster[gain] == pytest.approx([2.0**power * x for x in gains[gain]])
    for other, span in space.ranges.items():
        scale = 2.0 ** (power * span.power) if span.of == gain else 1.0
        if other != gain:
            assert faster[other] == pytest.approx([scale * x for x in gains[other]])
    assert space.faster(gains, 1.0) == gains


def test_the_capped_observer_is_the_first_order_one_with_a_slow_pole():
    capped = VARIANTS['first_order_capped']
    assert capped.space.ranges['cutoff'].high == 300.0
    assert capped.observer is OBSERVERS['first_order']
