# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Effort that repeats with position, and is taken for inertia or a delay where nothing has it."""

from __future__ import annotations

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.identification.data_finding import WARNING, DataFinding
from sosml_friction.identification.number_text import plus_minus, rounded
from sosml_friction.identification.term_fit import FittedTerm, TermFit
from sosml_friction.model.parameter import Z_95
from sosml_friction.model.terms.cogging import Cogging, lines
from sosml_friction.regression.noise_model import ORDER

#: The term that repeats.
COGGING = Cogging.identifier
#: Smallest share of what is left that one line over position explains, in squares of effort: of
#: less, most of what can be taken for inertia or a delay is left with it as well. Chosen, no
#: measurement.
_SHARE = 0.2
#: Rows that are looked at, at most: a line is seen in as many as well as in an hour. Chosen.
_ROWS = 20_000


def repeating(fit: TermFit) -> tuple[str, ...]:
    """
    Return cogging of the joints of which a fit leaves effort that repeats with position, labels.

    A line A cos w q + B sin w q with w on the grid of cogging, at least a fifth of what is left in
    squares. In a motion over the same way again and again it goes with acceleration and with the
    slope of effort: beside bodies and a delay alone these have it.
    """
    signals = fit.laboratory.signals
    left = fit.residual()
    # Where the rows of the band are.
    q = np.concatenate([s.band.at_rows(s.q)[ORDER:] for s in signals])
    every = -(-len(q) // _ROWS)
    found = []
    for i, joint in enumerate(fit.names):
        grid = [inner['frequency'] for inner in Cogging().grid(signals[0], i)]
        if _largest_share(q[::every, i], left[::every, i], np.array(grid)) > _SHARE:
            found.append(f'{COGGING}@{joint}')
    return tuple(found)


def repeats_finding(term: FittedTerm) -> DataFinding:
    """Return for a person what repeats, and that it is not in the law."""
    p = term.parameters
    length = p['frequency'].unit.removeprefix('rad/')
    size = float(np.hypot(p['cosine'].value, p['sine'].value))
    half = Z_95 * max(p['cosine'].std_error, p['sine'].std_error)
    period = 2.0 * np.pi / p['frequency'].value
    return DataFinding(
        COGGING,
        term.joint,
        WARNING,
        f'effort of joint {term.joint} repeats every {rounded(period)} {length} of position, '
        f'{plus_minus(size, half, p["cosine"].unit)} to each side (cogging): it was fitted beside '
        'the rigid body and when effort acts, and the law is without it; '
        f'--terms coulomb,viscous,{term.label} fits both, sosml diagnose looks for more',
    )


def _largest_share(q: FloatArray, left: FloatArray, grid: FloatArray) -> float:
    """Return what the best line of a grid explains of an effort (N,), as a share of squares."""
    q, energy, best = np.ascontiguousarray(q), float(left @ left), 0.0
    for w in grid.tolist() if energy > 0.0 else ():
        (C,) = lines(q, w, 0.0, 1).transpose(1, 0, 2)
        r = C.T @ left
        best = max(best, float(r @ np.linalg.pinv(C.T @ C) @ r))
    return best / max(energy, 1e-300)
