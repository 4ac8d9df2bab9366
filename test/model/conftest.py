# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The closed-form arm that the model tests believe."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

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
