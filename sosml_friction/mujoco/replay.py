# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A recording repeated in MuJoCo: the effort of its motion, and the motion of its effort."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.mujoco.engine import engine, joint_id
from sosml_friction.mujoco.friction import Friction, ripple_actuators


class Replay:
    """
    Hold an MjModel for a recording: the joints that were recorded move, all others are held.

    :param model: MjModel; its actuators are switched off but for ripple, its contacts and
        limits stay.
    :param joints: the recorded ones, in the order of the arrays.
    :param locked: positions of others [rad or m]; the rest is held where the MJCF has it.
    :param friction: of the module; None: what the MjModel has.
    """

    def __init__(
        self,
        model: Any,
        joints: tuple[str, ...],
        locked: Mapping[str, float],
        friction: Friction | None = None,
    ) -> None:
        mujoco = engine()
        self.model, self.data, self.friction = model, mujoco.MjData(model), friction
        ids = [joint_id(model, name) for name in joints]
        self._dof, self._q = model.jnt_dofadr[ids], model.jnt_qposadr[ids]
        self._held = model.qpos0.copy()
        for name, position in locked.items():
            j = joint_id(model, name)
            if j >= 0:
                self._held[model.jnt_qposadr[j]] = position
        ripples = ripple_actuators(model)
        others = [k for k in range(len(model.actuator_trnid)) if k not in ripples]
        model.actuator_gear[others] = 0.0
        if friction is not None and friction.content.joint_names != joints:
            raise ConfigurationError('the friction is not of the recorded joints in their order')

    def _put(self, q: FloatArray, v: FloatArray) -> None:
        data = self.data
        data.qpos[:] = self._held
        data.qvel[:] = 0.0
        data.qpos[self._q], data.qvel[self._dof] = q, v

    def effort(self, time: FloatArray, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
        """Return the effort (N, n) that a motion (N, n) takes, by inverse dynamics."""
        mujoco, m, d = engine(), self.model, self.data
        result = np.empty_like(q)
        mujoco.mj_resetData(m, d)
        for k in range(len(q)):
            self._put(q[k], v[k])
            d.time = time[k]
            d.qacc[:] = 0.0
            d.qacc[self._dof] = a[k]
            mujoco.mj_fwdPosition(m, d)
            mujoco.mj_fwdVelocity(m, d)
            mujoco.mj_fwdActuation(m, d)
            applied = d.qfrc_actuator[self._dof].copy()
            if self.friction is not None:
                self.friction.apply(m, d)
                applied += d.qfrc_applied[self._dof]
            # The rows of the friction constraint have the level of this sample.
            mujoco.mj_inverse(m, d)
            result[k] = d.qfrc_inverse[self._dof] - applied
        if self.friction is None:
            return result
        reported, delay = self.friction.reports(result), self.friction.delay
        columns = zip(delay, reported.T, strict=True)
        return np.column_stack([np.interp(time - late, time, x) for late, x in columns])

    def motion(
        self, q: FloatArray, v: FloatArray, time: FloatArray, reported: FloatArray
    ) -> FloatArray:
        """
        Return the positions (N, n) from a state (n,) under a reported effort (N, n), held each.

        :param time: of the samples, evenly (N,) [s].
        """
        mujoco, m, d = engine(), self.model, self.data
        torque = reported if self.friction is None else self.friction.torques(reported)
        period = float(time[1] - time[0])
        many = max(1, int(np.ceil(period / m.opt.timestep - 1e-9)))
        kept = m.opt.timestep
        m.opt.timestep = period / many
        mujoco.mj_resetData(m, d)
        d.time = time[0]
        self._put(q, v)
        mujoco.mj_forward(m, d)
        result = np.empty_like(reported)
        for k in range(len(reported)):
            result[k] = d.qpos[self._q]
            for _ in range(many):
                self._put(d.qpos[self._q].copy(), d.qvel[self._dof].copy())
                d.qfrc_applied[:] = 0.0
                if self.friction is not None:
                    self.friction.apply(m, d)
                d.qfrc_applied[self._dof] += torque[k]
                mujoco.mj_step(m, d)
        m.opt.timestep = kept
        return result
