# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Torque of one joint in the report of another."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.measurement_term import MeasurementTerm
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner


class JointCoupling(MeasurementTerm):
    """
    Add c tau_other: a belt or cable passes on, or a sensor picks up, another joint's torque.

    ``source``: the other joint, counted from 0 in the model's order. A regression has its torque
    as measured: what the model lacks of it, and what holds it at rest, is passed on as well. Noise
    of a share e in it makes c smaller by e^2. Where it was not measured it is the model's.
    """

    identifier: ClassVar[str] = 'joint_coupling'
    amplitudes: ClassVar[Mapping[str, str]] = {'coupling': '1'}
    inner: ClassVar[Mapping[str, str]] = {'source': 'joint'}

    def excess(
        self, torque: NDArray[np.inexact], joint: int | slice, inner: Inner
    ) -> tuple[NDArray[np.inexact], ...]:
        """Return the other joint's torque."""
        return (torque[..., int(inner['source'])],)

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return the other joint's effort as it was measured, or as the model has it."""
        source = int(inner['source'])
        torque = signals.whole_torque if source in signals.silent else signals.tau
        return signals.in_joint(joint, torque[:, source])

    def not_undone(self, n: int, joint: int, inner: Inner, amplitude: FloatArray) -> bool:
        """Tell whether there is no other joint of that number."""
        source = inner['source']
        return source not in range(n) or int(source) == joint

    def grid(self, signals: Recording, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        return [{'source': float(k)} for k in range(signals.robot.n) if k != joint]

    def applies(self, signals: Recording, joint: int) -> bool:
        """Tell whether there is another joint."""
        return signals.robot.n > 1

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        if abs(fit.amplitude[0]) > 0.5:
            return 'more than half of the torque would pass over'
        return ''
