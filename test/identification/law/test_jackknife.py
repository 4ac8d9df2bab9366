# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How many degrees of freedom a jackknife variance has."""

import numpy as np
import pytest

from sosml_friction.identification.law.jackknife import (
    jackknife_errors,
    jackknife_freedom,
    t_95,
)

#: 40 clusters of ten rows.
GROUPS = np.repeat(np.arange(40), 10)


def test_clusters_that_say_as_much_leave_clusters_less_parameters():
    X = np.tile(np.column_stack([np.ones(10), np.linspace(-1.0, 1.0, 10)]), (40, 1))
    np.testing.assert_allclose(jackknife_freedom(X, GROUPS, np.ones(len(X))), 38.0, rtol=1e-9)


@pytest.mark.parametrize('few', [1, 2, 5])
def test_a_parameter_that_few_clusters_tell_has_as_few_degrees_of_freedom(few):
    X = np.column_stack([np.ones(400), few > GROUPS])
    freedom = jackknife_freedom(X, GROUPS, np.ones(len(X)))
    assert freedom[0] > 25.0
    assert few <= freedom[1] <= 1.2 * few


def test_one_that_no_cluster_tells_is_a_number_without_a_warning(recwarn):
    X = np.column_stack([np.ones(400), np.zeros(400)])
    assert np.isfinite(jackknife_freedom(X, GROUPS, np.ones(len(X)))).all()
    assert not recwarn.list


@pytest.mark.parametrize('few', [2, 3])
def test_intervals_of_what_few_clusters_tell_hold_the_truth_as_often_as_they_say(few):
    """With the degrees of freedom of all clusters, 38, those of two hold in 0.83."""
    rng, held, before = np.random.default_rng(0), 0, 0
    X = np.column_stack([np.ones(400), few > GROUPS])
    half = t_95(jackknife_freedom(X, GROUPS, np.ones(len(X)))[1])
    for _ in range(400):
        y = rng.normal(size=40)[GROUPS] + rng.normal(size=400)
        theta = np.linalg.lstsq(X, y, rcond=None)[0]
        error = jackknife_errors(X, y - X @ theta, GROUPS)[1]
        held += abs(theta[1]) <= half * error
        before += abs(theta[1]) <= t_95(38) * error
    assert before < 0.93 * 400
    assert held > 0.93 * 400
