# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A point mass on the last body: the coordinates that motion tells, and files of before."""

from dataclasses import replace

import numpy as np
import pytest
from known_robots import arm_model, arm_motion, recording, rigid_effort, sines

from sosml_friction.model.known_terms import known_terms
from sosml_friction.model.model_folder import EffectTerm
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.simple_models import pendulum_model
from sosml_friction.model.terms.payload import Payload, body_centre, farthest
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare


def signals_of(model):
    t = np.arange(0.0, 20.0, 4e-3)
    q, v, a = arm_motion(t)
    log = recording(('shoulder', 'elbow'), t, q, rigid_effort(model, q, v, a))
    return prepare([log], model, model.make_robot(), DiagnosisSettings())[0]


def test_of_a_planar_arm_the_place_is_known_in_the_plane():
    """The link's x is along it, its z is the joint's axis; its centre is 0.135 m along x."""
    signals = signals_of(arm_model())
    assert set(Payload().inner_bounds(signals, 0)) == {'x', 'y'}
    assert farthest(signals.robot) == pytest.approx(max(0.30, 3.0 * 0.135))
    places = np.array([list(inner.values()) for inner in Payload().grid(signals, 0)])
    aside = 0.5 * 3.0 * 0.135
    expected = [[0.0, 0.0], [aside, 0.0], [-aside, 0.0], [0.0, aside], [0.0, -aside]]
    assert places[:, :2] - [0.135, 0.0] == pytest.approx(np.array(expected))
    assert (places[:, 2] == 0.0).all()


def test_a_place_that_another_mass_would_do_for_is_not_looked_for():
    """So slow that a pendulum has no inertia: m r is known across it, and neither m nor r."""
    t = np.arange(0.0, 40.0, 4e-3)
    model = pendulum_model(1.0, 0.1, 0.0, 0.0)
    for slower, axes in ((1.0, {'x', 'z'}), (1e3, {'x'})):
        q, v, a = sines(t / slower, ((1.2, 2.0), (0.3, 5.0, 1.0))) / np.array(
            [[1.0], [slower], [slower**2]]
        )
        tau = rigid_effort(model, q[:, None], v[:, None], a[:, None])
        log = recording(('joint',), t, q, tau)
        signals = prepare([log], model, model.make_robot(), DiagnosisSettings())[0]
        assert set(Payload().inner_bounds(signals, 0)) == axes


def test_a_model_of_before_has_the_place_that_its_distance_meant():
    parameters = {'mass': Parameter(0.3, 'kg'), 'distance': Parameter(0.2, 'm', 0.01)}
    model = replace(arm_model(), effects=(EffectTerm('payload', '*', parameters),))
    (known,) = known_terms(model)
    centre = body_centre(model.make_robot())
    place = np.array([known.inner[axis] for axis in 'xyz'])
    assert np.linalg.norm(place) == pytest.approx(0.2)
    assert place / 0.2 == pytest.approx(centre / np.linalg.norm(centre))
    assert known.amplitude == pytest.approx([0.3])
