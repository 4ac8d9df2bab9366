# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What repeats with position in what a model leaves."""

from typing import NamedTuple

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.diagnosis.decision.tone import BETWEEN_LINES
from sosml_friction.diagnosis.residual.joint_residual import JointResidual
from sosml_friction.model.terms.cogging import lines
from sosml_friction.model.terms.kinds.term import TERMS
from sosml_friction.regression.kernels import POINTS_AT_ONCE, squares

#: One turn [rad].
_TURN = 2.0 * np.pi
#: Most lines of a joint, both ways: those of a minute take half a second.
_MOST = 800
#: At this share of the speed a line still has to be within the band.
_SLOW = 0.04
#: Fewer samples in one direction are no spectrum.
_FEWEST = 200


def repeats_with_position(name: str) -> bool:
    """Tell whether the ``frequency`` of a cause is a line in position: its term says so."""
    return name in TERMS.classes and TERMS[name].repeats


class Lines(NamedTuple):
    """
    Hold the lines in position of one joint, (count,) each.

    ``periods``: to a turn or a metre; ``forwards`` and ``backwards``: the sizes before and after
    [Nm or N]; ``named``: the periods of the causes that were named.
    """

    periods: FloatArray
    forwards: tuple[FloatArray, FloatArray]
    backwards: tuple[FloatArray, FloatArray]
    named: tuple[float, ...]


def moves_enough(joint: JointResidual) -> bool:
    """Tell whether a joint moves far enough, in both directions, to have lines."""
    return bool(
        np.ptp(joint.axes['q']) > 0.0
        and _speed(joint) > 0.0
        and all(way.sum() >= _FEWEST for way in _ways(joint))
    )


def position_lines(joint: JointResidual) -> Lines:
    """Return the lines of a joint that :func:`moves_enough`."""
    diagnosis, q = joint.diagnosis, joint.axes['q']
    assert diagnosis.laboratory is not None
    span = float(np.ptp(q))
    first, step = _TURN / span, _TURN / (BETWEEN_LINES * span)
    high = _TURN * diagnosis.laboratory.signals[0].band.cutoff / (_SLOW * _speed(joint))
    count = int(min(max((high - first) / step, 2.0), _MOST))
    # w is radians per radian, which is periods per turn, or radians per metre.
    unit = 1.0 if joint.unit == 'Nm' else _TURN
    named = tuple(
        cause.parameters[name].value / unit
        for cause in diagnosis.causes
        if cause.joint == joint.name and repeats_with_position(cause.effect)
        for name in cause.parameters
        if name.startswith('frequency')
    )
    sizes = []
    for way in _ways(joint):
        place = np.ascontiguousarray(q[way])
        left = np.column_stack([joint.before[way], joint.after[way]])
        before, after = position_spectrum(place, left, first, step, count)
        sizes.append((before, after))
    periods = np.asarray((first + step * np.arange(count)) / unit, dtype=np.float64)
    return Lines(periods, sizes[0], sizes[1], named)


def _speed(joint: JointResidual) -> float:
    return float(np.quantile(np.abs(joint.axes['v']), 0.99))


def _ways(joint: JointResidual) -> tuple[BoolArray, BoolArray]:
    v, least = joint.axes['v'], 0.05 * _speed(joint)
    return v > least, v < -least


def position_spectrum(
    q: FloatArray, efforts: FloatArray, first: float, step: float, count: int
) -> FloatArray:
    """
    Return the size of the line A cos w q + B sin w q fitted to efforts at each w, (k, count).

    By least squares at each frequency by itself, the effort's mean taken off.

    :param q: position (N,) [rad or m]; efforts (N, k) [Nm or N]; w = first + j step [rad/rad,
        rad/m].
    """
    e = efforts - efforts.mean(axis=0)
    sizes = np.empty((e.shape[1], count))
    for begin in range(0, count, POINTS_AT_ONCE):
        some = min(POINTS_AT_ONCE, count - begin)
        columns = lines(q, first + begin * step, step, some)
        products = (e.T @ columns.reshape(len(e), 2 * some)).reshape(-1, some, 2)
        energy = squares(columns[:, None])
        energy += 1e-9 * len(q) * np.eye(2)
        amplitude = np.linalg.solve(energy, products[..., None])[..., 0]
        sizes[:, begin : begin + some] = np.hypot(amplitude[..., 0], amplitude[..., 1])
    return sizes
