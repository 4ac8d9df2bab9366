# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A torque constant that ripples over position."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.cogging import Cogging
from sosml_friction.model.terms.effort_scale import EffortScale
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner
from sosml_friction.regression.curves.curve import Curve


class TorqueRipple(Curve):
    """
    Add tau (A cos w q + B sin w q), of the nominal torque tau.

    ``frequency`` w [rad/rad or rad/m], where cogging has it.
    """

    identifier: ClassVar[str] = 'torque_ripple'
    amplitudes: ClassVar[Mapping[str, str]] = {'cosine': '1', 'sine': '1'}
    inner: ClassVar[Mapping[str, str]] = Cogging.inner
    refined: ClassVar[tuple[str, ...]] = ('frequency',)

    def grid(self, signals: Recording, joint: int) -> Sequence[Inner]:
        """Return the frequencies of cogging."""
        return Cogging().grid(signals, joint)

    def inner_bounds(self, signals: Recording, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the range of those of cogging."""
        return Cogging().inner_bounds(signals, joint)

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return tau cos w q and tau sin w q."""
        angle = float(inner['frequency']) * signals.q[:, joint]
        torque = signals.whole_torque[:, joint]
        return signals.in_joint(joint, torque * np.cos(angle), torque * np.sin(angle))

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        share = np.array([np.hypot(*fit.amplitude)])
        return EffortScale().implausible(replace(fit, amplitude=share))
