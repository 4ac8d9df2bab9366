# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The compiled look at a sample changes no verdict: it is only the quickest of the same looks."""

from __future__ import annotations

import numpy as np
import pytest
from full_runs import in_full

from sosml_friction.observers.plausibility import Plausibility


def stream(rng, n, rate, count=700):
    """Return stamps and a motion in which six things go wrong for a while."""
    t = np.arange(count) / rate
    phase = 3.0 * t[:, np.newaxis] + rng.uniform(0.0, 6.0, n)
    q, v = 0.3 * np.sin(phase), 0.9 * np.cos(phase) + 1e-3 * rng.normal(size=phase.shape)
    if rng.random() < 0.5:
        q = np.round(q / 1e-4) * 1e-4
    tau = rng.normal(size=q.shape) + np.sign(v)
    t_ns = np.round(t * 1e9).astype(np.int64)
    for what in rng.integers(9, size=6):
        first = int(rng.integers(50, count - 150))
        rows, joint = slice(first, first + int(rng.integers(1, 150))), int(rng.integers(n))
        match what:
            case 0:
                q[rows, joint] = q[first, joint]
            case 1:
                v[rows, joint] = v[first, joint]
            case 2:
                tau[rows, joint] = 0.0
            case 3:
                tau[rows, joint] *= 50.0
            case 4:
                q[rows, joint] += 1.0
            case 5:
                q[rows, joint] = np.nan
            case 6:
                tau[rows, joint] = np.nan
            case 7:
                v[rows, joint] *= 3.0
            case _:
                t_ns[first:] += int(rng.choice([5_000_000, 200_000_000, -300_000_000]))
    return t_ns, q, v, tau


@pytest.mark.parametrize('rate', [60.0, in_full(250.0), 1000.0])
@pytest.mark.parametrize('uses_velocity', [True, False])
def test_verdicts_are_those_of_the_close_look(two_joints, monkeypatch, rate, uses_velocity):
    rng = np.random.default_rng(int(rate) + uses_velocity)
    plain = 0
    for _ in range(4):
        quick = Plausibility(two_joints, uses_velocity=uses_velocity)
        close = Plausibility(two_joints, uses_velocity=uses_velocity)
        monkeypatch.setattr(close, '_is_plain', lambda *_: False)
        for t_ns, *sample in zip(*stream(rng, 2, rate), strict=True):
            before = quick._trusted.rows if quick._trusted else None
            ours, theirs = quick.judge(int(t_ns), *sample), close.judge(int(t_ns), *sample)
            plain += quick._trusted is not None and quick._trusted.rows is before
            for mine, other in zip(ours[:3], theirs[:3], strict=True):
                np.testing.assert_array_equal(mine, other)
            assert ours[3:] == theirs[3:]
            estimate = sample[2] - 0.1
            quick.learn(estimate, np.full(2, 0.01))
            close.learn(estimate, np.full(2, 0.01))
            np.testing.assert_array_equal(quick.steps, close.steps)
    # At 60 Hz each sample is looked at closely, and every sixth at 250 Hz.
    assert plain > (0 if rate == 60.0 else 800)
