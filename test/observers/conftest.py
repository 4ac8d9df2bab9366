# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Robots and recordings with exactly known friction."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.model.friction_laws import make_friction_law
from sosml_friction.model.robot import Robot
from sosml_friction.observers.momentum_samples import MomentumSamples
from sosml_friction.simulation.plant import Plant

REPOSITORY = Path(__file__).resolve().parents[2]
JOINTS = ('shoulder', 'elbow')
#: The set-up of the observer study, section 0.
ROTOR = (0.012, 0.004)
TRUTH = (
    {'coulomb': 0.80, 'viscous': 0.35, 'stribeck': 0.50, 'stribeck_velocity': 0.03, 'bias': 0.0},
    {'coulomb': 0.40, 'viscous': 0.20, 'stribeck': 0.25, 'stribeck_velocity': 0.03, 'bias': 0.0},
)
POSTURE = np.deg2rad([-50.0, 65.0])


@pytest.fixture(scope='session')
def two_joints() -> Robot:
    urdf = (REPOSITORY / 'urdf/exoskeleton.urdf').read_text(encoding='utf-8')
    return Robot(urdf, JOINTS, ROTOR)


@pytest.fixture(scope='session')
def slider() -> Robot:
    """One axis of 95.1089 kg without gravity: p = m v."""
    urdf = (REPOSITORY / 'urdf/emps.urdf').read_text(encoding='utf-8')
    return Robot(urdf, ['slider'], [0.0])


def simulate(
    robot: Robot, reference: Callable[[float], tuple[np.ndarray, ...]], duration: float
) -> tuple[JointLog, np.ndarray]:
    """Return exact signals at 1 kHz under computed torque + PD (60 rad/s), and the friction."""
    plant = Plant(
        robot, [make_friction_law('stribeck', p, 0.005) for p in TRUTH], *reference(0.0)[:2]
    )
    rows = []
    for k in range(round(duration * 1000)):
        q, v = plant.q.copy(), plant.v.copy()
        q_r, v_r, a_r = reference(k * 1e-3)
        a = a_r + 120.0 * (v_r - v) + 3600.0 * (q_r - q)
        tau = robot.inertia(q) @ a + robot.coriolis(q, v) @ v + robot.gravity(q)
        rows.append((q, v, tau, plant.friction_torque(v)))
        for _ in range(5):
            plant.step(tau, 2e-4)
    q, v, tau, friction = np.array(rows).transpose(1, 0, 2)
    t_ns = np.arange(len(q), dtype=np.int64) * 1_000_000
    return JointLog(JOINTS, t_ns, q, v, tau), friction


def reversal(t: float) -> tuple[np.ndarray, ...]:
    """Return 0.35 rad at 0.5 Hz of joint 1, joint 2 held."""
    w = np.pi
    return (
        POSTURE + np.array([0.35 * np.sin(w * t), 0.0]),
        np.array([0.35 * w * np.cos(w * t), 0.0]),
        np.array([-0.35 * w * w * np.sin(w * t), 0.0]),
    )


def slow(t: float) -> tuple[np.ndarray, ...]:
    """Return +-0.052 rad/s of joint 1, 3 s each way, with quintic turns of 3 s between."""
    phase = (t + 1.5) % 12.0
    sign, u = (1.0 if phase < 6.0 else -1.0), min(phase % 6.0 / 3.0, 1.0)
    shape, slope = u**3 * (10 - 15 * u + 6 * u**2), 30 * u**2 * (1 - u) ** 2 / 3.0
    way = 3.0 * u**4 * (2.5 - 3 * u + u**2) + (phase % 6.0 - 3.0 if phase % 6.0 > 3.0 else 0.0)
    q = sign * 0.052 * (2 * way - phase % 6.0) + (0.0 if sign > 0 else 0.156)
    v = sign * 0.052 * (2 * shape - 1.0)
    return (
        POSTURE + np.array([q, 0.0]),
        np.array([v, 0.0]),
        np.array([sign * 0.104 * slope if u < 1.0 else 0.0, 0.0]),
    )


@pytest.fixture(scope='session')
def drive() -> Callable[..., np.ndarray]:
    """
    Start an observer and run it over momenta, (N, n) or (N,) for one joint.

    Row 0 of ``p`` is the start; ``forcing`` and ``h`` (or one number) are of the intervals that
    end at the others. M is 1 and the integral of p that of the trapezoid, unless given.
    """

    def run(observer, p, forcing, h, integral=None, inertia=None):
        column = np.ndim(p) == 1
        p, forcing = (x[:, None] if column else x for x in (np.asarray(p), np.asarray(forcing)))
        count, n = p.shape
        h = np.broadcast_to(np.asarray(h, dtype=float), count)[1:].copy()
        if integral is None:
            integral = 0.5 * h[:, None] * (p[1:] + p[:-1])
        elif column:
            integral = integral[1:, None]
        else:
            integral = integral[1:]
        if inertia is None:
            inertia = np.broadcast_to(np.eye(n), (count - 1, n, n)).copy()
        observer.start(p[0])
        estimate = observer.run(MomentumSamples(h, p[1:], integral, forcing[1:], inertia))
        return estimate[:, 0] if column else estimate

    return run


@pytest.fixture(scope='session')
def reversal_run(two_joints: Robot) -> tuple[JointLog, np.ndarray]:
    return simulate(two_joints, reversal, 6.0)


@pytest.fixture(scope='session')
def slow_run(two_joints: Robot) -> tuple[JointLog, np.ndarray]:
    return simulate(two_joints, slow, 11.9)
