# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What joints leave where they turn around, and whether they stick there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import BoolArray, ColumnArray, FloatArray, IndexArray
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.term import Inner, Term
from sosml_friction.regression.band_rows import SMALL_GRID, BandRows
from sosml_friction.regression.column_norms import ROUNDING
from sosml_friction.regression.library_residual import in_motion
from sosml_friction.regression.signals import Signals

#: A joint sticks where it turns around if that leaves this many times the mean square of motion.
#: Largest of MuJoCo's arm, which sticks, at 83, 62 and 50 Hz: 5.0, 4.4 and 3.6; of an arm that
#: does not, without an effect or with a gap: 1.9 (``python -m validation.turns --seed 1``).
_MORE = 3.0
#: What acts there explains at least this share of the excess if it is the cause: in the same
#: recordings at most 5 % where joints stick, 15 to 35 % of elastic gears.
_EXPLAINED = 0.1
#: A rest of which nothing is known leaves this many times that mean square: measured, 8 to 12
#: where the emulator's joints creep, 5 beside late bus cycles; joints that stick leave less.
_AT_REST = 5.0
#: Turns at which one push may hold a joint: one, or two in a row.
_PUSHED = 2


@dataclass(frozen=True)
class TurnResidual:
    """
    Hold what is left of a joint where it turns around, in mean squares of what motion leaves.

    The nominal and what acts elsewhere are fitted together. ``whole``: of all turns; ``usual``:
    without the two that leave most, as a push does; ``least``: of all, beside that candidate which
    is possible, acts at reversals and explains most: all together would explain anything. Where
    ``whole`` is too little for a joint that sticks, ``least`` is not asked and the same.
    """

    whole: float
    usual: float
    least: float

    @classmethod
    def of(
        cls,
        rows: BandRows,
        joint: int,
        turning: Sequence[Signals],
    ) -> TurnResidual | None:
        """
        Return what is left of a joint, None if nothing can be told.

        :param turning: the stretches with where joints turn around as what is left out, too.
        """
        moves = _known(rows, joint, turning)
        turns = _known(rows, joint, rows.signals) & ~moves
        if not (moves.any() and turns.any()):
            return None
        used = np.flatnonzero(moves | turns)
        moves, turns = moves[used], turns[used]
        without, freedom, there = _elsewhere(rows, joint, used)
        freedom = int(moves.sum()) - freedom
        if freedom <= 0:
            return None
        y = without(np.concatenate([part[:, joint] for part in rows.residual])[used])

        def relative(left: FloatArray, where: BoolArray) -> float:
            square = left**2
            motion = max(float(square[moves].sum()) / freedom, 1e-300)
            return float(square[where].mean()) / motion

        whole = least = relative(y, turns)
        if whole > _MORE:
            noise = float(np.mean(y[moves] ** 2))
            for effect, inner, C in there:
                C = without(C[used].astype(np.float64))
                x = np.linalg.lstsq(C, y, rcond=1e-9)[0]
                error = np.sqrt(noise * np.maximum(np.diag(np.linalg.pinv(C.T @ C)), 0.0))
                found = Fitted(rows.signals[0], joint, inner, effect.whole(np.asarray(x)), error)
                # What is impossible acts nowhere.
                if not effect.implausible(found):
                    least = min(least, relative(y - C @ x, turns))
        return cls(whole, relative(y, _without_most(y**2, used, turns)), least)

    @property
    def explained(self) -> float:
        """Return the share of the excess that one candidate explains at most."""
        return (self.whole - self.least) / max(self.whole - 1.0, 1e-300)

    @property
    def sticks(self) -> bool:
        """
        Tell whether a joint sticks, each time for another time, and its friction is what holds it.

        It leaves too much, without the turns of a push at least half as much, and no candidate
        explains enough of it, or one does and still leaves what a rest that is not known does.
        """
        much = self.whole > _MORE and self.usual - 1.0 > 0.5 * (_MORE - 1.0)
        return much and (self.explained < _EXPLAINED or self.least > _AT_REST)


def sticking_joints(rows: BandRows, turning: Sequence[Signals]) -> frozenset[int]:
    """Return the joints that stick where they turn around; as of :meth:`TurnResidual.of`."""
    left = [TurnResidual.of(rows, i, turning) for i in range(rows.signals[0].robot.n)]
    return frozenset(i for i, own in enumerate(left) if own is not None and own.sticks)


def _known(rows: BandRows, joint: int, stretches: Sequence[Signals]) -> BoolArray:
    """Return which rows of all stretches see no rest of a joint."""
    pairs = zip(stretches, rows.residual, strict=True)
    return np.concatenate([in_motion(s, len(part))[:, joint] for s, part in pairs])


def _elsewhere(
    rows: BandRows, joint: int, used: IndexArray
) -> tuple[Callable[[FloatArray], FloatArray], int, list[tuple[Term, Inner, ColumnArray]]]:
    """
    Return what takes that which acts elsewhere off, its parameters, and what acts at reversals.

    The first takes it, fitted, off a column of the rows ``used`` (R,). The last are terms, inner
    parameters and columns of all rows.
    """
    elsewhere, there = [[part[:, joint] for part in rows.nominal_columns]], []
    for candidate, own in rows.in_joint(joint):
        if len(candidate.grid) > SMALL_GRID:
            continue
        if candidate.effect.at_reversals:
            C = np.concatenate(own)
            there += [(candidate.effect, inner, C[:, k]) for k, inner in enumerate(candidate.grid)]
        else:
            elsewhere.append([part.reshape(len(part), -1) for part in own])
    # Of an hour, a second copy of all columns would be what takes most memory.
    X = np.empty((len(used), sum(parts[0].shape[1] for parts in elsewhere)))
    column = 0
    for parts in elsewhere:
        width = parts[0].shape[1]
        X[:, column : column + width] = np.concatenate(parts)[used]
        column += width
    products = X.T @ X
    size = np.sqrt(np.diag(products))
    size[size == 0.0] = 1.0
    spread, axes = np.linalg.eigh(products / np.outer(size, size))
    kept = spread > ROUNDING * spread.max()
    to_unit = axes[:, kept] / np.sqrt(spread[kept]) / size[:, None]
    return (lambda y: y - X @ (to_unit @ (to_unit.T @ (X.T @ y)))), int(kept.sum()), there


def _without_most(square: FloatArray, used: IndexArray, turns: BoolArray) -> BoolArray:
    """Return the rows of all turns but the few that leave most, all if there are no more."""
    begins = turns & ~np.append(False, turns[:-1] & (np.diff(used) == 1))
    starts = np.flatnonzero(begins)
    if len(starts) <= _PUSHED:
        return turns
    most = np.argsort(np.add.reduceat(turns * square, starts))[-_PUSHED:]
    return np.asarray(turns & ~np.isin(np.cumsum(begins) - 1, most))
