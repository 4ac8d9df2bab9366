# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Free curves along one axis: what any cause there could explain at most. None is a cause."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import Effect, FloatArray, Inner
from sosml_friction.diagnosis.kernels import hats
from sosml_friction.diagnosis.signals import Signals
from sosml_friction.simulation.dahl import dahl_path

_HATS, _POSITION_HATS = 6, 8
#: Lowest knot of speed, as a share of the top speed: below it is the turning around.
_SLOWEST = 0.04
#: Displacement of the sign as shares of the fitted one, and smoothing of position, of the ways in
#: which friction may turn around at a reversal.
_TURNS = ((0.3, 1.0), (2.0, 1.0), (1.0, 3.0))
#: Powers of speed that are neither Coulomb friction nor viscous.
_POWERS = (0.3, 0.5, 0.7, 1.4, 2.0, 3.0)


def knots_of(
    stretches: Sequence[Signals], signal: Callable[[Signals], FloatArray], count: int
) -> list[FloatArray]:
    """
    Return the knots of each joint, quantiles of its signal (N, n) over all stretches.

    A curve is one over all of them: knots of each stretch would make it another in each.
    """
    x = np.concatenate([signal(s) for s in stretches])
    at = np.linspace(0.01, 0.99, count)
    return [np.unique(np.quantile(x[:, i], at)) for i in range(x.shape[1])]


def neighbours(n: int, joint: int) -> list[int]:
    """Return the joints before and after one of n."""
    return [k for k in (joint - 1, joint + 1) if 0 <= k < n]


class Reversal(Effect):
    """Add the differences between ways to turn around at a reversal and the fitted one."""

    identifier: ClassVar[str] = 'reversal'
    amplitudes: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ('faster', 'slower', 'smoother'), '{effort}'
    )

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return the differences of the sign."""
        scale = float(signals.scales.displacement[joint])
        columns = []
        for share, wider in _TURNS:
            q = signals.q[:, joint : joint + 1]
            if wider != 1.0:
                q = signals.band.smooth(q, wider)
            z = dahl_path(np.ascontiguousarray(q[:, 0]), share * scale)
            columns.append(z - signals.sign[:, joint])
        return signals.in_joint(joint, *columns)


class SpeedPower(Effect):
    """Add s |q'|^p: friction by speed that is neither Coulomb's nor viscous, in one term."""

    identifier: ClassVar[str] = 'power_of_speed'
    amplitudes: ClassVar[Mapping[str, str]] = {'level': '{effort}'}
    inner: ClassVar[Mapping[str, str]] = {'power': '1'}

    def grid(self, signals: Signals, joint: int) -> Sequence[Inner]:
        """Return powers well away from 0 and 1, which have names."""
        return [{'power': p} for p in _POWERS]

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return s (|q'| / top speed)^p."""
        speed = np.abs(signals.v[:, joint]) / float(signals.scales.speed[joint])
        return signals.in_joint(joint, signals.sign[:, joint] * speed ** inner['power'])


class SpeedCurve(Effect):
    """Add s f(|q'|) with any piecewise linear f: what friction by speed could explain at most."""

    identifier: ClassVar[str] = 'speed'
    amplitudes: ClassVar[Mapping[str, str]] = {f'hat_{k}': '{effort}' for k in range(_HATS)}

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return s times hat functions on knots of |q'| in geometric steps."""
        speed = np.abs(signals.v[:, joint])
        knots = float(signals.scales.speed[joint]) * np.geomspace(_SLOWEST, 1.0, _HATS)
        s = signals.sign[:, joint]
        return signals.in_joint(joint, *(s[:, None] * hats(speed, knots)).T)


class PositionCurve(Effect):
    """Add f(q) with any piecewise linear f: a spring that is not straight, a cable, a stop."""

    identifier: ClassVar[str] = 'position'
    amplitudes: ClassVar[Mapping[str, str]] = {
        f'hat_{k}': '{effort}' for k in range(_POSITION_HATS)
    }

    def __init__(self, stretches: Sequence[Signals]) -> None:
        self._knots = knots_of(stretches, lambda s: s.q, _POSITION_HATS)

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return hat functions on quantiles of q, (N, n, hats)."""
        result = np.zeros((len(signals.q), signals.robot.n, _POSITION_HATS))
        knots = self._knots[joint]
        result[:, joint, : len(knots)] = hats(np.ascontiguousarray(signals.q[:, joint]), knots)
        return result


class NeighbourCurve(Effect):
    """Add f(q_k) + s g(q_k), q_k of the joint before and after: no cause of the catalogue does."""

    identifier: ClassVar[str] = 'neighbours'
    amplitudes: ClassVar[Mapping[str, str]] = {f'hat_{k}': '{effort}' for k in range(4 * _HATS)}

    def __init__(self, stretches: Sequence[Signals]) -> None:
        self._knots = knots_of(stretches, lambda s: s.q, _HATS)

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return hat functions on quantiles of q_k, and s times each, (N, n, 4 hats)."""
        result = np.zeros((len(signals.q), signals.robot.n, 4 * _HATS))
        s = signals.sign[:, joint]
        first = 0
        for k in neighbours(signals.robot.n, joint):
            knots = self._knots[k]
            hat = hats(np.ascontiguousarray(signals.q[:, k]), knots)
            result[:, joint, first : first + len(knots)] = hat
            first += _HATS
            result[:, joint, first : first + len(knots)] = hat * s[:, None]
            first += _HATS
        return result


class NeighbourFriction(Effect):
    """
    Add s (a x_k + b x_k^2), x_k where the joint before and after is: friction that follows them.

    x_k is q_k in halves of its range over all recordings; beside a free s its origin is any. The
    curves above hold it too, among so many others that a little of it is lost in their chance.
    """

    identifier: ClassVar[str] = 'friction_by_neighbours'
    amplitudes: ClassVar[Mapping[str, str]] = {f'power_{k}': '{effort}' for k in range(4)}

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return the powers, (N, n, 4), the last two zero where there is one neighbour."""
        result = np.zeros((len(signals.q), signals.robot.n, 4))
        s = signals.sign[:, joint]
        for k, other in enumerate(neighbours(signals.robot.n, joint)):
            x = 2.0 * signals.q[:, other] / float(signals.scales.span[other])
            result[:, joint, 2 * k] = s * x
            result[:, joint, 2 * k + 1] = s * x**2
        return result
