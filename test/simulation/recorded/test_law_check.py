# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A recorded law that does not make the recorded effort is told, and what was added is found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known_robots import recording, slider_model

from sosml_friction.diagnosis.model_simulation import simulate_model
from sosml_friction.simulation.cascade_loop import CascadeController
from sosml_friction.simulation.recorded.controlled_joint import ControlledJoint
from sosml_friction.simulation.recorded.law_check import LawCheck

STEP, MASS, COULOMB, VISCOUS = 2e-3, 95.1089, 20.0, 200.0
LAW = CascadeController(kp=50.0, kv=100.0, scale=35.0, limit=10.0)
TIME = np.arange(0.0, 8.0, STEP)
#: 40 N, four times for half a second.
PULSES = 40.0 * (np.mod(TIME - 1.0, 2.0) < 0.5) * (TIME > 1.0)


def loop(added):
    """Return log and loop of the slider with a signal [N] added to its controller's output."""
    reference = 0.05 * (1.0 - np.cos(1.5 * TIME)) + 0.01 * np.sin(4.0 * TIME) ** 2
    q = v = last = last_mean = 0.0
    steps = 20
    positions, efforts = np.empty_like(TIME), np.empty_like(TIME)
    for k, wanted in enumerate(reference):
        mean = 0.5 * (q + last)
        command = LAW.kp * LAW.kv * (wanted - q) - LAW.kv * (mean - last_mean) / STEP
        last, last_mean = q, mean
        effort = LAW.scale * np.clip(command, -LAW.limit, LAW.limit) + added[k]
        positions[k], efforts[k] = q, effort
        for _ in range(steps):
            v += STEP / steps * (effort - COULOMB * np.tanh(v / 2e-3) - VISCOUS * v) / MASS
            q += STEP / steps * v
    log = recording(('slider',), TIME, positions, efforts)
    return log, {'slider': ControlledJoint(LAW, reference)}


@pytest.fixture(scope='module')
def pushed():
    return loop(PULSES)


def test_an_injected_signal_is_found_with_its_size_and_its_pieces(pushed):
    log, controlled = pushed
    found = simulate_model(log, slider_model(COULOMB, VISCOUS), controlled)
    assert found.mode == 'windows'
    assert '40 N in 4 pieces from 1.00' in found.why_not
    assert 'injected' in found.why_not


def test_the_injected_signal_is_added_in_closed_loop(pushed):
    log, controlled = pushed
    known = {'slider': replace(controlled['slider'], injected=PULSES)}
    found = simulate_model(log, slider_model(COULOMB, VISCOUS), known)
    assert found.mode == 'closed_loop'
    assert found.errors['slider']['effort'].relative < 3.0
    assert any('the recorded law makes the recorded effort' in line for line in found.remarks)


def test_a_loop_whose_law_makes_its_effort_is_simulated_as_it_was():
    log, controlled = loop(np.zeros_like(TIME))
    found = simulate_model(log, slider_model(COULOMB, VISCOUS), controlled)
    assert found.mode == 'closed_loop'
    assert found.errors['slider']['effort'].relative < 3.0


def test_other_gains_are_not_the_law_that_was_at_work(pushed):
    log, controlled = loop(np.zeros_like(TIME))
    other = replace(controlled['slider'], controller=replace(LAW, kv=60.0))
    found = simulate_model(log, slider_model(COULOMB, VISCOUS), {'slider': other})
    assert found.mode == 'windows'
    assert 'do not make the recorded effort of slider' in found.why_not


def test_noise_in_the_recorded_effort_is_no_injected_signal():
    t = np.arange(0.0, 1.0, 1e-3)
    left = np.random.default_rng(1).normal(0.0, 1.0, len(t))
    assert LawCheck('j', left, 10.0, 10.0, t).holds
    assert not LawCheck('j', left, 2.0, 2.0, t).holds
    assert 'pieces' not in LawCheck('j', left, 2.0, 2.0, t).objection('Nm')
