# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Columns of a recording that stand for one another's joint."""

from itertools import combinations

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.identification.joint_relations import (
    FEWEST_ROWS,
    ROWS,
    WELL,
    Slopes,
    mean_over,
)
from sosml_friction.model.robot import Robot
from sosml_friction.regression.column_norms import column_norms


def swapped_joints(log: JointLog, robot: Robot, slopes: Slopes) -> str | None:
    """
    Return that two joints have one another's position, effort, or both; None where none do.

    The bodies of the URDF, an inertia and the simplest friction of a joint leave a share of an
    effort. Of two joints that are swapped both shares are less where the columns are exchanged,
    by half in the geometric mean, and neither is all of it. Currents are swapped before each has a
    torque constant: then the efforts are those of the other joint times r and 1 / r.
    """
    moves = [i for i in range(robot.n) if np.ptp(np.nan_to_num(log.tau[:, i])) > 0.0]
    tau, sign = (_means(_means(x, slopes.half), slopes.half) for x in (log.tau, np.sign(slopes.v)))
    slow = _means(slopes.v, slopes.half)
    known = np.isfinite(slopes.a).all(axis=1) & np.isfinite(sign).all(axis=1)
    rows = np.flatnonzero(known & np.isfinite(tau[:, moves]).all(axis=1))
    rows = rows[:: max(1, len(rows) // ROWS)]
    if len(moves) < 2 or len(rows) < FEWEST_ROWS:
        return None
    tau, sign, slow, q, v, a = (x[rows] for x in (tau, sign, slow, log.q, slopes.v, slopes.a))

    def need(order: list[int]) -> FloatArray:
        """Return the effort of the bodies (R, n) where the joints move as ``order`` says."""
        states = zip(q[:, order], v[:, order], a[:, order], strict=True)
        return np.array([robot.inverse_dynamics(*state) for state in states])

    def left(effort: int, moved: int, bodies: FloatArray) -> float:
        """Return what bodies and friction by one joint's motion leave of an effort, a share."""
        return fitted(effort, moved, tau[:, effort] - bodies)[0]

    def fitted(effort: int, moved: int, y: FloatArray, *more: FloatArray) -> tuple[float, float]:
        """Return what such friction leaves of y, a share of an effort, and the last factor."""
        X = np.column_stack(
            [a[:, moved], sign[:, moved], slow[:, moved], np.ones(len(rows)), *more]
        )
        norms = column_norms(X)
        x = np.linalg.lstsq(X / norms, y, rcond=1e-9)[0] / norms
        size = np.linalg.norm(tau[:, effort] - tau[:, effort].mean())
        return float(np.linalg.norm(y - X @ x) / size), float(x[-1])

    same = list(range(robot.n))
    own = need(same)
    as_it_is = {i: left(i, i, own[:, i]) for i in moves}
    scaled = {i: fitted(i, i, tau[:, i], own[:, i])[0] for i in moves}
    found = []
    for i, j in combinations(moves, 2):
        if robot.effort_units[i] != robot.effort_units[j]:
            continue
        other = need([j if k == i else i if k == j else k for k in same])
        # What the efforts of both leave, each by the motion and the bodies it would be of.
        for what, its, others in (
            ('efforts', left(i, j, own[:, j]), left(j, i, own[:, i])),
            ('positions', left(i, j, other[:, i]), left(j, i, other[:, j])),
            ('columns', left(i, i, other[:, j]), left(j, j, other[:, i])),
        ):
            if its < min(as_it_is[i], 1.0) and others < min(as_it_is[j], 1.0):
                share = np.sqrt(its * others / (as_it_is[i] * as_it_is[j]))
                found.append((share, what, i, j, its, others))
        (its, r), (others, s) = (
            fitted(k, moved, tau[:, k], own[:, moved]) for k, moved in ((i, j), (j, i))
        )
        # As well as all else is known.
        inverse = r > 0.0 and WELL < r * s < 1.0 / WELL
        if inverse and its < min(scaled[i], 1.0) and others < min(scaled[j], 1.0):
            share = np.sqrt(its * others / (scaled[i] * scaled[j]))
            found.append((share, 'currents', i, j, its, others))
    share, what, i, j, its, others = min(found, default=(np.inf, '', 0, 0, 0.0, 0.0))
    if not share < WELL:
        return None
    now, then = (
        f'{100 * x:.2g} and {100 * y:.2g} %'
        for x, y in ((as_it_is[i], as_it_is[j]), (its, others))
    )
    return (
        f'the {what} of joints {robot.names[i]} and {robot.names[j]} seem to be swapped: '
        f'exchanged, the bodies of their URDF and friction leave {then} of their efforts '
        f'unexplained, and {now} as they are; exchange them in the mapping or the options, or '
        'correct the order in the driver'
    )


def _means(x: FloatArray, half: int) -> FloatArray:
    """Return the mean over a window of each column."""
    return np.column_stack([mean_over(each, half) for each in x.T])
