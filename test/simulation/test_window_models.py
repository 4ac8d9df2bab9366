# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Windows of several models together are those of each model by itself."""

import numpy as np
import pytest

from sosml_friction.model.joint_friction import JointFriction
from sosml_friction.model.laws import make_friction_law
from sosml_friction.model.model_folder import read_model
from sosml_friction.model.terms.cogging import Cogging
from sosml_friction.model.terms.kinds.body_term import ChangedBody
from sosml_friction.model.terms.kinds.simulated_term import Body, Gear, SimulatedTerm
from sosml_friction.model.terms.kinds.transmission_term import SimulatedGear
from sosml_friction.share import share_directory
from sosml_friction.simulation.forward_drive import RecordedDrive
from sosml_friction.simulation.forward_model import ForwardModel
from sosml_friction.simulation.forward_simulation import Start, simulate
from sosml_friction.simulation.window_models import WindowModels

SAMPLES, PERIOD = 40, 2e-3


@pytest.fixture(scope='module')
def robot():
    return read_model(share_directory() / 'config/exoskeleton').make_robot()


class Pull(SimulatedTerm):
    """A load of a kind that only this test has."""

    def __init__(self, size):
        self.size = size

    def load(self, motion, state):
        return self.size * motion.q


def model(robot, k, gear):
    laws = [
        make_friction_law(
            'stribeck',
            {
                'coulomb': c + 0.1 * k,
                'viscous': 0.2,
                'stribeck': 0.1 * k,
                'stribeck_velocity': 0.05,
                'bias': 0.01 * k,
            },
            1e-3,
        )
        for c in (0.8, 0.4)
    ]
    body = Body.unchanged(2)
    body.rotors[0] = 1e-3 * k
    body.inertias[1, 0] = 0.1 * k
    terms = [
        Cogging().simulated(robot, 0, {'frequency': 20.0}, np.array([0.1 * k, 0.05])),
        ChangedBody([body], [1.0]),
        Pull(0.2 * k),
    ]
    if gear:
        terms.append(SimulatedGear(Gear(1, 300.0 + 50.0 * k, 1e-3, 0.1)))
    return ForwardModel(robot, JointFriction(laws), np.array([1e-3, 1e-3]), terms)


@pytest.mark.parametrize('gear', [False, True])
@pytest.mark.parametrize('followed', [(), (0,)])
def test_windows_of_several_models_are_those_of_each_by_itself(robot, gear, followed):
    rng, count = np.random.default_rng(3), 400
    time = np.arange(count) * PERIOD
    path = np.column_stack([0.5 * np.sin(3.0 * time), 0.3 * np.cos(4.0 * time)])
    v = np.gradient(path, PERIOD, axis=0)
    a = np.gradient(v, PERIOD, axis=0)
    at = rng.integers(100, count - SAMPLES - 1, 6)
    torque = rng.normal(size=(6, SAMPLES, 2)) + 2.0
    models, of = [model(robot, k, gear) for k in range(3)], np.array([2, 0, 1, 1, 0, 2])
    effort = np.array([5.0, 3.0])

    def run(models, rows):
        start = Start(path[at[rows]], v[at[rows]], a[at[rows]], np.zeros((len(rows), 2)), path,
                      at[rows], time, np.full(path.shape, np.nan))  # fmt: skip
        drive = RecordedDrive(torque[rows])
        return simulate(models, start, drive, PERIOD, SAMPLES, effort, followed=followed)

    together = run(WindowModels(models, of), np.arange(6))
    for k, own in enumerate(models):
        rows = np.flatnonzero(of == k)
        alone = run(WindowModels([own, *models], np.zeros(len(rows), dtype=int)), rows)
        # The posture at which a motor is told from its body is that of all windows.
        np.testing.assert_allclose(together.q[rows], alone.q, rtol=0.0, atol=2e-6)
        np.testing.assert_allclose(together.v[rows], alone.v, rtol=0.0, atol=2e-4)


def test_a_window_that_runs_away_leaves_the_others_alone(robot):
    time = np.arange(SAMPLES) * PERIOD
    path = np.zeros((SAMPLES, 2))
    start = Start(path[:3], path[:3], path[:3], path[:3], path, np.zeros(3, dtype=int), time,
                  np.full(path.shape, np.nan))  # fmt: skip
    torque = np.ones((3, SAMPLES, 2))
    calm = simulate(model(robot, 1, False), start, RecordedDrive(torque), PERIOD, SAMPLES,
                    np.ones(2))  # fmt: skip
    torque[1, 10:] = 1e12
    found = simulate(model(robot, 1, False), start, RecordedDrive(torque), PERIOD, SAMPLES,
                     np.ones(2))  # fmt: skip
    np.testing.assert_allclose(found.q[[0, 2]], calm.q[[0, 2]], rtol=0.0, atol=1e-12)
    assert np.isfinite(found.q[1, :9]).all()
    assert np.isinf(found.q[1, -1]).all()
