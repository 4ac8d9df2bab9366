# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is half a period of the band long is bridged, and what is longer parts a recording."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.bags.even_stretches import even_stretches
from sosml_friction.bags.joint_log import JointLog

STEP, HERTZ = 2e-3, 1.0


def moving(missing: slice = slice(0)) -> JointLog:
    """Return two joints on sines of 1 and -0.5 rad, without some samples."""
    t = np.delete(np.arange(0.0, 4.0, STEP), missing)
    q = np.outer(np.sin(2.0 * np.pi * HERTZ * t), [1.0, -0.5])
    v = np.full_like(q, np.nan)
    return JointLog(('a', 'b'), np.round(1e9 * t).astype(np.int64), q, v, 3.0 + q)


@pytest.mark.parametrize('lost', [4, 5, 12, 19])
def test_a_gap_within_half_a_period_is_on_a_cubic(lost):
    """
    No joint is further off than three times the best cubic: M h^4 / 192 over 2 h, M of q''''.

    A straight line would be off by up to a T^2 / 8.
    """
    (bridged,) = even_stretches(moving(slice(1100, 1100 + lost)), cutoff=12.0)
    (whole,) = even_stretches(moving())
    assert np.array_equal(bridged.t_ns, whole.t_ns)
    off = np.abs(bridged.q - whole.q).max(axis=0)
    fastest, gap = 2.0 * np.pi * HERTZ, (lost + 1) * STEP
    half = 0.5 / 12.0 + 0.5 * gap
    cubic, line = fastest**4 * half**4 / 192.0, fastest**2 * gap**2 / 8.0
    limit = 3.0 * cubic if lost > 4 else line
    assert (off <= limit * np.array([1.0, 0.5])).all()
    assert lost < 12 or limit < 0.3 * line


@pytest.mark.parametrize(
    ('lost', 'cutoff', 'parts'),
    [(4, np.inf, 1), (5, np.inf, 2), (19, 12.0, 1), (21, 12.0, 2), (21, 11.0, 1)],
)
def test_a_hole_is_longer_than_half_a_period_and_five_steps(lost, cutoff, parts):
    found = even_stretches(moving(slice(1100, 1100 + lost)), cutoff)
    assert [len(part) for part in found] == ([2000] if parts == 1 else [1100, 900 - lost])


def test_effort_in_a_gap_is_on_a_line():
    """Friction changes its sign at once: a curve through it would overshoot."""
    log = moving(slice(1100, 1115))
    late = log.t_ns > 1150 * STEP * 1e9
    (part,) = even_stretches(
        JointLog(log.names, log.t_ns, log.q, log.v, np.repeat(late[:, None] * 1.0, 2, axis=1)),
        cutoff=12.0,
    )
    assert part.tau.min() == 0.0
    assert part.tau.max() == 1.0


@pytest.mark.filterwarnings('error')
def test_few_samples_between_gaps_are_on_a_curve_of_as_many_numbers():
    """Three samples are near the first gap, and they are on a parabola."""
    log = moving(np.r_[1001:1008, 1009:1016, 1017:1024])
    (part,) = even_stretches(log.rows(np.arange(1000, len(log))), cutoff=20.0)
    (whole,) = even_stretches(moving())
    assert np.array_equal(part.t_ns, whole.t_ns[1000:])
    assert part.q == pytest.approx(whole.q[1000:], abs=1e-4)


def test_effort_beside_samples_that_were_lost_holds_for_a_step():
    (part,) = even_stretches(moving(slice(1100, 1103)))
    assert part.held == pytest.approx(np.ones(2000), abs=1e-5)


def test_effort_at_a_sample_holds_as_long_as_the_steps_beside_it():
    """Steps of 2, 3 and 7 ms by turns, of 3 in the middle."""
    steps = np.tile([2e-3, 3e-3, 7e-3], 50)
    t = np.append(0.0, np.cumsum(steps))
    q = np.outer(t, [1.0, 2.0])
    log = JointLog(('a', 'b'), np.round(1e9 * t).astype(np.int64), q, 0.0 * q, q)
    (part,) = even_stretches(log)
    beside = [2.0, *(0.5e3 * (steps[1:] + steps[:-1])), 7.0]
    assert part.held == pytest.approx(np.interp(part.time, t, beside) / 3.0, abs=1e-5)
