# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A Stribeck term that grows with load."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner
from sosml_friction.model.terms.stribeck import Stribeck, fade


class LoadDependentStribeck(EffortTerm):
    """Add k_s |tau_load| s exp(-(|q'| / v_s)^d), tau_load what the gear passes on."""

    identifier: ClassVar[str] = 'load_dependent_stribeck'
    amplitudes: ClassVar[Mapping[str, str]] = {'load_stribeck_coefficient': '1'}
    inner: ClassVar[Mapping[str, str]] = Stribeck.inner
    refined: ClassVar[tuple[str, ...]] = Stribeck.refined
    axis: ClassVar[str] = 'load'
    searched: ClassVar[bool] = False

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Return |tau_load| s exp(-(|q'| / v_s)^d)."""
        own = fade(motion.v[:, joint], inner['stribeck_velocity'], inner['exponent'])
        return (np.abs(motion.load[:, joint]) * motion.sign[:, joint] * own,)

    def grid(self, signals: Recording, joint: int) -> Sequence[Inner]:
        """Return the values to try: those of the Stribeck term."""
        return Stribeck().grid(signals, joint)

    def inner_bounds(self, signals: Recording, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the physical range: that of the Stribeck term."""
        return Stribeck().inner_bounds(signals, joint)

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if not 0.0 < fit.amplitude[0] < 0.5:
            return 'a gear loses between nothing and half of its load'
        return ''
