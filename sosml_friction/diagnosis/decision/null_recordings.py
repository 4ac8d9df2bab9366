# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Recordings simulated along the measured motion, with no cause beyond those that are known."""

from collections.abc import Iterator

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.regression.evidence import System
from sosml_friction.regression.signals import sign_state
from sosml_friction.regression.whitened import WhitenedRegression

#: Nominal parameters of null simulations are off by up to this share of their bound: one at its
#: bound would be seen as wrong. Chosen, no measurement.
_OFF = 0.9
#: Friction that turns around in another way is this many times as large as the data show it, and
#: at most this many times Coulomb friction of the nominal. Chosen, no measurement.
_MORE, _MOST = 1.2, 1.5
#: Range of the displacement of such friction, as shares of what the nominal columns take, and the
#: low-pass of its position, in bands. Chosen, no measurement.
_SHARES, _SMOOTHED = (0.25, 1.5), (1.0, 1.5, 3.0)


def null_recordings(
    laboratory: WhitenedRegression, system: System, x: FloatArray, beside: System, seed: list[int]
) -> Iterator[FloatArray]:
    """
    Return whitened residuals (rows, n), without end: Z x with x anew, turning around, and noise.

    Nominal parameters are off by up to their tolerance, friction turns around in another way at
    reversals, and there is noise as measured.

    :param x: parameters of ``system`` (p,), of which the nominal's with a bound are drawn.
    :param beside: what its columns hold of friction that turns around in another way is drawn
        with them, and not besides.
    """
    rng = np.random.default_rng(seed)
    n, standstill = laboratory.robot.n, laboratory.whitening.standstill
    bound = laboratory.nominal.bound
    bounded = np.flatnonzero(np.isfinite(bound))
    x = np.array(x)
    while True:
        x[bounded] = rng.uniform(-_OFF, _OFF, len(bounded)) * bound[bounded]
        y = np.einsum('tip,p->ti', system.Z, x, optimize=True)
        y += _credible(laboratory, _friction_variant(laboratory, rng), beside)
        noise = rng.standard_normal(y.shape)
        yield y + (noise if standstill is None else standstill.take_out(noise, range(n)))


def _friction_variant(laboratory: WhitenedRegression, rng: np.random.Generator) -> FloatArray:
    """
    Return the whitened difference (rows, n) between friction of another build-up and s.

    Coulomb friction along the same motion, with its position low-passed more or less and another
    displacement: how friction turns around at a reversal is not known, and no cause.
    """
    share = rng.uniform(*_SHARES, laboratory.robot.n)
    wider = float(rng.choice(_SMOOTHED))
    parts = []
    for signals in laboratory.signals:
        if ('smooth', wider) not in signals.cache:
            signals.cache[('smooth', wider)] = signals.band.smooth(signals.q, wider)
        q = signals.cache[('smooth', wider)]
        difference = np.empty_like(q)
        for i in range(q.shape[1]):
            scale = float(signals.scales.displacement[i] * share[i])
            z = sign_state(q[:, i], signals.v[:, i], scale, signals.scales.width[i])
            coulomb = float(np.nan_to_num(signals.scales.coulomb[i]))
            difference[:, i] = coulomb * (z - signals.sign[:, i])
        parts.append(signals.in_band(difference))
    return laboratory.whitening.apply(parts)


def _credible(laboratory: WhitenedRegression, variant: FloatArray, system: System) -> FloatArray:
    """Return what of a variant of friction is beyond a system, as large as the data show it."""
    Z = system.Z
    result = np.empty_like(variant)
    for i in range(variant.shape[1]):
        x = variant[:, i]
        G = Z[:, i].T @ Z[:, i]
        G += np.diag(1e-9 * np.diag(G) + 1e-12)
        rest = x - Z[:, i] @ np.linalg.solve(G, Z[:, i].T @ x)
        shown = float(rest @ laboratory.y[:, i]) / max(float(rest @ rest), 1e-300)
        result[:, i] = rest * min(_MORE * abs(shown), _MOST)
    return result
