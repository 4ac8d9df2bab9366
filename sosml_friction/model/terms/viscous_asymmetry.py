# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Viscous friction that differs between the directions, in a law."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.term import Inner


class ViscousAsymmetry(EffortTerm):
    """
    Add D |q'|: viscous friction is B + D forwards and B - D backwards.

    The part of :class:`~sosml_friction.model.terms.asymmetric_friction.AsymmetricFriction` that a
    law has beside its bias, which stands for the difference of the level.
    """

    identifier: ClassVar[str] = 'viscous_asymmetry'
    amplitudes: ClassVar[Mapping[str, str]] = {'viscous_asymmetry': '{effort} s/{length}'}
    searched: ClassVar[bool] = False
    of_law: ClassVar[bool] = True
    axis: ClassVar[str] = 'speed'
    inseparable: ClassVar[tuple[str, ...]] = ('asymmetric_friction',)

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Return |q'|."""
        return (np.abs(motion.v[:, joint]),)
