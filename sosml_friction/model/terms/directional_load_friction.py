# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction by load that differs between driving and being driven."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.term import Inner


class DirectionalLoadFriction(EffortTerm):
    """
    Add (k_d d + k_b (1 - d)) |tau_load| s, d = 1 where the motor drives its load, else 0.

    tau_load is what the gear passes on; the motor drives where tau_load s > 0, else its load
    drives it. With both coefficients the same it is ``load_dependent_friction``. A gear of
    efficiency eta driving and eta' driven has k_d = 1 / eta - 1 and k_b = 1 - eta'.
    """

    identifier: ClassVar[str] = 'directional_load_friction'
    amplitudes: ClassVar[Mapping[str, str]] = {
        'driving_coefficient': '1',
        'driven_coefficient': '1',
    }
    axis: ClassVar[str] = 'load'
    searched: ClassVar[bool] = False

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Return |tau_load| s where the motor drives, and where it is driven."""
        load, sign = motion.load[:, joint], motion.sign[:, joint]
        size, drives = np.abs(load) * sign, load * sign > 0.0
        return np.where(drives, size, 0.0), np.where(drives, 0.0, size)

    def implausible(self, fit: Fitted) -> str:
        """Return why such amplitudes are impossible, else ''."""
        if not ((fit.amplitude > 0.0) & (fit.amplitude < 0.5)).all():
            return 'a gear loses between nothing and half of its load, either way'
        return ''
