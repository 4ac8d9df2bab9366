# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What friction does while a joint rests: unknown, and so taken out of both sides."""

from collections.abc import Collection, Sequence
from itertools import zip_longest

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d
from scipy.signal import lfilter

from sosml_friction.arrays import BoolArray, ColumnArray, FloatArray
from sosml_friction.regression.band import Band
from sosml_friction.regression.column_norms import COLLINEAR, column_norms
from sosml_friction.regression.kernels import hats, runs
from sosml_friction.regression.noise_model import ORDER
from sosml_friction.regression.rest import Rest
from sosml_friction.regression.row_bases import RowBases

#: A joint stands still where it is slower than this share of its top speed over one cycle of the
#: band. Doubled, no answer of ``python -m validation.sensitivity --seed 1`` changes; halved, one
#: of nine does: a gap is named that is else not seen.
STILL = 0.02
#: A joint that goes on as slowly for so many displacements of its sign does not rest. Between the
#: creep of the emulator, 4.5 at most, and plateaus of 10 mm/s of a slide, 41 and more (no command
#: prints these; ``test/regression/test_rests.py`` has a joint of either kind).
_ON = 10.0
#: A standstill of more cycles of the band and more time [s] than these is a stop; a shorter one is
#: a reversal in passing. Halved and doubled, no answer of ``python -m validation.sensitivity
#: --seed 1`` changes.
_STOP, _STOP_S = 3.0, 0.2
#: Rests that overlap are one for so many rows of the band at most: time and memory of one base
#: grow with the third and the second power. Chosen so that a parting, 2 half / factor + ORDER = 26
#: rows, costs 5 % of them.
_LONGEST = 512


def resting(q: FloatArray, band: Band, most: float, cycles: float = 1.0) -> list[tuple[int, int]]:
    """
    Return where a joint is slow enough to rest, as samples (from, to).

    All that is in so many cycles of the band in which it goes no further than ``most``.
    """
    size = max(3, round(cycles / (band.cutoff * band.step)))
    if len(q) < size:
        return []
    way = maximum_filter1d(q, size) - minimum_filter1d(q, size)
    still = maximum_filter1d((way <= most).astype(np.int8), size).astype(bool)
    return runs(still)


def turning(q: FloatArray, limit: float) -> list[tuple[int, int]]:
    """
    Return where a joint is within ``limit`` of where it turns around, as samples (from, to).

    There it may stick, for any time, and friction is anything up to that of motion to either side.
    """
    moves = np.flatnonzero(np.diff(q))
    forwards = q[moves + 1] > q[moves]
    near = np.zeros(len(q), dtype=np.bool_)
    for k in moves[1:][forwards[1:] != forwards[:-1]].tolist():
        if near[k]:
            continue
        # Windows grow until both ends have left the place.
        reach = 1
        while True:
            begin, end = max(0, k - reach), min(len(q), k + reach + 1)
            away = np.abs(q[begin:end] - q[k]) > limit
            if (begin == 0 or away[: k - begin].any()) and (
                end == len(q) or away[k - begin :].any()
            ):
                break
            reach *= 2
        before = np.flatnonzero(away[: k - begin])
        after = np.flatnonzero(away[k - begin :])
        first = begin + int(before[-1]) + 1 if len(before) else begin
        last = k + int(after[0]) if len(after) else end
        near[first:last] = True
    return runs(near)


def _stops_in_passing(q: FloatArray, band: Band, limit: float) -> list[tuple[int, int]]:
    """
    Return where a joint may have stopped for a moment and gone on the same way, as (from, to).

    It goes no further than ``limit`` in half a cycle of the band, the shortest that position as it
    is smoothed can tell, but for no longer than a stop takes: what is as slow for longer is a
    motion.
    """
    half, most = max(3, round(0.5 / (band.cutoff * band.step))), _stop(band)
    return [
        (a, b)
        for a, b in resting(q, band, limit, 0.5)
        if b - a <= most
        and (q[a] - q[max(a - half, 0)]) * (q[min(b - 1 + half, len(q) - 1)] - q[b - 1]) > 0.0
    ]


def _slow(q: FloatArray, band: Band, limit: float, speed: float) -> list[tuple[int, int]]:
    """
    Return where a joint is slow enough to rest, and does not go on, as samples (from, to).

    One that rests gives way by about ``limit``, whatever the time; one that creeps, by little
    more. One that goes on the same way moves, however slowly: by half of the limit in each half of
    the time of a stop, and by many limits in all. A plateau of a speed ladder does.
    """
    found = resting(q, band, _most(limit, speed, band))
    half = round(0.5 * _stop(band))
    slow = np.zeros(len(q), dtype=np.bool_)
    for begin, end in found:
        slow[begin:end] = True
        own = q[begin:end]
        if len(own) <= 2 * half:
            continue
        way = own[half:] - own[:-half]
        for sign in (1.0, -1.0):
            on = sign * way > 0.5 * limit
            # Of windows of a stop, by their first samples.
            for first, last in runs(on[:-half] & on[half:]):
                last += 2 * half - 1
                if abs(own[last] - own[first]) > _ON * limit:
                    slow[begin + first : begin + last + 1] = False
    return runs(slow)


def _most(limit: float, speed: float, band: Band) -> float:
    """Return how far a joint goes at most in a cycle in which it may stick."""
    return min(limit, STILL * speed / band.cutoff)


def _stop(band: Band) -> float:
    """Return how many samples a stop takes."""
    return max(_STOP / band.cutoff, _STOP_S) / band.step


def still(q: FloatArray, band: Band, limit: FloatArray, speed: FloatArray) -> BoolArray:
    """Return where joints are slow enough to stick, in passing too, (N, n)."""
    result = np.zeros(q.shape, dtype=np.bool_)
    for i in range(q.shape[1]):
        own = np.ascontiguousarray(q[:, i])
        for begin, end in resting(own, band, _most(float(limit[i]), float(speed[i]), band)):
            result[begin:end, i] = True
    return result


def stopping_joints(
    stretches: Sequence[tuple[FloatArray, Band]],
    limit: FloatArray,
    speed: FloatArray,
) -> list[int]:
    """
    Return the joints that stop between two motions: their rests are rests.

    A joint that is nowhere slow for three cycles and 0.2 s only reverses. A stop at an end of a
    stretch does not count: a hole may have cut it.

    :param limit: way over which the sign of motion may change [rad or m]; ``speed``: the top one.
    """
    result = []
    for i in range(len(limit)):
        for q, band in stretches:
            long = _stop(band)
            own = np.ascontiguousarray(q[:, i])
            found = _slow(own, band, float(limit[i]), float(speed[i]))
            if any(b - a > long and a > 0 for a, b in found):
                result.append(i)
                break
    return result


def find_rests(
    q: FloatArray,
    band: Band,
    limit: FloatArray,
    speed: FloatArray,
    joints: Sequence[int],
    turns: Collection[int] = (),
) -> tuple[Rest, ...]:
    """
    Return the rests of ``joints`` in one stretch, and where those of ``turns`` turn around.

    At standstill, friction equals the load, up to breakaway. Where a joint creeps, friction falls
    slowly. Motion below the resolution of position tells neither: any time course of effort may be
    friction. Piecewise linear courses with a knot at each row of the band are low-passed, and what
    they span is taken out of both sides.

    A joint that stands throughout the stretch has no rest: nothing would be left of it.

    :param joints: of :func:`stopping_joints`; ``limit`` and ``speed`` as there.
    """
    result: list[Rest] = []
    for i in sorted({*joints, *turns}):
        own = np.ascontiguousarray(q[:, i])
        found = _slow(own, band, float(limit[i]), float(speed[i]))
        if found == [(0, len(q))]:
            continue
        found += _stops_in_passing(own, band, float(limit[i]))
        if i in turns:
            around = turning(own, float(limit[i]))
            # One that turns around most of the time does not move: that is noise of position.
            if 2 * sum(end - begin for begin, end in around) <= len(q):
                found += around
        stuck = np.zeros(len(q), dtype=np.bool_)
        for begin, end in found:
            stuck[begin:end] = True
        if not stuck.all():
            for begin, end in runs(stuck):
                result += _pieces(i, begin, end, len(q), band)
    return _joined(result)


def _pieces(joint: int, begin: int, end: int, samples: int, band: Band) -> list[Rest]:
    """Return one rest, from sample ``begin`` to ``end``, as the rows of the band see it."""
    count = band.count(samples)
    # Row k of the band sees the samples from k factor to k factor + 2 half.
    first = max(0, -((2 * band.half - begin) // band.factor))
    last = min(count, (end - 1) // band.factor + 1)
    inside = slice(
        -(-begin // band.factor), min(count, (end - 1 - 2 * band.half) // band.factor + 1)
    )
    if inside.stop <= inside.start:
        inside = slice(last, last)
    pieces = []
    for rows in (slice(first, inside.start), inside, slice(inside.stop, last)):
        if rows.stop > rows.start:
            base = None if rows is inside else _courses(rows, begin, end, band)
            pieces.append(Rest(joint, rows, base))
    return pieces


def _courses(rows: slice, begin: int, end: int, band: Band) -> FloatArray:
    """Return what courses of effort between two samples are in rows that see others too."""
    low, high = rows.start * band.factor, (rows.stop - 1) * band.factor + 2 * band.half + 1
    t = np.arange(low, high)
    begin, end = max(begin, low), min(end, high)
    knots = np.linspace(begin, end - 1, max(2, round((end - begin) / band.factor) + 1))
    inside = (t >= begin) & (t < end)
    return _span(band.apply(hats(t, knots) * inside[:, None]))


def _span(columns: FloatArray) -> FloatArray:
    """Return an orthonormal base of columns, but for what is small beside the largest."""
    # The stop band of the filter is above that, 2e-3 (-53 dB).
    U, size, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(U[:, size > COLLINEAR * size.max()])


def _joined(rests: Sequence[Rest]) -> tuple[Rest, ...]:
    """
    Return the rests with those of a joint that see the same rows as one.

    A long chain of them is parted: the rows that both parts see, and as many as the whitening
    filter reaches, then say nothing.
    """
    result: list[Rest] = []
    for chain in _chains(rests):
        if chain[0].base is None:
            result += chain
            continue
        parts: list[list[Rest]] = []
        for rest in chain:
            if not parts or rest.rows.start - parts[-1][0].rows.start > _LONGEST:
                parts.append([])
            parts[-1].append(rest)
        begin, last = chain[0].rows.start, max(rest.rows.stop for rest in chain)
        for part, after in zip_longest(parts, parts[1:]):
            end = after[0].rows.start if after else last
            if end > begin:
                result.append(_together(part, slice(begin, end)))
            if after:
                begin = min(max(end + ORDER, *(rest.rows.stop for rest in part)), last)
                result.append(Rest(chain[0].joint, slice(end, begin), None))
    return tuple(result)


def _chains(rests: Sequence[Rest]) -> list[list[Rest]]:
    """Return groups of rests of a joint, each of which sees rows that one before it sees."""
    result: list[list[Rest]] = []
    stop = 0
    for rest in rests:
        before = result[-1][-1] if result else None
        if (
            before is None
            or before.joint != rest.joint
            or stop <= rest.rows.start
            or before.base is None
            or rest.base is None
        ):
            result.append([])
            stop = 0
        result[-1].append(rest)
        stop = max(stop, rest.rows.stop)
    return result


def _together(rests: Sequence[Rest], rows: slice) -> Rest:
    """Return several rests of a joint as one, in ``rows`` alone."""
    begin = min(rest.rows.start for rest in rests)
    bases = [(rest.rows.start - begin, rest.base) for rest in rests if rest.base is not None]
    columns = np.zeros((max(rest.rows.stop for rest in rests) - begin,
                        sum(base.shape[1] for _, base in bases)))  # fmt: skip
    k = 0
    for first, base in bases:
        columns[first : first + len(base), k : k + base.shape[1]] = base
        k += base.shape[1]
    return Rest(rests[0].joint, rows, _span(columns[rows.start - begin : rows.stop - begin]))


class WhitenedRests:
    """
    Hold what efforts at rest are in whitened rows, in all stretches joined.

    A whitening filter of ``order`` past rows spreads them: whitened rows that see nothing but a
    rest are zero, and the others are freed of the filtered bases and of the last rows inside,
    whose values are not known and still in the filter's history.

    :param rests: of each stretch; ``counts``: its rows of the band.
    :param whitening: filters of the joints, (order + 1,) each.
    :param silent: joints of each stretch whose rows say nothing at all.
    """

    def __init__(
        self,
        rests: Sequence[Sequence[Rest]],
        counts: Sequence[int],
        whitening: Sequence[FloatArray],
        silent: Sequence[Collection[int]] = (),
    ) -> None:
        order = len(whitening[0]) - 1
        rows = sum(count - order for count in counts)
        #: Rows (rows, n) that are zero.
        self.inside = np.zeros((rows, len(whitening)), dtype=np.bool_)
        bases: list[Rest] = []
        first = -order
        silences = silent or [()] * len(counts)
        for own, count, without in zip(rests, counts, silences, strict=True):
            for i, weights in enumerate(whitening):
                if i in without:
                    self.inside[first + order : first + count, i] = True
                    continue
                mine = [rest for rest in own if rest.joint == i]
                inside = np.zeros(count, dtype=np.bool_)
                for rest in mine:
                    if rest.base is None:
                        inside[rest.rows] = True
                self.inside[first + order : first + count, i] = inside[order:]
                for begin, columns in _clusters(mine, weights, inside):
                    cut = max(0, order - begin)
                    if not columns[cut:].any():
                        continue
                    base = _span(columns[cut:] / column_norms(columns[cut:]))
                    start = first + begin + cut
                    bases.append(Rest(i, slice(start, start + len(base)), base))
            first += count - order
        self._bases = RowBases(bases)

    def known(self) -> FloatArray:
        """Return how many rows of each joint say something (n,): those left less the freed."""
        freed = [self._bases.rank(joint) for joint in range(self.inside.shape[1])]
        return np.asarray((~self.inside).sum(axis=0) - np.array(freed, dtype=np.float64))

    def reached(self) -> BoolArray:
        """Return the rows (rows, n) from which rests take all or a part."""
        reached = self.inside.copy()
        for joint, rows in self._bases.rows():
            reached[rows, joint] = True
        return reached

    def take_out(self, x: ColumnArray, joints: Sequence[int]) -> ColumnArray:
        """Take what efforts at rest may be out of whitened ``x`` (rows, m, ...), in place."""
        for k, joint in enumerate(joints):
            x[self.inside[:, joint], k] = 0.0
        return self._bases.take_out(x, joints)


def _clusters(
    rests: Sequence[Rest], weights: FloatArray, inside: BoolArray
) -> list[tuple[int, FloatArray]]:
    """Return whitened nuisances of one joint, those that overlap as one: first row, columns."""
    order = len(weights) - 1
    result: list[tuple[int, FloatArray]] = []
    for rest in sorted(rests, key=lambda rest: rest.rows.start):
        base, begin = rest.base, rest.rows.start
        if base is None:
            begin = max(rest.rows.start, rest.rows.stop - order)
            base = np.eye(rest.rows.stop - begin)
        end = min(len(inside), begin + len(base) + order)
        # What is spread into rows that say nothing ties no rests to each other.
        known = np.flatnonzero(~inside[begin:end])
        if not len(known):
            continue
        end = begin + int(known[-1]) + 1
        columns = np.zeros((end - begin, base.shape[1]))
        columns[: len(base)] = base[: end - begin]
        columns = lfilter(weights, [1.0], columns, axis=0)
        columns[inside[begin:end]] = 0.0
        if result and begin < result[-1][0] + len(result[-1][1]):
            start, before = result.pop()
            joined = np.zeros((max(end - start, len(before)), before.shape[1] + base.shape[1]))
            joined[: len(before), : before.shape[1]] = before
            joined[begin - start : end - start, before.shape[1] :] = columns
            begin, columns = start, joined
        result.append((begin, columns))
    return result
