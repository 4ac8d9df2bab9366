# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the error of an estimate is made of."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from sosml_friction.observers.estimate_error import impulse_response


@pytest.mark.parametrize(
    ('b', 'a'),
    [
        ([0.2], [1.0, -0.8]),
        ([0.0, 0.0, 1.5], [2.0]),
        butter(3, 0.1),
        ([1.0, 0.5], [2.0, -0.4, 0.1, 0.05]),
    ],
)
@pytest.mark.parametrize('count', [2, 400])
def test_a_filter_answers_an_impulse_as_that_of_scipy(b, a, count):
    """To rounding: both sum the same few products, and no pole is beyond the unit circle."""
    impulse = np.zeros(count)
    impulse[0] = 1.0
    own = impulse_response(np.asarray(b, float), np.asarray(a, float), count)
    assert own == pytest.approx(lfilter(b, a, impulse), rel=1e-9, abs=1e-12)
