# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Noise of position passes for a function of acceleration where the motion has none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known_robots import SLIDER_MASS, recording, slider_model

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.model.model_folder import read_model
from sosml_friction.model.parameter import Parameter
from sosml_friction.regression.band import Band
from sosml_friction.regression.position_noise import PositionNoise
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import choose_band, prepare
from sosml_friction.share import share_directory

STEP, QUANTUM = 2e-3, 2.0 * np.pi / 65536
BAND = Band(28.0, STEP)


def share(q):
    """Return the share for one joint of 0.3 kg m2 with 50 mNm of noise in each sample."""
    noise = PositionNoise(
        q[:, None], np.array([QUANTUM]), np.zeros(1), np.array([0.05]), np.array([[0.3]])
    )
    return noise.share(BAND)


def test_steps_of_an_encoder_look_like_inertia_at_constant_speed_and_not_in_fast_motion():
    """
    At 0.05 rad/s the steps make a line at 0.05 / quantum = 521 Hz, seen at 500 Hz as 21 Hz.

    M e'' of that line is 0.3 (2 pi 21)^2 quantum / (sqrt(2) pi) = 0.11 Nm, in the band, and the
    motion has no acceleration beside it; the sine's is 10 rad/s2.
    """
    t = np.arange(0.0, 60.0, STEP)
    slow, fast = share(0.05 * t), share(0.4 * np.sin(5.0 * t))
    assert slow > 0.3
    assert fast < 0.01


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


def test_what_noise_feigns_is_measured_beside_the_noise_that_curves_leave():
    """
    The diagnosis whitens by what its whole catalogue leaves, and so does this.

    At constant speed acceleration is noise: its effort is a line over it, of slope -M, which a
    model of the noise that still had it would whiten away (0.16), and the diagnosis sees (0.57).
    """
    quantum, q, one = 2.0 * np.pi / 16384, plateaus()[:, None], np.ones(1)
    noise = PositionNoise(q, quantum * one, 0.5 * quantum * one, 0.02 * one, 0.2 * one[:, None])
    assert noise.share(Band(12.0, STEP)) > 0.4


def test_a_band_is_in_proportion_to_how_slow_a_motion_is():
    """
    A time k times as long and an inertia k^2 times as large leave every effort what it is.

    So the same is feigned in a band 1 / k as wide, and the band is lowered to it by steps of 15 %.
    """
    rng = np.random.default_rng(0)
    round_off = 0.5 - 0.5 * np.cos(np.pi * np.arange(200) / 200.0)
    v = np.concatenate(
        [
            sign * speed * np.concatenate([round_off, np.ones(1600), round_off[::-1]])
            for speed in (0.01, 0.05, 0.2, 0.5, 1.0)
            for sign in (1.0, -1.0)
        ]
    )
    v = np.tile(v, 3)
    q = 1e-3 * np.cumsum(v) + rng.normal(0.0, 1e-5, len(v))
    tau = rng.normal(0.0, 12.0, len(v))
    bands = []
    for k in (2.0, 3.0):
        model = slider_model()
        armature = Parameter((k**2 - 1.0) * SLIDER_MASS, 'kg')
        joints = {'slider': replace(model.joints['slider'], armature=armature)}
        robot = replace(model, joints=joints).make_robot()
        log = recording(('slider',), k * 1e-3 * np.arange(len(q)), q, tau)
        band, feigned = choose_band(log, robot, k * 1e-3, DiagnosisSettings())
        assert feigned < 0.02
        bands.append(band.cutoff)
    assert bands[0] < 5.0
    assert 2.0 * bands[0] == pytest.approx(3.0 * bands[1], rel=0.15)


def test_of_a_moment_nothing_is_said():
    """A recording with lost samples has stretches of any length."""
    for samples in (2, 40, 300):
        assert share(0.05 * STEP * np.arange(samples)) == 0.0


def test_moments_between_holes_have_no_say_in_the_band():
    """A busy computer loses samples; the pieces between are of any length, the first ones too."""
    model = read_model(share_directory() / 'config/exoskeleton')
    t_ns = np.arange(30_000, dtype=np.int64) * 2_000_000
    q = 0.05 * t_ns[:, None] * 1e-9 + np.array([-1.0, 0.5])
    q = QUANTUM * np.round(q / QUANTUM)
    tau = np.random.default_rng(0).normal(0.0, 0.1, q.shape)
    kept = np.ones(len(t_ns), dtype=bool)
    kept[3:20] = kept[60:90] = False

    def prepared(rows, band=None):
        log = JointLog(('shoulder', 'elbow'), t_ns[rows], q[rows], np.nan * q[rows], tau[rows])
        return prepare([log], model, model.make_robot(), DiagnosisSettings(band=band))

    (whole,) = prepared(np.flatnonzero(t_ns >= t_ns[90]))
    (left,) = prepared(np.flatnonzero(kept))
    assert left.band == whole.band
    assert len(left.q) == len(whole.q)
    # What the noise feigns in that band is known to the floors; of a band that is given it is not.
    assert left.feigned == pytest.approx(whole.feigned, rel=1e-6)
    assert 0.0 < whole.feigned < 0.05
    assert prepared(np.flatnonzero(t_ns >= t_ns[90]), 20.0)[0].feigned == 0.0
