# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that differs between the directions."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner


class AsymmetricFriction(EffortTerm):
    """
    Add c_v |q'| + c_c |s|: slope and level forwards exceed those backwards by 2 c_v and 2 c_c.

    ``by_speed`` is 1, or 0 for a difference of the level alone, c_v = 0. While the joint moves,
    c_c |s| is constant, as a bias of effort is: only standstill, or a hold without torque,
    separates the two.
    """

    identifier: ClassVar[str] = 'asymmetric_friction'
    amplitudes: ClassVar[Mapping[str, str]] = {
        'viscous_asymmetry': '{effort} s/{length}',
        'coulomb_asymmetry': '{effort}',
    }
    inner: ClassVar[Mapping[str, str]] = {'by_speed': '1'}
    unspoken: ClassVar[tuple[str, ...]] = ('by_speed',)
    axis: ClassVar[str] = 'direction'
    aliases: ClassVar[tuple[str, ...]] = ('effort_bias',)

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Return |q'|, or nothing, and |s|."""
        speed = np.abs(motion.v[:, joint]) * (inner['by_speed'] != 0.0)
        return speed, np.abs(motion.sign[:, joint])

    def grid(self, signals: Recording, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        return ({'by_speed': 1.0}, {'by_speed': 0.0})

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        scales, (by_speed, constant) = fit.signals.scales, np.abs(fit.amplitude)
        top = float(scales.speed[fit.joint])
        viscous = np.nan_to_num(scales.viscous[fit.joint])
        friction = scales.level(fit.joint)
        # Beside a bias that nobody stated the constant is any number: their sum alone is known.
        is_told = np.isfinite(scales.bias[fit.joint])
        if by_speed * top > friction + viscous * top or (is_told and constant > friction):
            return 'one direction would have no friction left'
        return ''
