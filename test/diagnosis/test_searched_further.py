# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a diagnosis looks for where data left out contradict what it had found."""

from dataclasses import replace

import numpy as np
import pytest
from known_robots import recording, rigid_effort, sines

from sosml_friction.diagnosis import judgement
from sosml_friction.diagnosis.decision.forward_gate import FORWARD_WORSE
from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.model.simple_models import pendulum_model
from sosml_friction.model.terms.kinds.term import TERMS


@pytest.fixture(scope='module')
def weighed():
    """Return a pendulum of 2.5 kg m whose weight is 3 kg m, which moves slowly, and its model."""
    t = np.arange(0.0, 40.0, 5e-3)
    q, v, a = (x[:, None] for x in sines(t, ((0.6, 0.5), (0.3, 1.3, 1.0))))
    tau = rigid_effort(pendulum_model(3.0, 0.3, 0.05, 0.05, 'knee'), q, v, a)
    tau += 0.5 * np.tanh(v / 5e-3) + 0.2 * v
    tau += np.random.default_rng(0).normal(0.0, 0.02, tau.shape)
    return recording(('knee',), t, q, tau), pendulum_model(2.5, 0.3, 0.05, 0.05, 'knee')


def contradicting(monkeypatch, *effects):
    """Let the simulation of data left out contradict these, and return what it was asked of."""
    asked = []

    def gate(forward, laboratory, selection):
        asked.append([finding.effect.identifier for finding in selection.accepted])
        stay = [f for f in selection.accepted if f.effect.identifier not in effects]
        gone = [f for f in selection.accepted if f.effect.identifier in effects]
        own = selection.refitted(laboratory, stay)
        if gone:
            own = own.taken_back(replace(gone[0], failed=(FORWARD_WORSE,)))
        squares = forward.squares(own.accepted, own.after.x, own.after.fold_x)
        return own, squares, squares

    monkeypatch.setattr(judgement, 'forward_gate', gate)
    return asked


def test_what_a_contradicted_cause_stood_for_is_looked_for_beside_it(weighed, monkeypatch):
    """A weight that is off or an effort that is scaled: with one out it is the other."""
    log, model = weighed
    asked = contradicting(monkeypatch, 'effort_scale')
    found = diagnose([log], model)
    assert asked == [['effort_scale'], ['payload']]
    assert [cause.key for cause in found.causes] == [('payload', '*')]
    assert not found.causes[0].rivals


def test_where_all_that_is_found_is_contradicted_the_first_answer_stays(weighed, monkeypatch):
    log, model = weighed
    asked = contradicting(monkeypatch, *TERMS.classes)
    found = diagnose([log], model)
    assert not found.causes
    # Each cause is judged once, and the reason that is told is that of the best.
    named = [effect for own in asked for effect in own]
    assert named[0] == 'effort_scale'
    assert len(set(named)) == len(named)
    assert found.rejected['effect'] == 'effort_scale'
    assert found.rejected['failed'] == [FORWARD_WORSE]
