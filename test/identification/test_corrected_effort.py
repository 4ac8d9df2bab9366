# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A model that knows what is wrong with the effort: the fit gives the friction that is there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.identification.bag_analysis import analyse_bag
from sosml_friction.identification.friction_fit import FitSettings
from sosml_friction.model.model_folder import EffectTerm, read_model
from sosml_friction.model.parameter import Parameter
from sosml_friction.share import share_directory

COULOMB, VISCOUS, MASS, STEP = 20.0, 200.0, 95.1089, 5e-3


@pytest.fixture(scope='module')
def fitted(tmp_path_factory):
    """Return the fit of a slider whose effort reads 10 % and 3 N too much, and is told so."""
    folder = tmp_path_factory.mktemp('fit')
    t = np.arange(0.0, 30.0, STEP)
    q, v, a = np.zeros((3, len(t)))
    for size, w in ((0.06, 0.7), (0.02, 2.3)):
        q += 0.12 / 2 + size * np.sin(w * t)
        v += size * w * np.cos(w * t)
        a -= size * w**2 * np.sin(w * t)
    tau = MASS * a + COULOMB * np.tanh(v / 1e-3) + VISCOUS * v
    reported = 1.1 * tau + 3.0 + np.random.default_rng(0).normal(0.0, 0.3, len(t))
    columns = (x[:, None] for x in (q, v, reported))
    log = JointLog(('slider',), np.rint(t * 1e9).astype(np.int64), *columns)
    effects = (
        EffectTerm('effort_scale', 'slider', {'error': Parameter(0.1, '1')}),
        EffectTerm('effort_bias', 'slider', {'bias': Parameter(3.0, 'N')}),
        EffectTerm('spring', 'slider', {'stiffness': Parameter(1.0, 'N/m')}),
        EffectTerm('effort_delay', '*', {'delay': Parameter(1e-3, 's')}),
    )
    known = replace(
        read_model(share_directory() / 'config/emps'),
        effects=effects,
        provenance={'rigid_body': {'written': ['refit'], 'refused': {}}},
    )
    bag = write_joint_log(log, folder / 'bag', known.urdf, known.to_yaml())
    return analyse_bag(bag, settings=FitSettings(method='samples'))


def test_friction_is_that_of_the_torque_and_not_of_what_was_reported(fitted):
    """Uncorrected it would be 22 N, 220 N s/m and a bias of 3 N."""
    parameters = fitted.fit.joints['slider']['sosml'].fit.parameters
    assert parameters['coulomb'].value == pytest.approx(COULOMB, rel=0.03)
    assert parameters['viscous'].value == pytest.approx(VISCOUS, rel=0.03)
    assert abs(parameters['bias'].value) < 0.5


def test_the_fitted_model_keeps_what_it_was_corrected_by_and_names_what_it_lost(fitted):
    assert [t.effect for t in fitted.model.effects] == ['effort_scale', 'effort_bias']
    assert fitted.model.is_rigid_body_identified
    assert fitted.model.provenance['effects_left_out'] == ['spring of slider', 'effort_delay of *']


def test_it_is_told(fitted):
    notes = [f.sentence for f in fitted.data_checks.findings if f.check == 'effects']
    assert any('corrected by the model: effort_scale of slider' in text for text in notes)
    (told,) = [text for text in fitted.data_checks.sentences if 'effort_delay' in text]
    assert 'left out' in told
    (held,) = [text for text in fitted.data_checks.sentences if 'on average' in text]
    assert 'holds the spring of slider of the model' in held
