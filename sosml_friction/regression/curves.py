# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Free curves along one axis: what any cause there could explain at most. None is a cause."""

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.simulated_term import SimulatedTerm
from sosml_friction.model.terms.kinds.term import Inner, Term
from sosml_friction.regression.kernels import hats, quantile_knots
from sosml_friction.regression.signals import Signals

#: Hat functions of a curve.
HATS = 9
#: The axes of :class:`Structure`, as signals (N, n).
_AXES: tuple[Callable[[Recording], FloatArray], ...] = (
    lambda s: s.v,
    lambda s: s.q,
    lambda s: s.a,
    lambda s: s.torque,
)
#: Powers of speed that are neither Coulomb friction nor viscous.
_POWERS = (0.3, 0.5, 0.7, 1.4, 2.0, 3.0)


class Curve(Term, registered=False):
    """A function without physics: it has columns, and is no term of a model."""

    def __init_subclass__(cls) -> None:
        super().__init_subclass__(registered=False)

    def simulated(
        self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray
    ) -> SimulatedTerm:
        """
        Refuse: a curve is no model of anything.

        :raises ConfigurationError: always.
        """
        raise ConfigurationError(f'the free curve {self.identifier} cannot be simulated')


class _Hats(Curve):
    """A curve of hat functions on quantiles of the data, which know no physics."""

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return the hats."""
        return signals.in_joint(joint, *self.own_columns(signals, joint, (inner,))[:, 0].T)

    @abstractmethod
    def own_columns(self, signals: Recording, joint: int, grid: Sequence[Inner]) -> FloatArray:
        """Return the hats of the joint alone, (N, 1, 2 hats of each axis)."""


class Structure(_Hats):
    """
    Add any smooth function of velocity, position, acceleration, load, and s times each.

    What they predict on data left out is structure, whatever its name. Not part of the catalogue.
    """

    identifier: ClassVar[str] = 'structure'
    amplitudes: ClassVar[Mapping[str, str]] = {f'hat_{k}': '{effort}' for k in range(8 * HATS)}

    def __init__(self, stretches: Sequence[Signals]) -> None:
        self._knots = [_knots_of(stretches, axis) for axis in _AXES]

    def own_columns(self, signals: Recording, joint: int, grid: Sequence[Inner]) -> FloatArray:
        """Return the hats of the joint alone, (N, 1, k)."""
        parts = [
            _odd_and_even(axis(signals)[:, joint], knots[joint], signals.sign[:, joint])
            for axis, knots in zip(_AXES, self._knots, strict=True)
        ]
        return np.concatenate(parts, axis=1)[:, None]


class Elsewhere(_Hats):
    """
    Add f(t) + s g(t), and f(q_k) + s g(q_k) of the joint before and after.

    What :class:`Structure` lacks, in the same hats.
    """

    identifier: ClassVar[str] = 'elsewhere'
    amplitudes: ClassVar[Mapping[str, str]] = {f'hat_{k}': '{effort}' for k in range(6 * HATS)}

    def __init__(self, stretches: Sequence[Signals]) -> None:
        times = np.concatenate([s.time for s in stretches])
        self._times = np.linspace(times.min(), times.max(), HATS)
        self._positions = _knots_of(stretches, lambda s: s.q)

    def own_columns(self, signals: Recording, joint: int, grid: Sequence[Inner]) -> FloatArray:
        """Return the hats of the joint alone, (N, 1, 2 hats of each axis)."""
        sign = signals.sign[:, joint]
        parts = [_odd_and_even(signals.time, self._times, sign)]
        for k in (joint - 1, joint + 1):
            if 0 <= k < signals.robot.n:
                parts.append(_odd_and_even(signals.q[:, k], self._positions[k], sign))
        return np.concatenate(parts, axis=1)[:, None]


class SpeedPower(Curve):
    """Add s |q'|^p: friction by speed that is neither Coulomb's nor viscous, in one term."""

    identifier: ClassVar[str] = 'power_of_speed'
    amplitudes: ClassVar[Mapping[str, str]] = {'level': '{effort}'}
    inner: ClassVar[Mapping[str, str]] = {'power': '1'}

    def grid(self, signals: Recording, joint: int) -> Sequence[Inner]:
        """Return powers well away from 0 and 1, which have names."""
        return [{'power': p} for p in _POWERS]

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return s (|q'| / top speed)^p."""
        speed = np.abs(signals.v[:, joint]) / float(signals.scales.speed[joint])
        return signals.in_joint(joint, signals.sign[:, joint] * speed ** inner['power'])


def _knots_of(
    stretches: Sequence[Signals], signal: Callable[[Signals], FloatArray]
) -> list[FloatArray]:
    """
    Return the knots of each joint, quantiles of its signal (N, n) over all stretches.

    A curve is one over all of them: knots of each stretch would make it another in each.
    """
    x = np.concatenate([signal(s) for s in stretches])
    return [quantile_knots(x[:, i], HATS) for i in range(x.shape[1])]


def _odd_and_even(x: FloatArray, knots: FloatArray, sign: FloatArray) -> FloatArray:
    """Return hats of x (N,) and the same times the sign (N,), (N, 2 HATS); 0 where none is."""
    hat = hats(np.ascontiguousarray(x), knots)
    result = np.zeros((len(x), 2, HATS))
    result[:, 0, : len(knots)], result[:, 1, : len(knots)] = hat, hat * sign[:, None]
    return result.reshape(len(x), -1)
