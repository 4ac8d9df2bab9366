# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The shipped robots with friction that is known, exact motions, and recordings of both."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.model.model_folder import FrictionParameters, RobotModelFile, read_model
from sosml_friction.model.parameter import Parameter
from sosml_friction.share import share_directory

FloatArray = NDArray[np.float64]
#: Size [rad], angular frequency [rad/s] and phase of the sines of shoulder and elbow.
ARM_SINES = (((0.5, 0.9, 0.0), (0.1, 4.0, 1.0)), ((0.6, 1.3, 0.5), (0.1, 5.0, 2.0)))
ARM_CENTRE = (-0.8, 0.9)
#: Size [m] and angular frequency [rad/s].
SLIDER_SINES = ((0.08, 0.9), (0.02, 2.1))
SLIDER_MASS = 95.1089
SLIDER_STEP = 4e-3


def coulomb_viscous(
    coulomb: float, viscous: float, bias: float = 0.0, unit: str = 'Nm', speed: str = 'rad'
) -> FrictionParameters:
    """Return the law with a sign that jumps."""
    parameters = {
        'coulomb': Parameter(coulomb, unit),
        'viscous': Parameter(viscous, f'{unit} s/{speed}'),
        'bias': Parameter(bias, unit),
    }
    return FrictionParameters('coulomb_viscous', 0.0, parameters)


def slider_model(
    coulomb: float = 20.3, viscous: float = 196.0, bias: float = 0.0
) -> RobotModelFile:
    """Return the EMPS axis with this friction [N, N s/m, N]."""
    model = read_model(share_directory() / 'config/emps')
    friction = coulomb_viscous(coulomb, viscous, bias, 'N', 'm')
    return replace(model, joints={'slider': replace(model.joints['slider'], friction=friction)})


def arm_model(
    shoulder: tuple[float, float] = (0.5, 0.2), elbow: tuple[float, float] = (0.5, 0.2)
) -> RobotModelFile:
    """Return the exoskeleton with Coulomb [Nm] and viscous [Nm s/rad] friction of each joint."""
    model = read_model(share_directory() / 'config/exoskeleton')
    joints = {
        name: replace(model.joints[name], friction=coulomb_viscous(*friction))
        for name, friction in (('shoulder', shoulder), ('elbow', elbow))
    }
    return replace(model, joints=joints)


def sines(t: FloatArray, lines: Sequence[Sequence[float]]) -> FloatArray:
    """Return position, velocity and acceleration (3, N) of lines of size, frequency, phase."""
    q, v, a = np.zeros((3, len(t)))
    for size, w, *phase in lines:
        angle = w * t + sum(phase)
        q += size * np.sin(angle)
        v += size * w * np.cos(angle)
        a -= size * w**2 * np.sin(angle)
    return np.stack([q, v, a])


def arm_motion(
    t: FloatArray, joints: Sequence[Sequence[Sequence[float]]] = ARM_SINES
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return position, velocity and acceleration (N, 2) about the arm's centre."""
    q, v, a = np.stack([sines(t, lines) for lines in joints], axis=-1)
    return q + np.array(ARM_CENTRE), v, a


def rigid_effort(model: RobotModelFile, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
    """Return M q'' + C q' + g (N, n) of the model."""
    robot = model.make_robot()
    return np.array([robot.inverse_dynamics(*x) for x in zip(q, v, a, strict=True)])


def recording(
    names: Sequence[str],
    t: FloatArray,
    q: FloatArray,
    tau: FloatArray,
    v: FloatArray | None = None,
) -> JointLog:
    """Return the log of (N, n), or of (N,) for one joint; without ``v`` velocity is not known."""
    q, tau = (x.reshape(len(t), -1) for x in (q, tau))
    t_ns = np.rint(t * 1e9).astype(np.int64)
    return JointLog(tuple(names), t_ns, q, np.full_like(q, np.nan) if v is None else v, tau)


def smooth_sign(q: FloatArray, v: FloatArray) -> FloatArray:
    """Return a sign that takes some samples: one that jumps is not what its samples say."""
    return np.tanh(v / 2e-3)


def slider_recording(
    extra: Callable[[FloatArray], FloatArray] = np.zeros_like,
    duration: float = 28.0,
    seed: int = 0,
    sign: Callable[[FloatArray, FloatArray], FloatArray] = smooth_sign,
) -> JointLog:
    """
    Return the slider along its sines, with 1 N of noise in its effort.

    Its friction is 20 sign(q, v) + 200 v + extra(v) [N].
    """
    t = np.arange(0.0, duration, SLIDER_STEP)
    q, v, a = sines(t, SLIDER_SINES)
    tau = SLIDER_MASS * a + 20.0 * sign(q, v) + 200.0 * v + extra(v)
    tau += np.random.default_rng(seed).normal(0.0, 1.0, len(t))
    return recording(('slider',), t, q, tau)
