# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Coulomb friction."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner


class Coulomb(EffortTerm):
    """Add C s: a level that opposes motion, s the sign of motion."""

    identifier: ClassVar[str] = 'coulomb'
    amplitudes: ClassVar[Mapping[str, str]] = {'coulomb': '{effort}'}
    parameter_error: ClassVar[bool] = True
    reported_as: ClassVar[Mapping[str, str]] = {'coulomb': 'change'}
    of_law: ClassVar[bool] = True
    held_by: ClassVar[tuple[str, ...]] = ('isaaclab', 'mjcf', 'ros2-control', 'sdf', 'urdf', 'usd')
    axis: ClassVar[str] = 'speed'
    free_axis: ClassVar[str] = 'speed'
    one_power: ClassVar[bool] = True
    told_apart: ClassVar[Mapping[str, tuple[str, str]]] = {
        'thermal_drift': (
            'warm_up_repeat',
            'repeat the same speeds cold and warm: a wrong Coulomb friction is the same in both',
        )
    }

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Return s."""
        return (motion.sign[:, joint],)

    def applies(self, signals: Recording, joint: int) -> bool:
        """Tell whether the model has a Coulomb friction to be wrong."""
        return bool(np.isfinite(signals.scales.coulomb[joint]))

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if fit.signals.scales.coulomb[fit.joint] + fit.amplitude[0] < 0.0:
            return 'Coulomb friction would be negative'
        return ''
