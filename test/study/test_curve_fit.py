# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The raw curve fit: exact on the law itself, bounded elsewhere."""

import numpy as np
import pytest

from sosml_friction.model.laws import make_friction_law
from sosml_friction.study.outcome import fit_raw


@pytest.mark.parametrize('v_s', [0.01, 0.03, 0.2])
def test_it_finds_the_law_that_made_the_data(v_s):
    law = make_friction_law(
        'stribeck',
        {'coulomb': 0.8, 'viscous': 0.35, 'stribeck': 0.5, 'stribeck_velocity': v_s, 'bias': -0.1},
        0.005,
    )
    v = np.sin(np.linspace(0.0, 20.0, 4000))
    found = fit_raw(v, law.torque(v), 0.005).parameters
    for name, value in law.parameters.items():
        assert found[name] == pytest.approx(value, rel=1e-5)


def test_parameters_stay_physical_on_data_that_are_not():
    v = np.sin(np.linspace(0.0, 20.0, 4000))
    found = fit_raw(v, -np.tanh(v / 0.005) - v, 0.005).parameters
    assert all(found[name] >= 0.0 for name in ('coulomb', 'viscous', 'stribeck'))
    assert 1e-3 <= found['stribeck_velocity'] <= 1.0
