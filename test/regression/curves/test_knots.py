# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Knots of free curves."""

from types import SimpleNamespace

import numpy as np
import pytest

from sosml_friction.regression.curves.knots import knots_of
from sosml_friction.regression.structure import HATS, Structure

STILL_AND_FAST = np.concatenate([np.linspace(-0.01, 0.01, 900), np.linspace(-2.0, 2.0, 100)])


@pytest.mark.parametrize('noise', [0.0, 0.05, 0.5, 5.0])
def test_knots_span_the_axis_and_are_no_nearer_than_its_noise(noise):
    stretch = SimpleNamespace(a=STILL_AND_FAST[:, None])
    (knots,) = knots_of([stretch], lambda s: s.a, 9, np.array([noise]))
    (all_of_them,) = knots_of([stretch], lambda s: s.a, 9)
    assert knots[[0, -1]] == pytest.approx(all_of_them[[0, -1]])
    assert set(knots) <= set(all_of_them)
    assert len(knots) == 2 or np.diff(knots).min() >= 6.0 * noise
    assert noise > 0.0 or len(knots) == len(all_of_them)


@pytest.mark.parametrize(('jitter', 'bends'), [(0.0, HATS), (2e-3, 4)])
def test_a_free_curve_does_not_bend_within_the_noise_of_a_constant_velocity(jitter, bends):
    """Two plateaus, 0.07 and 0.2 rad/s, of noise alone: a knot at either, and at either end."""
    rng = np.random.default_rng(0)
    plateaus = np.repeat([0.07, 0.2], 2000)[:, None]
    v = plateaus + 2e-3 * rng.standard_normal(plateaus.shape)
    still = np.zeros_like(v)
    stretch = SimpleNamespace(
        v=v, q=still, a=still, sure_torque=still, sign=np.ones_like(v), rough=still, shaken=still
    )
    stretch.jitter = np.array([jitter])
    hats = Structure([stretch]).own_columns(stretch, 0, ({},))[:, 0, :HATS]
    assert int(hats.any(axis=0).sum()) <= bends
    assert jitter > 0.0 or hats.any(axis=0).all()
