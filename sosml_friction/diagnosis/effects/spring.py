# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A spring between the bodies: a cable, a strap, a limb."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import Effect, FloatArray, Inner
from sosml_friction.diagnosis.fitted import Fitted
from sosml_friction.model.robot import Robot
from sosml_friction.regression.signals import Signals
from sosml_friction.simulation.forward_terms import LoadTerm

#: A stiffness is seen from so many standard errors.
_CLEAR = 4.0
#: Or where its rest position is so many ranges of the motion from its middle: gravity within its
#: tolerance may make up for the rest of a spring, but what is a constant alone relaxes nowhere.
_REACH = 1.5


class Spring(Effect):
    """Add k (q - q_0) as k q + offset."""

    identifier: ClassVar[str] = 'spring'
    amplitudes: ClassVar[Mapping[str, str]] = {
        'stiffness': '{effort}/{length}',
        'offset': '{effort}',
    }

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return q and 1."""
        return signals.in_joint(joint, signals.q[:, joint], np.ones(len(signals.q)))

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> LoadTerm:
        """Return k q + offset."""
        k, offset = float(amplitude[0]), float(amplitude[1])
        return LoadTerm(joint, lambda m: k * m.q[:, joint] + offset, stiffness=k)

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if fit.amplitude[0] <= 0.0:
            return 'a spring has a positive stiffness'
        if self.reduces_to(fit):
            return 'no stiffness is seen: what is left of a spring is a constant'
        return ''

    def reduces_to(self, fit: Fitted) -> str:
        """Return 'effort_bias' where no stiffness is seen: what is left is a constant."""
        k, offset = fit.amplitude
        if k >= _CLEAR * fit.error[0]:
            return ''
        q = fit.signals.q[:, fit.joint]
        middle, span = 0.5 * float(q.min() + q.max()), float(np.ptp(q))
        # A stiffer one within the standard error relaxes nearer.
        near = abs(k * middle + offset) < (k + fit.error[0]) * _REACH * span
        return '' if k > 0.0 and near else 'effort_bias'
