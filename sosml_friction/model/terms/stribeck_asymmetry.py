# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A Stribeck term that differs between the directions, in a law."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.fading_term import FadingTerm
from sosml_friction.model.terms.kinds.motion import Motion


class StribeckAsymmetry(FadingTerm):
    """Add D |s| exp(-(|q'| / v_s)^d): S + D forwards and S - D backwards, beside ``stribeck``."""

    identifier: ClassVar[str] = 'stribeck_asymmetry'
    amplitudes: ClassVar[Mapping[str, str]] = {'stribeck_asymmetry': '{effort}'}
    searched: ClassVar[bool] = False
    of_law: ClassVar[bool] = True
    axis: ClassVar[str] = 'speed'

    def at_standstill(self, motion: Motion, joint: int | slice, sign: FloatArray) -> FloatArray:
        """Return |s|."""
        return np.abs(sign)
