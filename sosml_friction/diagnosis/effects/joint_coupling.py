# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Torque of one joint in another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import Effect, FloatArray, Inner
from sosml_friction.diagnosis.fitted import Fitted
from sosml_friction.model.robot import Robot
from sosml_friction.regression.signals import Signals
from sosml_friction.simulation.forward_terms import ReportTerm


class JointCoupling(Effect):
    """
    Add c tau_other: a belt or cable passes on, or a sensor picks up, another joint's torque.

    ``source``: the other joint, counted from 0 in the model's order.
    """

    identifier: ClassVar[str] = 'joint_coupling'
    amplitudes: ClassVar[Mapping[str, str]] = {'coupling': '1'}
    inner: ClassVar[Mapping[str, str]] = {'source': 'joint'}

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return the other joint's nominal effort."""
        return signals.in_joint(joint, signals.torque[:, int(inner['source'])])

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> ReportTerm:
        """Return a report that has some of another joint's torque."""
        mix = np.eye(robot.n)
        mix[joint, int(inner['source'])] += amplitude[0]
        inverse = np.linalg.inv(mix)
        return ReportTerm(lambda torque: torque @ mix.T, lambda report: report @ inverse.T)

    def grid(self, signals: Signals, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        return [{'source': float(k)} for k in range(signals.robot.n) if k != joint]

    def applies(self, signals: Signals, joint: int) -> bool:
        """Tell whether there is another joint."""
        return signals.robot.n > 1

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if abs(fit.amplitude[0]) > 0.5:
            return 'more than half of the torque would pass over'
        return ''
