# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that builds up with displacement, and what is no more than another reversal."""

from types import SimpleNamespace

import numpy as np
import pytest

from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.presliding_hysteresis import PreslidingHysteresis


@pytest.mark.parametrize(('error', 'no_cause'), [(0.2e-3, False), (0.4e-3, True)])
def test_a_displacement_that_may_be_that_of_the_sign_is_no_cause(error, no_cause):
    scales = SimpleNamespace(displacement=np.array([0.3e-3]))
    fit = Fitted(
        SimpleNamespace(scales=scales),
        0,
        {'displacement': 0.9e-3},
        np.array([0.5]),
        np.array([0.1]),
        {'displacement': error},
    )
    assert PreslidingHysteresis().tolerated(fit, 0.035) == no_cause
