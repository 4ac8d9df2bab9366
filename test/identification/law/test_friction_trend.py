# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction of a joint that warms up: it is told, and the law is its mean."""

from dataclasses import replace

import numpy as np
import pytest

from sosml_friction.identification.law.friction_trend import TREND
from sosml_friction.identification.law.law_rows import LawRows
from sosml_friction.identification.law.law_stack import stack_rows

C, B = 1.2, 0.3
#: Rows a second, and the length of a recording [s].
RATE, WHOLE = 20, 60


def sines(t):
    """Return velocities that are alike at all times."""
    return sum(
        a * np.sin(w * t + p) for a, w, p in [(0.5, 1.1, 0.3), (0.4, 2.3, 1.0), (0.3, 5.1, 2)]
    )


def ladder(t):
    """Return velocities of a ladder that climbs once, there and back at each speed, then sines."""
    speeds = np.geomspace(0.02, 0.6, 6)
    k = np.minimum((t / 8.0).astype(int), 5)
    climbing = np.where(t % 8.0 < 4.0, 1.0, -1.0) * speeds[k]
    return np.where(t < 48.0, climbing, sines(t))


def recorded(motion, warmth, seed, time_constant=20.0):
    """Return rows of friction that falls by ``warmth`` with a time constant, and its mean."""
    t = np.arange(RATE * WHOLE) / RATE
    v = motion(t)
    factor = 1.0 - warmth * (1.0 - np.exp(-t / time_constant))
    noise = np.random.default_rng(seed).normal(0.0, 0.01, len(t))
    y = factor * (C * np.sign(v) + B * v) + noise
    clusters = t.astype(np.int64)
    keep = np.abs(v) > 5e-3
    return LawRows(v, y, clusters, keep, v, lambda column: column), float(factor[keep].mean())


def trends(fit):
    """Return what the fit says of a trend."""
    return [check.sentence for check in fit.checks if check.name == TREND]


@pytest.mark.parametrize('motion', [sines, ladder])
def test_friction_that_falls_is_told_and_the_law_is_its_mean(motion):
    """Of 8 recordings 95 % intervals of C and B hold the mean in 6 or more (all but 2: 0.6 %)."""
    held = {'coulomb': 0, 'viscous': 0}
    for seed in range(8):
        rows, mean = recorded(motion, 0.2, seed)
        fit = rows.with_trend().fit('Nm')
        (sentence,) = trends(fit)
        assert 'falls by 1' in sentence or 'falls by 2' in sentence
        for name, truth in (('coulomb', C * mean), ('viscous', B * mean)):
            low, high = fit.parameters[name].interval
            held[name] += low < truth < high
    assert min(held.values()) >= 6, held


def test_a_ladder_that_warms_is_no_stribeck_term():
    """Without the trend it is one: friction is larger at the slow speeds, which come first."""
    rows, _ = recorded(ladder, 0.2, 1)
    assert rows.fit('Nm').drawn['stribeck'] > 0.05
    assert 'stribeck' not in rows.with_trend().fit('Nm').drawn


@pytest.mark.parametrize('motion', [sines, ladder])
def test_constant_friction_has_a_trend_as_often_as_chance_has_it(motion):
    """By chance in 1 % of recordings: three of 20 or more in 0.1 %."""
    found = [recorded(motion, 0.0, seed)[0].with_trend().trend for seed in range(20)]
    assert sum(trend is not None for trend in found) < 3


def test_what_is_too_little_to_matter_is_corrected_without_a_word():
    rows, _ = recorded(sines, 0.012, 3)
    middle = rows.with_trend()
    assert middle.trend is not None
    assert trends(middle.fit('Nm')) == []


def test_the_trend_of_each_recording_is_in_the_errors_of_several():
    """Rows of another recording are off by nothing that the first one's trend is."""
    warm, still = (recorded(sines, warmth, 4)[0].with_trend() for warmth in (0.2, 0.0))
    stack = stack_rows([warm, still], [1.0, 2.0]).rows
    count = len(warm.y)
    assert stack.trending.shape == (2 * count, 2)
    assert np.array_equal(stack.trending[:count], warm.trending)
    assert not stack.trending[count:].any()


def test_recordings_without_friction_or_noise_have_no_trend_and_break_nothing():
    """Its columns are nothing, or what is left is rounding: the covariance is singular."""
    rows, _ = recorded(sines, 0.0, 5)
    clean = C * np.sign(rows.v) + B * rows.v
    for y in (clean, 1e-12 * clean, np.random.default_rng(1).normal(0.0, 0.01, len(rows.v))):
        fit = replace(rows, y=y).with_trend().fit('Nm')
        assert np.isfinite(fit.residual_std)
    falling = clean * (1.0 - 0.2 * np.arange(len(clean)) / len(clean))
    assert len(trends(replace(rows, y=falling).with_trend().fit('Nm'))) == 1
