# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The plant against physics and against an integrator that is not ours."""

from __future__ import annotations

import itertools
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import simpson, solve_ivp

from sosml_friction.model.laws import make_friction_law
from sosml_friction.model.robot import Robot
from sosml_friction.simulation import integrator
from sosml_friction.simulation import plant as plant_module
from sosml_friction.simulation.plant import Plant

URDF = Path(__file__).resolve().parents[2] / 'urdf/exoskeleton.urdf'
START = np.array([0.3, 1.0]), np.array([1.5, -2.0])


@pytest.fixture(scope='module')
def robot():
    return Robot(URDF.read_text(encoding='utf-8'), ('shoulder', 'elbow'), (0.0054, 0.004))


def stribeck_laws(width=0.05):
    values = {'viscous': 0.3, 'stribeck': 0.5, 'stribeck_velocity': 0.2, 'bias': 0.05}
    return [make_friction_law('stribeck', {'coulomb': c, **values}, width) for c in (0.8, 0.4)]


def test_free_motion_without_friction_keeps_its_energy_to_the_order_of_the_rule(robot):
    """Halving the step divides the drift by 2^4 (order of the rule) to 2^5 (of its energy)."""
    drift = []
    for h in (8e-3, 4e-3, 2e-3):
        plant = Plant(robot, (), *START)
        before = robot.energy(plant.q, plant.v)
        for _ in range(round(2.0 / h)):
            plant.step(np.zeros(2), h)
        drift.append(abs(robot.energy(plant.q, plant.v) - before))
    for coarse, fine in itertools.pairwise(drift):
        assert 2**4 < coarse / fine < 2**5.5
    assert drift[-1] < 1e-5


@pytest.mark.parametrize('with_friction', [False, True])
def test_motion_agrees_with_an_independent_integrator(robot, with_friction):
    """DOP853 at 1e-11; ours at 0.5 ms has an error of about 1e-9 over half a second."""
    laws = stribeck_laws() if with_friction else ()
    tau = np.array([1.0, -0.5])

    def slope(t, x):
        friction = [law.torque(v) for law, v in zip(laws, x[2:], strict=True)] if laws else 0.0
        q, v = x[:2].copy(), x[2:].copy()
        return np.concatenate([v, robot.acceleration(q, v, tau - friction)])

    truth = solve_ivp(slope, (0.0, 0.5), np.concatenate(START), 'DOP853', rtol=1e-11, atol=1e-12)
    plant = Plant(robot, laws, *START)
    for _ in range(1000):
        plant.step(tau, 5e-4)
    np.testing.assert_allclose(np.concatenate([plant.q, plant.v]), truth.y[:, -1], atol=1e-6)


def test_the_energy_lost_is_the_work_of_actuators_minus_that_of_friction(robot):
    """Simpson over 0.5 ms steps is exact to about 1e-8 of the 1 J that flows here."""
    h, steps = 5e-4, 2000
    plant = Plant(robot, stribeck_laws(), *START)
    before = robot.energy(plant.q, plant.v)
    power = []
    for k in range(steps + 1):
        tau = np.array([1.0 + plant.q[0], -0.3 * plant.v[1]])
        power.append((tau - plant.friction_torque(plant.v)) @ plant.v)
        if k < steps:
            plant.step(lambda q, v: np.array([1.0 + q[0], -0.3 * v[1]]), h)
    after = robot.energy(plant.q, plant.v)
    assert after - before == pytest.approx(simpson(power, dx=h), abs=1e-6)
    assert abs(after - before) > 0.1


def test_friction_of_the_plant_is_that_of_its_laws(robot):
    laws = stribeck_laws()
    mixed = [
        make_friction_law('coulomb_viscous', {'coulomb': 1, 'viscous': 2, 'bias': 0.3}, 0.0),
        laws[1],
    ]
    for chosen in (laws, mixed):
        plant = Plant(robot, chosen, *START)
        for v in (np.array([0.3, -0.01]), np.zeros(2), np.array([-5.0, 1e-4])):
            truth = [law.torque(x) for law, x in zip(chosen, v, strict=True)]
            np.testing.assert_allclose(plant.friction_torque(v), truth, rtol=1e-14, atol=1e-15)
    np.testing.assert_array_equal(
        Plant(robot, (), *START).friction_torque(np.ones(2)), np.zeros(2)
    )


def test_friction_alone_brings_the_hanging_arm_to_rest(robot):
    laws = [
        make_friction_law('coulomb_viscous', {'coulomb': c, 'viscous': 0.1, 'bias': 0.0}, 0.01)
        for c in (0.8, 0.4)
    ]
    plant = Plant(robot, laws, np.array([-np.pi / 2 + 0.3, 0.2]), np.array([1.0, -1.0]))
    energy = [robot.energy(plant.q, plant.v)]
    for _ in range(2000):
        plant.step(np.zeros(2), 1e-3)
        energy.append(robot.energy(plant.q, plant.v))
    assert np.max(np.diff(energy)) < 1e-9
    assert np.abs(plant.v).max() < 0.02


def test_the_caller_keeps_the_arrays_it_gave(robot):
    q, v = np.array([0.1, 0.2]), np.array([1.0, 2.0])
    plant = Plant(robot, (), q, v)
    plant.step(np.ones(2), 1e-3)
    np.testing.assert_array_equal(q, [0.1, 0.2])
    np.testing.assert_array_equal(v, [1.0, 2.0])


def test_all_that_a_step_calls_is_called_when_the_plant_is_made(robot, monkeypatch):
    """So it is compiled by then, and no step takes seconds; the state stays as it was given."""
    called = set()

    def noted(name, function, *args):
        called.add((name, *(type(arg) for arg in args)))
        return function(*args)

    compiled = {'table_torque': plant_module, '_ahead': integrator, '_sum': integrator}
    for name, module in compiled.items():
        monkeypatch.setattr(module, name, partial(noted, name, getattr(module, name)))
    plant = Plant(robot, stribeck_laws(), *START)
    made = set(called)
    np.testing.assert_array_equal([plant.q, plant.v], START)
    plant.step(np.ones(2), 1e-3)
    assert called == made
    assert {name for name, *_ in made} == set(compiled)
