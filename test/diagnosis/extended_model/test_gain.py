# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The gain on data left out: ratios of errors, and how far they are known."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.diagnosis.decision.forward_gain import _spread
from sosml_friction.diagnosis.extended_model.gain import make_gain

EFFORT = np.ones((4, 1))


def gain_of(before, after):
    """Return the gain of mean squares (W,) of simulated windows, the effort's being nothing."""
    windows = [np.asarray(x, dtype=float)[:, None] for x in (before, after)]
    return make_gain(EFFORT, EFFORT, EFFORT, *windows, 0.3, 'folds left out')


def test_the_standard_error_of_the_ratio_is_its_spread_over_recordings():
    """
    400 recordings of 60 windows, each with and without a cause that takes off a fifth.

    The spread of 400 is known to 3.5 %, the formula is of first order: 10 %. Most of both errors
    is the same noise, which windows that are not paired would count.
    """
    rng = np.random.default_rng(0)
    found = []
    for _ in range(400):
        shared = rng.gamma(2.0, 1.0, 60)
        found.append(gain_of(shared, 0.8 * shared * rng.lognormal(0.0, 0.2, 60)))
    ratios = np.array([gain.forward_ratio[0] for gain in found])
    errors = np.array([gain.forward_error[0] for gain in found])
    # The mean of exp(0.2 z) is exp(0.02).
    assert ratios.mean() == pytest.approx(np.sqrt(0.8 * np.exp(0.02)), rel=0.01)
    assert errors.mean() == pytest.approx(ratios.std(ddof=1), rel=0.1)


def test_what_is_not_known_is_no_number_and_no_chance():
    nothing = gain_of([], [])
    one = gain_of([1.0], [0.25])
    away = gain_of([1.0, 1.0], [0.5, np.inf])
    perfect = gain_of([0.0, 0.0], [0.0, 0.0])
    assert np.isnan([nothing.forward_ratio[0], nothing.forward_error[0]]).all()
    assert one.forward_ratio[0] == 0.5
    assert np.isnan(one.forward_error[0])
    assert np.isinf(away.forward_ratio[0])
    assert np.isnan(away.forward_error[0])
    assert np.isnan([perfect.forward_ratio[0], perfect.forward_error[0]]).all()
    for gain in (nothing, one, away, perfect):
        assert not gain.forward_by_chance.any()
        told = gain.to_dict(('elbow',), ('Nm',))['elbow']['forward']
        assert told['ratio'] == pytest.approx(gain.forward_ratio[0], nan_ok=True)


def test_a_change_within_its_standard_errors_is_chance():
    rng = np.random.default_rng(1)
    shared = rng.gamma(2.0, 1.0, 60)
    for size, chance in ((0.99, True), (0.5, False)):
        gain = gain_of(shared, size * shared * rng.lognormal(0.0, 0.2, 60))
        assert gain.forward_by_chance[0] == chance


@pytest.mark.parametrize(('first', 'last', 'most'), [(0, 1000, 5), (7, 1000, 50), (3, 90, 9)])
def test_windows_do_not_overlap_and_stay_where_they_may_begin(first, last, most):
    """What overlaps counts twice, and its standard error is too small."""
    samples = 100
    begins = _spread(first, last, samples, most)
    assert (np.diff(begins) >= samples).all()
    assert first <= begins.min()
    assert begins.max() <= last
    assert len(begins) == min(most, (last - first) // samples + 1)
