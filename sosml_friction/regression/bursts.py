# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Short stretches that nothing explains: a touch of the robot, or teeth that change flanks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label, maximum_filter1d, uniform_filter1d

FloatArray = NDArray[np.float64]

_WINDOW_S = 0.24
#: A mean over a window that is so many robust standard deviations off belongs to a burst, if the
#: largest of its neighbours reaches the second number.
_OVER, _CLEAR = 7.0, 14.0
#: More of the time than this, or more bursts, is no touch, but a model that is wrong throughout.
_MOST, _MANY = 0.15, 12

#: The load that teeth pass on is smoothed at this share of the band: where it changes its sign is
#: asked, not how fast.
LOAD_SMOOTHER = 0.6
#: Teeth that change flanks are looked for so long before and after the load changes its sign [s].
_FLANKS_S = 0.15
#: The load has changed its sign when it is beyond this share of its root mean square.
_SIDE = 0.02
#: It is backlash where the mean square around these changes is so many times that of the rest,
#: with so many changes at least, and with so large a share of them above three times the rest.
#: Of 10 simulated gears without it the largest ratio was 3, of 6 with it the least 6.6.
_IMPACT, _FEWEST, _REGULAR = 4.5, 4, 0.6
#: What follows a change belongs to it while its mean square over this long [s] is so many times
#: that of the rest.
_RINGING_S, _RINGING = 0.1, 4.0


@dataclass(frozen=True)
class Episode:
    """Hold one burst: ``joint``, from ``start_s`` to ``end_s``, ``energy`` in noise variances."""

    joint: int
    start_s: float
    end_s: float
    energy: float


@dataclass(frozen=True)
class Impacts:
    """
    Hold the impacts of a gear with a gap.

    ``changes``: how often the load of ``joint`` changed its sign; ``share`` of those with an
    impact; ``ratio``: mean square of what nothing explains around them and elsewhere.
    """

    joint: int
    changes: int
    share: float
    ratio: float


@dataclass(frozen=True)
class Bursts:
    """Hold bursts, impacts, and the whitened rows (rows, n) they spoil."""

    episodes: tuple[Episode, ...]
    mask: NDArray[np.bool_]
    impacts: tuple[Impacts, ...] = ()


def find_impacts(
    residual: FloatArray, load: FloatArray, step: float, moving: NDArray[np.bool_]
) -> tuple[tuple[Impacts, ...], NDArray[np.bool_]]:
    """
    Return the gears whose teeth hit the other flank, and the rows (rows,) that they spoil.

    A gear with a gap is free of load where what its body needs changes its sign: its motor then
    runs ahead and hits, and nowhere else. So few moments are left out of some folds altogether,
    which is why it is asked where the energy is, and not whether a waveform predicts it.

    :param residual: what the whole library leaves (rows, n) [Nm or N].
    :param load: what the body behind each gear needs (rows, n) [Nm or N].
    :param step: time between rows [s].
    :param moving: rows (rows, n) that say something of a joint.
    """
    rows, n = residual.shape
    energy = residual**2
    around = max(2, round(_FLANKS_S / step))
    spoiled = np.zeros(rows, dtype=bool)
    found: list[Impacts] = []
    changes = [_sign_changes(load[:, i]) for i in range(n)]
    while True:
        best: tuple[Impacts, NDArray[np.bool_], float] | None = None
        for i in range(n):
            if any(impacts.joint == i for impacts in found) or len(changes[i]) < _FEWEST:
                continue
            inside = np.zeros(rows, dtype=bool)
            for k in changes[i]:
                inside[max(0, k - around) : k + around] = True
            known = moving[:, i] & ~spoiled
            here, rest = inside & known, ~inside & known
            if not here.any() or not rest.any():
                continue
            level = max(float(energy[rest, i].mean()), 1e-300)
            each = np.array(
                [
                    float(np.mean(energy[max(0, k - around) : k + around, i]))
                    for k in changes[i]
                    if not spoiled[k]
                ]
            )
            if len(each) < _FEWEST:
                continue
            share = float(np.mean(each > 3.0 * level))
            ratio = float(energy[here, i].mean()) / level
            if ratio > _IMPACT and share > _REGULAR and (best is None or ratio > best[0].ratio):
                best = Impacts(i, len(changes[i]), share, ratio), inside, level
        if best is None:
            return tuple(found), spoiled
        impacts, inside, _ = best
        found.append(impacts)
        ring = inside.copy()
        width = max(2, round(_RINGING_S / step))
        for j in range(n):
            calm = moving[:, j] & ~inside & ~spoiled
            level = max(float(energy[calm, j].mean()), 1e-300) if calm.any() else np.inf
            over, count = label(uniform_filter1d(energy[:, j], width) > _RINGING * level)
            touching = np.unique(over[inside])
            ring |= np.isin(over, touching[touching > 0]) if count else False
        spoiled |= ring


def _sign_changes(load: FloatArray) -> NDArray[np.int64]:
    """Return the rows at which a load has come to the other side of zero."""
    least = _SIDE * float(np.sqrt(np.mean(load**2)))
    sided = np.flatnonzero(np.abs(load) > least)
    return sided[1:][np.diff(np.sign(load[sided])) != 0.0]


def find_bursts(
    residual: FloatArray,
    times: FloatArray,
    step: float,
    load: FloatArray | None = None,
    moving: NDArray[np.bool_] | None = None,
) -> Bursts:
    """
    Return the stretches in which a residual is pushed to one side far beyond its usual size.

    By its mean over 0.24 s, against the median size of such means: a push has a mean, where a
    resonance swings to both sides.

    :param residual: what the whole library leaves (rows, n) [Nm or N].
    :param times: of the rows (rows,) [s].
    :param step: time between rows [s].
    :param load: what the body behind each gear needs (rows, n) [Nm or N], to look for impacts.
    :param moving: rows (rows, n) that say something of a joint; None for all.
    """
    rows, n = residual.shape
    moving = np.ones(residual.shape, dtype=np.bool_) if moving is None else moving
    m = max(2, round(_WINDOW_S / step))
    mask = np.zeros((rows, n), dtype=bool)
    episodes: list[Episode] = []
    if rows < 20 * m:
        return Bursts((), mask)
    impacts: tuple[Impacts, ...] = ()
    if load is not None:
        impacts, spoiled = find_impacts(residual, load, step, moving)
        mask |= spoiled[:, None]
        # They are no touch.
        residual = np.where(spoiled[:, None], 0.0, residual)
    for i in np.flatnonzero(moving.any(axis=0)).tolist():
        mean = np.convolve(residual[:, i], np.full(m, 1.0 / m), mode='same')
        usual = max(1.4826 * float(np.median(np.abs(mean[moving[:, i]]))), 1e-300)
        relative = np.abs(mean) / usual
        over = maximum_filter1d((relative > _OVER).astype(np.int8), m) > 0
        edges = np.flatnonzero(np.diff(np.concatenate([[False], over, [False]])))
        kept = [
            (int(a), int(b))
            for a, b in zip(edges[::2], edges[1::2], strict=True)
            if relative[a:b].max() > _CLEAR
        ]
        if not kept or len(kept) > _MANY or sum(b - a for a, b in kept) > _MOST * rows:
            continue
        size = max(1.4826 * float(np.median(np.abs(residual[moving[:, i], i]))), 1e-300)
        for a, b in kept:
            mask[a:b, i] = True
            total = float((residual[a:b, i] ** 2).sum()) / size**2
            episodes.append(Episode(i, float(times[a]), float(times[b - 1]), total))
    return Bursts(tuple(episodes), mask, impacts)
