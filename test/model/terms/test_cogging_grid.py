# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""At which frequencies cogging is looked for."""

from types import SimpleNamespace

import numpy as np
import pytest

from sosml_friction.model.terms.cogging import Cogging
from sosml_friction.model.terms.kinds.fitted import Fitted


@pytest.mark.parametrize('turns', [0.5, 1.05, 2.0, 10.0, 160.0])
def test_every_frequency_is_near_one_that_is_tried_and_of_many_turns_those_that_repeat(turns):
    span = 2.0 * np.pi * turns
    signals = SimpleNamespace(
        scales=SimpleNamespace(span=np.array([span]), speed=np.array([25.0])),
        band=SimpleNamespace(cutoff=20.0),
        length_unit=lambda joint: 'rad',
    )
    w = np.array([inner['frequency'] for inner in Cogging().grid(signals, 0)])
    low, high = Cogging().inner_bounds(signals, 0)['frequency']
    assert low <= w[0]
    assert w[-1] <= high
    # Half a step apart, the phase differs by 2.5 / 2 over the range of motion.
    fine = 2.5 / span
    ends_at = 400.0 * fine
    for wanted in (15.0, 15.5, 24.0, 100.0):
        if wanted.is_integer() or wanted < ends_at:
            assert np.abs(w - wanted).min() <= 0.5 * fine + 1e-9, wanted


@pytest.mark.parametrize(('share', 'possible'), [(0.5, True), (1.4, True), (1.5, False)])
def test_cogging_is_no_larger_than_all_of_the_measured_effort(share, possible):
    """A sine of the amplitude of 1.41 root mean squares would be all of it."""
    scales = SimpleNamespace(effort=np.array([7.0]))
    amplitude = 7.0 * share * np.array([0.6, -0.8])
    fit = Fitted(SimpleNamespace(scales=scales), 0, {'frequency': 9.0}, amplitude, 0.1 * amplitude)
    assert (Cogging().implausible(fit) == '') == possible
