# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Effort that is late, and what is no more than where in an interval it holds."""

from types import SimpleNamespace

import numpy as np
import pytest

from sosml_friction.model.terms.effort_delay import EffortDelay
from sosml_friction.model.terms.kinds.fitted import Fitted


@pytest.mark.parametrize(
    ('delay', 'error', 'no_cause'),
    [(-3.8e-3, 1e-3, True), (-3.8e-3, 0.3e-3, False), (4.8e-3, 1e-3, False), (2e-3, 1e-4, True)],
)
def test_a_delay_that_may_be_within_half_an_interval_is_no_cause(delay, error, no_cause):
    """Of samples that are 5 ms apart: a command that is held is 2.5 ms early."""
    signals = SimpleNamespace(band=SimpleNamespace(step=5e-3))
    fit = Fitted(signals, 0, {}, np.array([delay]), np.array([error]))
    assert EffortDelay().tolerated(fit, 0.035) == no_cause
