# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A Stribeck term that differs between the directions, in a law."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner
from sosml_friction.model.terms.stribeck import Stribeck, fade


class StribeckAsymmetry(EffortTerm):
    """Add D |s| exp(-(|q'| / v_s)^d): S + D forwards and S - D backwards, beside ``stribeck``."""

    identifier: ClassVar[str] = 'stribeck_asymmetry'
    amplitudes: ClassVar[Mapping[str, str]] = {'stribeck_asymmetry': '{effort}'}
    inner: ClassVar[Mapping[str, str]] = Stribeck.inner
    refined: ClassVar[tuple[str, ...]] = Stribeck.refined
    searched: ClassVar[bool] = False
    of_law: ClassVar[bool] = True
    axis: ClassVar[str] = 'speed'

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Return |s| exp(-(|q'| / v_s)^d)."""
        own = fade(motion.v[:, joint], inner['stribeck_velocity'], inner['exponent'])
        return (np.abs(motion.sign[:, joint]) * own,)

    def grid(self, signals: Recording, joint: int) -> Sequence[Inner]:
        """Return the values to try: those of the Stribeck term."""
        return Stribeck().grid(signals, joint)

    def inner_bounds(self, signals: Recording, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the physical range: that of the Stribeck term."""
        return Stribeck().inner_bounds(signals, joint)
