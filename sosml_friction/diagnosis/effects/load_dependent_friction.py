# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that grows with the load on the gear."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import Effect, FloatArray, Inner
from sosml_friction.diagnosis.fitted import Fitted
from sosml_friction.model.robot import Robot
from sosml_friction.regression.signals import Signals
from sosml_friction.simulation.forward_term import Motion
from sosml_friction.simulation.forward_terms import LoadTerm


class LoadDependentFriction(Effect):
    """Add k |tau_load| s, tau_load what the gear passes on, k = ``load_coefficient``."""

    identifier: ClassVar[str] = 'load_dependent_friction'
    amplitudes: ClassVar[Mapping[str, str]] = {'load_coefficient': '1'}

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return |tau_load| s."""
        return signals.in_joint(joint, np.abs(signals.rigid[:, joint]) * signals.sign[:, joint])

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> LoadTerm:
        """Return k |tau_load| s, of the load a step before."""
        k = float(amplitude[0])

        def load(motion: Motion) -> FloatArray:
            return np.asarray(k * np.abs(motion.load[:, joint]) * motion.sign[:, joint])

        return LoadTerm(joint, load, lambda effort: k * effort)

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if not 0.0 < fit.amplitude[0] < 0.5:
            return 'a gear loses between nothing and half of its load'
        return ''
