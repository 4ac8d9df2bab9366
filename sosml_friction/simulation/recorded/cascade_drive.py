# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The controllers of a recording, driving a simulation in their loop."""

from collections.abc import Mapping

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.simulation.forward_model import ForwardModel
from sosml_friction.simulation.recorded.controlled_joint import ControlledJoint
from sosml_friction.simulation.recorded.loop_drive import LoopDrive


class CascadeDrive(LoopDrive):
    """
    Drive one window by a :class:`CascadeController` for each joint, as in the recording.

    What was added to its output is added to its effort here.

    :param controlled: each joint of the model, its wanted position known throughout.
    :param q: position (n,) and v: velocity (n,) at the first sample.
    """

    def __init__(
        self,
        model: ForwardModel,
        controlled: Mapping[str, ControlledJoint],
        q: FloatArray,
        v: FloatArray,
        period: float,
    ) -> None:
        super().__init__(model, period)
        joints = [controlled[name] for name in model.robot.names]
        loops = [joint.controller for joint in joints]
        self._kp, self._kv, self._scale, self._limit = (
            np.array([getattr(loop, key) for loop in loops])
            for key in ('kp', 'kv', 'scale', 'limit')
        )
        self._reference = np.column_stack([joint.reference for joint in joints])
        self._injected = np.zeros_like(self._reference)
        for i, joint in enumerate(joints):
            if joint.injected is not None:
                self._injected[:, i] = np.nan_to_num(joint.injected)
        self._last = q - v * period
        self._last_mean = q - 1.5 * v * period

    def begin(self, k: int, q: FloatArray) -> None:
        """Compute the command of sample ``k``, which holds until the next."""
        super().begin(k, q)
        x = q[0]
        mean = 0.5 * (x + self._last)
        rate = (mean - self._last_mean) / self._period
        command = self._kp * self._kv * (self._reference[k] - x) - self._kv * rate
        self._last, self._last_mean = x, mean
        effort = self._scale * np.clip(command, -self._limit, self._limit)
        self.ask(float(k), effort + self._injected[k])

    def reported(self) -> FloatArray:
        """Return the efforts that were reported, (N, n), late where the model says so."""
        asked = np.array(self.commands)
        samples = np.arange(len(asked), dtype=np.float64)
        columns = zip(np.maximum(0.0, self._model.delay) / self._period, asked.T, strict=True)
        return np.column_stack([np.interp(samples - late, samples, x) for late, x in columns])
