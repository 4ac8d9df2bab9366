# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that grows with the load on the gear."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import (
    Effect,
    FloatArray,
    Inner,
    in_joint,
)
from sosml_friction.diagnosis.signals import Signals
from sosml_friction.model.robot import Robot
from sosml_friction.simulation.forward_term import Motion
from sosml_friction.simulation.forward_terms import LoadTerm


class LoadDependentFriction(Effect):
    """Add k |tau_load| s, tau_load what the gear passes on, k = ``load_coefficient``."""

    identifier: ClassVar[str] = 'load_dependent_friction'
    amplitudes: ClassVar[tuple[str, ...]] = ('load_coefficient',)

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return |tau_load| s."""
        return in_joint(signals, joint, np.abs(signals.rigid[:, joint]) * signals.sign[:, joint])

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> LoadTerm:
        """Return k |tau_load| s, of the load a step before."""
        k = float(amplitude[0])

        def load(motion: Motion) -> FloatArray:
            return np.asarray(k * np.abs(motion.load[:, joint]) * motion.sign[:, joint])

        return LoadTerm(joint, load, lambda effort: k * effort)

    def units(self, signals: Signals, joint: int) -> Mapping[str, str]:
        """Return the units."""
        return {'load_coefficient': '1'}

    def implausible(
        self,
        signals: Signals,
        joint: int,
        inner: Inner,
        amplitude: FloatArray,
        error: FloatArray,
    ) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if not 0.0 < amplitude[0] < 0.5:
            return 'a gear loses between nothing and half of its load'
        return ''
