# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Any smooth function of two quantities at once: what curves of one each cannot follow."""

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner
from sosml_friction.regression.curves.axes import LOAD, NEIGHBOURS, POSITION, SPEED, TIME
from sosml_friction.regression.curves.curve import Curve
from sosml_friction.regression.curves.elsewhere import apart
from sosml_friction.regression.curves.knots import knots_of
from sosml_friction.regression.signals import Signals
from sosml_friction.regression.structure import spread

#: Waves of a quantity, half of one and a whole one in its range: the fewest of which one is odd
#: and one even about the middle.
WAVES = 2
#: Quantiles by which a quantity is spread evenly over its range: two steps for half a wave.
_KNOTS = 2 * WAVES + 1


class Pairs(Curve):
    """
    Add sum_kl c_kl w_k(x) w_l(y) of a joint, for each two of its quantities x and y.

    w_k(x) = cos(k pi u), k = 1, 2, u the share of samples that are below x; of speed s and
    s cos(pi u), u of |q'|. Quantities: speed, position, load, time, and position and velocity of
    both next joints. What has more noise than its knots are apart is none, nor is the velocity of
    a joint that moves in proportion.
    """

    identifier: ClassVar[str] = 'pairs'
    amplitudes: ClassVar[Mapping[str, str]] = {'wave': '{effort}'}

    def __init__(self, stretches: Sequence[Signals]) -> None:
        times = np.concatenate([s.time for s in stretches])
        self._times = np.linspace(times.min(), times.max(), _KNOTS)
        self._speeds = knots_of(stretches, lambda s: np.abs(s.v), _KNOTS)
        self._positions = knots_of(stretches, lambda s: s.q, _KNOTS)
        self._velocities = knots_of(stretches, lambda s: s.v, _KNOTS)
        noise = spread(stretches, lambda s: s.shaken)
        self._loads = knots_of(stretches, lambda s: s.sure_torque, _KNOTS, noise)
        self._apart = apart(stretches)

    def axes(self, joint: int) -> list[tuple[str, str]]:
        """Return the two quantities of each ``WAVES``^2 columns of a joint."""
        return list(itertools.combinations([name for name, _ in self._quantities(joint)], 2))

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return the products of waves."""
        return signals.in_joint(joint, *self.own_columns(signals, joint, (inner,))[:, 0].T)

    def own_columns(self, signals: Recording, joint: int, grid: Sequence[Inner]) -> FloatArray:
        """Return the products of waves in the joint alone, (N, 1, WAVES^2 of each pair)."""
        waves = [make(signals) for _, make in self._quantities(joint)]
        products = [
            (x[:, :, None] * y[:, None]).reshape(len(x), WAVES**2)
            for x, y in itertools.combinations(waves, 2)
        ]
        return np.concatenate(products, axis=1)[:, None]

    def _quantities(self, joint: int) -> Iterator[tuple[str, Callable[[Recording], FloatArray]]]:
        """Yield each quantity of a joint with what makes its waves (N, WAVES)."""
        speeds = self._speeds[joint]
        if len(speeds) == _KNOTS:
            yield SPEED, lambda s: _of_speed(s.v[:, joint], s.sign[:, joint], speeds)
        yield TIME, lambda s: _waves(s.time, self._times)
        found = [
            (POSITION, joint, self._positions, lambda s: s.q),
            (LOAD, joint, self._loads, lambda s: s.sure_torque),
        ]
        for k in (joint - 1, joint + 1):
            if 0 <= k < len(self._positions):
                found.append((NEIGHBOURS[0], k, self._positions, lambda s: s.q))
                if self._apart[joint, k]:
                    found.append((NEIGHBOURS[1], k, self._velocities, lambda s: s.v))
        for name, k, knots, signal in found:
            if len(knots[k]) == _KNOTS:
                yield name, partial(_waves_of, signal, k, knots[k])


def _of_speed(v: FloatArray, sign: FloatArray, knots: FloatArray) -> FloatArray:
    """Return what friction by two quantities has of speed: s, and s times half a wave."""
    level = _waves(np.abs(v), knots)[:, 0]
    return np.stack([sign, sign * level], axis=1)


def _waves_of(
    signal: Callable[[Recording], FloatArray], joint: int, knots: FloatArray, s: Recording
) -> FloatArray:
    return _waves(signal(s)[:, joint], knots)


def _waves(x: FloatArray, knots: FloatArray) -> FloatArray:
    u = np.interp(x, knots, np.linspace(0.0, 1.0, len(knots)))
    return np.cos(np.pi * u[:, None] * np.arange(1, WAVES + 1))
