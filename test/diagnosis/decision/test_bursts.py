# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What comes now and then is no noise, and no all-clear."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from known_robots import SLIDER_MASS, recording, sines, slider_model, smooth_sign

from sosml_friction.diagnosis.decision.bursts import bursts
from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.regression.noise_model import ORDER

#: When something knocks [s], all while the slider slides; the first is the hardest.
KNOCKS = (11.1, 4.2, 17.3, 21.2, 30.9, 35.6)


def found(size, seed=7):
    """Return the diagnosis of a slider that is knocked to and fro, half a sine of 20 ms each."""
    t = np.arange(0.0, 40.0, 4e-3)
    q, v, a = sines(t, ((0.08, 0.9), (0.02, 2.1)))
    tau = SLIDER_MASS * a + 20.0 * smooth_sign(q, v) + 200.0 * v
    tau += np.random.default_rng(seed).normal(0.0, 1.0, len(t))
    for k, knock in enumerate(KNOCKS):
        phase = (t - knock) / 0.02
        tau += (
            size
            * (1.0 if k == 0 else (-0.8) ** k)
            * np.where(np.abs(phase - 0.5) < 0.5, np.sin(2.0 * np.pi * phase), 0.0)
        )
    log = recording(('slider',), t, q, tau)
    return diagnose([log], slider_model(20.0, 200.0))


def of_bursts(diagnosis):
    """Return what is written of bursts."""
    return [x for x in diagnosis.structure['axes'] if x['axis'] == 'bursts']


def test_knocks_are_no_noise():
    """Their means are nothing, so that they are no contacts; the all-clear was given."""
    knocked = found(50.0)
    assert knocked.verdict == 'unknown_structure'
    (bursts,) = of_bursts(knocked)
    assert bursts['unknown']
    assert bursts['bursts'] == len(KNOCKS)
    assert bursts['at_s'] == pytest.approx(KNOCKS[0], abs=0.1)
    assert 'slider has 6 short bursts, the largest at 11.' in knocked.sentence


def test_noise_alone_has_none():
    quiet = found(0.0)
    assert quiet.verdict == 'nothing_above_floor'
    assert not any(x['unknown'] for x in of_bursts(quiet))


def of_rows(v):
    """Return whitened rows of joints that go at these speeds (rows, n), without a rest."""
    speeds = np.concatenate([np.zeros((ORDER, v.shape[1])), v])
    signals = SimpleNamespace(
        band=SimpleNamespace(reach=20, at_rows=lambda x: x),
        time=0.01 * np.arange(len(speeds)),
        v=speeds,
    )
    return SimpleNamespace(
        contacts=SimpleNamespace(impacts=[]),
        signals=[signals],
        whitening=SimpleNamespace(standstill=None),
    )


def test_noise_that_grows_with_speed_is_no_burst_and_a_knock_at_speed_is_one():
    """Moves from point to point, whose stamps scatter: at top speed noise is seven times usual."""
    rng, rows = np.random.default_rng(5), 8000
    v = np.maximum(np.sin(2.0 * np.pi * np.arange(rows) / 400.0), 0.0)[:, None]
    left = np.hypot(0.3, 2.1 * v) * rng.normal(size=v.shape)
    slides = np.ones(v.shape, dtype=np.bool_)
    assert bursts(of_rows(v), left, slides, [0]) == []
    left[2100] = 15.0
    ((_, burst),) = bursts(of_rows(v), left, slides, [0])
    assert (burst.count, burst.energy) == (1, pytest.approx(225.0))


def test_noise_of_which_rests_took_a_part_is_no_measure_of_the_rest():
    """Three quarters of the rows are beside rests, as of moves from point to point."""
    rng, rows = np.random.default_rng(4), 8000
    reached = (np.arange(rows) % 400 < 300)[:, None]
    left = np.where(reached, 0.2, 1.0) * rng.normal(size=(rows, 1))
    laboratory = of_rows(np.ones((rows, 1)))
    laboratory.whitening.standstill = SimpleNamespace(reached=lambda: reached)
    slides = np.ones_like(reached)
    assert bursts(laboratory, left, slides, [0]) == []
    left[350] = 8.0
    ((joint, burst),) = bursts(laboratory, left, slides, [0])
    assert (joint, burst.count) == (0, 1)
    assert burst.energy == pytest.approx(64.0)
    laboratory.whitening.standstill = None
    assert bursts(laboratory, left, slides, [0])[0][1].count > 10
