# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the nominal model expects of a motion, of its steady acceleration and of the rest."""

from __future__ import annotations

import numpy as np
import pytest

import sosml_friction as sf
from sosml_friction.exceptions import DataError
from sosml_friction.model.finite_differences import first_derivative
from sosml_friction.model.terms.kinds.term import TERMS
from sosml_friction.regression.band import Band
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare

STEP = 4e-3
BAND = 20.0


@pytest.mark.parametrize('follows', [False, True], ids=['every joint', 'one that follows'])
def test_the_bodies_of_the_residual_have_the_acceleration_as_it_is_measured(
    make_serial_arm, follows
):
    """Inverse dynamics of q'' as measured, of the bodies that follow a joint too."""
    urdf, names = make_serial_arm(['revolute'] * 3), ['j1', 'j2', 'j3']
    if follows:
        mimic = '<mimic joint="j1" multiplier="-2" offset="0.4"/><limit lower="-3"'
        urdf, names = urdf.replace('<limit lower="-3"', mimic), names[:2]
    model = sf.Model.from_urdf(urdf, dict.fromkeys(names, 0.01))
    rng = np.random.default_rng(2)
    t = np.arange(0.0, 30.0, STEP)
    phase = rng.uniform(0.0, 6.0, len(names))
    q = 0.4 * np.sin(2.0 * np.pi * 0.3 * t[:, None] + phase)
    q += 5e-5 * rng.standard_normal(q.shape)
    t_ns = np.round(1e9 * t).astype(np.int64)
    log = sf.JointLog(tuple(names), t_ns, q, np.full_like(q, np.nan), rng.normal(size=q.shape))
    robot = model.content.make_robot()
    (s,) = prepare([log], model.content, robot, DiagnosisSettings(band=BAND))
    smooth = Band(BAND, STEP).smooth(q)
    v = first_derivative(smooth, STEP)
    a = first_derivative(v, STEP)
    assert bool(robot.followers) == follows
    assert np.std(s.shaken) > 0.0
    # What may be noise in the acceleration is less than all that is none of the motion.
    assert 0.0 < np.std(s.doubted) < np.std(s.shaken)
    np.testing.assert_array_equal(s.sure_torque, s.torque - s.doubted)
    for k in range(100, len(q) - 100, 400):
        needed = robot.inverse_dynamics(smooth[k], v[k], a[k])
        expected = (s.tau - s.unexplained - s.friction)[k]
        assert expected == pytest.approx(needed, abs=1e-9)
    # An encoder that is wrong by e moves all of them, to the first order in it.
    (cosine, _) = np.moveaxis(TERMS['encoder_eccentricity']().columns(s, 1, {}), 2, 0)
    for k in range(100, len(q) - 100, 800):
        (c, n), v_1 = (np.cos(s.q[k, 1]), np.sin(s.q[k, 1])), s.v[k, 1]
        moved = 1e-5 * np.array([c, -n * v_1, -c * v_1**2 - n * s.a[k, 1]])
        state = [
            x[k] + np.eye(len(names))[1] * e for x, e in zip((s.q, s.v, s.a), moved, strict=True)
        ]
        more = robot.inverse_dynamics(*state) - robot.inverse_dynamics(s.q[k], s.v[k], s.a[k])
        assert cosine[k] == pytest.approx(more / 1e-5, rel=1e-3, abs=1e-3)


def pendulum():
    """Return a model of one joint, and its robot."""
    urdf = '<robot name="p"><link name="a"/><link name="b"><inertial><mass value="2"/><origin'
    urdf += ' xyz="0 0.3 0"/><inertia ixx="0.02" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/>'
    urdf += '</inertial></link><joint name="j" type="continuous"><parent link="a"/>'
    urdf += '<child link="b"/><axis xyz="1 0 0"/></joint></robot>'
    model = sf.Model.from_urdf(urdf, {'j': 0.01}).content
    return model, model.make_robot()


def swinging(t: np.ndarray, moves: np.ndarray | bool = True, effort: float = 0.1) -> sf.JointLog:
    """Return a swing of 0.5 rad at 2 rad/s with noise of 2e-5 rad where it moves, else rest."""
    rng = np.random.default_rng(4)
    noisy = 0.5 * np.sin(2.0 * t) + 2e-5 * rng.standard_normal(len(t))
    q = np.where(moves, noisy, 0.0)[:, None]
    tau = effort * rng.standard_normal(q.shape)
    t_ns = np.round(1e9 * t).astype(np.int64)
    return sf.JointLog(('j',), t_ns, q, np.full_like(q, np.nan), tau)


def test_recordings_of_different_rates_have_their_own_velocities():
    """Both are those of the swing; with the step of one for both they were off by a factor."""
    model, robot = pendulum()
    logs = [swinging(np.arange(0.0, 20.0, 1.0 / rate)) for rate in (500.0, 400.0, 250.0)]
    signals = prepare(logs, model, robot, DiagnosisSettings())
    assert len({s.band.cutoff for s in signals}) == 1
    for own, s in zip(logs, signals, strict=True):
        assert s.band.step == pytest.approx(own.step)
        inner = slice(200, -200)
        v = np.cos(2.0 * (s.time - s.time[0]))[:, None]
        # The noise of a position of 2e-5 rad, twice low-passed at 24 Hz: some 2 mrad/s.
        assert s.v[inner] == pytest.approx(v[inner], abs=0.01)


@pytest.mark.parametrize('first', ['rest', 'motion'])
def test_a_rest_before_a_hole_says_nothing_of_the_band(first):
    """Where M (2 pi f)^2 s_q / sqrt(5) = s_tau: a joint at rest shows no noise of its position."""
    model, robot = pendulum()
    inertia, cutoff = float(robot.inertia(np.zeros(1))[0, 0]), 20.0
    effort = inertia * (2.0 * np.pi * cutoff) ** 2 * 2e-5 / np.sqrt(5.0)
    t = np.arange(0.0, 32.0, 2e-3)
    moves = t >= 1.5 if first == 'rest' else t < 30.5
    hole = np.abs(t - (1.5 if first == 'rest' else 30.5)) < 0.1
    log = swinging(t, moves, effort).rows(np.flatnonzero(~hole))
    s = prepare([log], model, robot, DiagnosisSettings())[0]
    # 1.4 of 31.8 s of rest make the mean square of the noise, f^-4, smaller by as much: 1.1 %;
    # the noise of the rest is of 15 000 samples, whose f is known to some 0.3 %.
    assert s.band.cutoff == pytest.approx(cutoff, rel=0.02)


def test_a_recording_that_is_too_short_for_its_rate_says_how_long_it_has_to_be():
    """At 20 Hz the band ends at a tenth of it, 2 Hz, of which 60 periods are 30 s."""
    model, robot = pendulum()
    slow = swinging(np.arange(0.0, 25.0, 0.05))
    with pytest.raises(DataError, match=r'^25 s is the longest .* 30 s are needed .* 2 Hz'):
        prepare([slow], model, robot, DiagnosisSettings())
