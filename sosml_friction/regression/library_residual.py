# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What no candidate explains: the noise of the recordings, and contacts and impacts in it."""

from collections.abc import Iterator, Sequence

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.regression.band_rows import SMALL_GRID, BandRows
from sosml_friction.regression.kernels import products, squares
from sosml_friction.regression.signals import Signals

#: Rows whose columns are put together at a time. Chosen, no measurement.
_ROWS = 8192
#: Added to the normal equations of columns of norm 1, of which many are collinear.
RIDGE = 1e-8
#: At most this many points of a large grid are taken off, each of at least this share of the
#: residual's energy. Chosen, no measurement.
_LINES, _LINE = 16, 0.02
#: A point must also explain this many times the variance of a row. From chance alone one of 300
#: points does so with a probability of 300 exp(-15 / 2) = 0.17 (chi-squared, cosine and sine).
_CHANCE = 15.0
#: The friction at standstill is unknown if the library leaves this many times the mean square of
#: motion there. Measured: 8 to 12 for joints that creep (the emulator's), 5 beside late bus
#: cycles; less for joints that stick, but up to 5 if a push holds one of them at standstill.
MORE_AT_REST = 5.0


def library_residual(rows: BandRows) -> list[list[FloatArray]]:
    """Return what all candidates together leave of each joint, by stretch (K,) [Nm or N]."""
    left = []
    ends = np.cumsum([len(part) for part in rows.residual])[:-1]
    for i in range(rows.signals[0].robot.n):
        G, r = np.zeros(()), np.zeros(())
        for s, part in _parts(rows):
            X = _design_matrix(rows, i, s, part)
            G, r = G + X.T @ X, r + X.T @ rows.residual[s][part, i]
        size = np.sqrt(np.diag(G))
        acts = size > 0.0
        size = size[acts]
        G = G[np.ix_(acts, acts)] / size / size[:, None] + RIDGE * np.eye(len(size))
        x = np.zeros(len(acts))
        x[acts] = np.linalg.solve(G, r[acts] / size) / size
        residual = np.concatenate(
            [
                rows.residual[s][part, i] - _design_matrix(rows, i, s, part) @ x
                for s, part in _parts(rows)
            ]
        )
        left.append(np.split(_without_lines(rows, i, residual), ends))
    return left


def _parts(rows: BandRows) -> Iterator[tuple[int, slice]]:
    """Yield stretches and rows of them: all rows of all columns at once would be large."""
    for s, part in enumerate(rows.residual):
        for first in range(0, len(part), _ROWS):
            yield s, slice(first, first + _ROWS)


def _design_matrix(rows: BandRows, joint: int, s: int, part: slice) -> FloatArray:
    """
    Return the columns of the nominal, of all small grids and of the free curves in a joint.

    Of some rows of a stretch. Points of a larger grid are fitted one after the other.
    """
    stack = [rows.nominal_columns[s][part, joint]]
    for candidate, (joints, columns) in zip(rows.candidates, rows.columns, strict=True):
        at = np.flatnonzero(joints == joint)
        if len(at) and len(candidate.grid) <= SMALL_GRID:
            stack.append(columns[s][part, at[0]].reshape(len(stack[0]), -1))
    joints, columns = rows.structure_columns[joint]
    at = np.flatnonzero(joints == joint)
    stack.append(columns[s][part, at[0]].reshape(len(stack[0]), -1))
    return np.concatenate(stack, axis=1)


def _without_lines(rows: BandRows, joint: int, residual: FloatArray) -> FloatArray:
    """
    Return a residual without the strongest points of the large grids.

    They are sinusoids of position; left in, the noise model would whiten them away. The strongest
    is fitted and taken off, again and again, while it takes more than chance would.
    """
    for candidate, (joints, columns) in zip(rows.candidates, rows.columns, strict=True):
        at = np.flatnonzero(joints == joint)
        if not len(at) or len(candidate.grid) <= SMALL_GRID:
            continue
        parts = [part[:, at[0]] for part in columns]
        C = np.ascontiguousarray(parts[0]) if len(parts) == 1 else np.concatenate(parts)
        inverse = np.linalg.pinv(squares(C[:, None]))
        kept: list[FloatArray] = []
        left = residual
        for _ in range(_LINES):
            d = products(left[None], C.reshape(len(C), -1))[0].reshape(C.shape[1:])
            gain = np.einsum('gk,gkl,gl->g', d, inverse, d)
            best = int(np.argmax(gain))
            energy = float(left @ left)
            if gain[best] < _LINE * energy + _CHANCE * energy / len(left):
                break
            kept.append(C[:, best])
            X = np.concatenate(kept, axis=1)
            left = residual - X @ np.linalg.lstsq(X, residual, rcond=1e-9)[0]
        residual = left
    return residual


def unknown_at_rest(
    left: Sequence[Sequence[FloatArray]], resting: Sequence[Signals]
) -> frozenset[int]:
    """
    Return the joints of which the library leaves notably more at standstill than in motion.

    There the sign of the last motion is not what friction is at standstill.

    :param left: what is left of each joint, by stretch (K,).
    """
    found = set()
    for i, stretches in enumerate(left):
        moves = np.concatenate(
            [in_motion(s, len(x))[:, i] for s, x in zip(resting, stretches, strict=True)]
        )
        if moves.any() and not moves.all():
            square = np.concatenate(stretches) ** 2
            if np.mean(square[~moves]) > MORE_AT_REST * np.mean(square[moves]):
                found.add(i)
    return frozenset(found)


def in_motion(signals: Signals, rows: int) -> BoolArray:
    """Return where no rest of a joint is seen, (rows, n) of the band."""
    result = np.ones((rows, signals.robot.n), dtype=np.bool_)
    for rest in signals.rests:
        result[rest.rows, rest.joint] = False
    result[:, sorted(signals.silent)] = False
    return result
