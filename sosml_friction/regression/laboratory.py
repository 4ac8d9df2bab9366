# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Recordings made ready for selection: whitened columns of the nominal and of all candidates."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.model.dahl import dahl_path
from sosml_friction.model.terms.kinds.term import ROBOT, Inner, Term
from sosml_friction.regression.bursts import LOAD_SMOOTHER, Bursts, find_bursts
from sosml_friction.regression.evidence import (
    Blocks,
    CandidateColumns,
    System,
    make_blocks,
    whiten_all,
)
from sosml_friction.regression.kernels import acts, squares
from sosml_friction.regression.noise_model import ORDER, NoiseModel, fit_noise
from sosml_friction.regression.nominal import Nominal, make_nominal
from sosml_friction.regression.rests import WhitenedRests, without_rests
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import Signals, with_rests
from sosml_friction.regression.structure import Structure

FloatArray = NDArray[np.float64]

#: A grid with more points than this takes no part in the fit that leaves only noise.
_SMALL_GRID = 12
#: So many points of a grid are filtered at a time.
_AT_ONCE = 16
#: Added to the normalised equations of that fit, whose columns are many and alike.
_RIDGE = 1e-8
#: So many lines in position are taken off before the noise is fitted, each of at least so much of
#: the energy.
_LINES, _LINE = 16, 0.02
#: A line of pure noise, the strongest of some hundred, takes less than this times its variance.
_CHANCE = 15.0
#: Noise is fitted to pieces of more than so many times its order in rows.
_PIECE = 4
#: Friction at rest is not known where the library leaves so many times the mean square of motion:
#: joints that creep, as an emulator's, leave 8 to 12, 5 beside late cycles; joints that stick
#: less, but where a push holds one of them at rest up to 5.
_MORE_AT_REST = 5.0
#: Least noise, as a share of the effort.
_LEAST_NOISE = 1e-6


@dataclass(frozen=True)
class Candidate:
    """Hold one effect in one joint (0 or :data:`ROBOT`: in the whole robot) and its grid."""

    effect: Term
    joint: int
    grid: Sequence[Inner]


class Laboratory:
    """
    Filter, whiten and multiply once; then any target can be tried against any candidate.

    :param signals: stretches of the recordings.
    :param library: effects to look for, by identifier.
    :param step: called with what is being done.
    """

    def __init__(
        self,
        signals: Sequence[Signals],
        library: dict[str, Term],
        settings: DiagnosisSettings,
        step: Callable[[str], None] = lambda text: None,
    ) -> None:
        self.signals = tuple(signals)
        self.settings = settings
        self.robot = signals[0].robot
        self.nominal: Nominal = make_nominal(signals[0], settings.tolerance)
        self.candidates = self._candidates(library)
        if not self.candidates:
            raise ConfigurationError(
                'no cause is left that could act in these joints: leave out fewer of them'
            )
        step('computing the columns of all candidates')
        self._Z = [s.in_band(self.nominal.columns(s)) for s in signals]
        self._y = [s.in_band(s.tau - s.torque) for s in signals]
        self._C = [self._all_columns(candidate) for candidate in self.candidates]
        structure = Structure(signals)
        self.structures = [Candidate(structure, i, ({},)) for i in range(self.robot.n)]
        self._S = [self._all_columns(candidate) for candidate in self.structures]
        self.noise: tuple[NoiseModel, ...] = ()
        self._rests: WhitenedRests | None = None
        #: How many whitened rows of each joint say something (n,).
        self.known: FloatArray
        self.bursts: Bursts
        self.blocks: Blocks
        self.y: FloatArray
        self.system: System
        self.columns: list[CandidateColumns] = []
        self.structure_columns: list[CandidateColumns] = []
        step('whitening')
        left = self._left_by_library()
        resting = with_rests(self.signals)
        self.without_rests = _at_rest_is_unknown(left, resting)
        if self.without_rests:
            self._leave_out_rests(resting)
            left = self._left_by_library()
        self._whiten(left)

    def _candidates(self, library: dict[str, Term]) -> list[Candidate]:
        first = self.signals[0]
        result = []
        for effect in library.values():
            joints = (0,) if effect.of_robot else range(self.robot.n)
            for i in joints:
                if effect.applies(first, i):
                    grid = effect.grid(first, i)
                    if grid:
                        result.append(Candidate(effect, i, tuple(grid)))
            if effect.everywhere is not None and self.robot.n > 1:
                both = effect.everywhere()
                result.append(Candidate(both, ROBOT, tuple(both.grid(first, ROBOT))))
        return result

    def _all_columns(self, candidate: Candidate) -> tuple[NDArray[np.int64], list[FloatArray]]:
        """Return the joints a candidate acts in, and its filtered columns (K, m, g, k)."""
        parts: list[FloatArray] = []
        acting: list[NDArray[np.int64]] = []
        for signals in self.signals:
            rows, part = self._in_one_joint(signals, candidate) or self._in_all_joints(
                signals, candidate
            )
            acting.append(rows)
            parts.append(part)
        if any(not np.array_equal(rows, acting[0]) for rows in acting):
            # A stretch in which a joint does not move has no column of its own there.
            whole = np.unique(np.concatenate(acting))
            for k, rows in enumerate(acting):
                wide = np.zeros((len(parts[k]), len(whole), *parts[k].shape[2:]))
                wide[:, np.searchsorted(whole, rows)] = parts[k]
                parts[k] = wide
            acting = [whole]
        return acting[0], parts

    def _in_one_joint(
        self, signals: Signals, candidate: Candidate
    ) -> tuple[NDArray[np.int64], FloatArray] | None:
        """Return the same of one stretch, many points at once, where the effect can do that."""
        joint, grid = candidate.joint, candidate.grid
        part: FloatArray | None = None
        for begin in range(0, len(grid), _AT_ONCE):
            points = slice(begin, begin + _AT_ONCE)
            own = candidate.effect.own_columns(signals, joint, grid[points])
            if own is None:
                return None
            if part is None:
                part = np.empty((signals.band.count(len(own)), 1, len(grid), own.shape[2]))
            part[:, 0, points] = signals.in_band(own[:, None], [joint])[:, 0]
        return None if part is None else (np.array([joint]), part)

    def _in_all_joints(
        self, signals: Signals, candidate: Candidate
    ) -> tuple[NDArray[np.int64], FloatArray]:
        """Return the same of one stretch, one point of the grid after the other."""
        joint, grid = candidate.joint, candidate.grid
        columns = candidate.effect.columns(signals, joint, grid[0])
        rows = np.array([i for i in range(columns.shape[1]) if acts(columns[:, i])])
        if not len(rows):
            rows = np.array([max(joint, 0)])
        count = signals.band.count(len(columns))
        part = np.empty((count, len(rows), len(grid), columns.shape[2]))
        for g, inner in enumerate(grid):
            if g:
                columns = candidate.effect.columns(signals, joint, inner)
            part[:, :, g] = signals.in_band(columns[:, rows], rows.tolist())
        return rows, part

    def _own(self, signals: Signals, columns: FloatArray) -> FloatArray:
        """Return the columns filtered, without filtering joints that they are zero in."""
        result = np.zeros((signals.band.count(len(columns)), *columns.shape[1:]))
        for i in range(columns.shape[1]):
            if columns[:, i].any():
                own = np.ascontiguousarray(columns[:, i : i + 1])
                result[:, i] = signals.in_band(own, [i])[:, 0]
        return result

    def _left_by_library(self) -> list[list[FloatArray]]:
        """Return what the whole library leaves of each joint, by stretch (K,)."""
        left = []
        for i in range(self.robot.n):
            parts = []
            for s in range(len(self.signals)):
                stack = [self._Z[s][:, i]]
                for candidate, (rows, columns) in zip(self.candidates, self._C, strict=True):
                    at = np.flatnonzero(rows == i)
                    if len(at) and len(candidate.grid) <= _SMALL_GRID:
                        stack.append(columns[s][:, at[0]].reshape(len(columns[s]), -1))
                at = np.flatnonzero(self._S[i][0] == i)
                stack.append(self._S[i][1][s][:, at[0]].reshape(len(self._Z[s]), -1))
                parts.append(np.concatenate(stack, axis=1))
            X = np.concatenate(parts)
            y = np.concatenate([part[:, i] for part in self._y])
            size = np.linalg.norm(X, axis=0)
            X = X[:, size > 0.0] / size[size > 0.0]
            G = X.T @ X
            G += np.diag(np.full(len(G), _RIDGE))
            beta = np.linalg.solve(G, X.T @ y)
            residual = self._without_lines(i, y - X @ beta)
            ends = np.cumsum([len(part) for part in self._y])[:-1]
            left.append(np.split(residual, ends))
        return left

    def _leave_out_rests(self, resting: tuple[Signals, ...]) -> None:
        """Take out of both sides what joints may take at rest."""
        joints = range(self.robot.n)
        self.signals = resting
        for k, signals in enumerate(self.signals):
            for part in (self._Z[k], self._y[k]):
                without_rests(part, joints, signals.rests)
            for rows, parts in (*self._C, *self._S):
                without_rests(parts[k], rows.tolist(), signals.rests)

    def seen_alike(self, others: Sequence[Signals]) -> list[Signals]:
        """Return stretches of another recording, without rests where these are without."""
        return list(with_rests(others, self.signals) if self.without_rests else others)

    def _whiten(self, left: list[list[FloatArray]]) -> None:
        """Fit the noise to what is left of each joint, and whiten everything by it."""
        models = []
        for i, stretches in enumerate(left):
            least = _LEAST_NOISE * max(float(self.signals[0].scales.effort[i]), 1e-12)
            calm = self._calm(i, stretches) if self.without_rests else stretches
            models.append(fit_noise(calm or stretches, least))
        self.noise = tuple(models)
        self.bursts = self._find_bursts(left)
        rows = sum(len(part) - ORDER for part in self._y)
        self.known = np.full(self.robot.n, float(rows))
        if self.without_rests:
            self._rests = self.whitened_rests(self.signals)
            self.known = self._rests.known()
        self.y = self._masked(whiten_all(self._y, self.noise))
        blocks = self.settings.blocks
        if len(self.y) < 20 * blocks:
            raise DataError(
                f'{len(self.y)} samples are left of the recording in the band of '
                f'{self.signals[0].band.cutoff:.3g} Hz: record longer'
            )
        self.blocks = make_blocks(len(self.y), blocks, self.settings.folds)
        self.system = System.make(
            self._masked(whiten_all(self._Z, self.noise)),
            self.nominal.bound,
            self.nominal.prior,
            self.blocks,
        )
        self.columns = [self._products(*entry) for entry in self._C]
        self.structure_columns = [self._products(*entry) for entry in self._S]

    def _without_lines(self, i: int, residual: FloatArray) -> FloatArray:
        """
        Return what is left of a residual without the strongest points of the large grids.

        They are lines in position; left in, the noise model would whiten them away. The strongest
        is fitted and taken off, again and again, while it takes more than chance would.
        """
        for candidate, (rows, columns) in zip(self.candidates, self._C, strict=True):
            at = np.flatnonzero(rows == i)
            if not len(at) or len(candidate.grid) <= _SMALL_GRID:
                continue
            parts = [part[:, at[0]] for part in columns]
            C = np.ascontiguousarray(parts[0]) if len(parts) == 1 else np.concatenate(parts)
            inverse = np.linalg.pinv(squares(C[:, None]))
            kept: list[FloatArray] = []
            left = residual
            for _ in range(_LINES):
                d = (left @ C.reshape(len(C), -1)).reshape(C.shape[1:])
                gain = np.einsum('gk,gkl,gl->g', d, inverse, d)
                best = int(np.argmax(gain))
                if gain[best] < _LINE * float(left @ left) + _CHANCE * float(left @ left) / len(
                    left
                ):
                    break
                kept.append(C[:, best])
                X = np.concatenate(kept, axis=1)
                left = residual - X @ np.linalg.lstsq(X, residual, rcond=1e-9)[0]
            residual = left
        return residual

    def _products(self, rows: NDArray[np.int64], parts: Sequence[FloatArray]) -> CandidateColumns:
        noise = [self.noise[i] for i in rows]
        whitened = whiten_all(parts, noise)
        if self._rests is not None:
            self._rests.take_out(whitened, rows.tolist())
        if self.bursts.mask.any():
            whitened[self.bursts.mask[:, rows]] = 0.0
        return CandidateColumns.make(self.system, rows, whitened)

    def _masked(self, x: FloatArray) -> FloatArray:
        """Return whitened rows (rows, n, ...) in which rests and bursts say nothing, in place."""
        if self._rests is not None:
            self._rests.take_out(x, range(self.robot.n))
        x[self.bursts.mask] = 0.0
        return x

    def _find_bursts(self, left: list[list[FloatArray]]) -> Bursts:
        """Return where what the whole library leaves is far beyond noise, and refit the noise."""
        found = self._bursts(left)
        if found.mask.any():
            models = []
            for i, stretches in enumerate(left):
                calm = self._calm(i, stretches, found.mask[:, i])
                refitted = fit_noise(calm, 1e-12) if calm else self.noise[i]
                models.append(refitted)
            self.noise = tuple(models)
            found = self._bursts(left)
        return found

    def _calm(
        self,
        joint: int,
        stretches: Sequence[FloatArray],
        burst: NDArray[np.bool_] | None = None,
    ) -> list[FloatArray]:
        """
        Return the pieces of a residual in which a joint moves and no burst is.

        :param burst: by whitened row.
        """
        pieces = []
        first = 0
        for signals, x in zip(self.signals, stretches, strict=True):
            spoiled = ~_moving(signals, len(x))[:, joint]
            if burst is not None:
                spoiled[ORDER:] |= burst[first : first + len(x) - ORDER]
                first += len(x) - ORDER
            edges = np.flatnonzero(np.diff(np.concatenate([[True], spoiled, [True]])))
            pieces += [
                x[a:b]
                for a, b in zip(edges[::2], edges[1::2], strict=True)
                if b - a > _PIECE * ORDER
            ]
        return pieces

    def _bursts(self, left: list[list[FloatArray]]) -> Bursts:
        parts = [np.stack([x[s] for x in left], axis=1) for s in range(len(self.signals))]
        residual = np.concatenate([part[ORDER:] for part in parts])
        step = self.signals[0].band.output_step
        moving = np.concatenate(
            [_moving(s, len(part))[ORDER:] for s, part in zip(self.signals, parts, strict=True)]
        )
        times = np.concatenate(
            [
                signals.time[signals.band.first :: signals.band.factor][: len(part)][ORDER:]
                for signals, part in zip(self.signals, parts, strict=True)
            ]
        )
        return find_bursts(residual, times, step, self._load(len(residual)), moving)

    def _load(self, rows: int) -> FloatArray:
        """Return what the bodies behind their gears need (rows, n), smoothed [Nm or N]."""
        parts = []
        for signals, y in zip(self.signals, self._y, strict=True):
            body = signals.rigid - np.array(self.robot.armature) * signals.a
            smooth = signals.band.smooth(body, LOAD_SMOOTHER)
            parts.append(smooth[signals.band.first :: signals.band.factor][: len(y)][ORDER:])
        return np.concatenate(parts)[:rows]

    @property
    def feigned(self) -> float:
        """
        Return the largest share of a joint's noise that noise of position makes look like a cause.

        Simulated recordings hold none: it is known from the motion alone.
        """
        return max(signals.feigned for signals in self.signals)

    def unwhitened(self) -> tuple[FloatArray, FloatArray]:
        """
        Return residual (rows, n) and nominal columns (rows, n, p).

        In the band, in Nm or N, in the rows of the whitened ones.
        """
        y = np.concatenate([part[ORDER:] for part in self._y])
        Z = np.concatenate([part[ORDER:] for part in self._Z])
        return y, Z

    def split(self, rows: FloatArray) -> list[FloatArray]:
        """Return what has one entry per whitened row as one array per stretch."""
        ends = np.cumsum([len(part) - ORDER for part in self._y])[:-1]
        return np.split(rows, ends)

    def measured(self) -> FloatArray:
        """Return the measured effort in the band (rows, n), in the rows of the whitened ones."""
        parts = [signals.band.apply(signals.tau)[ORDER:] for signals in self.signals]
        return np.concatenate(parts)

    def measured_in_motion(self) -> FloatArray:
        """Return the same without what joints at rest may take, as residual and columns are."""
        parts = [signals.in_band(signals.tau)[ORDER:] for signals in self.signals]
        return np.concatenate(parts)

    def own_columns(self, effect: Term, joint: int, inner: Inner) -> FloatArray:
        """Return an effect's columns in the band (rows, n, k), in Nm or N."""
        parts = [
            self._own(signals, effect.columns(signals, joint, inner)) for signals in self.signals
        ]
        return np.concatenate([part[ORDER:] for part in parts])

    def single(self, effect: Term, joint: int, inner: Inner) -> CandidateColumns:
        """Return the whitened columns of an effect at one value of its inner parameters."""
        return self._products(*self._all_columns(Candidate(effect, joint, (inner,))))

    def inseparable(self, effect: Term) -> tuple[str, ...]:
        """Return the causes looked for that joint sensors cannot tell from an effect at all."""
        sought = {candidate.effect.identifier for candidate in self.candidates}
        return tuple(name for name in effect.inseparable if name in sought)

    def white(self, rng: np.random.Generator) -> FloatArray:
        """Return noise as whitened rows (rows, n) have it: less where a joint rests."""
        noise = rng.standard_normal(self.y.shape)
        return noise if self._rests is None else self._rests.take_out(noise, range(self.robot.n))

    def whitened_rests(self, stretches: Sequence[Signals]) -> WhitenedRests:
        """Return what joints at rest may take, as whitened rows of stretches have it."""
        return WhitenedRests(
            [s.rests for s in stretches],
            [s.band.count(len(s.q)) for s in stretches],
            [model.whitening for model in self.noise],
        )

    def friction_variants(self, rng: np.random.Generator) -> FloatArray:
        """
        Return the whitened difference (rows, n) between friction of another build-up and s.

        Coulomb friction along the same motion, position smoothed more or less, and the sign's
        displacement between a quarter and one and a half of what the nominal columns take: how
        friction turns around at a reversal is not known, and no cause.
        """
        parts = []
        share = rng.uniform(0.25, 1.5, self.robot.n)
        wider = float(rng.choice([1.0, 1.5, 3.0]))
        for signals in self.signals:
            if ('smooth', wider) not in signals.cache:
                signals.cache[('smooth', wider)] = signals.band.smooth(signals.q, wider)
            q = signals.cache[('smooth', wider)]
            difference = np.empty_like(q)
            for i in range(self.robot.n):
                scale = float(signals.scales.displacement[i] * share[i])
                z = dahl_path(np.ascontiguousarray(q[:, i]), scale)
                coulomb = float(np.nan_to_num(signals.scales.coulomb[i]))
                difference[:, i] = coulomb * (z - signals.sign[:, i])
            parts.append(signals.in_band(difference))
        return self._masked(whiten_all(parts, self.noise))


def _moving(signals: Signals, rows: int) -> NDArray[np.bool_]:
    """Return where no rest of a joint is seen, (rows, n) of the band."""
    result = np.ones((rows, signals.robot.n), dtype=np.bool_)
    for rest in signals.rests:
        result[rest.rows, rest.joint] = False
    return result


def _at_rest_is_unknown(left: Sequence[Sequence[FloatArray]], resting: Sequence[Signals]) -> bool:
    """
    Tell whether the library leaves notably more of a joint at rest than in motion.

    There the sign of the last motion is not what friction is at rest. One joint is enough: others
    creep as it does, though more noise in their motion may hide it.

    :param left: what is left of each joint, by stretch (K,).
    """
    for i, stretches in enumerate(left):
        moves = np.concatenate(
            [_moving(s, len(x))[:, i] for s, x in zip(resting, stretches, strict=True)]
        )
        if moves.any() and not moves.all():
            square = np.concatenate(stretches) ** 2
            if np.mean(square[~moves]) > _MORE_AT_REST * np.mean(square[moves]):
                return True
    return False
