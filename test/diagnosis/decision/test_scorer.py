# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What counts as evidence for a candidate, and what is how friction turns around."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known_robots import slider_model, slider_recording

from sosml_friction.diagnosis.decision.scorer import Scorer
from sosml_friction.model.terms.stribeck import Stribeck
from sosml_friction.regression.estimate import far_from_reversals
from sosml_friction.regression.evidence import Fit
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare
from sosml_friction.regression.whitened import WhitenedRegression


@pytest.fixture(scope='module')
def laboratory():
    """Return a slider's recording in which only a Stribeck term is looked for."""
    model, settings = slider_model(20.0, 200.0), DiagnosisSettings()
    signals = prepare([slider_recording(seed=1)], model, model.make_robot(), settings)
    return WhitenedRegression.make(signals, {'stribeck': Stribeck()}, settings)


@pytest.mark.parametrize('sign', [1.0, -1.0])
def test_what_is_beside_reversals_is_evidence_for_those_alone_that_act_there(
    monkeypatch, laboratory, sign
):
    """A joint that sticks has any friction: that is no Stribeck term, of either sign."""
    (columns,) = laboratory.columns
    (candidate,) = laboratory.candidates
    far = far_from_reversals(laboratory, laboratory.system.Z)
    g = len(candidate.grid) // 2
    effect = sign * 5.0 * columns.C[:, :, g, 0]
    noise = np.random.default_rng(0).standard_normal(effect.shape)

    def bic(part):
        its = replace(laboratory, y=noise + part)
        fit = Fit.make(its.system, its.y)
        found = Scorer(its).finding(fit, candidate, columns)
        assert bool(found.objection) == (sign < 0.0)
        return found.delta_bic

    everywhere, beside = bic(effect), bic(np.where(far, 0.0, effect))
    assert everywhere > 10.0
    assert beside < 10.0
    monkeypatch.setattr(Stribeck, 'at_reversals', True)
    assert (bic(np.where(far, 0.0, effect)) > 10.0) == (sign > 0.0)
    # What acts everywhere else as well has to show there.
    monkeypatch.setattr(Stribeck, 'elsewhere_too', True)
    assert bic(np.where(far, 0.0, effect)) < 10.0
    assert bic(effect) > 10.0


@pytest.mark.parametrize('count', [1, 40])
def test_the_best_of_many_candidates_has_the_price_of_the_choice(laboratory, count):
    """2 ln K, beside that of three parameters and of the points of a grid."""
    (columns,) = laboratory.columns
    (candidate,) = laboratory.candidates
    rows = replace(laboratory.rows, candidates=(candidate,) * count)
    found = Scorer(replace(laboratory, rows=rows)).finding(
        Fit.make(laboratory.system, laboratory.y), candidate, columns
    )
    price = 3.0 * np.log(laboratory.known[0]) + 2.0 * np.log(count * len(candidate.grid))
    assert found.delta_bic == pytest.approx(found.score.gain - price)


def test_what_may_choose_among_more_points_has_a_higher_floor(laboratory):
    """0.5 % of the energy, times 1 + ln g."""
    fit = Fit.make(laboratory.system, laboratory.y)
    (columns,) = laboratory.columns
    (candidate,) = laboratory.candidates
    assert len(candidate.grid) > 1
    found = Scorer(laboratory).finding(fit, candidate, columns)
    assert found.floor == pytest.approx(0.005 * (1.0 + np.log(len(candidate.grid))))
    first = replace(candidate, grid=candidate.grid[:1])
    one = columns.make(laboratory.system, columns.rows, columns.C[:, :, :1])
    assert Scorer(laboratory).finding(fit, first, one).floor == pytest.approx(0.005)


def test_a_candidate_of_joints_of_which_nothing_is_known_is_none(laboratory):
    """Its price was the logarithm of no row, and its gain a share of nothing."""
    its = replace(laboratory, known=np.zeros_like(laboratory.known))
    assert Scorer(its).ranked(Fit.make(its.system, its.y), its.columns) == []
    assert len(Scorer(laboratory).ranked(Fit.make(its.system, its.y), its.columns)) == 1
