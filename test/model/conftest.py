# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The closed-form arm that the model tests believe, and generated serial arms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from sosml_friction.model.robot import Robot

REPOSITORY = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class PlanarArm:
    """Two uniform rods in a plane inclined by 20 degrees, written from Lagrange's equations."""

    rotor: tuple[float, float] = (0.0, 0.0)
    m1: float = 2.5
    l1: float = 0.30
    m2: float = 1.8
    l2: float = 0.27
    gravity_in_plane: float = 9.81 * float(np.cos(np.deg2rad(20.0)))

    def inertia(self, q: np.ndarray) -> np.ndarray:
        c1, c2 = self.l1 / 2, self.l2 / 2
        i1, i2 = self.m1 * self.l1**2 / 12, self.m2 * self.l2**2 / 12
        cross = self.m2 * (c2**2 + self.l1 * c2 * np.cos(q[1])) + i2
        m22 = i2 + self.m2 * c2**2
        m11 = (
            i1
            + self.m1 * c1**2
            + i2
            + self.m2 * (self.l1**2 + c2**2 + 2 * self.l1 * c2 * np.cos(q[1]))
        )
        return np.array([[m11 + self.rotor[0], cross], [cross, m22 + self.rotor[1]]])

    def coriolis(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        k = -self.m2 * self.l1 * self.l2 / 2 * np.sin(q[1])
        return np.array([[k * v[1], k * (v[0] + v[1])], [-k * v[0], 0.0]])

    def gravity(self, q: np.ndarray) -> np.ndarray:
        second = self.m2 * self.l2 / 2 * np.cos(q[0] + q[1])
        first = (self.m1 * self.l1 / 2 + self.m2 * self.l1) * np.cos(q[0]) + second
        return self.gravity_in_plane * np.array([first, second])

    def energy(self, q: np.ndarray, v: np.ndarray) -> float:
        height = (self.m1 * self.l1 / 2 + self.m2 * self.l1) * np.sin(
            q[0]
        ) + self.m2 * self.l2 / 2 * np.sin(q[0] + q[1])
        return float(0.5 * v @ self.inertia(q) @ v + self.gravity_in_plane * height)


@pytest.fixture(scope='session')
def planar_arm() -> type[PlanarArm]:
    return PlanarArm


@pytest.fixture(scope='session')
def exoskeleton_urdf() -> str:
    return (REPOSITORY / 'urdf/exoskeleton.urdf').read_text(encoding='utf-8')


@pytest.fixture(scope='session')
def emps_urdf() -> str:
    return (REPOSITORY / 'urdf/emps.urdf').read_text(encoding='utf-8')


def serial_arm(types: list[str], seed: int = 0) -> str:
    """Return the URDF of a serial arm of random axes, offsets and (valid) inertias."""
    rng = np.random.default_rng(seed)
    parts = ['<robot name="chain"><link name="l0"/>']
    for k, kind in enumerate(types, start=1):
        # The inertia of eight point masses is positive definite and obeys the triangle rule.
        points = rng.normal(scale=0.08, size=(8, 3))
        points -= points.mean(0)
        mass = rng.uniform(0.5, 3.0)
        tensor = mass / 8 * (np.sum(points**2) * np.eye(3) - points.T @ points)
        axis = rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        text = [' '.join(f'{x:.17g}' for x in rng.uniform(-0.3, 0.3, size=3)) for _ in range(3)]
        entries = zip(
            ('ixx', 'ixy', 'ixz', 'iyy', 'iyz', 'izz'), tensor[np.triu_indices(3)], strict=True
        )
        parts.append(
            f'<link name="l{k}"><inertial><origin xyz="{text[0]}"/><mass value="{mass:.17g}"/>'
            f'<inertia {" ".join(f"{name}={chr(34)}{x:.17g}{chr(34)}" for name, x in entries)}/>'
            f'</inertial></link><joint name="j{k}" type="{kind}"><parent link="l{k - 1}"/>'
            f'<child link="l{k}"/><origin xyz="{text[1]}" rpy="{text[2]}"/>'
            f'<axis xyz="{" ".join(f"{x:.17g}" for x in axis)}"/>'
            f'<limit lower="-{k}" upper="{k}" effort="{10 * k}" velocity="{2 * k}"/></joint>'
        )
    return ''.join(parts) + '</robot>'


@pytest.fixture(scope='session')
def make_serial_arm() -> Callable[..., str]:
    return serial_arm


@pytest.fixture(scope='session')
def seven_joints() -> Robot:
    """Return an arm of seven joints, one of them prismatic, with rotors."""
    urdf = serial_arm(['revolute'] * 5 + ['prismatic', 'revolute'])
    return Robot(urdf, [f'j{k}' for k in range(1, 8)], np.linspace(0.01, 0.07, 7))
