# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A drag by a power of speed beside a Stribeck term: a rival where it explains as much."""

from dataclasses import replace

import numpy as np
import pytest
from known_robots import coulomb_viscous, recording, sines

from sosml_friction.diagnosis.decision.leftover import Leftover
from sosml_friction.diagnosis.decision.one_power import OnePower
from sosml_friction.diagnosis.decision.remainder import Remainder
from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.model.simple_models import pendulum_model
from sosml_friction.regression.curves.axes import SPEED

MASS, LENGTH, ARMATURE, COULOMB, VISCOUS = 0.25, 0.16, 0.006, 0.1, 0.04


def answered(more):
    """Return the causes of a servo's pendulum, up to 3.6 rad/s, with ``more`` friction [Nm]."""
    t = 0.01 * np.arange(6000)
    q, v, a = sines(t, ((0.9, 1.3, 0.0), (0.5, 3.1, 1.0), (0.1, 9.3, 2.0)))
    rng = np.random.default_rng(1)
    tau = (ARMATURE + MASS * LENGTH**2) * a + 9.81 * MASS * LENGTH * np.sin(q)
    tau += COULOMB * np.tanh(v / 4e-3) + VISCOUS * v + more(v)
    q = q + 1e-4 * rng.standard_normal(len(t))
    log = recording(('joint',), t, q, tau + 0.02 * rng.standard_normal(len(t)))
    model = pendulum_model(MASS, LENGTH, 0.0, ARMATURE)
    own = replace(model.joints['joint'], friction=coulomb_viscous(COULOMB, VISCOUS))
    found = diagnose([log], replace(model, joints={'joint': own}))
    return [(cause.effect, cause.rivals) for cause in found.causes]


@pytest.mark.parametrize(
    ('count', 'gain', 'instead'),
    [
        *((1, 89.0, False), (1, 91.0, True), (2, 89.0, False), (2, 91.0, True)),
        *((3, 69.0, False), (3, 71.0, True), (4, 71.0, True)),
    ],
)
def test_one_power_stands_in_the_place_of_three_causes_where_it_is_a_rival_of_them(
    count, gain, instead
):
    """It is as likely as they are from 80 on: what they explain, 100, less the price of 20."""
    bent = Leftover(SPEED, 0, 5.0, 4.0, 1.0, 0.0)
    found = Remainder((bent,)).with_powers([OnePower(0, (None,) * count, 100.0, gain, 20.0)]).found
    # In the place of what is left over speed it is the reason of it.
    assert [(each.axis, each.instead) for each in found] == [(SPEED, instead)]


def test_a_drag_that_looks_like_friction_of_slow_motion_may_be_either():
    assert answered(lambda v: 0.008 * v * np.abs(v)) == [('stribeck', ('nonlinear_viscous',))]


@pytest.mark.parametrize('knee', [0.2, 1.0])
def test_friction_that_fades_below_top_speed_is_no_drag(knee):
    """Up to a knee at a fourth of the top speed."""
    fading = answered(lambda v: 0.05 * np.tanh(v / 4e-3) * np.exp(-np.abs(v) / knee))
    assert fading == [('stribeck', ())]
