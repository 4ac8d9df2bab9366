# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Which fit becomes the model, and how the weak form comes beside the observers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.identification.bag_analysis import analyse_bag
from sosml_friction.identification.fitted_model import preferred_observer
from sosml_friction.identification.friction_fit import FitSettings
from sosml_friction.model.model_folder import FrictionParameters, read_model
from sosml_friction.model.parameter import Parameter
from sosml_friction.motion.trajectory_kinds.speed_ladder import speed_ladder
from sosml_friction.share import share_directory

COULOMB, VISCOUS, V0 = 20.0, 200.0, 0.002


@pytest.fixture(scope='module')
def nominal():
    """Return the slider with a friction whose sign is V0 wide; its numbers are not the truth."""
    model = read_model(share_directory() / 'config' / 'emps')
    guess = {
        'coulomb': Parameter(1.0, 'N'),
        'viscous': Parameter(1.0, 'N s/m'),
        'bias': Parameter(0.0, 'N'),
    }
    friction = FrictionParameters('coulomb_viscous', V0, guess)
    joints = {name: replace(joint, friction=friction) for name, joint in model.joints.items()}
    return replace(model, joints=joints)


@pytest.fixture(scope='module')
def bag(nominal, tmp_path_factory):
    robot = nominal.make_robot()
    ladder = speed_ladder({'slider': 0.1}, {'slider': 0.12}, [0.01, 0.04, 0.1], plateau_s=0.6)
    spline = ladder.spline()
    t = np.arange(0.0, ladder.duration, 0.004)
    q, v, a = spline(t), spline(t, 1), spline(t, 2)
    tau = np.array([robot.inverse_dynamics(*state) for state in zip(q, v, a, strict=True)])
    tau += COULOMB * np.tanh(v / V0) + VISCOUS * v
    tau += np.random.default_rng(3).normal(0.0, 0.3, v.shape)
    log = JointLog(robot.names, np.rint(t * 1e9).astype(np.int64), q, v, tau)
    folder = tmp_path_factory.mktemp('bags') / 'ladder'
    return write_joint_log(log, folder, nominal.urdf, nominal.to_yaml())


def test_the_weak_form_comes_first_then_sosml_then_any():
    assert preferred_observer(['first_order', 'sosml', 'weak_form']) == 'weak_form'
    assert preferred_observer(['first_order', 'sosml']) == 'sosml'
    assert preferred_observer(['kalman', 'first_order']) == 'kalman'
    assert preferred_observer([]) is None


def test_the_weak_form_is_not_told_the_width_of_the_sign_and_the_model_has_what_it_found(bag):
    """The slowest plateau is at 5 v0, where the sign is 1 to 1e-4: it may be found as 0."""
    analysis = analyse_bag(bag, settings=FitSettings(method='weak'))
    fits = analysis.fit.joints['slider']
    assert list(fits) == ['first_order', 'sosml', 'weak_form']
    assert fits['weak_form'].fit.smoothing_velocity < 1.5 * V0
    assert fits['sosml'].fit.smoothing_velocity == 0.0
    friction = analysis.model.joints['slider'].friction
    assert friction.smoothing_velocity == fits['weak_form'].fit.smoothing_velocity
    assert friction.parameters['coulomb'].value == pytest.approx(COULOMB, rel=0.02)
    assert friction.parameters['viscous'].value == pytest.approx(VISCOUS, rel=0.03)
    assert set(analysis.estimates) == {'first_order', 'sosml', 'weak_form'}
    assert analysis.inverse is None
    # What figures show of it is friction: its levels lie on the law.
    used = [not segment.rejected for segment in fits['weak_form'].segments]
    levels = fits['weak_form'].levels[used]
    speeds = np.array([segment.velocity for segment in fits['weak_form'].segments])[used]
    known = np.isfinite(levels)
    assert known.sum() >= 6
    law = COULOMB * np.tanh(speeds / V0) + VISCOUS * speeds
    np.testing.assert_allclose(levels[known], law[known], atol=0.3)


def test_a_joint_without_weak_form_has_the_law_of_the_regression_besides(bag, monkeypatch):
    from sosml_friction.exceptions import DataError
    from sosml_friction.identification import weak_form

    def refuse(*_):
        raise DataError('too few pieces')

    monkeypatch.setattr(weak_form.WeakForm, 'fit', refuse)
    analysis = analyse_bag(bag, settings=FitSettings(method='weak'))
    assert list(analysis.fit.joints['slider']) == ['first_order', 'sosml', 'regression']
    assert analysis.fit.unavailable['slider'] == 'the weak form has no fit: too few pieces'
    assert np.isnan(analysis.estimates['weak_form']).all()
    friction = analysis.model.joints['slider'].friction
    assert friction.parameters['coulomb'].value == pytest.approx(COULOMB, rel=0.05)


def test_the_weak_form_stands_alone_where_no_observer_can_be_fitted(bag, monkeypatch):
    from sosml_friction.exceptions import DataError
    from sosml_friction.identification import friction_fit

    def refuse(*_):
        raise DataError('no steady window')

    monkeypatch.setattr(friction_fit._JointTask, 'fit', refuse)
    analysis = analyse_bag(bag)
    assert list(analysis.fit.joints['slider']) == ['weak_form']
    assert analysis.fit.unavailable == {'slider': 'no observer could be fitted: no steady window'}
    friction = analysis.model.joints['slider'].friction
    assert friction.parameters['coulomb'].value == pytest.approx(COULOMB, rel=0.05)
    with pytest.raises(DataError, match='slider: no steady window'):
        analyse_bag(bag, settings=FitSettings(method='samples'))
