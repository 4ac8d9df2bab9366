# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Effort that is late, and a command that is held."""

from types import SimpleNamespace

import numpy as np
import pytest

from sosml_friction.model.terms.effort_delay import EffortDelay
from sosml_friction.model.terms.kinds.fitted import Fitted


@pytest.mark.parametrize(
    ('delay', 'no_cause'), [(-4.9e-3, True), (-5.1e-3, False), (4.9e-3, False), (-1e-4, True)]
)
def test_a_command_that_is_held_within_its_interval_is_no_cause(delay, no_cause):
    """Of samples that are 5 ms apart."""
    signals = SimpleNamespace(band=SimpleNamespace(step=5e-3))
    fit = Fitted(signals, 0, {}, np.array([delay]), np.array([1e-3]))
    assert EffortDelay().tolerated(fit, 0.035) == no_cause
