# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A Stribeck term that grows with load."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.fading_term import FadingTerm
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.motion import Motion


class LoadDependentStribeck(FadingTerm):
    """Add k_s |tau_load| s exp(-(|q'| / v_s)^d), tau_load what the gear passes on."""

    identifier: ClassVar[str] = 'load_dependent_stribeck'
    amplitudes: ClassVar[Mapping[str, str]] = {'load_stribeck_coefficient': '1'}
    axis: ClassVar[str] = 'load'
    searched: ClassVar[bool] = False

    def at_standstill(self, motion: Motion, joint: int | slice, sign: FloatArray) -> FloatArray:
        """Return |tau_load| s."""
        return np.abs(motion.load[:, joint]) * sign

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if not 0.0 < fit.amplitude[0] < 0.5:
            return 'a gear loses between nothing and half of its load'
        return ''
