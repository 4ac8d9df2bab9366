# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that changes with posture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import Effect, FloatArray, Inner
from sosml_friction.diagnosis.fitted import Fitted
from sosml_friction.model.robot import Robot
from sosml_friction.regression.signals import Signals
from sosml_friction.simulation.forward_term import Motion
from sosml_friction.simulation.forward_terms import LoadTerm


class PositionDependentFriction(Effect):
    """
    Add s (A cos w q + B sin w q): friction with w periods per rad or m, its sign by direction.

    ``frequency`` w [rad/rad or rad/m]: 1 and 2 per turn.
    """

    identifier: ClassVar[str] = 'position_dependent_friction'
    amplitudes: ClassVar[Mapping[str, str]] = {'cosine': '{effort}', 'sine': '{effort}'}
    inner: ClassVar[Mapping[str, str]] = {'frequency': 'rad/{length}'}

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return s cos w q and s sin w q."""
        angle = inner['frequency'] * signals.q[:, joint]
        s = signals.sign[:, joint]
        return signals.in_joint(joint, s * np.cos(angle), s * np.sin(angle))

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> LoadTerm:
        """Return s (A cos w q + B sin w q)."""
        w, (cosine, sine) = inner['frequency'], amplitude

        def load(motion: Motion) -> FloatArray:
            angle = w * motion.q[:, joint]
            level = cosine * np.cos(angle) + sine * np.sin(angle)
            return np.asarray(level * motion.sign[:, joint])

        return LoadTerm(joint, load, float(np.hypot(cosine, sine)))

    def grid(self, signals: Signals, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        if signals.length_unit(joint) == 'rad':
            return ({'frequency': 1.0}, {'frequency': 2.0})
        span = float(signals.scales.span[joint])
        return tuple({'frequency': np.pi * k / span} for k in (1.0, 2.0))

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if float(np.hypot(*fit.amplitude)) > 1.5 * fit.signals.scales.level(fit.joint):
            return 'friction would be negative in some posture'
        return ''
