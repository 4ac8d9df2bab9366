# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What every effect has from its base: units by the kind of joint, columns of one joint."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.term import TERMS
from sosml_friction.regression.signals import Scales, Signals

TURNS, SLIDES = 0, 1


@pytest.fixture
def signals():
    """Return five samples of a robot whose first joint turns and whose second slides."""
    zero, nothing = np.zeros((5, 2)), np.zeros(2)
    scales = Scales(*(nothing for _ in range(4)), np.array([3.0, 4.0]),
                    np.array([0.5, np.nan]), *(nothing for _ in range(5)))  # fmt: skip
    robot = SimpleNamespace(n=2, effort_units=('Nm', 'N'))
    return Signals(np.arange(5.0), *([zero] * 7), np.zeros((5, 2, 20)), robot, scales, None)


@pytest.mark.parametrize(
    ('name', 'parameter', 'turns', 'slides'),
    [
        ('coulomb', 'change', 'Nm', 'N'),
        ('viscous', 'change', 'Nm s/rad', 'N s/m'),
        ('stribeck', 'stribeck_velocity', 'rad/s', 'm/s'),
        ('inertia', 'change', 'kg m2', 'kg'),
        ('spring', 'stiffness', 'Nm/rad', 'N/m'),
        ('backlash', 'gap', 'rad', 'm'),
        ('cogging', 'frequency', 'rad/rad', 'rad/m'),
        ('thermal_drift', 'viscous_drift', 'Nm s/rad', 'N s/m'),
        ('effort_scale', 'error', '1', '1'),
    ],
)
def test_units_follow_the_kind_of_joint(signals, name, parameter, turns, slides):
    effect = TERMS[name]()
    k = len(effect.amplitudes)
    for joint, unit in ((TURNS, turns), (SLIDES, slides)):
        fit = Fitted(signals, joint, dict.fromkeys(effect.inner, 1.0), np.ones(k), np.ones(k))
        assert effect.reported(fit)[parameter].unit == unit


def test_a_drift_is_per_degree_where_temperature_is_measured(signals):
    drift = TERMS['thermal_drift']()
    warm = replace(signals, temperature=np.outer(np.arange(5.0), [1.0, 0.0]))
    assert drift.units(warm, TURNS) == {
        'viscous_drift': 'Nm s/rad/degC', 'coulomb_drift': 'Nm/degC', 'time_constant': 's',
    }  # fmt: skip
    assert drift.units(warm, SLIDES)['coulomb_drift'] == 'N'


def test_columns_are_of_one_joint(signals):
    one, two = np.arange(5.0), np.ones(5)
    columns = signals.in_joint(SLIDES, one, two)
    assert columns.shape == (5, 2, 2)
    assert not columns[:, TURNS].any()
    assert ((one, two) == columns[:, SLIDES].T).all()


def test_friction_is_measured_against_coulombs_or_all_effort(signals):
    assert [signals.scales.level(joint) for joint in (TURNS, SLIDES)] == [0.5, 4.0]


@pytest.mark.parametrize(
    ('displacement', 'share', 'possible'),
    [
        (1.25e-3, 1.0, True),
        (1.25e-3, 2.4, True),
        (1.25e-3, 2.6, False),
        (6e-3, 1.9, True),
        (6e-3, 2.1, False),
        (6e-3, 0.3, False),
        (0.7e-3, 5.0, True),
    ],
)
def test_friction_that_builds_up_grows_as_the_joint_moves_on(
    signals, displacement, share, possible
):
    """(C - F) / x_0 + F / x_s > 0: up to 2.54 C where x_0 is 0.76 mrad and x_s 1.25 mrad."""
    scales = replace(signals.scales, displacement=np.array([0.76e-3, 1.0]))
    fit = Fitted(
        replace(signals, scales=scales), TURNS, {'displacement': displacement},
        np.array([0.5 * share]), np.ones(1),
    )  # fmt: skip
    assert (TERMS['presliding_hysteresis']().implausible(fit) == '') == possible
