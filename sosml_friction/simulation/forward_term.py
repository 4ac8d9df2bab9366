# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One thing a simulated arm has beyond its rigid bodies and its friction law."""

from __future__ import annotations

from abc import ABC
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass
class Body:
    """
    Hold what the rigid bodies are made of, for terms to change in place.

    ``inertias`` (n, 10) as :meth:`~sosml_friction.model.robot.Robot.inertial_parameters`;
    ``rotors`` (n,) reflected inertia [kg m2 or kg]; ``gravity`` (3,) [m/s2].
    """

    inertias: FloatArray
    rotors: FloatArray
    gravity: FloatArray


@dataclass
class Motion:
    """
    Hold the state of W simulated windows at one instant, for terms to look at.

    ``time`` (W,) [s] as the recording counts it; ``q``, ``v`` (W, n) of the motors [rad or m];
    ``sign`` (W, n): the state of friction, -1..1; ``load`` (W, n): what the gear passes on, M q''
    + C q' + g [Nm or N]; ``warm`` (W, n): rise of temperature since the first sample [degC], NaN
    where it is not measured.
    """

    time: FloatArray
    q: FloatArray
    v: FloatArray
    sign: FloatArray
    load: FloatArray
    warm: FloatArray


@dataclass(frozen=True)
class Gear:
    """
    Hold a gear that gives: torque ``stiffness`` * (motor - body) outside of ``gap`` / 2.

    ``damping``: share of the critical damping of the body on it.
    """

    joint: int
    stiffness: float
    gap: float
    damping: float


class ForwardTerm(ABC):  # noqa: B024 - a term overrides what it has, and most have one thing
    """
    Say how one effect enters a simulation; what is not overridden is nothing.

    Signs as everywhere: :meth:`load` is effort that the actuator spends, so that it is positive
    where friction is. Effort is *reported* by the actuator's current and is a *torque* at the
    joint; a term may map one to the other, shift the report in time, or bend the measured
    position.
    """

    #: How long after the torque it is reported [s].
    delay: float = 0.0

    def change_body(self, body: Body) -> None:
        """Change inertias, rotors or gravity."""
        return

    def gear(self) -> Gear | None:
        """Return the gear that gives, or None."""
        return None

    def start(self, path: FloatArray, at: NDArray[np.int64]) -> FloatArray:
        """
        Return the states of one's own, (W, k), at the samples ``at`` of a measured path (N, n).

        The path is what happened before: a state that remembers has it from there.
        """
        return np.zeros((len(at), 0))

    def advance(self, state: FloatArray, dq: FloatArray) -> FloatArray:
        """Return the states after the motors moved by ``dq`` (W, n)."""
        return state

    def load(self, motion: Motion, state: FloatArray) -> FloatArray | None:
        """Return the effort that it takes, (W, n) [Nm or N], or None for none."""
        return None

    def torque(self, reported: FloatArray) -> FloatArray:
        """Return the torque at the joint behind a reported effort, (..., n)."""
        return reported

    def reported(self, torque: FloatArray) -> FloatArray:
        """Return what the actuator reports of a torque, (..., n): the inverse of the former."""
        return torque

    def true_position(self, measured: FloatArray) -> FloatArray:
        """Return where the motors are that the encoders say are at ``measured``, (..., n)."""
        return measured

    def friction_level(self, effort: FloatArray) -> FloatArray | float:
        """Return the most it adds to what ``sign`` is multiplied with, by joint (n,)."""
        return 0.0

    def stiffness(self) -> FloatArray | float:
        """Return the steepest slope of its load over position, by joint (n,)."""
        return 0.0
