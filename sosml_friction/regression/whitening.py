# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How rows in the band become white: the noise of each joint, and the rows that say nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from sosml_friction.arrays import BoolArray, ColumnArray, FloatArray, IndexArray
from sosml_friction.regression.band_rows import BandRows
from sosml_friction.regression.contacts import Contacts, find_contacts
from sosml_friction.regression.evidence import whiten_all
from sosml_friction.regression.kernels import runs
from sosml_friction.regression.library_residual import LibraryResidual, in_motion
from sosml_friction.regression.noise_model import ORDER, NoiseModel
from sosml_friction.regression.rests import WhitenedRests, still
from sosml_friction.regression.signals import Signals

#: Noise is fitted to pieces of more rows than this many times its order: a piece gives ORDER rows
#: less than it has, and so at least three quarters of them.
_PIECE = 4
#: Smallest standard deviation of noise, as a share of the effort's root mean square.
_LEAST_NOISE = 1e-6


@dataclass(frozen=True)
class Whitening:
    """
    Hold the noise of each joint, and where whitened rows say nothing.

    ``contacts``: contacts and impacts; ``standstill``: None where no joint rests and the effort of
    every one is known.
    """

    noise: tuple[NoiseModel, ...]
    contacts: Contacts
    standstill: WhitenedRests | None = None

    @classmethod
    def fit(
        cls,
        rows: BandRows,
        libraries: Sequence[LibraryResidual],
        pushed: BoolArray,
        tolerance: float,
    ) -> Whitening:
        """
        Return the whitening of the noise in a residual.

        :param libraries: what it leaves, fitted to all rows and, if there are any ``pushed`` ones,
            without these: noise is what is steady, and a push need not be. Pushes that are none
            once it is fitted without them take part again.
        :param pushed: rows of all stretches (rows, n) that the last one was fitted without.
        """
        before = None
        if pushed.any():
            ends = np.cumsum([len(part) for part in rows.residual])[:-1]
            before = np.concatenate([own[ORDER:] for own in np.split(pushed, ends)])
        contacts = _contacts(rows, libraries[-1].left, tolerance, before)
        library, spoiled = libraries[0], contacts.mask
        if before is not None and contacts.contacts:
            library, spoiled = libraries[-1], spoiled | before
        models = []
        for i in range(rows.signals[0].robot.n):
            least = _LEAST_NOISE * max(float(rows.signals[0].scales.effort[i]), 1e-12)
            pieces = partial(_pieces, rows.signals, i, spoiled[:, i])
            models.append(library.noise(i, pieces, least))
        result = cls(tuple(models), contacts)
        if any(s.rests or s.silent for s in rows.signals):
            return replace(result, standstill=result.rests(rows.signals))
        return result

    def rests(self, stretches: Sequence[Signals]) -> WhitenedRests:
        """Return what joints at rest may take and silent ones say, in whitened rows."""
        return WhitenedRests(
            [s.rests for s in stretches],
            [s.band.count(len(s.q)) for s in stretches],
            [model.whitening for model in self.noise],
            [s.silent for s in stretches],
        )

    def apply(self, parts: Sequence[ColumnArray], joints: IndexArray | None = None) -> ColumnArray:
        """Return (K, m, ...) of ``joints``, None for all, whitened and joined; 0: says nothing."""
        joints = np.arange(len(self.noise)) if joints is None else joints
        x = whiten_all(parts, [self.noise[i] for i in joints])
        if self.standstill is not None:
            self.standstill.take_out(x, joints.tolist())
        if self.contacts.mask.any():
            x[self.contacts.mask[:, joints]] = 0.0
        return x


def _pieces(
    signals: Sequence[Signals],
    joint: int,
    contact: BoolArray,
    stretches: Sequence[FloatArray],
) -> list[FloatArray]:
    """
    Return the pieces of a residual that are noise: without contacts and rests.

    Shorter ones where none is long enough, and all that is known where there is none.
    """
    told = [(s, x) for s, x in zip(signals, stretches, strict=True) if joint not in s.silent]
    if not contact.any() and not any(s.rests for s in signals):
        return [x for _, x in told] or list(stretches)
    pieces = []
    first = 0
    for s, x in zip(signals, stretches, strict=True):
        spoiled = ~in_motion(s, len(x))[:, joint]
        spoiled[ORDER:] |= contact[first : first + len(x) - ORDER]
        first += len(x) - ORDER
        if joint not in s.silent:
            pieces += [x[a:b] for a, b in runs(~spoiled) if b - a > ORDER]
    long = [piece for piece in pieces if len(piece) > _PIECE * ORDER]
    return long or pieces or [x for _, x in told] or list(stretches)


def pushed_rows(
    rows: BandRows,
    left: Sequence[Sequence[FloatArray]],
    tolerance: float,
) -> BoolArray:
    """Return the rows of all stretches in the band (rows, n) that are none of a motion alone."""
    found = _contacts(rows, left, tolerance)
    parts, first = [np.zeros(part.shape, dtype=np.bool_) for part in rows.residual], 0
    if found.contacts:
        for own in parts:
            own[ORDER:] = found.mask[first : first + len(own) - ORDER]
            first += len(own) - ORDER
    return np.concatenate(parts)


def _contacts(
    rows: BandRows,
    left: Sequence[Sequence[FloatArray]],
    tolerance: float,
    before: BoolArray | None = None,
) -> Contacts:
    """
    Return where the residual of the library is far beyond noise.

    A joint at rest has any friction up to that of motion, to either side: what is within twice
    that is no push. Nor is what a model whose numbers are refitted may be wrong by in its
    equations, nor what a reversal may add: all of them share what is fitted, and each may be
    another one.

    :param tolerance: of these numbers: in its square the equations may be wrong, as shares.
    :param before: whitened rows (rows, n) of contacts that the library was fitted without.
    """
    second = tolerance**2
    friction = 2.0 * _coulomb(rows)
    parts = []
    band = rows.signals[0].band
    reversing = [k for k, name in enumerate(rows.nominal.names) if ' reversal ' in name]
    most = rows.nominal.bound[reversing]
    for s, Z, nominal, *own in zip(
        rows.signals, rows.nominal_columns, rows.residual, *left, strict=True
    ):
        x = np.stack(own, axis=1)
        moves, seen = in_motion(s, len(x)), slice(ORDER, len(x))
        # Nor is what is left of a slow plateau, where hardly anything acts, that of a motion.
        rests = sorted({rest.joint for rest in s.rests})
        slow = s.band.at_rows(still(s.q, s.band, s.scales.sign_limit, s.scales.speed))
        moves[:, rests] &= ~slow[:, rests]
        # What the body behind each gear needs, without the motor's own rotor.
        body = s.band.smooth(s.rigid - np.array(s.robot.armature) * s.a, 1.0)
        residual = x - np.where(moves, 0.0, np.clip(x, -friction, friction))
        wrong = second * np.abs(s.band.apply(s.tau))
        wrong += moves * (np.abs(Z[:, :, reversing]) @ most)
        columns = (residual, s.band.at_rows(s.time), s.band.at_rows(body), moves, nominal, wrong)
        parts.append([column[seen] for column in columns])
    residual, times, load, moving, expected, wrong = map(np.concatenate, zip(*parts, strict=True))
    reach = band.reach + ORDER
    step = band.output_step
    return find_contacts(residual, times, step, load, moving, expected, reach, wrong, before)


def _coulomb(rows: BandRows) -> FloatArray:
    """Return the level of friction (n,) that the nominal columns alone have in the recordings."""
    names, signals = rows.nominal.names, rows.signals[0]
    result = np.nan_to_num(signals.scales.coulomb)
    X, y = np.concatenate(rows.nominal_columns), np.concatenate(rows.residual)
    for i, joint in enumerate(signals.robot.names):
        name = f'{joint} coulomb'
        if name in names:
            x, *_ = np.linalg.lstsq(X[:, i], y[:, i], rcond=None)
            result[i] += x[names.index(name)]
    return np.asarray(np.abs(result))
