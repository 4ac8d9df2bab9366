# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A wrap is recognised by its jumps, and by nothing else that jumps."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sosml_friction.bags.wrap import recognise_wrap, unwrap


def motion(seed, step, samples=600):
    """Return a smooth motion whose largest step is ``step``."""
    rng = np.random.default_rng(seed)
    phase = np.linspace(0.0, rng.uniform(6.0, 12.0), samples)
    path = np.sin(phase) + 0.3 * np.sin(2.3 * phase + rng.uniform(0.0, 6.0))
    return path * step / np.abs(np.diff(path)).max()


def wrapped(path, period, low):
    return (path - low) % period + low


@given(
    seed=st.integers(0, 1000),
    share=st.floats(0.02, 0.1),
    period=st.sampled_from([2 * math.pi, 360.0, 1.0, 25.0, 4096.0, 0.7]),
    low=st.sampled_from([-0.5, 0.0]),
)
def test_a_wrapped_motion_is_recognised_and_undone(seed, share, period, low):
    path = motion(seed, share * period)
    seen = wrapped(path, period, low * period)
    found = recognise_wrap(seen)
    assert found == pytest.approx(period, rel=2e-3)
    if period in (2 * math.pi, 360.0, 25.0, 4096.0):
        assert found == pytest.approx(period, rel=1e-12)
    whole = unwrap(seen, period)
    np.testing.assert_allclose(whole - whole[0], path - path[0], atol=1e-9 * period)


@given(seed=st.integers(0, 1000), step=st.floats(1e-4, 10.0))
def test_a_motion_without_a_wrap_is_left_alone(seed, step):
    assert recognise_wrap(motion(seed, step)) is None


@pytest.mark.parametrize('seed', range(5))
def test_pulses_levels_and_lost_samples_are_no_wraps(seed):
    rng = np.random.default_rng(seed)
    path = motion(seed, 0.02)
    pulses = 5.0 * (np.arange(600) % 60 < 20)
    assert recognise_wrap(pulses) is None
    assert recognise_wrap(31.0 + (np.arange(600) > 300)) is None
    lost = path + 3.0
    lost[rng.integers(0, 600, 4)] = 0.0
    assert recognise_wrap(lost) is None
    assert recognise_wrap(rng.integers(0, 2, 600)) is None
    assert recognise_wrap(rng.normal(size=600)) is None


def test_unknown_samples_stay_unknown():
    path = wrapped(motion(1, 0.3), 2 * math.pi, -math.pi)
    path[100:105] = np.nan
    whole = unwrap(path, 2 * math.pi)
    assert np.isnan(whole).sum() == 5
    known = np.isfinite(whole)
    assert np.abs(np.diff(whole[known])).max() < math.pi
