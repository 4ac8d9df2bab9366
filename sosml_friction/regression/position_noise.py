# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the measurement of a position adds to it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.observers.signal_noise import white_noise, white_noise_of

#: The share of samples whose noise is taken for that of a joint at rest, but for what they move.
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
        than reading the motion in them makes, and late by what that is more in the faster half
        of the samples than in the slowest.
        """
        steps = cls(q, quantum, np.zeros(len(quantum)), effort, inertia)
        read = q + steps.drawn(np.random.default_rng(0))
        seen, own = (np.array([white_noise(column) for column in x.T]) for x in (measured, read))
        more = seen**2 - np.where(quantum > 0.0, own**2, 0.0)
        columns = zip(measured.T, q.T, read.T, quantum, strict=True)
        late, slow = np.array([_late(*each) for each in columns]).reshape(-1, 2).T
        # That of the slowest is sure where the faster have much more.
        rest = np.maximum(more - late**2 * np.mean(_speed(q) ** 2, axis=0), slow)
        more = np.where(late > 0.0, rest, more)
        return replace(steps, white=np.sqrt(np.maximum(more, 0.0)), late=late)

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


def _late(
    measured: FloatArray, q: FloatArray, read: FloatArray, quantum: float
) -> tuple[float, float]:
    """Return by how much samples are read late, in steps, and the square of white noise beside."""
    squares, differences = _speed(q)[1:-2] ** 2, [np.diff(x, 3) for x in (measured, read)]
    # A joint that rests within a step shows no noise.
    told = differences[0] != 0.0
    if not told.any():
        return 0.0, 0.0
    slowest, middle = np.quantile(squares[told], [_SLOWEST, 0.5])
    power, speed = [], []
    for part in (told & (squares > middle), told & (squares <= slowest)):
        if not part.any():
            return 0.0, 0.0
        seen, own = (white_noise_of(each[part]) for each in differences)
        power.append(seen**2 - (own**2 if quantum > 0.0 else 0.0))
        speed.append(float(np.mean(squares[part])))
    late = max(power[0] - power[1], 0.0) / max(speed[0] - speed[1], 1e-300)
    return float(np.sqrt(late)), power[1] - late * speed[1]
