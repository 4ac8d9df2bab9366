# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Whether what passes for friction takes energy, as friction does."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.compiled import compiled

#: What is judged: the last motion of so long, gathered in pieces [s].
SPAN_S = 1.0
_PIECE_S = 0.05
#: A model may be off by this share of the torque that it makes. Chosen: masses of a CAD model are
#: good to a few per cent.
MODEL = 0.1
_ERRORS = 3.0


class Dissipation:
    """
    Judge the work of friction over the last second of motion of each joint.

    Friction takes energy: tau_f v >= 0. With s the standard error of tau_f, and tau - tau_f what
    the model makes of the motion, of which it may be off by :data:`MODEL`, it is none where::

        int tau_f v dt  <  -int (3 s + MODEL |tau - tau_f|) |v| dt

    Where s is not known nothing is judged.

    :param n: number of joints.
    """

    def __init__(self, n: int) -> None:
        self._sums = np.zeros((3, n))
        self._pieces: list[deque[tuple[float, float, float]]] = [deque() for _ in range(n)]
        self.reset()
        # Compile now: at the first sample it would stall the node.
        nothing = np.zeros(n)
        _add(0.0, nothing, nothing, nothing, nothing, np.zeros(n, dtype=bool), self._sums)

    def reset(self) -> None:
        """Forget the past."""
        self._sums[:] = 0.0
        for pieces in self._pieces:
            pieces.clear()
        self._last_s = self._piece_s = math.nan
        #: By joint that gives energy: what is said.
        self.remarks: dict[int, str] = {}

    def take(
        self,
        t_s: float,
        v: FloatArray,
        friction: FloatArray,
        error: FloatArray,
        torque: FloatArray,
        moving: BoolArray,
    ) -> None:
        """
        Take one sample.

        :param t_s: stamp [s].
        :param v: velocity (n,) [rad/s or m/s].
        :param friction: tau_f (n,) [Nm or N], NaN where not known.
        :param error: its standard error (n,).
        :param torque: tau (n,).
        :param moving: which joints move (n,).
        """
        step = t_s - self._last_s
        self._last_s = t_s
        if not 0.0 < step < SPAN_S:
            self._piece_s = t_s
            return
        _add(step, v, friction, error, torque, moving, self._sums)
        if t_s - self._piece_s >= _PIECE_S:
            self._piece_s = t_s
            self._judge()

    def _judge(self) -> None:
        for i, piece in enumerate(self._sums.T.tolist()):
            if not piece[0]:
                continue
            pieces = self._pieces[i]
            pieces.append(tuple(piece))
            span, work, doubt = map(sum, zip(*pieces, strict=True))
            if span - pieces[0][0] >= SPAN_S:
                pieces.popleft()
            if span < SPAN_S or work >= -doubt:
                self.remarks.pop(i, None)
            else:
                self.remarks[i] = (
                    f'what passes for friction gave {-work:.2g} J over the last {span:.1f} s of '
                    f'motion ({doubt:.2g} J are in doubt), and friction takes energy: check sign, '
                    'scale and offset of the effort, that it is of this joint, and what the model '
                    'lacks, as a load or a spring'
                )
        self._sums[:] = 0.0


@compiled
def _add(
    step: float,
    v: FloatArray,
    friction: FloatArray,
    error: FloatArray,
    torque: FloatArray,
    moving: BoolArray,
    sums: FloatArray,
) -> None:
    """Add time in motion [s], work [J] and what of it is in doubt [J], ``sums`` (3, n)."""
    for i in range(len(v)):
        doubt = _ERRORS * error[i] + MODEL * abs(torque[i] - friction[i])
        if moving[i] and math.isfinite(doubt):
            sums[0, i] += step
            sums[1, i] += step * friction[i] * v[i]
            sums[2, i] += step * doubt * abs(v[i])
