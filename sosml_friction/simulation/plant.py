# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The simulated joint: rigid body plus static friction."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.compiled import compiled
from sosml_friction.model.laws import FrictionLaw
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.fading_term import fade
from sosml_friction.simulation.integrator import runge_kutta_step

Drive = Callable[[FloatArray, FloatArray], FloatArray]


class Plant:
    """
    Integrate M q'' + C q' + g = tau - tau_f(q').

    Friction is a static function of velocity with a smooth sign, so there is no sticking, no
    presliding and no backlash: a joint at rest under a load creeps at up to its smoothing
    velocity.
    Stable while step < 2.78 M_eff v0 / C (the slope of the smooth sign).

    :param friction: one law per joint, or empty for a plant without friction.
    :param q: initial position (n,) [rad or m].
    :param v: initial velocity (n,) [rad/s or m/s].
    """

    def __init__(
        self, robot: Robot, friction: Sequence[FrictionLaw], q: FloatArray, v: FloatArray
    ) -> None:
        self.robot = robot
        self.friction = tuple(friction)
        self._table = friction_table(self.friction) if self.friction else None
        self.q = np.array(q, dtype=float)
        self.v = np.array(v, dtype=float)
        # Compile now: at the first step it would silence an emulator that a driver listens to.
        Plant.step(self, np.zeros(len(self.v)), 0.0)

    def friction_torque(self, v: FloatArray) -> FloatArray:
        """Return tau_f per joint, (n,) [Nm or N], positive for positive velocity."""
        if not self.friction:
            return np.zeros_like(v)
        if self._table is not None:
            return table_torque(self._table, v)
        return np.array([law.torque(x) for law, x in zip(self.friction, v, strict=True)])

    def step(self, tau: FloatArray | Drive, h: float) -> None:
        """Advance by ``h`` [s]; ``tau``: effort (n,) that is held, or a function of (q, v)."""
        self.q, self.v = runge_kutta_step(self._acceleration, tau, self.q, self.v, h)

    def _acceleration(
        self, tau: FloatArray | Drive, _: float, q: FloatArray, v: FloatArray
    ) -> FloatArray:
        effort = tau(q, v) if callable(tau) else tau
        return self.robot.acceleration(q, v, effort - self.friction_torque(v))


#: Amplitudes and inner parameters of the terms that the compiled friction has, by column; the
#: rest of a row is the width of the sign.
_COLUMNS = (
    'coulomb', 'viscous', 'stribeck', 'bias', 'viscous_asymmetry', 'stribeck_asymmetry',
    'stribeck_velocity', 'exponent',
)  # fmt: skip
_fade = compiled(fade)


def friction_table(laws: Sequence[FrictionLaw]) -> FloatArray | None:
    """Return the laws as rows of numbers, or None if one has a term that is not compiled."""
    rows = []
    for law in laws:
        values = {**law.definition.fixed, **law.parameters}
        if not set(values) <= set(_COLUMNS):
            return None
        row = [values.get(name, 0.0) for name in _COLUMNS[:6]]
        row += [values.get(name, 1.0) for name in _COLUMNS[6:]]
        rows.append([*row, law.smoothing_velocity])
    return np.array(rows, dtype=float).reshape(len(rows), len(_COLUMNS) + 1)


@compiled
def table_torque(table: FloatArray, v: FloatArray) -> FloatArray:
    """Return tau_f (n,) [Nm or N] at ``v``: the sum of the laws' terms, row by row."""
    tau = np.empty(len(v))
    for i in range(len(v)):
        x, v0 = v[i], table[i, 8]
        sign = math.tanh(x / v0) if v0 > 0.0 else np.sign(x)
        faded = _fade(x, table[i, 6], table[i, 7])
        level = table[i, 0] + table[i, 2] * faded
        even = table[i, 4] * abs(x) + table[i, 5] * abs(sign) * faded
        tau[i] = level * sign + table[i, 1] * x + table[i, 3] + even
    return tau
