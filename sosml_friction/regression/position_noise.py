# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How much of a residual noise of position would make look like a function of acceleration."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.finite_differences import second_derivative
from sosml_friction.observers.signal_noise import white_noise
from sosml_friction.regression.band import Band
from sosml_friction.regression.kernels import hats, quantile_knots
from sosml_friction.regression.noise_model import fit_noise

#: Knots of the curve in acceleration: those of one axis of ``structure.Structure``.
_HATS = 9
#: Fewest samples in the band for a regression on these curves. Chosen, no measurement.
_FEWEST = 200


@dataclass(frozen=True)
class PositionNoise:
    """
    Hold a motion and what its measurement adds, for n joints.

    ``q`` (N, n) [rad or m]: the motion without what was added; ``quantum`` (n,) [rad or m]: its
    steps, 0 for none; ``white`` (n,) [rad or m] and ``effort`` (n,) [Nm or N]: standard deviation
    of white noise of position and of effort; ``inertia`` (n, n).
    """

    q: FloatArray
    quantum: FloatArray
    white: FloatArray
    effort: FloatArray
    inertia: FloatArray

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
        than reading the motion in them makes.
        """
        steps = cls(q, quantum, np.zeros(len(quantum)), effort, inertia)
        read = q + steps.drawn(np.random.default_rng(0))
        seen, own = (np.array([white_noise(column) for column in x.T]) for x in (measured, read))
        more = seen**2 - np.where(quantum > 0.0, own**2, 0.0)
        return replace(steps, white=np.sqrt(np.maximum(more, 0.0)))

    def drawn(self, rng: np.random.Generator) -> FloatArray:
        """
        Return noise of position along the motion, (N, n).

        The motion is read in steps once more, from another zero: at constant speed the steps of
        an encoder make a line, which may be in the band, and not white noise.
        """
        e = self.white * rng.standard_normal(self.q.shape)
        for i in np.flatnonzero(self.quantum > 0.0):
            step = self.quantum[i]
            true = self.q[:, i] + rng.uniform(0.0, step)
            e[:, i] = step * np.round((true + e[:, i]) / step) - true
        return e

    def share(self, band: Band, seed: int = 0) -> float:
        """
        Return the share of a joint's whitened noise that curves of acceleration explain, at most.

        Noise e of position makes the residual -M e'' and is in the acceleration q'' + e'' as
        well. The regression of -M e'' plus noise of effort on the accelerations, and on a
        piecewise linear curve of the joint's own, explains of it what is no structure: at most, as
        columns of the diagnosis have a steady acceleration. Where the
        accelerations are much larger than e'' it is nothing, however large the noise. Of a motion
        of less than 200 samples in the band nothing can be said: 0.
        """
        if band.count(len(self.q)) < _FEWEST:
            return 0.0
        rng = np.random.default_rng(seed)
        noisy = second_derivative(band.smooth(self.drawn(rng)), band.step)
        a = second_derivative(band.smooth(self.q), band.step) + noisy
        y = band.apply(-noisy @ self.inertia.T)
        n = band.apply(self.effort * rng.standard_normal(a.shape))
        largest = 0.0
        for i in np.flatnonzero(self.effort > 0.0):
            own = np.ascontiguousarray(a[:, i])
            knots = quantile_knots(own, _HATS)
            columns = [a] if len(knots) < 2 else [a, hats(own, knots)]
            X = band.apply(np.concatenate(columns, axis=1))
            both = y[:, i] + n[:, i]
            # As the diagnosis does: the noise is what curves leave.
            left = both - X @ np.linalg.lstsq(X, both, rcond=1e-9)[0]
            model = fit_noise([left], 1e-12 * float(self.effort[i]))
            X = model.whiten(X)
            made, rest = model.whiten(y[:, i]), model.whiten(n[:, i])
            fit = X @ np.linalg.lstsq(X, made, rcond=1e-9)[0]
            largest = max(largest, float(fit @ fit) / float(made @ made + rest @ rest))
        return largest
