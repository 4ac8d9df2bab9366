# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction that differs between the directions."""

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


class AsymmetricFriction(Effect):
    """
    Add c_v |q'| + c_c |s|: slope and level forwards exceed those backwards by 2 c_v and 2 c_c.

    ``by_speed`` is 1, or 0 for a difference of the level alone, c_v = 0. While the joint moves
    the level's part is a constant, as a bias of effort is: only a hold without torque, or rest,
    tells the two apart.
    """

    identifier: ClassVar[str] = 'asymmetric_friction'
    amplitudes: ClassVar[Mapping[str, str]] = {
        'viscous_asymmetry': '{effort} s/{length}',
        'coulomb_asymmetry': '{effort}',
    }
    inner: ClassVar[Mapping[str, str]] = {'by_speed': '1'}
    twins: ClassVar[tuple[str, ...]] = ('effort_bias',)

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return |q'| and |s|."""
        constant = np.abs(signals.sign[:, joint])
        speed = np.abs(signals.v[:, joint])
        if inner['by_speed'] == 0.0:
            speed = np.zeros_like(speed)
        return signals.in_joint(joint, speed, constant)

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> LoadTerm:
        """Return c_v |q'| + c_c |s|."""
        by_speed = float(amplitude[0]) if inner['by_speed'] else 0.0
        constant = float(amplitude[1])

        def load(motion: Motion) -> FloatArray:
            speed, sign = np.abs(motion.v[:, joint]), np.abs(motion.sign[:, joint])
            return np.asarray(by_speed * speed + constant * sign)

        return LoadTerm(joint, load, constant)

    def grid(self, signals: Signals, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        return ({'by_speed': 1.0}, {'by_speed': 0.0})

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        scales, (by_speed, constant) = fit.signals.scales, np.abs(fit.amplitude)
        top = float(scales.speed[fit.joint])
        viscous = np.nan_to_num(scales.viscous[fit.joint])
        friction = scales.level(fit.joint)
        if by_speed * top > friction + viscous * top or constant > friction:
            return 'one direction would have no friction left'
        return ''
