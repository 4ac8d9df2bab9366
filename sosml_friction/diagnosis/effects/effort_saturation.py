# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A torque constant that drops at high current."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import Effect, FloatArray, Inner
from sosml_friction.diagnosis.fitted import Fitted
from sosml_friction.model.robot import Robot
from sosml_friction.regression.signals import Signals
from sosml_friction.simulation.forward_terms import ReportTerm

#: Rounds of Newton's rule: the cube is less than half of the torque.
_ROUNDS = 8


class EffortSaturation(Effect):
    """
    Add excess * (tau / tau_99)^3: measured effort exceeds the torque by ``excess`` at tau_99.

    tau_99 = ``reference`` is what 99 % of the nominal effort stay below.
    """

    identifier: ClassVar[str] = 'effort_saturation'
    amplitudes: ClassVar[Mapping[str, str]] = {'excess': '{effort}'}
    inner: ClassVar[Mapping[str, str]] = {'reference': '{effort}'}

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return the cube of the effort."""
        return signals.in_joint(joint, (signals.torque[:, joint] / inner['reference']) ** 3)

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> ReportTerm:
        """Return a report of the torque and its cube; Newton's rule solves it for the torque."""
        gain, reference = float(amplitude[0]), inner['reference']

        def reported(torque: FloatArray) -> FloatArray:
            result = np.array(torque)
            result[..., joint] += gain * (torque[..., joint] / reference) ** 3
            return result

        def torque(report: FloatArray) -> FloatArray:
            result, wanted = np.array(report), report[..., joint]
            x = np.array(wanted)
            for _ in range(_ROUNDS):
                cube = gain * (x / reference) ** 3
                x = x - (x + cube - wanted) / (1.0 + 3.0 * gain * (x / reference) ** 2 / reference)
            result[..., joint] = x
            return result

        return ReportTerm(reported, torque)

    def grid(self, signals: Signals, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        reference = float(np.quantile(np.abs(signals.torque[:, joint]), 0.99))
        return ({'reference': max(reference, 1e-9)},)

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if not 0.0 < fit.amplitude[0] < 0.5 * fit.inner['reference']:
            return 'saturation makes the effort exceed the torque, by less than half'
        return ''
