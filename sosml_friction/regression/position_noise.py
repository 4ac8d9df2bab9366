# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the measurement of a position adds to it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.observers.signal_noise import white_noise, white_noise_of

#: Share of samples, the slowest, whose noise stands for that of a joint at rest. Chosen, no
#: measurement.
_SLOWEST = 0.1


@dataclass(frozen=True)
class PositionNoise:
    """
    Hold a motion and what its measurement adds, for n joints.

    ``q`` (N, n) [rad or m]: the motion without what was added; ``quantum`` (n,) [rad or m]: its
    steps, 0 for none; ``white`` (n,) [rad or m] and ``effort`` (n,) [Nm or N]: standard deviation
    of white noise of position and of effort; ``late`` (n,) [steps]: that of when it was read, as
    by stamps of a busy computer, which adds as much noise as the joint goes in it; ``inertia``
    (n, n).
    """

    q: FloatArray
    quantum: FloatArray
    white: FloatArray
    effort: FloatArray
    inertia: FloatArray
    late: FloatArray | float = 0.0

    @classmethod
    def seen(
        cls,
        measured: FloatArray,
        q: FloatArray,
        quantum: FloatArray,
        effort: FloatArray,
        inertia: FloatArray,
    ) -> PositionNoise:
        """
        Return the noise of ``measured`` (N, n), a motion ``q`` read in steps of ``quantum``.

        Steps alone look like noise, by how fast the motion goes over them: white is what is more
        than reading the motion in them makes, and late by what that is more where the joint is
        faster than its root mean square than where it is slowest.
        """
        steps = cls(q, quantum, np.zeros(len(quantum)), effort, inertia)
        read = q + steps.drawn(np.random.default_rng(0))
        seen, own = (np.array([white_noise(column) for column in x.T]) for x in (measured, read))
        more = seen**2 - np.where(quantum > 0.0, own**2, 0.0)
        pairs = [_late(*each) for each in zip(measured.T, q.T, read.T, strict=True)]
        late, slowest = np.array(pairs).reshape(-1, 2).T
        # That of the slowest is sure where the faster have much more.
        rest = np.maximum(more - late * np.mean(_speed(q) ** 2, axis=0), slowest)
        white = np.maximum(np.where(late > 0.0, rest, more), 0.0)
        return replace(steps, white=np.sqrt(white), late=np.sqrt(late))

    @property
    def scale(self) -> FloatArray:
        """Return the standard deviation of noise over that of the whole recording, (N, n)."""
        square = self.white**2 + self.quantum**2 / 12.0 + (self.late * _speed(self.q)) ** 2
        mean = square.mean(axis=0)
        share = square / np.where(mean > 0.0, mean, np.inf)
        return np.asarray(
            np.sqrt(np.where(mean > 0.0, np.maximum(share, np.finfo(np.float64).eps), 1.0))
        )

    def drawn(self, rng: np.random.Generator) -> FloatArray:
        """
        Return noise of position along the motion, (N, n).

        The motion is read in steps once more, from another zero: at constant speed the steps of
        an encoder make a line, which may be in the band, and not white noise.
        """
        white = np.hypot(self.white, self.late * _speed(self.q))
        e = white * rng.standard_normal(self.q.shape)
        for i in np.flatnonzero(self.quantum > 0.0):
            step = self.quantum[i]
            true = self.q[:, i] + rng.uniform(0.0, step)
            e[:, i] = step * np.round((true + e[:, i]) / step) - true
        return e


def _speed(q: FloatArray) -> FloatArray:
    """Return how far a motion goes in a step, (N, n)."""
    return np.gradient(q, axis=0)


def _late(measured: FloatArray, q: FloatArray, read: FloatArray) -> tuple[float, float]:
    """Return the squares of how late samples are read, in steps, and of white noise beside it."""
    squares, differences = _speed(q)[1:-2] ** 2, [np.diff(x, 3) for x in (measured, read)]
    # A joint that rests within a step shows no noise.
    told = differences[0] != 0.0
    if not told.any():
        return 0.0, 0.0
    slowest, usual = np.quantile(squares[told], _SLOWEST), np.mean(squares[told])
    power, speed = [], []
    for part in (squares > usual, squares <= slowest):
        if not (told & part).any():
            return 0.0, 0.0
        seen, own = (white_noise_of(each[part & (each != 0.0)]) for each in differences)
        power.append(seen**2 - own**2)
        speed.append(float(np.mean(squares[part])))
    late = max(power[0] - power[1], 0.0) / max(speed[0] - speed[1], 1e-300)
    return late, power[1] - late * speed[1]
