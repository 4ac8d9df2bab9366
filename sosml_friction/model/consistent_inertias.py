# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Inertias that bodies can have, for parameters that data only know in combinations."""

from collections.abc import Sequence

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.robot import Robot

#: Least eigenvalue that a repaired pseudo-inertia gets, in units of the body itself; for a thinner
#: nominal body, as a share of its own.
_THIN, _SHARE = 1e-4, 0.5
_MOST_STEPS = 5000
#: Singular values below this share of the largest belong to combinations that nothing feels.
_UNFELT = 1e-9
#: Weight of staying at the model's bodies, as a share of the best known direction's: it decides
#: what no motion feels.
_STAY = 1e-9
#: The bodies are found where a step moves them by less than this share of themselves.
_CLOSE = 1e-8


def pseudo_inertia(body: FloatArray) -> FloatArray:
    """
    Return [[S, h], [h', m]], (4, 4): S = tr(I) / 2 - I, h = m c, of ten numbers.

    A body of that mass distribution exists if and only if the matrix is positive semidefinite
    (Wensing, Kim, Slotine, IEEE RA-L 2018).

    :param body: m, m c (x, y, z), I (xx, xy, yy, xz, yz, zz) about the origin [kg, kg m, kg m2].
    """
    m, x, y, z, xx, xy, yy, xz, yz, zz = body
    half = 0.5 * (xx + yy + zz)
    return np.array(
        [
            [half - xx, -xy, -xz, x],
            [-xy, half - yy, -yz, y],
            [-xz, -yz, half - zz, z],
            [x, y, z, m],
        ]
    )


def body_numbers(matrix: FloatArray) -> FloatArray:
    """Return the ten numbers of a pseudo-inertia, the inverse of :func:`pseudo_inertia`."""
    S = matrix[:3, :3]
    tensor = np.trace(S) * np.eye(3) - S
    return np.concatenate(
        [[matrix[3, 3]], matrix[:3, 3], tensor[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]]
    )


def is_possible(body: FloatArray) -> bool:
    """Tell whether a body can have these ten numbers; nothing at all, ten zeros, can be."""
    if not body.any():
        return True
    matrix = pseudo_inertia(body)
    return bool(body[0] > 0.0 and np.linalg.eigvalsh(_scaled(matrix, _units(body)))[0] >= -1e-12)


def consistent_inertias(
    robot: Robot, bodies: FloatArray, rotors: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """
    Return bodies (n, 10) and rotors (n,) that can exist and need the same effort as the given.

    Bodies that can exist are returned as they are. Otherwise only combinations that no motion
    feels are changed: Dykstra's projections, in turn onto the bodies that can exist and onto those
    that need the same effort in every motion.

    :param robot: the nominal one, for its kinematics, gravity and the units of each body.
    :param bodies: ten numbers each (:meth:`Robot.inertial_parameters`).
    :param rotors: reflected inertias [kg m2 or kg].
    :raises ConfigurationError: if there are none, as part of a sentence.
    """
    if (rotors >= 0.0).all() and all(is_possible(body) for body in bodies):
        return bodies, rotors
    space = _Space(robot)
    x = space.enter(bodies, rotors)
    wanted = x.copy()
    correction = np.zeros_like(x)
    for _ in range(_MOST_STEPS):
        y = space.onto_possible(x + correction)
        correction = x + correction - y
        x = wanted + space.unfelt @ (space.unfelt.T @ (y - wanted))
        new_bodies, new_rotors = space.leave(x)
        # A rotor of zero is one that the projection met from below.
        new_rotors = np.where(np.abs(new_rotors) < 1e-12 * space.rotor_unit, 0.0, new_rotors)
        if (new_rotors >= 0.0).all() and all(is_possible(body) for body in new_bodies):
            return new_bodies, new_rotors
    raise ConfigurationError('no bodies of positive mass move so')


def nearest_bodies(
    robot: Robot,
    rigid: Sequence[int],
    x: FloatArray,
    precision: FloatArray,
    rotors: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """
    Return the most likely bodies (n, 10) and rotors (n,) that can exist, for an estimate.

    And how far their base parameters b are from those of the robot, (p,). They minimise
    (b - x)' A (b - x): a convex problem, by the alternating direction method of multipliers (Boyd
    et al., Foundations and Trends in Machine Learning 3, 2011, sections 3 and 3.4.1).

    :param rigid: which of the ten numbers per body and then the rotors are base parameters (p,).
    :param x: estimated deviations of these (p,).
    :param precision: A (p, p), the inverse of their covariance.
    :param rotors: reflected inertias (n,) beside the robot's bodies, where these are better known
        than its rotors: what no motion feels stays there; None for its own [kg m2 or kg].
    """
    space = _Space(robot)
    own = space.enter(robot.inertial_parameters(), np.array(robot.armature))
    start = own if rotors is None else space.enter(robot.inertial_parameters(), rotors)
    # What each direction of the space adds to the base parameters.
    base = np.linalg.lstsq(space.numbers_to_effort[:, list(rigid)], space.efforts, rcond=None)[0]
    H = base.T @ precision @ base
    b = H @ (space.columns.T @ own) + base.T @ precision @ x
    h, V = np.linalg.eigh(H)
    # Directions that no motion feels stay where they are.
    stay = _STAY * float(h[-1])
    h, b = np.maximum(h, 0.0) + stay, V.T @ (b + stay * (space.columns.T @ start))
    rho = float(np.sqrt(h[0] * h[-1]))
    possible = space.onto_possible(start)
    u = np.zeros_like(start)
    for _ in range(_MOST_STEPS):
        aim = V.T @ (space.columns.T @ (possible - u))
        best = space.columns @ (V @ ((b + rho * aim) / (h + rho)))
        before, possible = possible, space.onto_possible(best + u)
        u += best - possible
        apart = float(np.linalg.norm(best - possible))
        moved = rho * float(np.linalg.norm(possible - before))
        if max(apart, moved / rho) < _CLOSE * float(np.linalg.norm(possible)):
            break
        factor = (
            2.0 if apart > 10.0 * moved / h[-1] else 0.5 if 10.0 * apart < moved / h[-1] else 1.0
        )
        rho, u = rho * factor, u / factor
    return (*space.leave(possible), base @ (space.columns.T @ (possible - own)))


class _Space:
    """
    The inertias of a robot as one vector, in which each body's own size is 1.

    ``columns``: an orthonormal basis of the symmetric pseudo-inertias and the rotors; ``efforts``:
    what each needs at random states; ``numbers_to_effort``: what the ten numbers of each body and
    the rotors need there; ``unfelt``: an orthonormal basis of what changes no effort.
    """

    def __init__(self, robot: Robot) -> None:
        self._n = robot.n
        own = robot.inertial_parameters()
        self._units = [_units(body) for body in own]
        self._present = [bool(body.any()) for body in own]
        self._floors = np.zeros(robot.n)
        for i, (body, unit) in enumerate(zip(own, self._units, strict=True)):
            if self._present[i]:
                thinnest = float(np.linalg.eigvalsh(_scaled(pseudo_inertia(body), unit))[0])
                self._floors[i] = min(_THIN, max(_SHARE * thinnest, 0.0))
        self.rotor_unit = np.array([m * length**2 for length, m in self._units])
        self._span(robot)

    def enter(self, bodies: FloatArray, rotors: FloatArray) -> FloatArray:
        """Return the vector of bodies and rotors."""
        rows = [
            _scaled(pseudo_inertia(body), unit).ravel()
            for body, unit in zip(bodies, self._units, strict=True)
        ]
        return np.concatenate([*rows, rotors / self.rotor_unit])

    def leave(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the bodies and rotors of a vector."""
        bodies = np.array(
            [
                body_numbers(_unscaled(block.reshape(4, 4), unit))
                for block, unit in zip(x[: 16 * self._n].reshape(-1, 16), self._units, strict=True)
            ]
        )
        return bodies, x[16 * self._n :] * self.rotor_unit

    def onto_possible(self, x: FloatArray) -> FloatArray:
        """Return the nearest vector whose bodies and rotors can exist, with some room."""
        y = x.copy()
        for i in range(self._n):
            if not self._present[i]:
                continue
            block = x[16 * i : 16 * i + 16].reshape(4, 4)
            values, vectors = np.linalg.eigh(0.5 * (block + block.T))
            kept = np.maximum(values, self._floors[i])
            y[16 * i : 16 * i + 16] = ((vectors * kept) @ vectors.T).ravel()
        y[16 * self._n :] = np.maximum(x[16 * self._n :], 0.0)
        return y

    def _span(self, robot: Robot) -> None:
        n = self._n
        # The symmetric 4x4 matrices, the rotors, as columns of the ten numbers and rotors.
        entries = [k for k in range(n) if self._present[k]]
        columns, efforts = [], []
        rng = np.random.default_rng(0)
        states = rng.uniform(-2.0, 2.0, (20 * n, 3, n))
        Y = np.concatenate([robot.torque_regressor(*state) for state in states])
        A = np.concatenate([np.diag(state[2]) for state in states])
        for i in entries:
            for j in range(4):
                for k in range(j + 1):
                    matrix = np.zeros((4, 4))
                    matrix[j, k] = matrix[k, j] = 1.0 if j == k else np.sqrt(0.5)
                    column = np.zeros(17 * n)
                    column[16 * i : 16 * i + 16] = matrix.ravel()
                    columns.append(column)
                    numbers = body_numbers(_unscaled(matrix, self._units[i]))
                    efforts.append(Y[:, 10 * i : 10 * i + 10] @ numbers)
        for i in range(n):
            column = np.zeros(17 * n)
            column[16 * n + i] = 1.0
            columns.append(column)
            efforts.append(A[:, i] * self.rotor_unit[i])
        self.numbers_to_effort = np.concatenate([Y, A], axis=1)
        self.columns, self.efforts = np.column_stack(columns), np.column_stack(efforts)
        _, values, rows = np.linalg.svd(np.linalg.qr(self.efforts, mode='r'))
        rank = int(np.sum(values > _UNFELT * values[0]))
        self.unfelt = np.asarray(self.columns @ rows[rank:].T)


def _units(body: FloatArray) -> tuple[float, float]:
    """Return a length [m] and a mass [kg] that are those of a body; 0.1 and 1 of none."""
    if body[0] <= 0.0:
        return 0.1, 1.0
    spread = float(np.trace(pseudo_inertia(body)[:3, :3])) / float(body[0])
    return (np.sqrt(spread) if spread > 0.0 else 0.1), float(body[0])


def _scaled(matrix: FloatArray, unit: tuple[float, float]) -> FloatArray:
    length, mass = unit
    d = np.array([1.0 / length] * 3 + [1.0])
    return np.asarray(matrix * d * d[:, None] / mass)


def _unscaled(matrix: FloatArray, unit: tuple[float, float]) -> FloatArray:
    length, mass = unit
    d = np.array([length] * 3 + [1.0])
    return np.asarray(matrix * d * d[:, None] * mass)
