# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The evidence of a model is that of the Gaussian it states."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known_robots import slider_model, slider_recording

from sosml_friction.model.terms.stribeck import Stribeck
from sosml_friction.regression.evidence import UNIFORM, Fit
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare
from sosml_friction.regression.whitened import WhitenedRegression
from validation.evidence_criterion import EvidenceSelector, ModelEvidence


@pytest.fixture(scope='module')
def laboratory():
    """Return a slider's recording in which only a Stribeck term is looked for."""
    model, settings = slider_model(20.0, 200.0), DiagnosisSettings()
    signals = prepare([slider_recording(seed=1)], model, model.make_robot(), settings)
    return WhitenedRegression.make(signals, {'stribeck': Stribeck()}, settings)


def at_best(laboratory, effect):
    """Return the regression of noise and an effect of a size, and the term where it is best."""
    (columns,) = laboratory.columns
    g = columns.C.shape[2] // 2
    noise = np.random.default_rng(0).standard_normal(laboratory.y.shape)
    its = replace(laboratory, y=noise + effect * columns.C[:, :, g, 0])
    fit = Fit.make(its.system, its.y)
    (candidate,) = its.candidates
    scorer = EvidenceSelector(its).scorer
    return its, scorer.refine(fit, scorer.finding(fit, candidate, columns))


def log_likelihood(y, covariance):
    return -0.5 * (np.linalg.slogdet(covariance)[1] + y @ np.linalg.solve(covariance, y))


def test_without_curves_it_is_the_likelihood_of_one_gaussian(monkeypatch, laboratory):
    """Of a dense covariance, 1 + Z b^2 / 3 Z' + A^2 X X'; what has no prior is of 1e8 of both."""
    monkeypatch.setattr(ModelEvidence, '_curves', lambda own, far: [])
    its, finding = at_best(laboratory, 0.5)
    evidence = ModelEvidence(its)
    Z, X = its.system.Z[:, 0], np.asarray(finding.columns.C[:, 0, 0])
    (A,) = evidence._amplitudes(finding)
    weight = its.system.prior_weight() / UNIFORM
    free = 1e-10 * np.sum(Z**2, axis=0) + 1e-12
    without = np.eye(len(Z)) + Z @ ((1.0 / (weight + free))[:, None] * Z.T)
    with_it = without + A**2 * X @ X.T
    expected = log_likelihood(its.y[:, 0], with_it) - log_likelihood(its.y[:, 0], without)
    assert evidence.of((finding,)) - evidence.of(()) == pytest.approx(expected, abs=0.01)


@pytest.mark.parametrize('effect', [0.0, 5.0])
def test_a_cause_that_is_there_has_more_evidence_beside_curves_and_no_other_one_has(
    laboratory, effect
):
    its, finding = at_best(laboratory, effect)
    evidence = ModelEvidence(its)
    assert (evidence.of((finding,)) > evidence.of(())) == (effect > 0.0)
