# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Stamps that are not the times of measurement are found by positions, with what they feign."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.identification.stamp_checks import check_stamps, feigned_viscous, lateness

PERIOD = 2e-3
W, AMPLITUDE, INERTIA = 1.2 * np.pi, 0.5, 0.3


def recorded(measured: np.ndarray, stamps: np.ndarray, late: float = 0.0) -> JointLog:
    """Return a swing measured at ``measured`` [s], its effort ``late`` [s] older, with noise."""
    rng = np.random.default_rng(3)
    q = AMPLITUDE * np.sin(W * measured) + 1e-4 * rng.standard_normal(len(measured))
    tau = -INERTIA * W**2 * AMPLITUDE * np.sin(W * (measured - late))
    tau += 0.02 * rng.standard_normal(len(measured))
    t_ns = np.rint(stamps * 1e9).astype(np.int64)
    return JointLog(('hip',), t_ns, q[:, None], np.full((len(q), 1), np.nan), tau[:, None])


@pytest.fixture
def regular() -> np.ndarray:
    return np.arange(0.0, 30.0, PERIOD)


@pytest.fixture
def delays(regular: np.ndarray) -> np.ndarray:
    """Return how late a busy machine is: one time in five, by a millisecond on average."""
    rng = np.random.default_rng(5)
    return np.where(rng.random(len(regular)) < 0.2, rng.exponential(1e-3, len(regular)), 0.0)


def test_late_stamps_are_measured_by_the_positions(regular, delays):
    late_s, sure = lateness(recorded(regular, regular + delays), 0, PERIOD)
    assert late_s == pytest.approx(float(np.std(delays)), rel=0.1)
    assert sure > 10.0


def test_cycles_that_were_late_with_true_stamps_are_not_accused(regular, delays):
    _, sure = lateness(recorded(regular + delays, regular + delays), 0, PERIOD)
    assert sure < 3.0
    assert not list(check_stamps(recorded(regular + delays, regular + delays), PERIOD))


def test_even_stamps_say_nothing_however_they_came_about(regular, delays):
    assert not list(check_stamps(recorded(regular + delays, regular), PERIOD))


def test_an_effort_that_is_late_feigns_inertia_times_the_square_of_the_frequency(regular):
    """B = d M w^2 for a swing; that is what a fit then finds."""
    per_second, v = feigned_viscous(recorded(regular, regular), 0, PERIOD)
    assert per_second == pytest.approx(INERTIA * W**2, rel=0.02)
    late = recorded(regular, regular, late=5e-3)
    feigned = float(late.tau[5:-5, 0] @ v) / float(v @ v)
    assert feigned == pytest.approx(per_second * 5e-3, rel=0.05)


def test_the_sentence_has_the_time_and_what_it_feigns_and_warns_where_it_matters(regular, delays):
    (note,) = check_stamps(recorded(regular, regular + delays), PERIOD)
    assert (note.level, note.joint, note.check) == ('note', 'hip', 'late_stamps')
    assert 'by 0.58 ms (rms)' in note.sentence
    assert 'viscous friction of 0.0025' in note.sentence
    (found,) = check_stamps(recorded(regular, regular + 5.0 * delays), PERIOD)
    assert found.level == 'warning'
