# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The compiled friction and integrator are the laws and the rule they stand for."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import pytest

from sosml_friction.model.laws import make_friction_law
from sosml_friction.model.model_folder import read_model
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.term import TERMS
from sosml_friction.share import share_directory
from sosml_friction.simulation.plant import Plant, friction_table, table_torque

STRIBECK = {
    'coulomb': 0.8,
    'viscous': 0.35,
    'stribeck': 0.5,
    'stribeck_velocity': 0.03,
    'bias': -0.1,
}


MORE = {'viscous_asymmetry': 0.1, 'stribeck_asymmetry': -0.2}


@pytest.mark.parametrize('v0', [0.0, 0.005])
@pytest.mark.parametrize('law', ['stribeck_asymmetric', 'stribeck_gaussian_asymmetric'])
def test_the_table_gives_what_the_laws_give(v0, law):
    laws = [
        make_friction_law('stribeck', STRIBECK, v0),
        make_friction_law(law, {**STRIBECK, **MORE}, v0),
    ]
    table = friction_table(laws)
    for v in np.concatenate([np.linspace(-2, 2, 41), [1e-4, -3e-3, 0.0]]):
        expected = [float(law.torque(v)) for law in laws]
        np.testing.assert_allclose(table_torque(table, np.full(2, v)), expected, atol=1e-14)


@pytest.fixture
def quadratic():
    """Return a law that is not compiled, of a term that is not the package's."""

    class Quadratic(EffortTerm):
        identifier = 'quadratic'
        amplitudes: ClassVar = {'c': '{effort} s2/{length}2'}
        of_law = True

        def effort(self, motion, joint, inner, state):
            v = motion.v[:, joint]
            return (v * np.abs(v),)

    yield make_friction_law('quadratic', {'c': 0.5}, 0.0)
    TERMS.remove('quadratic')


def make(laws):
    model = read_model(share_directory() / 'config' / 'emulated_exoskeleton')
    return Plant(model.make_robot(), laws, np.array([-1.2, 0.4]), np.array([0.3, -0.2]))


def test_a_law_the_table_does_not_know_is_still_integrated(quadratic):
    laws = [quadratic, make_friction_law('stribeck', STRIBECK, 0.005)]
    assert friction_table(laws) is None
    plant = make(laws)
    np.testing.assert_allclose(plant.friction_torque(np.array([2.0, 0.1]))[0], 2.0)
    plant.step(np.zeros(2), 1e-4)
    assert np.isfinite(plant.q).all()


def test_a_plant_without_friction_has_none():
    plant = make([])
    np.testing.assert_array_equal(plant.friction_torque(np.ones(2)), 0.0)


def test_the_compiled_step_is_the_general_step():
    model = read_model(share_directory() / 'config' / 'emulated_exoskeleton')
    tau = np.array([1.0, 0.5])
    held, called = make(model.friction_laws()), make(model.friction_laws())
    for _ in range(2000):
        held.step(tau, 2.5e-4)
        called.step(lambda q, v: tau, 2.5e-4)
    np.testing.assert_allclose(held.q, called.q, atol=1e-13)
    np.testing.assert_allclose(held.v, called.v, atol=1e-13)
