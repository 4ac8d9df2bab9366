# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that is larger near standstill."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import Effect, FloatArray, Inner
from sosml_friction.diagnosis.fitted import Fitted
from sosml_friction.model.robot import Robot
from sosml_friction.regression.signals import Signals
from sosml_friction.simulation.forward_term import Motion
from sosml_friction.simulation.forward_terms import LoadTerm


class Stribeck(Effect):
    """
    Add S s exp(-(|q'| / v_s)^d): breakaway is S above Coulomb friction.

    S = ``stribeck`` > 0, v_s = ``stribeck_velocity``, d = ``exponent``.
    """

    identifier: ClassVar[str] = 'stribeck'
    amplitudes: ClassVar[Mapping[str, str]] = {'stribeck': '{effort}'}
    inner: ClassVar[Mapping[str, str]] = {'stribeck_velocity': '{length}/s', 'exponent': '1'}
    refined: ClassVar[tuple[str, ...]] = ('stribeck_velocity', 'exponent')

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return s exp(-(|q'| / v_s)^d)."""
        v = np.abs(signals.v[:, joint]) / inner['stribeck_velocity']
        return signals.in_joint(joint, signals.sign[:, joint] * np.exp(-(v ** inner['exponent'])))

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> LoadTerm:
        """Return S s exp(-(|q'| / v_s)^d)."""
        size, v_s, d = float(amplitude[0]), inner['stribeck_velocity'], inner['exponent']

        def load(motion: Motion) -> FloatArray:
            fade = np.exp(-((np.abs(motion.v[:, joint]) / v_s) ** d))
            return np.asarray(size * motion.sign[:, joint] * fade)

        return LoadTerm(joint, load, size)

    def grid(self, signals: Signals, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        speeds = signals.scales.speed[joint] * np.geomspace(0.01, 0.25, 7)
        return [{'stribeck_velocity': float(v), 'exponent': 1.0} for v in speeds]

    def inner_bounds(self, signals: Signals, joint: int) -> Mapping[str, tuple[float, float]]:
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
