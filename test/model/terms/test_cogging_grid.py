# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""At which frequencies cogging is looked for."""

from types import SimpleNamespace

import numpy as np
import pytest

from sosml_friction.model.terms.cogging import Cogging


@pytest.mark.parametrize(('turns', 'whole'), [(0.5, False), (2.0, False), (160.0, True)])
def test_of_many_turns_the_frequencies_are_those_that_repeat_with_each(turns, whole):
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
    if whole:
        assert {4.0, 7.0, 24.0, 100.0} <= set(w.tolist())
    else:
        # No frequency of the range of motion is missed.
        assert np.allclose(np.diff(w), 2.5 / span)
