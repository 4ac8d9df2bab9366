# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The tones of joints, and where they are as good a reason as a cause."""

from collections.abc import Iterable

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.even_stretches import on_lines
from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.diagnosis.decision.tone import BETWEEN_LINES, Tone, strongest_tone
from sosml_friction.regression.chance import CHANCE
from sosml_friction.regression.curves.tone_of_time import ToneOfTime
from sosml_friction.regression.evidence import Fit
from sosml_friction.regression.noise_model import ORDER
from sosml_friction.regression.signals import Signals
from sosml_friction.regression.whitened import WhitenedRegression

#: Smallest share of what is left, in effort, that makes a tone: of SNR 0.5 it is 0.2. In 300
#: recordings of the blind plant without a tone it was at most 0.119, with one of SNR 0.9 and more
#: 0.35 and more.
TONE_SHARE = 0.2


def tones(
    laboratory: WhitenedRegression, left: FloatArray, joints: Iterable[int]
) -> list[tuple[int, Tone]]:
    """
    Return the strongest tone of each joint in what is left (rows, n), if it is one.

    In the recording of most rows, whose holes say nothing: in a short stretch noise is a tone.
    """
    signals, rows = _recording(laboratory, left)
    band = signals[0].band
    when, q = (
        np.concatenate([s.band.at_rows(x)[ORDER:] for s, x in zip(signals, own, strict=True)])
        for own in ([s.time for s in signals], [s.q for s in signals])
    )
    # On one grid of time, as the rows of a stretch are: each at most half a step off.
    at = np.rint((when - when[0]) / band.output_step).astype(np.int64)
    even = np.zeros((int(at[-1]) + 1, rows.shape[1]))
    even[at] = rows
    q = on_lines(when[0] + band.output_step * np.arange(len(even)), when, q)
    found = []
    for i in joints:
        tone = strongest_tone(even[:, i], laboratory.noise[i], band.output_step, band.cutoff)
        loud = tone.share >= TONE_SHARE and tone.chance <= CHANCE
        if loud and not tone.follows(q, band.output_step):
            found.append((i, tone))
    return found


def _recording(
    laboratory: WhitenedRegression, left: FloatArray
) -> tuple[list[Signals], FloatArray]:
    """Return the stretches of the recording that has most rows, and these rows (K, n)."""
    parts = laboratory.split(left)
    numbers = [signals.recording for signals in laboratory.signals]
    rows = np.bincount(numbers, weights=[len(part) for part in parts])
    own = [k for k, number in enumerate(numbers) if number == int(np.argmax(rows))]
    return [laboratory.signals[k] for k in own], np.concatenate([parts[k] for k in own])


def tone_in_place(laboratory: WhitenedRegression, fit: Fit, best: Finding) -> str:
    """
    Return the tones of time that may be there instead of a cause, '' where they explain less.

    A loop moves at what shakes it, and so slowly otherwise that inertia, delay or elasticity are
    the same line of the spectrum. Tones have three numbers in each joint, and are the reason where
    their evidence is the larger.

    :param fit: without the cause.
    """
    left = fit.target.y - fit.system.Z @ fit.baseline.x
    evidence, hertz = 0.0, []
    times = np.concatenate([signals.time[[0, -1]] for signals in laboratory.signals])
    longest = max(np.ptp(signals.time) for signals in laboratory.signals)
    for i, tone in tones(laboratory, left, best.columns.rows.tolist()):
        step = 1.0 / (BETWEEN_LINES * np.ptp(times))
        around = tone.hertz + np.arange(-1.0 / longest, 1.0 / longest + step, step)
        grid = [{'hertz': float(f)} for f in around if f > 0.0]
        columns = laboratory.on_grid(ToneOfTime(), i, grid).beside(fit.system)
        gain = fit.score(columns).gain - 3.0 * float(np.log(laboratory.known[i]))
        if gain > 0.0:
            evidence += gain
            hertz.append(f'{tone.hertz:.3g}')
    if evidence <= best.delta_bic:
        return ''
    return f'a tone of {" and ".join(hertz)} Hz'
