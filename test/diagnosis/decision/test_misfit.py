# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is impossible sets a floor in the joints that it acts in, and in no others."""

from types import SimpleNamespace

import numpy as np
import pytest

from sosml_friction.diagnosis.decision.misfit import Misfit, explained
from sosml_friction.regression.evidence import CandidateColumns, Fit, System, make_blocks

ROWS = 400


@pytest.fixture
def fit() -> Fit:
    rng = np.random.default_rng(1)
    Z = rng.normal(size=(ROWS, 2, 3))
    blocks = make_blocks(ROWS, 4, 2)
    system = System.make(Z, np.full(3, np.inf), np.full(3, np.inf), blocks)
    return Fit.make(system, rng.normal(size=(ROWS, 2)))


def finding(fit, joints, seed, scale):
    """Return a candidate that explains much of a joint where its scale is large."""
    rng = np.random.default_rng(seed)
    C = rng.normal(size=(ROWS, len(joints), 1, 1))
    for i, joint in enumerate(joints):
        C[:, i, 0, 0] += scale[i] * fit.target.y[:, joint]
    columns = CandidateColumns.make(fit.system, np.array(joints), C)
    return SimpleNamespace(columns=columns, score=fit.score(columns))


def test_what_each_joint_gains_is_the_fall_of_its_own_sum_of_squares(fit):
    own = finding(fit, [0, 1], 2, [1.0, 0.2])
    s, C = own.score, own.columns.C[:, :, 0, 0]
    before = fit.target.y - fit.system.Z @ fit.baseline.x
    after = fit.target.y - fit.system.Z @ s.x - C * s.amplitude
    wanted = (before**2).sum(axis=0) - (after**2).sum(axis=0)
    assert explained(fit, own.columns, 0, s.x, s.amplitude) == pytest.approx(wanted)
    assert wanted.sum() == pytest.approx(s.gain)


def test_an_impossible_one_of_another_joint_sets_no_floor(fit):
    mine, other = finding(fit, [0], 3, [0.3]), finding(fit, [1], 4, [2.0])
    assert Misfit.make(fit, [other]).floor(mine) <= 0.0
    same = finding(fit, [0], 5, [2.0])
    floor = same.score.energy * mine.score.cv_gain / mine.score.energy - mine.score.cv_se
    assert Misfit.make(fit, [other, same]).floor(mine) == pytest.approx(floor)


def test_one_of_several_joints_counts_with_what_it_explains_there(fit):
    both = finding(fit, [0, 1], 6, [0.2, 2.0])
    here, there = (finding(fit, [joint], 7, [0.5]) for joint in (0, 1))
    misfit = Misfit.make(fit, [both])
    of_all = [
        both.score.energy * own.score.cv_gain / own.score.energy - own.score.cv_se
        for own in (here, there)
    ]
    # In the first joint next to nothing, in the second nearly all of it.
    assert misfit.floor(here) < 0.2 * of_all[0]
    assert misfit.floor(there) > 0.8 * of_all[1]
