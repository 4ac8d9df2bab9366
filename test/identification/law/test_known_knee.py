# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The Stribeck velocity is known if an interval of 1.5 times the usual width is closed."""

from __future__ import annotations

import numpy as np
import pytest
from fitted_law import fit_law

from sosml_friction.identification.law.law_form import LawForm
from sosml_friction.identification.law.law_profile import LawProfile
from sosml_friction.model.parameter import NOT_IDENTIFIABLE


@pytest.mark.parametrize(('closed_up_to', 'known'), [(1.6, True), (1.4, False)])
def test_a_knee_is_known_only_if_one_and_a_half_times_its_interval_is_closed(
    monkeypatch, closed_up_to, known
):
    """A profile of cost is closed up to so many times the half-width: its square in the cost."""
    speeds = np.array([0.01, 0.02, 0.03, 0.05, 0.1, 0.2, 0.4])
    v = np.concatenate([speeds, -speeds, speeds, -speeds])
    error = 1e-3 * np.random.default_rng(0).normal(size=len(v))
    y = (0.8 + 0.5 * np.exp(-np.abs(v) / 0.03)) * np.sign(v) + 0.35 * v + error
    monkeypatch.setattr(
        LawProfile,
        'velocity_interval',
        lambda self, cost=1.0: (0.02 if cost <= closed_up_to**2 else 0.0, 0.04),
    )
    fit = fit_law(v, y, np.arange(len(v)), 'Nm', form=LawForm(alpha=1.0))
    assert (NOT_IDENTIFIABLE not in fit.parameters['stribeck_velocity'].flags) == known
    assert (fit.law == 'stribeck') == known
