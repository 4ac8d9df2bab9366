# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Noise of position beside the steps of an encoder, and the band that it allows."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.model.model_folder import read_model
from sosml_friction.regression.position_noise import PositionNoise
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare
from sosml_friction.share import share_directory

STEP, QUANTUM = 2e-3, 2.0 * np.pi / 65536


def plateaus():
    """Return a motion of 60 s at constant speeds, 0.2 to 2 rad/s, with 8 rad/s2 between them."""
    rng = np.random.default_rng(1)
    v, parts = 0.0, []
    for k in range(60):
        goal = rng.uniform(0.2, 2.0) * (1 - 2 * (k % 2))
        ramp = np.arange(v, goal, 8.0 * STEP * np.sign(goal - v))
        parts += [ramp, np.full(500 - len(ramp), goal)]
        v = goal
    return np.cumsum(np.concatenate(parts)) * STEP


@pytest.mark.parametrize('dither', [0.0, 0.2, 0.5, 2.0])
def test_noise_beside_the_steps_of_an_encoder_is_seen(dither):
    """A reading that noise dithers has both: the steps' own noise says nothing of the other."""
    quantum, q = 2.0 * np.pi / 16384, plateaus()
    white = dither * quantum * np.random.default_rng(2).standard_normal(len(q))
    read = (quantum * np.round((q + white) / quantum))[:, None]
    one = np.ones(1)
    seen = PositionNoise.seen(read, q[:, None], quantum * one, 0.05 * one, one[:, None])
    assert seen.white[0] / quantum == pytest.approx(dither, rel=0.1, abs=0.05)


@pytest.mark.parametrize('late', [0.0, 10e-6, 50e-6])
def test_noise_that_grows_with_speed_is_that_of_when_positions_were_read(late):
    """Read 10 us off, 1 rad/s is 10 urad, twice the noise of this encoder; scale says where."""
    rng, q = np.random.default_rng(3), plateaus()
    speed = np.gradient(q)
    white = 5e-6
    read = q + late / STEP * speed * rng.standard_normal(len(q))
    read += white * rng.standard_normal(len(q))
    one = np.ones(1)
    seen = PositionNoise.seen(read[:, None], q[:, None], 0.0 * one, one, one[:, None])
    assert seen.late[0] * STEP == pytest.approx(late, rel=0.1, abs=1e-6)
    # It is the small difference of two large ones where the other is much more.
    assert seen.white[0] == pytest.approx(white, rel=0.3, abs=0.15 * late)
    shape = np.hypot(white, late / STEP * speed)
    assert seen.scale[:, 0] == pytest.approx(shape / np.sqrt(np.mean(shape**2)), rel=0.3)
    drawn, fast = seen.drawn(np.random.default_rng(4))[:, 0], np.abs(speed) > 1.2 * STEP
    for part in (fast, ~fast):
        assert np.std(drawn[part]) == pytest.approx(np.sqrt(np.mean(shape[part] ** 2)), rel=0.1)


@pytest.mark.parametrize(('size', 'phase'), [(0.01, 0.7), (0.02, 0.0), (0.02, 0.7)])
def test_the_steps_of_a_slow_joint_are_no_noise_that_grows(size, phase):
    """14 bits at 1 kHz: less than a count for each sample, wherever its zero is."""
    count, one = 2.0 * np.pi / 16384, np.ones(1)
    q = size * np.sin(2.0 * np.pi * 0.2 * np.arange(0.0, 60.0, 1e-3) + phase)
    read = count * np.round(q / count)
    seen = PositionNoise.seen(read[:, None], q[:, None], count * one, one, one[:, None])
    assert seen.white[0] < 0.1 * count
    assert seen.late[0] * np.abs(np.gradient(q)).max() < 0.2 * count


def test_a_fast_sine_at_a_low_rate_is_not_read_late():
    """50 Hz and 2 Hz: its third difference is that of the motion, largest where it is fast."""
    one, q = np.ones(1), np.sin(2.0 * np.pi * 2.0 * np.arange(0.0, 60.0, 0.02))
    seen = PositionNoise.seen(q[:, None], q[:, None], 0.0 * one, one, one[:, None])
    assert seen.late[0] * 0.02 < 1e-5


def test_a_joint_without_noise_has_none_that_grows():
    one, still = np.ones(1), np.zeros((100, 1))
    seen = PositionNoise.seen(still, still, 0.0 * one, one, one[:, None])
    assert seen.late[0] == 0.0
    assert (seen.scale == 1.0).all()


def test_moments_between_holes_have_no_say_in_the_band():
    """A busy computer loses samples; the pieces between are of any length, the first ones too."""
    model = read_model(share_directory() / 'config/exoskeleton')
    t_ns = np.arange(30_000, dtype=np.int64) * 2_000_000
    q = 0.05 * t_ns[:, None] * 1e-9 + np.array([-1.0, 0.5])
    q = QUANTUM * np.round(q / QUANTUM)
    tau = np.random.default_rng(0).normal(0.0, 0.1, q.shape)
    kept = np.ones(len(t_ns), dtype=bool)
    kept[3:20] = kept[60:90] = False

    def prepared(rows):
        log = JointLog(('shoulder', 'elbow'), t_ns[rows], q[rows], np.nan * q[rows], tau[rows])
        return prepare([log], model, model.make_robot(), DiagnosisSettings())

    (whole,) = prepared(np.flatnonzero(t_ns >= t_ns[90]))
    (left,) = prepared(np.flatnonzero(kept))
    assert left.band == whole.band
    assert len(left.q) == len(whole.q)
