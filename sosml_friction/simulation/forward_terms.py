# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The kinds of term that effects are made of."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from sosml_friction.model.dahl import dahl_path, dahl_step
from sosml_friction.simulation.forward_term import Body, FloatArray, ForwardTerm, Gear, Motion


class LoadTerm(ForwardTerm):
    """
    Take an effort in one joint that depends on the state alone.

    :param load: gives the effort (W,) [Nm or N] of a :class:`Motion`.
    :param level: the most that ``sign`` is multiplied with; of the effort, where it is a function.
    :param stiffness: the steepest slope over position.
    """

    def __init__(
        self,
        joint: int,
        load: Callable[[Motion], FloatArray],
        level: float | Callable[[float], float] = 0.0,
        stiffness: float = 0.0,
    ) -> None:
        self._joint = joint
        self._load = load
        self._level = level
        self._stiffness = abs(float(stiffness))

    def load(self, motion: Motion, state: FloatArray) -> FloatArray:
        """Return the effort that it takes."""
        result = np.zeros_like(motion.q)
        result[:, self._joint] = self._load(motion)
        return result

    def friction_level(self, effort: FloatArray) -> FloatArray:
        """Return the most it adds to the level of friction."""
        level = self._level
        size = level(float(effort[self._joint])) if callable(level) else level
        return _in_joint(self._joint, abs(float(size)), len(effort))

    def stiffness(self) -> float:
        """Return the steepest slope; it counts in every joint, which is on the safe side."""
        return self._stiffness


class BodyTerm(ForwardTerm):
    """Change the rigid bodies by a function."""

    def __init__(self, change: Callable[[Body], None]) -> None:
        self._change = change

    def change_body(self, body: Body) -> None:
        """Change inertias, rotors or gravity."""
        self._change(body)


class ReportTerm(ForwardTerm):
    """
    Report another effort than the torque: two functions of arrays (..., n), inverse of each other.

    :param reported: what is reported of a torque; ``torque`` its inverse.
    :param delay: how long after the torque it is reported [s].
    """

    def __init__(
        self,
        reported: Callable[[FloatArray], FloatArray],
        torque: Callable[[FloatArray], FloatArray],
        delay: float = 0.0,
    ) -> None:
        self._reported = reported
        self._torque = torque
        self.delay = delay

    def reported(self, torque: FloatArray) -> FloatArray:
        """Return what is reported."""
        return self._reported(torque)

    def torque(self, reported: FloatArray) -> FloatArray:
        """Return the torque behind a report."""
        return self._torque(reported)


class EncoderTerm(ForwardTerm):
    """Measure another position than that of the motor: true = measured + error(measured)."""

    def __init__(self, joint: int, error: Callable[[FloatArray], FloatArray]) -> None:
        self._joint = joint
        self._error = error

    def true_position(self, measured: FloatArray) -> FloatArray:
        """Return where the motor is."""
        result = np.array(measured)
        result[..., self._joint] += self._error(measured[..., self._joint])
        return result


class GearTerm(ForwardTerm):
    """Put the body of a joint behind a spring with a gap, the motor before it."""

    def __init__(self, gear: Gear) -> None:
        self._gear = gear

    def gear(self) -> Gear:
        """Return the gear."""
        return self._gear


class BuildUpTerm(ForwardTerm):
    """
    Let friction of ``level`` build up over ``displacement`` and not as the sign: level (z - s).

    z is a Dahl state of its own.
    """

    def __init__(self, joint: int, level: float, displacement: float) -> None:
        self._joint, self._level, self._displacement = joint, level, displacement

    def start(self, path: FloatArray, at: NDArray[np.int64]) -> FloatArray:
        """Return z, (W, 1), as the path left it."""
        z = dahl_path(np.ascontiguousarray(path[:, self._joint]), self._displacement)
        return z[at][:, None]

    def advance(self, state: FloatArray, dq: FloatArray) -> FloatArray:
        """Return z after a displacement."""
        return dahl_step(state, dq[:, self._joint, None], self._displacement)

    def load(self, motion: Motion, state: FloatArray) -> FloatArray:
        """Return level (z - s)."""
        result = np.zeros_like(motion.q)
        result[:, self._joint] = self._level * (state[:, 0] - motion.sign[:, self._joint])
        return result

    def friction_level(self, effort: FloatArray) -> FloatArray:
        """Return the level, which is taken off the sign."""
        return _in_joint(self._joint, abs(self._level), len(effort))

    def stiffness(self) -> float:
        """Return the slope of its own state, in every joint."""
        return abs(self._level) / self._displacement


def _in_joint(joint: int, value: float, n: int) -> FloatArray:
    result = np.zeros(n)
    result[joint] = value
    return result
