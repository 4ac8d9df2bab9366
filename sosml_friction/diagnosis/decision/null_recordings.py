# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Recordings simulated along the measured motion, with no cause beyond those that are known."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from sosml_friction.regression.evidence import System
from sosml_friction.regression.laboratory import Laboratory

FloatArray = NDArray[np.float64]

#: A nominal parameter is off by up to so much of its bound.
_OFF = 0.9
#: Friction that turns around in another way is so many times as large as the data show it, and at
#: most so many times Coulomb friction of the nominal.
_MORE, _MOST = 1.2, 1.5


def null_recordings(
    laboratory: Laboratory, system: System, x: FloatArray, beside: System, seed: list[int]
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
    bound = laboratory.nominal.bound
    bounded = np.flatnonzero(np.isfinite(bound))
    x = np.array(x)
    while True:
        x[bounded] = rng.uniform(-_OFF, _OFF, len(bounded)) * bound[bounded]
        y = np.einsum('tip,p->ti', system.Z, x, optimize=True)
        y += _credible(laboratory, laboratory.friction_variants(rng), beside)
        yield y + laboratory.white(rng)


def _credible(laboratory: Laboratory, variant: FloatArray, system: System) -> FloatArray:
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
