# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""An encoder that runs out of true."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import Effect, FloatArray, Inner
from sosml_friction.diagnosis.fitted import Fitted
from sosml_friction.model.robot import Robot
from sosml_friction.regression.rigid_terms import moved_body
from sosml_friction.regression.signals import Signals
from sosml_friction.simulation.forward_terms import EncoderTerm


class EncoderEccentricity(Effect):
    """Add (M d2/dt2 + dg/dq) (A cos q + B sin q): position is wrong once per turn."""

    identifier: ClassVar[str] = 'encoder_eccentricity'
    amplitudes: ClassVar[Mapping[str, str]] = {'cosine': 'rad', 'sine': 'rad'}

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return the effort of a wrong position."""
        q = signals.q[:, joint]
        parts = [moved_body(signals, joint, x) for x in (np.cos(q), np.sin(q))]
        return np.stack(parts, axis=2)

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> EncoderTerm:
        """Return an encoder that is A cos q + B sin q behind."""
        cosine, sine = amplitude
        return EncoderTerm(joint, lambda q: np.asarray(cosine * np.cos(q) + sine * np.sin(q)))

    def applies(self, signals: Signals, joint: int) -> bool:
        """Tell whether the joint turns."""
        return signals.length_unit(joint) == 'rad'

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if float(np.hypot(*fit.amplitude)) > 0.03:
            return 'an eccentricity of over 30 mrad would be seen'
        return ''
