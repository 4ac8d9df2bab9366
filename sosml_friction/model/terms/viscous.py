# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Viscous friction."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner


class Viscous(EffortTerm):
    """Add B q'."""

    identifier: ClassVar[str] = 'viscous'
    amplitudes: ClassVar[Mapping[str, str]] = {'viscous': '{effort} s/{length}'}
    parameter_error: ClassVar[bool] = True
    reported_as: ClassVar[Mapping[str, str]] = {'viscous': 'change'}
    of_law: ClassVar[bool] = True
    held_by: ClassVar[tuple[str, ...]] = ('isaaclab', 'mjcf', 'ros2-control', 'sdf', 'urdf', 'usd')
    axis: ClassVar[str] = 'speed'
    free_axis: ClassVar[str] = 'speed'
    one_power: ClassVar[bool] = True
    told_apart: ClassVar[Mapping[str, tuple[str, str]]] = {
        'thermal_drift': (
            'warm_up_repeat',
            'repeat the same speeds cold and warm: a wrong viscous friction is the same in both',
        )
    }

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Return q'."""
        return (motion.v[:, joint],)

    def applies(self, signals: Recording, joint: int) -> bool:
        """Tell whether the model has a viscous friction to be wrong."""
        return bool(np.isfinite(signals.scales.viscous[joint]))

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if fit.signals.scales.viscous[fit.joint] + fit.amplitude[0] < 0.0:
            return 'viscous friction would be negative'
        return ''
