# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""An inertia that the effort contradicts altogether is told, and fitted freely."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known_robots import SLIDER_MASS, recording, sines, slider_model, smooth_sign

from sosml_friction.diagnosis.design import Design
from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.diagnosis.library import make_library
from sosml_friction.diagnosis.recordings import Recordings
from sosml_friction.diagnosis.untold_inertia import UNTOLD, untold_inertia
from sosml_friction.model.terms.cogging import Cogging
from sosml_friction.model.terms.inertia import Inertia
from sosml_friction.model.terms.joint_elasticity import JointElasticity
from sosml_friction.regression.placed import Placed
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare
from sosml_friction.regression.whitened import WhitenedRegression

MODEL = slider_model(20.0, 200.0)
#: Of a ripple of the effort [rad/m].
FREQUENCY = 300.0


def with_friction(t, q, v, force):
    """Return a recording of the slider with this force [N] beside its friction, and noise."""
    tau = force + 20.0 * smooth_sign(q, v) + 200.0 * v
    return recording(('slider',), t, q, tau + np.random.default_rng(2).normal(0.0, 1.0, len(t)))


def moved(mass, ripple=0.0):
    """Return a slider that moves as if it had this mass [kg], with a ripple [N]."""
    t = np.arange(0.0, 24.0, 5e-3)
    q, v, a = sines(t, ((0.08, 0.9), (0.02, 2.1)))
    return with_friction(t, q, v, mass * a + ripple * np.sin(FREQUENCY * q))


def behind_a_spring(resonance):
    """
    Return the slider's rotor, 0.3 of its mass; the rest follows by a spring.

    Along a line of w the rest needs a / (1 - (w / w0)^2) of its acceleration a, in steady state.

    :param resonance: of the rest on its spring, w0 [rad/s].
    """
    t = np.arange(0.0, 30.0, 4e-3)
    lines = ((0.08, 0.94, 0.0), (0.02, 2.51, 1.3), (0.004, 10.7, 2.6), (0.0015, 34.6, 3.9))
    motions = np.array([sines(t, (line,)) for line in lines])
    needed = [0.3 + 0.7 / (1.0 - (w / resonance) ** 2) for _, w, _ in lines]
    q, v, _ = motions.sum(axis=0)
    return with_friction(t, q, v, SLIDER_MASS * (needed @ motions[:, 2]))


def regression(mass, ripple=0.0, **settings):
    """Return the rows of :func:`moved`."""
    asked = replace(DiagnosisSettings(), **settings)
    signals = prepare([moved(mass, ripple)], MODEL, MODEL.make_robot(), asked)
    library = {'inertia': Inertia(), 'joint_elasticity': JointElasticity()}
    if ripple:
        # What has a name is no noise.
        library['cogging'] = Cogging()
    return WhitenedRegression.make(signals, library, asked)


def test_an_inertia_that_is_not_there_is_told_with_both_numbers():
    (check,) = untold_inertia(regression(10.0)).values()
    assert (check.kind, check.joint, check.severity) == ('inertia', 'slider', 'warning')
    error = check.values['seen_std_error']
    assert check.values['seen'] == pytest.approx(10.0, abs=5.0 * error + 0.5)
    assert check.values['model'] == pytest.approx(SLIDER_MASS)


@pytest.mark.parametrize('mass', [0.5 * SLIDER_MASS, SLIDER_MASS, 2.0 * SLIDER_MASS])
def test_an_inertia_that_a_cause_can_correct_is_left_to_it(mass):
    assert not untold_inertia(regression(mass))


def test_a_cause_that_hides_how_small_an_inertia_is_stands_beside_it():
    """A ripple of the effort of three times what the mass needs: beside it, it is told."""
    ripple = Cogging()
    rows = regression(0.2 * SLIDER_MASS, ripple=60.0)
    inner = {'frequency': FREQUENCY}
    placed = Placed(ripple, 0, inner, rows.single(ripple, 0, inner))
    alone, beside = untold_inertia(rows), untold_inertia(rows, [placed])
    assert not alone
    assert beside['slider'].values['seen'] == pytest.approx(0.2 * SLIDER_MASS, rel=0.2)


def test_a_gear_is_no_candidate_where_the_inertia_is_not_told():
    found = [regression(10.0, free_inertia=free).candidates for free in ((), ('slider',))]
    assert [{c.effect.identifier for c in each} for each in found] == [
        {'inertia', 'joint_elasticity'}, {'inertia'},
    ]  # fmt: skip


def test_a_free_inertia_may_be_off_by_all_but_the_tolerance():
    nominal = regression(10.0, free_inertia=('slider',)).nominal
    at = nominal.names.index('slider armature')
    assert nominal.bound[at] == pytest.approx((1.0 - 0.035) * SLIDER_MASS)


def test_an_inertia_that_is_not_there_is_no_all_clear():
    found = diagnose([moved(10.0)], MODEL)
    assert found.verdict == 'unknown_structure'
    assert 'The effort of slider contradicts the inertia of the model' in found.sentence
    assert UNTOLD in [check.kind for check in found.checks]


def test_a_gear_that_leaves_less_than_an_inertia_that_is_free_is_told_instead():
    log = behind_a_spring(19.0)
    rows = Design.make(
        Recordings.checked([log], MODEL.make_robot()), MODEL, MODEL.make_robot(), None,
        make_library(), DiagnosisSettings(), lambda text: None,
    )  # fmt: skip
    assert rows.untold == ('slider',)
    found = diagnose([log], MODEL)
    names = {name for cause in found.causes for name in (cause.effect, *cause.rivals)}
    assert {'joint_elasticity', 'backlash'} <= names
    assert not any(check.kind == UNTOLD for check in found.checks)
    assert found.gain.relative_after[0] < 0.2 * found.gain.relative_before[0]
