# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Where a joint turns around it may stick, each time for another time."""

from __future__ import annotations

import numpy as np
from known_robots import coulomb_viscous, recording

from sosml_friction.diagnosis.library import make_library
from sosml_friction.model.simple_models import free_model
from sosml_friction.regression.rests import turning
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare
from sosml_friction.regression.whitened import WhitenedRegression

STEP, LIMIT = 0.01, 1e-3


def test_turning_is_within_the_limit_of_each_extreme_and_nowhere_else():
    t = STEP * np.arange(1000)
    q = np.sin(t)
    found = turning(q, LIMIT)
    for place in (0.5 * np.pi, 1.5 * np.pi, 2.5 * np.pi):
        k = round(place / STEP)
        (own,) = (run for run in found if run[0] <= k < run[1])
        assert np.abs(q[slice(*own)] - q[k]).max() <= 1.01 * LIMIT
        # (1 - cos) = limit, to either side.
        assert abs(own[1] - own[0] - 2.0 * np.sqrt(2.0 * LIMIT) / STEP) < 3.0
    assert turning(t, LIMIT) == []


def stuck(seconds):
    """Return a shaft whose friction turns around in one or the other of some times."""
    t = STEP * np.arange(6000)
    rng = np.random.default_rng(2)
    q = np.sin(0.8 * t) + 0.5 * np.sin(1.9 * t + 1.0)
    v = 0.8 * np.cos(0.8 * t) + 0.95 * np.cos(1.9 * t + 1.0)
    a = -0.64 * np.sin(0.8 * t) - 1.805 * np.sin(1.9 * t + 1.0)
    s = np.sign(v)
    turns = np.flatnonzero(np.diff(s))
    for k, wait in zip(turns, rng.choice(seconds, len(turns)), strict=True):
        last = k + 1 + round(wait / STEP)
        s[k + 1 : last] = np.linspace(s[k], -s[k], len(s[k + 1 : last]))
    tau = 0.05 * a + 0.5 * s + 0.1 * v + 0.05 * rng.standard_normal(len(t))
    return recording(('joint',), t, q + 1e-6 * rng.standard_normal(len(t)), tau)


def made(log):
    model = free_model(0.05, 'joint')
    law = coulomb_viscous(0.5, 0.1)
    joints = {'joint': type(model.joints['joint'])(model.joints['joint'].armature, law)}
    model = type(model)(model.name, joints, model.urdf)
    settings = DiagnosisSettings()
    signals = prepare([log], model, model.make_robot(), settings)
    return WhitenedRegression.make(signals, make_library(()), settings)


def test_a_joint_that_sticks_now_longer_now_shorter_says_nothing_where_it_turns_around():
    assert made(stuck((0.05, 0.1, 0.2))).signals[0].turns == {0}


def test_one_that_turns_around_at_once_says_something_there():
    assert made(stuck((0.0,))).signals[0].turns == frozenset()
