# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What no candidate explains: the noise of the recordings, and contacts and impacts in it."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2

from sosml_friction.arrays import BoolArray, ColumnArray, FloatArray, IndexArray
from sosml_friction.regression.band import Band
from sosml_friction.regression.band_rows import SMALL_GRID, BandRows, columns_in_band
from sosml_friction.regression.candidate import Candidate
from sosml_friction.regression.chance import CHANCE, NEGLIGIBLE
from sosml_friction.regression.column_norms import COLLINEAR, ROUNDING
from sosml_friction.regression.kernels import ROWS_AT_ONCE, products, squares
from sosml_friction.regression.noise_model import NoiseModel, fit_noise
from sosml_friction.regression.signals import Signals
from sosml_friction.regression.wandering_friction import CYCLES, wandering_friction

#: At most this many points of a large grid are taken off. Halved and doubled, no answer of
#: ``python -m validation.sensitivity --seed 1`` changes.
_LINES = 16
#: Steps for the frequency of a line, of which each has the square of the error of the one before:
#: a fourth is of no account. Its slope over frequency is from this share of the grid's step.
_NEWTON, _SMALL = 3, 1e-3
#: Times at which a step is tried, at most. 15 ms of a minute. Halved and doubled, no answer of
#: ``python -m validation.sensitivity --seed 1`` changes.
_STEPS = 4096
#: How often what the library takes of noise is put back. Where it takes the share h, the power
#: that is missing is h^(k + 1) after k rounds: of 0.4 it is 3 %.
_FILLED = 3
#: The largest share of the known rows that a whole library may take of the joint in which it takes
#: least: 6 % of its noise are missing then. Of more, what is left looks like a structure.
MOST_TAKEN = 0.5
#: Draws of each round. Of a minute's noise below 1 Hz, which the library may take as a whole, the
#: power of one draw is off by 13 %, sqrt(2 / 120) of chi-squared, and of eight by 5 %.
_DRAWS = 8
#: Rows of flat noise to which its model is fitted: its power is off by 2 %, sqrt(2 / 4096).
_FLAT_ROWS = 4096
#: A point must also explain this many times the variance of a row. From chance alone one of 300
#: points does so with a probability of 300 exp(-15 / 2) = 0.17 (chi-squared, cosine and sine).
_CHANCE = 15.0


@dataclass(frozen=True)
class LibraryFit:
    """
    Hold the fit of all candidates together to one joint, by normal equations of columns of norm 1.

    ``told`` (K,): 1 for the rows that take part, 0 for others. ``norms`` (p,) of the columns that
    ``act``; ``products`` (p, p) of them in these rows, with the ridge.
    """

    rows: BandRows
    joint: int
    told: FloatArray
    act: BoolArray
    norms: FloatArray
    products: FloatArray

    def solved(self, r: FloatArray) -> FloatArray:
        """Return coefficients (p, ...) for products (p, ...) of the columns with efforts."""
        return np.asarray(np.linalg.solve(self.products, r), dtype=np.float64)

    def fitted(self, x: FloatArray) -> FloatArray:
        """Return what columns of norm 1 with coefficients (p, ...) are in all rows (K, ...)."""
        every = np.zeros((len(self.act), *x.shape[1:]))
        every[self.act] = (x.T / self.norms).T
        return np.concatenate(
            [
                _design_matrix(self.rows, self.joint, s, part) @ every
                for s, part in _parts(self.rows)
            ]
        )

    def taken(self, efforts: FloatArray) -> FloatArray:
        """Return what the fit takes of efforts (K, m), in all rows by those that take part."""
        efforts = efforts * self.told[:, None]
        r, first = np.zeros((len(self.act), efforts.shape[1])), 0
        for s, part in _parts(self.rows):
            X = _design_matrix(self.rows, self.joint, s, part)
            r += X.T @ efforts[first : first + len(X)]
            first += len(X)
        return self.fitted(self.solved(r[self.act] / self.norms[:, None]))

    def inverse_beside(self, columns: ColumnArray) -> FloatArray:
        """
        Return the inverse products (g, l, l) of what the fit leaves of columns (K, g, l).

        0 of columns of which it leaves nothing. In single precision, as the columns are.
        """
        shape = (len(self.norms), *columns.shape[1:])
        crossed, whole, first = np.zeros(shape), np.zeros((*shape[1:], shape[2])), 0
        weights = self.told.astype(columns.dtype)[:, None, None]
        for s, part in _parts(self.rows):
            X = _design_matrix(self.rows, self.joint, s, part)[:, self.act] / self.norms
            its = slice(first, first + len(X))
            first += len(X)
            own = columns[its] * weights[its]
            crossed += (X.astype(own.dtype).T @ own.reshape(len(own), -1)).reshape(shape)
            whole += squares(own[:, None])
        taken = self.solved(crossed.reshape(len(crossed), -1)).reshape(shape)
        left = whole - np.einsum('pgk,pgl->gkl', crossed, taken)
        some = np.einsum('gkk->g', left) > COLLINEAR * np.einsum('gkk->g', whole)
        result = np.zeros(left.shape)
        result[some] = np.linalg.pinv(left[some], hermitian=True)
        return result


@dataclass(frozen=True)
class LibraryResidual:
    """
    Hold what all candidates together leave of each joint, by stretch (K,) [Nm or N].

    ``steady``: the same without a step in time of effort or of friction. What changes once is no
    noise: a model of noise that had it would whiten it away. ``fits``: how it was left.
    """

    left: list[list[FloatArray]]
    steady: list[list[FloatArray]]
    fits: list[LibraryFit]

    def noise(
        self, joint: int, pieces: Callable[[list[FloatArray]], list[FloatArray]], least: float
    ) -> NoiseModel:
        """
        Return the noise of a joint: what is left, and what the library took of it.

        Some hundred functions, most of them slow, take noise as well, and most of what is slow. It
        is drawn from a model of it, as much of it as the library takes is put back, and the model
        is fitted again: the steps of an expectation maximisation with any coefficients of the
        library alike. The first model is flat in the band: where the library takes all, as it does
        of what is slow in a short recording, nothing says otherwise. Begun with what is left,
        noise would stay as small there as the library leaves it.

        :param pieces: which pieces of the stretches are of noise.
        """
        left, rng = self.steady[joint], np.random.default_rng(joint)
        *ends, count = np.cumsum([len(x) for x in left]).tolist()
        fit, told = self.fits[joint], self.fits[joint].told[:, None]
        model = flat_noise(fit.rows.signals[0].band, rng)
        own = np.concatenate(pieces(left))
        for k in range(_FILLED):
            drawn = np.column_stack([model.draw(count, rng) for _ in range(_DRAWS)])
            taken = fit.taken(drawn)
            if not k:
                # As large as leaves what is left, of which one row is known at least.
                kept = np.sum(told * (drawn - taken) ** 2) / _DRAWS / max(float(told.sum()), 1.0)
                one_row = float(np.mean(drawn**2)) / len(told)
                size = float(own @ own) / len(own) / max(float(kept), one_row)
                taken *= np.sqrt(size)
            filled = [np.split(np.concatenate(left) + own, ends) for own in taken.T]
            model = fit_noise([x for own in filled for x in pieces(own)], least)
        return model


def flat_noise(band: Band, rng: np.random.Generator) -> NoiseModel:
    """Return the model of noise that is white before the low-pass, of variance 1 there."""
    drawn = rng.standard_normal((_FLAT_ROWS * band.factor, 1))
    return fit_noise([band.apply(drawn)[:, 0]], 0.0)


def library_residual(rows: BandRows, pushed: BoolArray | None = None) -> LibraryResidual:
    """
    Return what all candidates together leave.

    :param pushed: rows of all stretches (rows, n) that take no part in the fit, None for none.
    """
    left, steady, fits = [], [], []
    counts = [len(part) for part in rows.residual]
    ends, every = np.cumsum(counts)[:-1], max(1, -(-sum(counts) // _STEPS))
    most = max(1, round(CYCLES / (rows.signals[0].band.cutoff * rows.signals[0].band.output_step)))
    for i in range(rows.signals[0].robot.n):
        effort = np.concatenate([part[:, i] for part in rows.residual])
        told: FloatArray = np.ones(len(effort))
        if pushed is not None:
            told[pushed[:, i]] = 0.0
        G, r, first = np.zeros(()), np.zeros(()), 0
        # A step of effort, and one of friction.
        sign = [s.in_band(s.sign[:, i : i + 1], [i])[:, 0] for s in rows.signals]
        steps = np.ones(len(effort)), np.concatenate(sign)
        sums: list[list[FloatArray]] = [[] for _ in steps]
        for s, part in _parts(rows):
            X = _design_matrix(rows, i, s, part)
            its = slice(first, first + len(X))
            first += len(X)
            X *= told[its, None]
            G, r = G + X.T @ X, r + X.T @ effort[its]
            for own, shape in zip(sums, steps, strict=True):
                weighted = X * shape[its, None]
                own.append(np.add.reduceat(weighted, np.arange(0, len(X), every)))
        norms = np.sqrt(np.diag(G))
        act = norms > 0.0
        norms = norms[act]
        G = G[np.ix_(act, act)] / norms / norms[:, None] + ROUNDING * np.eye(len(norms))
        fit = LibraryFit(rows, i, told, act, norms, G)
        fits.append(fit)
        residual = effort - fit.fitted(fit.solved(r[act] / norms))
        left.append(np.split(_without_lines(fit, residual), ends))
        starts = _starts(rows, every)
        found = [
            (_step(residual, told, shape, starts, np.concatenate(own)[:, act] / norms, G), shape)
            for own, shape in zip(sums, steps, strict=True)
        ]
        (gain, begin, height, beside), shape = max(found, key=lambda one: one[0][0])
        changing = np.zeros(len(effort))
        if gain:
            changing = fit.fitted(-height * beside)
            changing[begin:] += height * shape[begin:]
        changing += wandering_friction(residual - changing, steps[1], told, counts, most)
        if not changing.any():
            steady.append(left[-1])
            continue
        steady.append(np.split(_without_lines(fit, residual - changing), ends))
    return LibraryResidual(left, steady, fits)


def _starts(rows: BandRows, every: int) -> IndexArray:
    """Return every so manieth row of each part, counted through all of them."""
    starts, first = [], 0
    for s, part in _parts(rows):
        count = len(rows.residual[s][part])
        starts.append(first + np.arange(0, count, every))
        first += count
    return np.concatenate(starts)


def _step(
    residual: FloatArray,
    told: FloatArray,
    shape: FloatArray,
    starts: IndexArray,
    sums: FloatArray,
    G: FloatArray,
) -> tuple[float, int, float, FloatArray]:
    """
    Return the step in time that is in a residual: its gain, first row, height, and its fit.

    The gain is 0 where there is none. A step at any time gains as chi-squared of one degree of
    freedom has it, times the power of slow noise, which is seen at all other times: the best is
    one if it gains more than the largest of all would by chance.

    :param told: 1 for the rows that say something, 0 for others.
    :param shape: what the step is a multiple of from its time on: 1 for an effort, the sign of
        motion for a friction.
    :param starts: first rows of the chunks (C,) at which a step is tried.
    :param sums: of each chunk, the sums (C, p) of the library's columns, of size 1, times it.
    :param G: products of these columns (p, p).
    """
    after = np.cumsum(np.add.reduceat(residual * told * shape, starts)[::-1])[::-1]
    D = np.cumsum(sums[::-1], axis=0)[::-1]
    beside = np.linalg.solve(G, D.T)
    count = np.cumsum(np.add.reduceat(told * shape**2, starts)[::-1])[::-1]
    own = count - np.einsum('cp,pc->c', D, beside)
    # What the library can make of its columns is no step beside it.
    tried = own > COLLINEAR * count
    if not tried.any():
        return 0.0, 0, 0.0, np.zeros(len(G))
    own = np.where(tried, own, 1.0)
    gain = np.where(tried, after**2 / own, 0.0)
    best = int(np.argmax(gain))
    height = float(after[best] / own[best])
    # Of all others the gain is that of noise, once this one is taken off.
    overlap = count[np.maximum(np.arange(len(count)), best)] - D @ beside[:, best]
    others = (after - height * overlap)[tried] ** 2 / own[tried]
    usual = float(np.median(others)) / float(chi2.median(1))
    least = float(chi2.isf(CHANCE / tried.sum(), 1))
    share = gain[best] / max(float(np.sum(told * residual**2)), 1e-300)
    if gain[best] <= least * usual or share < NEGLIGIBLE:
        return 0.0, 0, 0.0, np.zeros(len(G))
    return float(gain[best]), int(starts[best]), height, beside[:, best]


def _parts(rows: BandRows) -> Iterator[tuple[int, slice]]:
    """Yield stretches and rows of them: all rows of all columns at once would be large."""
    for s, part in enumerate(rows.residual):
        for first in range(0, len(part), ROWS_AT_ONCE):
            yield s, slice(first, first + ROWS_AT_ONCE)


def _design_matrix(rows: BandRows, joint: int, s: int, part: slice) -> FloatArray:
    """Return a joint's nominal columns, small grids and free curves in rows of a stretch."""
    stack = [rows.nominal_columns[s][part, joint]]
    for candidate, columns in rows.in_joint(joint):
        if len(candidate.grid) <= SMALL_GRID:
            stack.append(columns[s][part].reshape(len(stack[0]), -1))
    joints, columns = rows.structure_columns[joint]
    stack.append(columns[s][part, int(np.argmax(joints == joint))].reshape(len(stack[0]), -1))
    return np.concatenate(stack, axis=1)


def _without_lines(fit: LibraryFit, residual: FloatArray) -> FloatArray:
    """
    Return a residual without the strongest points of the large grids.

    They are sinusoids of position, or loops over it; left in, the noise model would whiten them
    away. The strongest is fitted beside the library and taken off, again and again, while it takes
    more than chance would. What the library has of a sinusoid differs along its way: its curves
    follow it where they have many knots, and alone it would stay where they have few. Rows that
    take no part lose theirs as well.
    """
    told = fit.told
    for candidate, parts in fit.rows.in_joint(fit.joint):
        if len(candidate.grid) <= SMALL_GRID:
            continue
        C = np.ascontiguousarray(parts[0]) if len(parts) == 1 else np.concatenate(parts)
        inverse = fit.inverse_beside(C)
        kept: list[FloatArray] = []
        left = residual
        for _ in range(_LINES):
            seen = left * told
            d = products(seen[None], C.reshape(len(C), -1))[0].reshape(C.shape[1:])
            gain = np.einsum('gk,gkl,gl->g', d, inverse, d)
            best = int(np.argmax(gain))
            energy = float(seen @ seen)
            if gain[best] < NEGLIGIBLE * energy + _CHANCE * energy / len(seen):
                break
            kept.append(_line(fit, candidate, best, seen))
            X = np.concatenate(kept, axis=1)
            size = np.linalg.lstsq(X * told[:, None], residual * told, rcond=1e-9)[0]
            left = residual - X @ size
        residual = left
    return residual


def _line(fit: LibraryFit, candidate: Candidate, best: int, seen: FloatArray) -> FloatArray:
    """
    Return the columns (K, k) of the line next to a point of a grid, beside the library.

    Steps of Gauss and Newton for its frequency, between the points before and after.

    :param seen: what is left in the rows that say something, 0 in others.
    """
    (name,) = candidate.grid[best]
    values = [inner[name] for inner in candidate.grid[max(0, best - 1) : best + 2]]
    value, step = candidate.grid[best][name], _SMALL * (values[-1] - values[0])

    def columns(at: float) -> FloatArray:
        one = replace(candidate, grid=({name: at},))
        joints, parts = columns_in_band(fit.rows.signals, one)
        own = int(np.argmax(joints == fit.joint))
        return np.concatenate([part[:, own, 0] for part in parts])

    for _ in range(_NEWTON):
        slope = (columns(value + step) - columns(value - step)) / (2.0 * step)
        both = np.hstack([columns(value), slope])
        both -= fit.taken(both)
        X, D = np.split(both, 2, axis=1)
        size = np.linalg.lstsq(X * fit.told[:, None], seen, rcond=1e-9)[0]
        turned = np.column_stack([X, D @ size]) * fit.told[:, None]
        more = float(np.linalg.lstsq(turned, seen, rcond=1e-9)[0][-1])
        value = float(np.clip(value + more, values[0], values[-1]))
    line = columns(value)
    return line - fit.taken(line)


def in_motion(signals: Signals, rows: int) -> BoolArray:
    """Return where no rest of a joint is seen, (rows, n) of the band."""
    result = np.ones((rows, signals.robot.n), dtype=np.bool_)
    for rest in signals.rests:
        result[rest.rows, rest.joint] = False
    result[:, sorted(signals.silent)] = False
    return result
