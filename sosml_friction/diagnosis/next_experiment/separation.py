# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""By how much more data would separate two causes."""

from collections.abc import Sequence

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.diagnosis.next_experiment.stretch import Stretch
from sosml_friction.diagnosis.next_experiment.supposed import Supposed
from sosml_friction.model.terms.kinds.term import Inner
from sosml_friction.regression.evidence import falls, whiten_all
from sosml_friction.regression.whitened import WhitenedRegression


def separation(
    laboratory: WhitenedRegression, cause: Supposed, rival: Supposed, more: Sequence[Stretch]
) -> tuple[float, float]:
    """
    Return what a rival explains of a cause, and by how much the cause leads.

    Were these data, and those of the stretches ``more`` besides, made by the cause as it was
    found and by the nominal model refitted beside it, without noise, the rival would be fitted to
    them at a cost that is greater by 2 D: D = N snr^2 (1 - C) / 2, the log-likelihood by which the
    right cause leads. The noise is that of these data. Nominal parameters stay within their
    bounds; all points of the rival's grid are tried.

    :param more: may be empty.
    """
    system = laboratory.system
    p = len(laboratory.nominal.bound)
    G = system.total
    x = cause.x[:p]
    effort = np.zeros_like(laboratory.y)
    effort[:, cause.columns.rows] = cause.columns.C[:, :, 0] @ cause.amplitude
    y = effort + np.einsum('tip,p->ti', system.Z, x, optimize=True)
    r = np.einsum('tip,ti->p', system.Z, y, optimize=True)
    own = rival.columns
    A, B = own.A.sum(axis=0), own.B.sum(axis=0)[:, :p]
    d = own.products(system, y).sum(axis=0)
    energy = float(np.sum(y**2))
    for stretch in more:
        Z = _nominal(laboratory, stretch)
        y = _columns(laboratory, stretch, cause, (cause.points[0],))[0] @ cause.amplitude + Z @ x
        wide = _columns(laboratory, stretch, rival, rival.points)
        G = G + np.einsum('tip,tiq->pq', Z, Z, optimize=True)
        r = r + np.einsum('tip,ti->p', Z, y, optimize=True)
        A = A + np.einsum('gtik,gtil->gkl', wide, wide, optimize=True)
        B = B + np.einsum('tip,gtik->gpk', Z, wide, optimize=True)
        d = d + np.einsum('gtik,ti->gk', wide, y, optimize=True)
        energy += float(np.sum(y**2))
    alone, beside = falls(G + np.diag(system.penalty()), r, system.bound, A, B, d)
    # Of the right cause the fit leaves nothing but the prior of the deviations it was found with.
    prior = float(x**2 @ system.penalty())
    without = max(energy - alone - prior, 0.0)
    left = max(energy - float(beside.max()) - prior, 0.0)
    share = 1.0 - left / max(without, 1e-300)
    return float(np.clip(share, 0.0, 1.0)), 0.5 * left


def _columns(
    laboratory: WhitenedRegression, stretch: Stretch, supposed: Supposed, points: Sequence[Inner]
) -> FloatArray:
    """Return whitened columns (g, rows, n, k) along a stretch."""
    parts = []
    for inner in points:
        columns = supposed.effect.columns(stretch.signals, supposed.joint, inner)
        if not stretch.acts(supposed.effect):
            columns = np.zeros_like(columns)
        parts.append(_whitened(laboratory, stretch, columns))
    return np.stack(parts)


def _nominal(laboratory: WhitenedRegression, stretch: Stretch) -> FloatArray:
    """Return the whitened columns (rows, n, p) of the nominal deviations along a stretch."""
    return _whitened(laboratory, stretch, laboratory.nominal.columns(stretch.signals))


def _whitened(laboratory: WhitenedRegression, stretch: Stretch, columns: FloatArray) -> FloatArray:
    """
    Return columns (N, n, ...) along a stretch as the laboratory has its own (rows, n, ...).

    Of a joint whose effort no recording tells no noise is known: it takes no part.
    """
    whitened = whiten_all([stretch.signals.band.apply(columns)], laboratory.noise)
    whitened[:, sorted(laboratory.nominal.silent)] = 0.0
    if stretch.signals.rests:
        rests = laboratory.whitening.rests([stretch.signals])
        rests.take_out(whitened, range(columns.shape[1]))
    return whitened
