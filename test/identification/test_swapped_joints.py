# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Columns that stand for another joint are told, whichever they are, and right ones never."""

from dataclasses import replace

import numpy as np
import pytest
from known_robots import arm_model, arm_motion, recording, rigid_effort

from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.exceptions import DataError
from sosml_friction.identification.data_checks import check_data
from sosml_friction.identification.joint_relations import Slopes
from sosml_friction.identification.swapped_joints import swapped_joints

_OTHER = [1, 0]


@pytest.fixture(scope='module')
def arm():
    """Return the arm's recording with C 0.5 Nm and B 0.2 Nm s/rad in both joints."""
    t = np.arange(0.0, 24.0, 5e-3)
    q, v, a = arm_motion(t)
    tau = rigid_effort(arm_model(), q, v, a) + 0.5 * np.tanh(v / 5e-3) + 0.2 * v
    tau += np.random.default_rng(0).normal(0.0, 0.02, tau.shape)
    return recording(('shoulder', 'elbow'), t, q, tau)


def told(log, model=None):
    return swapped_joints(log, (model or arm_model()).make_robot(), Slopes.of(log))


@pytest.mark.parametrize('swapped', [{'efforts'}, {'positions'}, {'efforts', 'positions'}])
def test_which_columns_are_swapped_is_said(arm, swapped):
    q = arm.q[:, _OTHER] if 'positions' in swapped else arm.q
    tau = arm.tau[:, _OTHER] if 'efforts' in swapped else arm.tau
    what = next(iter(swapped)) if len(swapped) == 1 else 'columns'
    assert f'the {what} of joints shoulder and elbow seem to be swapped' in told(
        replace(arm, q=q, tau=tau)
    )


@pytest.mark.parametrize('ratio', [0.2, 2.4])
def test_currents_that_are_swapped_before_their_torque_constants_are_said(arm, ratio):
    """Each times the other's constant: the efforts are too large by r and by 1 / r."""
    tau = arm.tau[:, _OTHER] * (ratio, 1.0 / ratio)
    assert 'the currents of joints shoulder and elbow seem to be swapped' in told(
        replace(arm, tau=tau)
    )


def test_columns_in_their_places_are_not_swapped_whatever_the_model_gets_wrong(arm):
    assert told(arm) is None
    sign, t = np.sign(arm_motion(arm.time)[1]), arm.time[:, None]
    wrong = {
        'twice the effort in one joint': arm.tau * (1.0, 2.0),
        'half of it in both': 0.5 * arm.tau,
        'friction of five times the weight': arm.tau + 30.0 * sign,
        'a drift': arm.tau + 0.5 * t,
        'efforts that are one': arm.tau[:, [0, 0]],
        'no effort in one joint': arm.tau * (1.0, np.nan),
        'a constant effort in one joint': np.where([True, False], arm.tau, 1.0),
    }
    for what, tau in wrong.items():
        assert told(replace(arm, tau=tau)) is None, what


def test_an_exchange_that_leaves_more_than_all_of_an_effort_explains_nothing(arm):
    """Of a position in degrees: 'exchanged, 160 and 97 % are left, and 210 and 550 % as it is'."""
    degrees = arm.q * (1.0, 180.0 / np.pi)
    assert told(replace(arm, q=degrees, v=np.gradient(degrees, 5e-3, axis=0))) is None


def test_fit_and_diagnose_refuse_them_in_the_same_words(arm):
    log = replace(arm, tau=arm.tau[:, _OTHER])
    with pytest.raises(DataError, match='seem to be swapped') as refused:
        check_data(log, arm_model().make_robot())
    found = diagnose([log], arm_model())
    assert found.verdict == 'bad_data'
    assert found.sentence == str(refused.value)
