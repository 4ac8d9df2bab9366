# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is done to many columns at once is what is done to one, by another implementation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import lsq_linear
from scipy.signal import firwin, lfilter, upfirdn

from sosml_friction.model.terms.cogging import lines
from sosml_friction.regression.band import Band
from sosml_friction.regression.bounded import bounded_from, bounded_least_squares
from sosml_friction.regression.evidence import (
    CandidateColumns,
    Fit,
    System,
    make_blocks,
    whiten_all,
)
from sosml_friction.regression.kernels import convolve_rows, hats, products, squares
from sosml_friction.regression.noise_model import ORDER, NoiseModel


@pytest.mark.parametrize('step', [1e-3, 4e-3, 8e-3])
@pytest.mark.parametrize('samples', [0, 1, 500, 2000, 2001, 2002, 2003])
def test_filtering_by_matrices_is_the_filter_of_scipy_decimated(step, samples):
    band = Band(15.0, step)
    x = np.random.default_rng(1).normal(size=(samples, 2, 3))
    filtered = band.apply(x)
    assert filtered.shape == (band.count(samples), 2, 3)
    if len(filtered):
        taps = firwin(2 * band.half + 1, 15.0, fs=1.0 / step)
        full = upfirdn(taps, x, axis=0)[2 * band.half : samples]
        assert filtered == pytest.approx(full[:: band.factor], abs=1e-12)
        one = band.apply(x[:, 1, 2])
        assert one == pytest.approx(filtered[:, 1, 2], abs=1e-12)


def test_whitening_stretches_of_columns_is_the_filter_of_scipy():
    rng = np.random.default_rng(2)
    noise = [NoiseModel(rng.normal(0.0, 0.3, ORDER), sigma) for sigma in (0.5, 2.0)]
    parts = [rng.normal(size=(count, 2, 3, 2)) for count in (40, 7)]
    whitened = whiten_all(parts, noise)
    assert whitened.shape == (40 + 7 - 2 * ORDER, 2, 3, 2)
    for i, model in enumerate(noise):
        wanted = np.concatenate(
            [lfilter(model.whitening, [1.0], part[:, i], axis=0)[ORDER:] for part in parts]
        )
        assert whitened[:, i] == pytest.approx(wanted, abs=1e-12)
    assert len(convolve_rows(rng.normal(size=(3, 1, 2)), np.ones((1, ORDER + 1)))) == 0


def test_squares_are_the_products_of_columns_at_each_point():
    C = np.random.default_rng(3).normal(size=(50, 2, 4, 3))
    assert squares(C) == pytest.approx(np.einsum('tmgk,tmgl->gkl', C, C), abs=1e-12)


def test_lines_by_rotation_are_cosines_and_sines():
    q = np.linspace(-2.0, 2.0, 101)
    w = 7.0 + 1.3 * np.arange(40)
    found = lines(q, 7.0, 1.3, 40)
    # Forty rotations, each exact to a few units of 2e-16, of angles exact to 120 rad times that.
    assert found[:, :, 0] == pytest.approx(np.cos(q[:, None] * w), abs=1e-13)
    assert found[:, :, 1] == pytest.approx(np.sin(q[:, None] * w), abs=1e-13)


def test_hats_are_lines_between_knots():
    knots = np.array([-1.0, -0.2, 0.5, 2.0])
    x = np.concatenate([np.random.default_rng(4).normal(0.0, 2.0, 200), knots])
    wanted = np.column_stack([np.interp(x, knots, hat) for hat in np.eye(4)])
    assert hats(x, knots) == pytest.approx(wanted, abs=1e-15)
    assert hats(x, knots[:1]) == pytest.approx(1.0)


def bounded_problems(rng):
    """Yield A, b, the bound of each number, and what scipy finds, of 40 problems."""
    for _ in range(40):
        p = int(rng.integers(1, 9))
        A = rng.normal(size=(30, p))
        A[:, -1] += 0.99 * A[:, 0]
        b = rng.normal(size=30) + 3.0 * A[:, 0]
        limit = rng.uniform(0.0, 2.0, p) + 0.01
        limit[rng.random(p) < 0.3] = np.inf
        yield A, b, limit, lsq_linear(A, b, (-limit, limit), method='bvls', tol=1e-14).x


def test_bounded_least_squares_agrees_with_scipy():
    for A, b, limit, wanted in bounded_problems(np.random.default_rng(1)):
        x = bounded_least_squares(A.T @ A, A.T @ b, -limit, limit)
        assert x == pytest.approx(wanted, abs=1e-7)


def test_bounded_least_squares_finds_the_same_from_any_guess_within_bounds():
    rng = np.random.default_rng(5)
    for A, b, limit, wanted in bounded_problems(rng):
        # Each number within its bounds, or at one of them.
        guess = rng.choice([-1.0, 0.3, 1.0], len(limit)) * np.minimum(limit, 5.0)
        for start in (guess, wanted):
            x = bounded_from(A.T @ A, A.T @ b, -limit, limit, start)
            assert x == pytest.approx(wanted, abs=1e-7)


def test_a_cause_is_weighed_beside_any_others_whenever_it_was_found():
    """Products of a cause found late are the same beside fewer, other and wider causes."""
    rng = np.random.default_rng(5)
    both = np.arange(2)
    columns = [rng.standard_normal((240, 2, 1, k)) for k in (2, 1, 2, 1)]
    first = System.make(
        rng.standard_normal((240, 2, 3)),
        np.ones(3),
        np.ones(3),
        make_blocks(240, 4, 2),
    )
    accepted: list[CandidateColumns] = []
    for C in columns:
        its = CandidateColumns.make(first, both, C)
        accepted.append(its.beside(first.extended(accepted)))
    for others in ([], [0], [1], [0, 2], [1, 2], [2, 0, 1]):
        system = first.extended([accepted[k] for k in others])
        late = accepted[3].beside_first(3).beside(system)
        afresh = CandidateColumns.make(system, both, columns[3])
        np.testing.assert_allclose(late.B, afresh.B, rtol=1e-12, atol=1e-10)


@pytest.mark.parametrize('bound', [0.02, 0.1, np.inf])
def test_a_point_of_a_large_grid_has_the_score_that_it_has_alone(bound):
    """Along a grid it is computed from the points before; bounds hold some deviations or none."""
    rng = np.random.default_rng(6)
    rows, p = 420, 8
    Z = rng.standard_normal((rows, 1, p))
    y = Z[:, 0] @ rng.normal(0.0, 0.08, p) + 0.2 * rng.standard_normal(rows)
    system = System.make(Z, np.full(p, bound), np.full(p, np.inf), make_blocks(rows, 14, 7))
    C = rng.standard_normal((rows, 1, 30, 2))
    C += (Z @ rng.standard_normal((p, 60))).reshape(C.shape)
    fit = Fit.make(system, y[:, None])
    whole = fit.score(CandidateColumns.make(system, np.array([0]), C))
    alone = [
        fit.score(CandidateColumns.make(system, np.array([0]), C[:, :, k : k + 1]))
        for k in range(30)
    ]
    assert whole.gains == pytest.approx([one.gain for one in alone], abs=1e-8)
    assert whole.x == pytest.approx(alone[whole.best].x, abs=1e-8)
    if np.isfinite(bound):
        held = [tuple(np.abs(one.x) >= 0.999 * bound) for one in alone]
        assert len({*held}) > 1


def test_columns_of_single_precision_are_multiplied_in_double():
    rng = np.random.default_rng(7)
    C = rng.standard_normal((1500, 6)).astype(np.float32)
    left = rng.standard_normal((2, 1500))
    assert products(left, C) == pytest.approx(left @ C.astype(float), rel=1e-13, abs=1e-11)
    weights = rng.standard_normal((1, ORDER + 1))
    wanted = convolve_rows(C[:, None].astype(float), weights)
    whitened = convolve_rows(C[:, None], weights)
    assert whitened.dtype == np.float32
    assert whitened == pytest.approx(wanted, rel=1e-6, abs=1e-6)
