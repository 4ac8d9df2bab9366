# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A torque that repeats with position."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.diagnosis.effect import Effect, FloatArray, Inner
from sosml_friction.model.robot import Robot
from sosml_friction.regression.kernels import lines
from sosml_friction.regression.signals import Signals
from sosml_friction.simulation.forward_term import Motion
from sosml_friction.simulation.forward_terms import LoadTerm

_TURN = 2.0 * np.pi
#: The slowest passes, as a share of the top speed.
_SLOW = 0.04
#: Frequencies are tried so far apart, times the range of motion [rad]; two that differ by 2 pi are
#: orthogonal.
_SPACING = 2.5
#: So many periods are in the range of motion at least: fewer are a smooth curve of position, which
#: a spring or gravity may be as well.
_PERIODS = 3.0
_MOST = 400


class Cogging(Effect):
    """
    Add A cos w q + B sin w q: cogging or mesh ripple, the same in both directions.

    ``frequency`` w [rad/rad or rad/m]: periods per turn, or 2 pi over the period in m.
    """

    identifier: ClassVar[str] = 'cogging'
    amplitudes: ClassVar[Mapping[str, str]] = {'cosine': '{effort}', 'sine': '{effort}'}
    inner: ClassVar[Mapping[str, str]] = {'frequency': 'rad/{length}'}
    refined: ClassVar[tuple[str, ...]] = ('frequency',)

    def columns(self, signals: Signals, joint: int, inner: Inner) -> FloatArray:
        """Return cos w q and sin w q."""
        angle = inner['frequency'] * signals.q[:, joint]
        return signals.in_joint(joint, np.cos(angle), np.sin(angle))

    def term(self, robot: Robot, joint: int, inner: Inner, amplitude: FloatArray) -> LoadTerm:
        """Return A cos w q + B sin w q."""
        w, (cosine, sine) = inner['frequency'], amplitude

        def load(motion: Motion) -> FloatArray:
            angle = w * motion.q[:, joint]
            return np.asarray(cosine * np.cos(angle) + sine * np.sin(angle))

        return LoadTerm(joint, load, stiffness=w * float(np.hypot(cosine, sine)))

    def own_columns(
        self, signals: Signals, joint: int, grid: Sequence[Inner]
    ) -> FloatArray | None:
        """Return cos w q and sin w q of frequencies in equal steps, (N, g, 2), else None."""
        w = np.array([inner['frequency'] for inner in grid])
        step = float(w[-1] - w[0]) / max(len(w) - 1, 1)
        if np.abs(w - w[0] - step * np.arange(len(w))).max() > 1e-12 * float(np.abs(w).max()):
            return None
        q = np.ascontiguousarray(signals.q[:, joint])
        return lines(q, float(w[0]), step, len(w))

    def grid(self, signals: Signals, joint: int) -> Sequence[Inner]:
        """Return the values to try."""
        span, top = float(signals.scales.span[joint]), float(signals.scales.speed[joint])
        # Enough periods in the range of motion, and a slow pass within the band.
        low = _PERIODS * _TURN / span
        if signals.length_unit(joint) == 'rad':
            low = max(low, 4.0)
        high = min(_TURN * signals.band.cutoff / (_SLOW * top), _MOST * _SPACING / span)
        return [{'frequency': float(w)} for w in np.arange(low, high, _SPACING / span)]

    def inner_bounds(self, signals: Signals, joint: int) -> Mapping[str, tuple[float, float]]:
        """Return the physical range."""
        span = float(signals.scales.span[joint])
        return {'frequency': (_PERIODS * _TURN / span, _MOST * _SPACING / span)}
