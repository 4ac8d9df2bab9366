# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that falls from standstill: Stribeck."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner


def fade(
    v: FloatArray | float, stribeck_velocity: FloatArray | float, exponent: FloatArray | float
) -> FloatArray:
    """
    Return exp(-(|v| / v_s)^d): the one place where this is written.

    Of numbers or arrays that broadcast, all dimensions [rad/s or m/s] but for d; plain enough to
    be compiled where a loop needs it.
    """
    result: FloatArray = np.exp(-((np.abs(v) / stribeck_velocity) ** exponent))
    return result


class Stribeck(EffortTerm):
    """
    Add S s exp(-(|q'| / v_s)^d): breakaway is S above Coulomb friction.

    S = ``stribeck`` > 0, v_s = ``stribeck_velocity``, d = ``exponent``.
    """

    identifier: ClassVar[str] = 'stribeck'
    amplitudes: ClassVar[Mapping[str, str]] = {'stribeck': '{effort}'}
    inner: ClassVar[Mapping[str, str]] = {'stribeck_velocity': '{length}/s', 'exponent': '1'}
    refined: ClassVar[tuple[str, ...]] = ('stribeck_velocity', 'exponent')
    of_law: ClassVar[bool] = True
    axis: ClassVar[str] = 'speed'
    free_axis: ClassVar[str] = 'speed'
    one_power: ClassVar[bool] = True

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Return s exp(-(|q'| / v_s)^d)."""
        own = fade(motion.v[:, joint], inner['stribeck_velocity'], inner['exponent'])
        return (motion.sign[:, joint] * own,)

    def grid(self, signals: Recording, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        speeds = signals.scales.speed[joint] * np.geomspace(0.01, 0.25, 7)
        return [{'stribeck_velocity': float(v), 'exponent': 1.0} for v in speeds]

    def inner_bounds(self, signals: Recording, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the physical range."""
        top = float(signals.scales.speed[joint])
        return {'stribeck_velocity': (0.005 * top, 0.4 * top), 'exponent': (0.5, 2.5)}

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if fit.amplitude[0] <= 0.0:
            return 'friction would fall towards standstill'
        if fit.amplitude[0] > 2.0 * fit.signals.scales.level(fit.joint):
            return 'breakaway would be over three times Coulomb friction'
        return ''
