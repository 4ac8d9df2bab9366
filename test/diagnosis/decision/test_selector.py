# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a search begins with, and which causes cannot stand beside one another."""

from types import SimpleNamespace

import numpy as np
import pytest
from known_robots import (
    arm_model,
    arm_motion,
    recording,
    rigid_effort,
    sines,
)

from sosml_friction.diagnosis import diagnosis
from sosml_friction.diagnosis.decision.selector import Selector, _cancel, _once
from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.model.simple_models import pendulum_model
from sosml_friction.model.terms.cogging import Cogging
from sosml_friction.model.terms.stribeck import Stribeck
from sosml_friction.regression.settings import DiagnosisSettings

_SETTINGS = DiagnosisSettings(band=15.0)


def arm_recording(seed):
    """Return the arm with C 0.5 Nm and B 0.2 Nm s/rad in both joints, and 20 mNm of noise."""
    t = np.arange(0.0, 24.0, 5e-3)
    q, v, a = arm_motion(t)
    tau = rigid_effort(arm_model(), q, v, a) + 0.5 * np.tanh(v / 5e-3) + 0.2 * v
    tau += np.random.default_rng(seed).normal(0.0, 0.02, tau.shape)
    return recording(('shoulder', 'elbow'), t, q, tau)


def test_of_all_friction_only_what_is_off_stays(monkeypatch):
    """Asked for where something is unknown: both joints' C and B, of which one of each is off."""
    searched, looks = diagnosis._searched, []

    def unknown_at_first(design, model, keep_all, without, step, all_friction=False):
        looks.append(all_friction)
        found = searched(design, model, keep_all, without, step, all_friction)
        if not all_friction:
            object.__setattr__(found, 'verdict', 'unknown_structure')
        return found

    monkeypatch.setattr(diagnosis, '_searched', unknown_at_first)
    monkeypatch.setattr(diagnosis, 'large_delay', lambda *_: None)
    found = diagnose([arm_recording(0)], arm_model((0.6, 0.2), (0.5, 0.15)), None, _SETTINGS)
    assert looks == [False, True]
    assert found.verdict == 'named'
    assert {cause.key for cause in found.causes} == {('coulomb', 'shoulder'), ('viscous', 'elbow')}
    for cause, change in zip(found.causes, (-0.1, 0.05), strict=True):
        size = cause.parameters['change']
        assert size.value == pytest.approx(change, abs=3.0 * size.std_error)


def test_a_stop_on_one_side_is_no_gravity_that_a_spring_cancels():
    """2.5 Nm/rad from 0.8 rad on: the body has 0.75 kg m, and 1.2 kg m were said to be added."""
    t = np.arange(0.0, 60.0, 5e-3)
    q, v, a = sines(t, ((0.45, 0.9), (0.3, 2.1, 1.0), (0.1, 5.0, 2.0)))
    q += 0.5
    model = pendulum_model(2.5, 0.3, 0.05, 0.05, 'knee')
    tau = rigid_effort(model, q[:, None], v[:, None], a[:, None])[:, 0]
    tau += np.sign(v) + 0.2 * v + 2.5 * np.maximum(q - 0.8, 0.0)
    tau += np.random.default_rng(0).normal(0.0, 0.03, len(t))
    found = diagnose([recording(('knee',), t, q, tau)], model)
    assert found.verdict == 'unknown_structure'
    assert {'gravity', 'spring'} - {cause.effect for cause in found.causes}


def test_two_courses_of_time_that_make_a_step_cancel_and_others_do_not():
    t = np.linspace(0.0, 240.0, 2000)
    slow, fast = (np.exp(-t / constant)[:, None] for constant in (200.0, 20.0))
    nearly = np.exp(-t / 190.0)[:, None]
    assert _cancel(26.0 * slow, -25.0 * nearly)
    assert not _cancel(slow, nearly)
    assert not _cancel(slow, -0.5 * fast)


def test_where_the_friction_of_all_joints_is_right_none_of_it_stays(monkeypatch):
    run = Selector.run
    monkeypatch.setattr(Selector, 'run', lambda self, _: run(self, all_friction=True))
    found = diagnose([arm_recording(1)], arm_model(), None, _SETTINGS)
    assert (found.verdict, found.causes, found.tolerated) == ('nothing_above_floor', (), ())


def test_a_law_has_each_term_once_and_a_joint_a_ripple_of_many_waves():
    """Two Stribeck terms of one joint made a model that no command read."""
    own, other, ripple = (
        SimpleNamespace(key=(effect.identifier, joint), effect=effect)
        for effect, joint in ((Stribeck(), 0), (Stribeck(), 1), (Cogging(), 0))
    )
    assert _once([own, other, ripple], []) == [own, other, ripple]
    assert _once([own, other, ripple], [own, ripple]) == [other, ripple]
