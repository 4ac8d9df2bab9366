# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
What one cause by itself removes of the effort error on data left out, and whether it carries over.

A cause's gain is that of the model with all causes over the one without it, both fitted to the
training data and nothing to the data left out. The other values are fitted anew without it: what
the nominal can take in its place (a bias for a constant of friction by direction) is not its gain.

With e the error with the cause, e_0 without, and d = e_0 - e what it predicts,

    |e_0|^2 - |e|^2 = |d|^2 (2 b - 1),   b = d' e_0 / d' d,

so that b, how much of what was predicted recurs, says it all: 1 where the cause carries over, 0
where nothing of it is there. It makes the error larger where b < 1/2, half-way between the two.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.diagnosis.decision.model_causes import tolerated
from sosml_friction.diagnosis.decision.selection import Selection
from sosml_friction.diagnosis.extended_model.cause_gain import CauseGain
from sosml_friction.diagnosis.extended_model.effort_error import HeldOut
from sosml_friction.diagnosis.extended_model.uncertain import Uncertain
from sosml_friction.regression.placed import with_amplitudes
from sosml_friction.regression.whitened import WhitenedRegression

Key = tuple[str, int]

#: Why a cause is taken back.
NOT_RECURRING = 'by its 95 % interval it may as well make the error of data left out larger'

#: Amplitudes of a term that are one size and a phase.
_WAVE = {'cosine', 'sine'}


def cause_gains(
    laboratory: WhitenedRegression, selection: Selection, held: HeldOut
) -> dict[Key, CauseGain]:
    """Return what each cause removes beside the others; harmonics of one are one cause."""
    error = held.error(selection.after, selection.accepted)
    result: dict[Key, CauseGain] = {}
    for key in dict.fromkeys(finding.key for finding in selection.accepted):
        own = [finding for finding in selection.accepted if finding.key == key]
        fewer = without(laboratory, selection, key)
        left = held.error(fewer.after, fewer.accepted)
        result[key] = _gain(laboratory, selection, held, own, error, left)
    return result


def without(laboratory: WhitenedRegression, selection: Selection, key: Key) -> Selection:
    """Return the selection fitted anew without a cause."""
    accepted = [finding for finding in selection.accepted if finding.key != key]
    return Selection(selection.before, selection.fit).refitted(laboratory, accepted)


def what_carries_over(
    laboratory: WhitenedRegression, selection: Selection, held: HeldOut
) -> tuple[Selection, dict[Key, CauseGain]]:
    """
    Return the causes that data left out do not contradict, fitted anew, and the gains of all.

    The one that contradicts most is left out first: beside it others may have seemed to do so.
    """
    gains: dict[Key, CauseGain] = {}
    kept = selection
    while True:
        now = cause_gains(laboratory, kept, held)
        # A cause that was left out keeps what was found of it then.
        gains.update(now)
        against = {key: gain for key, gain in now.items() if not gain.carries_over}
        if not against:
            return kept, gains
        worst = min(against, key=lambda key: against[key].recurs.value)
        kept = without(laboratory, kept, worst)


def what_recurs(laboratory: WhitenedRegression, selection: Selection, folds: HeldOut) -> Selection:
    """
    Take back the causes that may make the error of folds left out larger.

    The one that recurs least is the first, as in :func:`what_carries_over`. What is within its
    tolerance is a refit of the nominal model, which needs no such evidence.
    """
    while True:
        gains = cause_gains(laboratory, selection, folds)
        doubted = {key: gain.recurs for key, gain in gains.items() if not gain.shown}
        for key in tolerated(laboratory, selection) if doubted else ():
            doubted.pop(key, None)
        if not doubted:
            return selection
        worst = min(doubted, key=lambda key: doubted[key].value)
        taken = next(finding for finding in selection.accepted if finding.key == worst)
        taken = replace(taken, failed=(NOT_RECURRING,))
        fewer = [finding for finding in selection.accepted if finding.key != worst]
        selection = selection.refitted(laboratory, fewer).taken_back(taken)


def _gain(
    laboratory: WhitenedRegression,
    selection: Selection,
    held: HeldOut,
    own: Sequence[Finding],
    error: FloatArray,
    left: FloatArray,
) -> CauseGain:
    """Return the gain of the findings ``own`` of a cause, from the errors with it and without."""
    robot = laboratory.robot
    rows = np.unique(np.concatenate([finding.columns.rows for finding in own]))
    e, e_0 = error[:, rows], left[:, rows]
    # Each joint counts by what is left of it.
    scale = np.maximum(np.sqrt(np.mean(e**2, axis=0)), 1e-300)
    d = (e_0 - e) / scale
    # Standard errors are taken over as many stretches as a diagnosis has blocks.
    stretches = laboratory.settings.blocks
    without, with_it = (np.sqrt(np.mean(x**2, axis=0)) for x in (e_0, e))
    size, phase = _on_these(held, selection, own, rows, e_0 / scale, scale, stretches)
    return CauseGain(
        tuple(robot.names[i] for i in rows),
        tuple(robot.effort_units[i] for i in rows),
        without,
        with_it,
        tuple(removed(e_0[:, i], e[:, i], stretches) for i in range(len(rows))),
        _recurring(d, e_0 / scale, stretches),
        size,
        phase,
    )


def removed(e_0: FloatArray, e: FloatArray, stretches: int) -> Uncertain:
    """
    Return by how much a cause lowers the root mean square of errors of one joint, (rows,).

    With r what is left across d, |e_0|^2 = b^2 |d|^2 + |r|^2, |e|^2 = (1 - b)^2 |d|^2 + |r|^2: the
    slope of |e_0| - |e| over b is |d|^2 (b / |e_0| + (1 - b) / |e|). Its error is that of b, and
    not how it differs between stretches: of what acts in fast ones alone all is removed.
    """
    before, after = (float(np.sqrt(np.mean(x**2))) for x in (e_0, e))
    d = e_0 - e
    b = _recurring(d, e_0, stretches)
    slope = b.value / max(before, 1e-300) + (1.0 - b.value) / max(after, 1e-300)
    return Uncertain(before - after, abs(float(np.mean(d**2)) * slope) * b.std_error)


def _recurring(d: FloatArray, e_0: FloatArray, stretches: int) -> Uncertain:
    """Return the share b of what is predicted that is there, of one joint or of several."""
    d, e_0 = (x.reshape(len(x), -1) for x in (d, e_0))
    sums = _by_stretch(np.column_stack([(d * e_0).sum(1), (d * d).sum(1)]), stretches)
    return _jackknife(sums, lambda total: float(total[0] / max(total[1], 1e-300)))


def _on_these(
    held: HeldOut,
    selection: Selection,
    own: Sequence[Finding],
    rows: IndexArray,
    target: FloatArray,
    scale: FloatArray,
    stretches: int,
) -> tuple[Uncertain, float]:
    """Return size and phase [degrees] of a cause in data left out, beside what was found."""
    parts, found = [], []
    for finding, at in with_amplitudes(selection.accepted, held.nominal.shape[2]):
        if finding.key == own[0].key:
            parts.append(held.columns(finding)[:, rows] / scale[:, None])
            found.append(selection.after.x[at])
    C, x = np.concatenate(parts, axis=2), np.concatenate(found)
    k = len(x)
    # Amplitudes of one term have different units.
    unit = np.maximum(np.sqrt(np.mean(C**2, axis=(0, 1))), 1e-300)
    C, x = C / unit, x * unit
    sums = _by_stretch(
        np.column_stack(
            [
                np.einsum('rni,rnj->rij', C, C).reshape(len(C), k * k),
                np.einsum('rni,rn->ri', C, target),
            ]
        ),
        stretches,
    )

    def fitted(total: FloatArray) -> tuple[FloatArray, FloatArray]:
        G, r = total[: k * k].reshape(k, k), total[k * k : k * k + k]
        return np.linalg.pinv(G, rcond=1e-9, hermitian=True) @ r, G

    def size(total: FloatArray) -> float:
        b, G = fitted(total)
        there, predicted = float(b @ G @ b), float(x @ G @ x)
        return float(np.sqrt(max(there, 0.0) / max(predicted, 1e-300)))

    phase = np.nan
    if all(set(finding.effect.amplitudes) == _WAVE for finding in own):
        b, _ = fitted(sums.sum(axis=0))
        names = list(own[0].effect.amplitudes)
        cosine, sine = names.index('cosine'), names.index('sine')
        # Of the first harmonic, which explains most.
        turn = complex(b[cosine], -b[sine]) * complex(x[cosine], x[sine])
        phase = float(np.degrees(np.angle(turn)))
    return _jackknife(sums, size), phase


def _by_stretch(x: FloatArray, stretches: int) -> FloatArray:
    """Return the sums of columns (rows, c) by stretch, and how many rows, (stretches, c + 1)."""
    parts = np.array_split(x, min(stretches, len(x)))
    return np.array([[*part.sum(axis=0), len(part)] for part in parts])


def _jackknife(sums: FloatArray, of: Callable[[FloatArray], float]) -> Uncertain:
    """Return a function of sums over stretches, and its standard error by leaving each out."""
    total = sums.sum(axis=0)
    each = np.array([of(total - part) for part in sums])
    count = len(sums)
    error = np.sqrt((count - 1) / count * np.sum((each - each.mean()) ** 2))
    return Uncertain(of(total), float(error))
