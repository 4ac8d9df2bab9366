# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A torque that repeats with position."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.compiled import compiled
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner

_TURN = 2.0 * np.pi
#: The slowest passes, as a share of the top speed.
_SLOW = 0.04
#: Step of the grid of frequencies, times the range of motion [rad]; two frequencies that are 2 pi
#: apart are orthogonal.
_SPACING = 2.5
#: Fewest periods in the range of motion: fewer are a smooth curve of position, which a spring or
#: gravity may be as well.
PERIODS = 3.0
_MOST = 400


class Cogging(EffortTerm):
    """
    Add A cos w q + B sin w q: cogging or mesh ripple, the same in both directions.

    ``frequency`` w [rad/rad or rad/m]: periods per turn, or 2 pi over the period in m.
    """

    identifier: ClassVar[str] = 'cogging'
    amplitudes: ClassVar[Mapping[str, str]] = {'cosine': '{effort}', 'sine': '{effort}'}
    inner: ClassVar[Mapping[str, str]] = {'frequency': 'rad/{length}'}
    refined: ClassVar[tuple[str, ...]] = ('frequency',)
    axis: ClassVar[str] = 'position'
    trusted_as: ClassVar[str] = 'terms'
    repeats: ClassVar[bool] = True
    held_by: ClassVar[tuple[str, ...]] = ('mjcf',)

    def effort(
        self, motion: Motion, joint: int | slice, inner: Inner, state: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Return cos w q and sin w q."""
        angle = inner['frequency'] * motion.q[:, joint]
        return np.cos(angle), np.sin(angle)

    def own_columns(
        self, signals: Recording, joint: int, grid: Sequence[Inner]
    ) -> FloatArray | None:
        """Return the columns of frequencies in equal steps, (N, g, 2), else None."""
        w = np.array([inner['frequency'] for inner in grid])
        step = float(w[-1] - w[0]) / max(len(w) - 1, 1)
        if np.abs(w - w[0] - step * np.arange(len(w))).max() > 1e-12 * float(np.abs(w).max()):
            return None
        q = np.ascontiguousarray(signals.q[:, joint])
        return lines(q, float(w[0]), step, len(w))

    def grid(self, signals: Recording, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        span, top = float(signals.scales.span[joint]), float(signals.scales.speed[joint])
        # Enough periods in the range of motion, and a slow pass within the band.
        low = PERIODS * _TURN / span
        if signals.length_unit(joint) == 'rad':
            low = max(low, 4.0)
        high = _TURN * signals.band.cutoff / (_SLOW * top)
        end = min(high, _MOST * _SPACING / span)
        fine = np.arange(low, end, _SPACING / span)
        # Of many turns there are too many frequencies: further, those that repeat with each.
        last = min(high, self.inner_bounds(signals, joint)['frequency'][1])
        found = [*fine, *np.arange(np.ceil(max(low, end)), last)]
        return [{'frequency': float(w)} for w in found]

    def implausible(self, fit: Fitted) -> str:
        """Return why such an amplitude is impossible, else ''."""
        # Nothing else has three periods in the range that it could cancel against.
        mean_square = 0.5 * float(fit.amplitude @ fit.amplitude)
        if mean_square > float(fit.signals.scales.effort[fit.joint]) ** 2:
            return 'it would be more than all of the measured effort'
        return ''

    def inner_bounds(self, signals: Recording, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the physical range."""
        span = float(signals.scales.span[joint])
        last = _MOST * _SPACING / span
        if signals.length_unit(joint) == 'rad' and span > _TURN:
            last = max(last, float(_MOST))
        return {'frequency': (PERIODS * _TURN / span, last)}


@compiled
def lines(q: FloatArray, first: float, step: float, count: int) -> FloatArray:
    """
    Return cos w q and sin w q, (N, count, 2), of the frequencies first, first + step, ...

    Each by one rotation of the one before: rounding grows with ``count``, which is to be tens.
    """
    result = np.empty((len(q), count, 2))
    for t in range(len(q)):
        c, s = np.cos(first * q[t]), np.sin(first * q[t])
        turn_c, turn_s = np.cos(step * q[t]), np.sin(step * q[t])
        for k in range(count):
            result[t, k, 0] = c
            result[t, k, 1] = s
            c, s = c * turn_c - s * turn_s, s * turn_c + c * turn_s
    return result
