# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A first moment that a body of such mass and inertia can have, and one that it cannot."""

from dataclasses import replace

import numpy as np
import pytest
from known_robots import arm_model, arm_motion, coulomb_viscous, recording, rigid_effort, sines

from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.model.simple_models import pendulum_model
from sosml_friction.model.terms.gravity import Gravity, first_moments
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare

MASS, LENGTH, INERTIA = 1.35, 0.16, 0.012
FRICTION = coulomb_viscous(0.6, 0.3)


def pendulum():
    """Return a forearm's worth of pendulum with friction: its first moment is 0.216 kg m."""
    model = pendulum_model(MASS, LENGTH, INERTIA, 0.011)
    return replace(model, joints={'joint': replace(model.joints['joint'], friction=FRICTION)})


def moved(model, tau_of, duration=60.0):
    """Return a motion about 0.5 rad; its effort has more than the model, and 30 mNm of noise."""
    t = np.arange(0.0, duration, 5e-3)
    q, v, a = sines(t, ((0.3, 1.1, 0.0), (0.12, 3.7, 1.0), (0.05, 9.0, 2.0)))
    q = q + 0.5
    tau = rigid_effort(model, q[:, None], v[:, None], a[:, None])[:, 0]
    tau = tau + 0.6 * np.tanh(v / 2e-3) + 0.3 * v + tau_of(q)
    tau = tau + np.random.default_rng(0).normal(0.0, 0.03, len(t))
    return recording(('joint',), t, q, tau)


def objection(model, log, joint, change):
    robot = model.make_robot()
    (signals, *_) = prepare([log], model, robot, DiagnosisSettings())
    return Gravity().implausible(Fitted(signals, joint, {}, np.array(change), 1e-3 * np.ones(2)))


@pytest.mark.parametrize(
    ('times', 'possible'), [(0.0, True), (-1.0, True), (2.0, True), (6.0, False), (-6.0, False)]
)
def test_a_first_moment_is_bounded_by_mass_and_inertia(times, possible):
    """A centre on the other side of the axis can be: of a URDF with a wrong sign."""
    model = pendulum()
    log = moved(model, np.zeros_like)
    x, z = (model.make_robot().inertial_parameters()[0, k] for k in (1, 3))
    assert (x, z) == (0.0, pytest.approx(-MASS * LENGTH))
    change = [0.0, (times - 1.0) * z]
    assert (objection(model, log, 0, change) == '') == possible


def test_the_bound_is_that_of_all_that_a_joint_carries():
    """The upper arm has little of its own: a forearm that is wrong is its first moment, too."""
    model, t = arm_model(), np.arange(0.0, 20.0, 4e-3)
    q, v, a = arm_motion(t)
    log = recording(('shoulder', 'elbow'), t, q, rigid_effort(model, q, v, a))
    robot = model.make_robot()
    assert len(first_moments(robot, 0)) == 2
    mass = float(robot.inertial_parameters()[:, 0].sum())
    inertia = float(robot.inertia(np.median(q, axis=0))[0, 0]) - robot.armature[0]
    most = (mass * inertia) ** 0.5
    assert objection(model, log, 0, [1.5 * most, 0.0]) == ''
    assert 'over 3 times as much' in objection(model, log, 0, [6.0 * most, 0.0])


def test_a_spring_that_stiffens_is_no_spring_beside_a_body_that_cannot_be():
    """
    Of 6 Nm/rad3, a spring of 36 Nm/rad and -3 kg m of gravity make the Taylor series.

    It was named as these two, for a body of 0.2 kg m.
    """
    model = pendulum()
    found = diagnose([moved(model, lambda q: 6.0 * (q - 0.5) ** 3)], model)
    assert found.verdict == 'unknown_structure', found.sentence
    assert 'gravity' not in [cause.effect for cause in found.causes]
