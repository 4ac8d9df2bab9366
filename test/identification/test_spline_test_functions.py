# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The test function of the weak form is SciPy's B-spline, and its integral SciPy's."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from sosml_friction.identification.spline_test_functions import cubic_spline


def test_it_is_the_spline_of_scipy_and_its_integral():
    """Each is a sum of a few terms of up to 1.3: rounding leaves a few 1e-16."""
    x = np.linspace(-3.0, 3.0, 601)
    inside = np.clip(x, -2.0, 2.0)
    spline = BSpline.basis_element(np.arange(-2.0, 3.0))
    value, integral = cubic_spline(x)
    assert value == pytest.approx(spline(inside), abs=2e-15)
    assert integral == pytest.approx(spline.antiderivative()(inside), abs=2e-15)
