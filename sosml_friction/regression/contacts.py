# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Short stretches that nothing explains: a touch of the robot, or teeth that change flanks."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import label, maximum_filter1d, uniform_filter1d

from sosml_friction.arrays import BoolArray, FloatArray, IndexArray
from sosml_friction.regression.chance import FEWEST, NEGLIGIBLE
from sosml_friction.regression.kernels import runs

#: A contact is looked for in the mean of the residual over this time [s]. Halved and doubled, no
#: answer of ``python -m validation.sensitivity --seed 1`` changes.
_WINDOW_S = 0.24
#: A mean that is off by more than this many robust standard deviations belongs to a contact.
#: Measured by ``python -m validation.leftovers``, seeds 424242, 20261213 and 20261283: the largest
#: of 174 recordings without one, of three plants, was 5.3. At 7 a null of ``python -m
#: validation.campaign --seed 20261284`` had one, where a joint all but stops.
_OVER = 9.0
#: Most of the mean square that a sine of a period and more within that time has in its mean:
#: 2 sinc(1.43)^2, the first side lobe. What has less there swings to both sides. Its first half
#: period does not: it is asked with the windows before and after.
_SWINGS = 0.094
#: Contacts over more than this share of the time, or more contacts than this, are none, but a
#: model that is wrong throughout. Halved and doubled, no answer of ``python -m
#: validation.sensitivity --seed 1`` changes.
_MOST, _MANY = 0.15, 12
#: Largest share of the rows of a motion that pushes may spoil. Halved and doubled, no answer of
#: ``python -m validation.sensitivity --seed 1`` changes.
_MOST_PUSHED = 0.75
#: Most rounds in which the two levels of a push are found: they settle in a few.
_ROUNDS = 100
#: Standard deviation of a normal distribution over its median absolute deviation.
_ROBUST = 1.4826

#: Impacts are looked for within this time before and after the load changes its sign [s]. Halved,
#: no answer of ``python -m validation.sensitivity --seed 1`` changes; doubled, one of nine does: a
#: gap is named that is else not seen.
_FLANKS_S = 0.15
#: A gear has backlash if the mean square around these changes is more than the first number of
#: times that of the rest, at the second number of changes or more, and if most of what the load
#: changes by is where an impact is. Measured for the first: the largest ratio of 10 simulated
#: gears without backlash was 3, the smallest of 6 with backlash was 6.6.
_IMPACT, _FEWEST, _MOST_OF_CHANGE = 4.5, 4, 0.5
#: An impact lasts while the mean square over this time [s] is that many times that of the rest,
#: too. Halved and doubled, no answer of ``python -m validation.sensitivity --seed 1`` changes.
_RINGING_S = 0.1
#: Impacts spoil less than this share of the rows in which a joint moves: what most of a motion is
#: made of is the motion. What a fit has of a push that the nominal model has not is less than
#: this share of it. By definition of a minority.
_MINORITY = 0.5


@dataclass(frozen=True)
class Contact:
    """
    Hold one contact of ``joint``, from ``start_s`` to ``end_s``; ``energy`` [variances].

    ``level`` [Nm or N]: how far the residual is from where it is otherwise, if a push is switched
    on and off; else NaN.
    """

    joint: int
    start_s: float
    end_s: float
    energy: float
    level: float = np.nan


@dataclass(frozen=True)
class Impacts:
    """
    Hold the impacts of a gear with a gap.

    ``changes``: how often the load of ``joint`` changed its sign; ``share`` of those with an
    impact, each counted by how far the load goes there; ``ratio``: mean square of what nothing
    explains around them and elsewhere.
    """

    joint: int
    changes: int
    share: float
    ratio: float


@dataclass(frozen=True)
class Contacts:
    """
    Hold contacts, impacts, and the whitened rows (rows, n) that they spoil.

    ``largest`` (n,): how far the largest mean to one side is off, in usual ones; 0 if none is.
    """

    contacts: tuple[Contact, ...]
    mask: BoolArray
    impacts: tuple[Impacts, ...]
    largest: FloatArray


def find_impacts(
    residual: FloatArray, load: FloatArray, step: float, moving: BoolArray
) -> tuple[tuple[Impacts, ...], BoolArray]:
    """
    Return the gears whose teeth hit the other flank, and the rows (rows,) that they spoil.

    A gear with a gap is free of load where what its body needs changes its sign: its motor then
    runs ahead and hits, and nowhere else. Across a gap g at a load that changes by r a second, a
    body of mass M comes with M (4.5 g^2 r / M)^(1/3): where the load hardly changes, in slow
    motion, noise hides it. Some folds have no such moment at all: that is why the energy is
    compared, and no waveform is predicted on data left out. What would spoil most of a joint's
    motion is no impact.

    :param residual: what the whole library leaves (rows, n) [Nm or N].
    :param load: what the body behind each gear needs (rows, n) [Nm or N].
    :param moving: rows (rows, n) that say something of a joint.
    """
    energy = residual**2
    spoiled = np.zeros(len(residual), dtype=bool)
    found: list[Impacts] = []
    joints = [(i, _sign_changes(x)) for i, x in enumerate(load.T)]
    width = max(2, round(_RINGING_S / step))
    done: set[int] = set()
    while True:
        seen = [
            _impacts(i, energy[:, i], load[:, i], changes, step, moving[:, i], spoiled)
            for i, changes in joints
            if i not in done
        ]
        hit = max((x for x in seen if x is not None), key=lambda x: x[0].ratio, default=None)
        if hit is None:
            return tuple(found), spoiled
        impacts, inside = hit
        done.add(impacts.joint)
        ring = inside.copy()
        for j, own in enumerate(energy.T):
            calm = moving[:, j] & ~inside & ~spoiled
            level = _mean(own[calm]) if calm.any() else np.inf
            over, count = label(uniform_filter1d(own, width) > _IMPACT * level)
            touching = np.unique(over[inside])
            ring |= np.isin(over, touching[touching > 0]) if count else False
        rows = spoiled | ring
        if all(rows[own].mean() < _MINORITY for own in moving.T if own.any()):
            found.append(impacts)
            spoiled |= ring


def _impacts(
    joint: int,
    energy: FloatArray,
    load: FloatArray,
    changes: IndexArray,
    step: float,
    moving: BoolArray,
    spoiled: BoolArray,
) -> tuple[Impacts, BoolArray] | None:
    """Return the impacts of one joint and the rows (rows,) around them; None for no backlash."""
    around = max(2, round(_FLANKS_S / step))
    windows = [slice(max(0, k - around), k + around) for k in changes]
    inside = np.zeros(len(energy), dtype=bool)
    for window in windows:
        inside[window] = True
    known = moving & ~spoiled
    here, rest = inside & known, ~inside & known
    # At rest, where rows say nothing, no impact would be seen.
    told = [w for w in windows if known[w].mean() > _MINORITY]
    if len(told) < _FEWEST or not rest.any():
        return None
    each = np.array([float(np.mean(energy[w][known[w]])) for w in told])
    change = np.array([float(np.ptp(load[w])) for w in told])
    level = _mean(energy[rest])
    share = float(change[each > _IMPACT * level].sum() / change.sum())
    ratio = float(energy[here].mean()) / level
    if ratio > _IMPACT and share > _MOST_OF_CHANGE:
        return Impacts(joint, len(told), share, ratio), inside
    return None


def _mean(x: FloatArray) -> float:
    """Return the mean of what is divided by."""
    return max(float(x.mean()), 1e-300)


def _sign_changes(load: FloatArray) -> IndexArray:
    """Return the rows at which a load has come to the other side of zero."""
    # Within noise of zero it has no sign.
    least = NEGLIGIBLE * float(np.sqrt(np.mean(load**2)))
    sided = np.flatnonzero(np.abs(load) > least)
    return sided[1:][np.diff(np.sign(load[sided])) != 0.0]


def find_contacts(
    residual: FloatArray,
    times: FloatArray,
    step: float,
    load: FloatArray | None = None,
    moving: BoolArray | None = None,
    expected: FloatArray | None = None,
    reach: int = 0,
    wrong: FloatArray | None = None,
    before: BoolArray | None = None,
) -> Contacts:
    """
    Return the stretches in which a residual is pushed to one side far beyond its usual size.

    By its mean over 0.24 s, against the median size of such means and what the model may be wrong
    by: a push has a mean, where a resonance swings to both sides.

    :param residual: what the whole library leaves (rows, n) [Nm or N].
    :param load: what the body behind each gear needs (rows, n) [Nm or N], to look for impacts.
    :param moving: rows (rows, n) that say something of a joint; None for all.
    :param expected: what the nominal model leaves (rows, n) [Nm or N]: it has half of a push at
        least, and one that is on as often as off is on where this is larger; None for
        ``residual``.
    :param reach: rows that a filter spreads the end of a push over.
    :param wrong: by how much the model may be wrong (rows, n) [Nm or N]; None for nothing.
    :param before: rows (rows, n) of the contacts that a fit with them has, where this one is
        without them: others are none, nor is a joint pushed that was not. None for a fit with
        them.
    """
    rows = len(residual)
    moving = np.ones(residual.shape, dtype=np.bool_) if moving is None else moving
    m = max(2, round(_WINDOW_S / step))
    mask = np.zeros(residual.shape, dtype=bool)
    wrong = np.zeros(residual.shape) if wrong is None else wrong
    largest = np.zeros(residual.shape[1])
    if rows < FEWEST * m:
        return Contacts((), mask, (), largest)
    contacts: list[Contact] = []
    impacts: tuple[Impacts, ...] = ()
    if load is not None:
        impacts, spoiled = find_impacts(residual, load, step, moving)
        mask |= spoiled[:, None]
        # An impact is no contact.
        residual = np.where(spoiled[:, None], 0.0, residual)
    for i in np.flatnonzero(moving.any(axis=0)).tolist():
        mean = np.abs(np.convolve(residual[:, i], np.full(m, 1.0 / m), mode='same'))
        doubt = np.convolve(wrong[:, i], np.full(m, 1.0 / m), mode='same')
        relative = mean / (usual(mean[moving[:, i]]) + doubt)
        one_way = mean**2 > 3.0 * _SWINGS * uniform_filter1d(residual[:, i] ** 2, 3 * m)
        relative[~one_way] = 0.0
        largest[i] = relative.max()
        over = maximum_filter1d((relative > _OVER).astype(np.int8), m) > 0
        nominal = (residual if expected is None else expected)[:, i]
        kept = [
            (a, b)
            for a, b in runs(over)
            if (before is None or before[a:b, i].any())
            # What touches is in the effort: else the fit that a touch elsewhere bends has made it.
            and np.abs(nominal[a:b]).sum() > _MINORITY * np.abs(residual[a:b, i]).sum()
        ]
        if not kept or len(kept) > _MANY or sum(b - a for a, b in kept) > _MOST * rows:
            if before is None or before[:, i].any():
                own, mine = _pushes(
                    i, residual[:, i], nominal, moving[:, i], times, m, reach, wrong[:, i]
                )
                contacts += own
                mask[:, i] |= mine
            continue
        variance = usual(np.abs(residual[moving[:, i], i])) ** 2
        for a, b in kept:
            mask[a:b, i] = True
            total = float((residual[a:b, i] ** 2).sum()) / variance
            contacts.append(Contact(i, float(times[a]), float(times[b - 1]), total))
    return Contacts(tuple(contacts), mask, impacts, largest)


def _pushes(
    joint: int,
    residual: FloatArray,
    expected: FloatArray,
    moving: BoolArray,
    times: FloatArray,
    least: int,
    reach: int,
    wrong: FloatArray,
) -> tuple[list[Contact], BoolArray]:
    """
    Return the pushes of a residual (rows,) that is at one of two levels, and the rows they spoil.

    A signal that something switches on and off, as often as it will: what most of the time is
    spent at is no usual size then, but the spread about each level is. Levels are those of least
    squares. Noise changes sides within a few rows; a push lasts for ``least`` rows on the average.
    """
    nothing: tuple[list[Contact], BoolArray] = ([], np.zeros(len(residual), dtype=bool))
    x = residual[moving]
    if not x.size or not np.ptp(x) > 0.0:
        return nothing
    edge = 0.5 * float(x.min() + x.max())
    for _ in range(_ROUNDS):
        low, high = x[x <= edge], x[x > edge]
        before, edge = edge, 0.5 * float(low.mean() + high.mean())
        if edge == before:
            break
    low, high = x[x <= edge], x[x > edge]
    centres = float(np.median(low)), float(np.median(high))
    within = usual(np.concatenate([np.abs(low - centres[0]), np.abs(high - centres[1])]))
    apart = centres[1] - centres[0]
    upper = residual > edge
    # Ends of shorter pushes would spoil more than that share of the rows.
    least = max(least, round(reach / (1.0 - _MOST_PUSHED)))
    doubt = max(float(wrong[moving & side].mean()) for side in (~upper, upper))
    if apart < _OVER * (within + doubt) or np.count_nonzero(np.diff(upper)) * least > len(
        residual
    ):
        return nothing
    sizes = [abs(float(np.median(expected[moving & side]))) for side in (~upper, upper)]
    pushed = moving & (upper if sizes[1] > sizes[0] else ~upper)
    found = [
        Contact(
            joint,
            float(times[a]),
            float(times[b - 1]),
            float((residual[a:b] ** 2).sum()) / within**2,
            apart,
        )
        for a, b in runs(pushed)
        if b - a > reach
    ]
    spoiled = maximum_filter1d(pushed.astype(np.int8), 2 * reach + 1) > 0
    # As many rows as that must say something of the rest.
    return (found, spoiled) if float(spoiled[moving].mean()) <= _MOST_PUSHED else nothing


def usual(sizes: FloatArray) -> float:
    """Return the robust standard deviation of what has these absolute values."""
    # Its square is a number still.
    return max(_ROBUST * float(np.median(sizes)), 1e-150)
