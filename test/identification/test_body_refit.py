# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A URDF that is wrong does not spoil friction: its bodies are refitted, and only then."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.body_refit import refit_body
from sosml_friction.identification.friction_fit import FitSettings
from sosml_friction.identification.log_analysis import analyse_log
from sosml_friction.model.consistent_inertias import is_possible
from sosml_friction.model.urdf_bodies import with_bodies
from validation import plant as bp
from validation.motion import reference
from validation.trial import JOINTS, nominal_model

#: A drawn number for the seeds of this file.
SEED = 20261140


@pytest.fixture(scope='module')
def log():
    """Return what the independent plant measures of itself."""
    run = bp.simulate(
        bp.Plant(), *reference('rich', None), np.random.default_rng(SEED), bp.Noise()
    )
    return JointLog(JOINTS, np.rint(run.t * 1e9).astype(np.int64), run.q, run.v, run.tau)


def scaled(share):
    """Return the nominal model without friction, each body scaled by ``1 + share``."""
    model = nominal_model()
    robot = model.make_robot()
    bodies = dict(zip(robot.names, robot.inertial_parameters() * (1.0 + share), strict=True))
    joints = {name: replace(joint, friction=None) for name, joint in model.joints.items()}
    return replace(model, joints=joints, urdf=with_bodies(model.urdf, bodies))


@pytest.fixture(scope='module')
def refitted(log):
    return refit_body([log], scaled(0.4))


def test_a_body_that_fits_is_left_alone(log):
    assert refit_body([log], scaled(0.0)) is None
    assert refit_body([log], scaled(0.4), tolerance=0.0) is None


def test_the_weight_of_bodies_40_percent_too_heavy_is_found(refitted):
    """What gravity feels of the bodies, within 3 standard errors of their first moments."""
    assert refitted is not None
    assert refitted.tolerance >= 0.3
    true, found = scaled(0.0).make_robot(), refitted.model.make_robot()
    wrong = scaled(0.4).make_robot()
    moments = [p.std_error for n, p in refitted.deviations.items() if 'moment' in n]
    poses = np.random.default_rng(SEED).uniform(-1.5, 1.5, (20, 2))
    off, before = (
        np.abs([robot.gravity(q) - true.gravity(q) for q in poses]) for robot in (found, wrong)
    )
    assert off.max() < 3.0 * 9.81 * sum(moments)
    assert off.max() < 0.05 * before.max()
    for p in refitted.deviations.values():
        assert np.isfinite(p.std_error)
        assert p.std_error > 0.0
    assert all(is_possible(body) for body in found.inertial_parameters())


def test_friction_beside_refitted_bodies_is_that_of_the_plant(refitted):
    """Within its 95 % interval or 3 %: the plant's build-up at a reversal is not the fit's."""
    for i, joint in enumerate(JOINTS):
        law = refitted.laws[joint].parameters
        for name, truth in (('coulomb', bp.COULOMB[i]), ('viscous', bp.VISCOUS[i])):
            low, high = law[name].interval
            assert low - 0.03 * truth < truth < high + 0.03 * truth, (joint, name)
    assert refitted.loads == ()


def test_the_fit_of_a_log_uses_the_refitted_bodies_and_says_so(log):
    analysis = analyse_log(log, scaled(0.4), FitSettings())
    assert analysis.body is not None
    assert analysis.model.urdf == analysis.body.model.urdf
    (told,) = [f for f in analysis.data_checks.findings if f.check == 'rigid_body']
    assert 'refitted within' in told.sentence
    for i, joint in enumerate(JOINTS):
        friction = analysis.model.joints[joint].friction
        assert friction.parameters['coulomb'].value == pytest.approx(bp.COULOMB[i], rel=0.05)


@pytest.mark.parametrize('share', [-0.1, float('nan')])
def test_a_tolerance_that_is_none_is_refused(share):
    with pytest.raises(ConfigurationError, match='give a share'):
        FitSettings(body_tolerance=share)
