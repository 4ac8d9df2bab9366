# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that falls from standstill: Stribeck."""

from collections.abc import Mapping
from typing import ClassVar

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.fading_term import FadingTerm
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.motion import Motion


class Stribeck(FadingTerm):
    """
    Add S s exp(-(|q'| / v_s)^d): breakaway is S above Coulomb friction.

    S = ``stribeck`` > 0, v_s = ``stribeck_velocity``, d = ``exponent``.
    """

    identifier: ClassVar[str] = 'stribeck'
    amplitudes: ClassVar[Mapping[str, str]] = {'stribeck': '{effort}'}
    of_law: ClassVar[bool] = True
    axis: ClassVar[str] = 'speed'
    free_axis: ClassVar[str] = 'speed'
    one_power: ClassVar[bool] = True
    told_apart: ClassVar[Mapping[str, tuple[str, str]]] = {
        'nonlinear_viscous': (
            '',
            'move up to twice as fast: far above its velocity Stribeck friction is gone, and the '
            'rest is a straight line of speed; a drag bends on',
        )
    }

    def at_standstill(self, motion: Motion, joint: int | slice, sign: FloatArray) -> FloatArray:
        """Return s."""
        return sign

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if fit.amplitude[0] <= 0.0:
            return 'friction would fall towards standstill'
        if fit.amplitude[0] > 2.0 * fit.signals.scales.level(fit.joint):
            return 'breakaway would be over three times Coulomb friction'
        return ''
