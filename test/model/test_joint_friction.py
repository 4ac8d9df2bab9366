# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The friction of several joints: each has its own terms, amplitudes and inner parameters."""

import numpy as np
import pytest

from sosml_friction.model.joint_friction import JointFriction
from sosml_friction.model.laws import make_friction_law

V = np.linspace(-0.5, 0.5, 11)


def laws():
    """Return a plain law, one with Stribeck terms by direction, and none."""
    plain = {'coulomb': 0.8, 'viscous': 0.35, 'bias': 0.05}
    stribeck = {
        'coulomb': 1.2, 'viscous': 0.5, 'bias': -0.1, 'stribeck': 0.3, 'stribeck_velocity': 0.07,
        'viscous_asymmetry': 0.04, 'stribeck_asymmetry': 0.06,
    }  # fmt: skip
    return [
        make_friction_law('coulomb_viscous', plain, 0.0),
        make_friction_law('stribeck_gaussian_asymmetric', stribeck, 0.0),
        None,
    ]


def torque(friction, v=V):
    v = np.repeat(v[:, None], 3, axis=1)
    return friction.torque(v, np.sign(v))


def test_each_joint_has_its_own_law():
    mine = laws()
    tau = torque(JointFriction(mine))
    for i in (0, 1):
        assert tau[:, i] == pytest.approx(mine[i].torque(V), abs=1e-14)
    assert not tau[:, 2].any()


def test_the_level_is_what_the_sign_is_multiplied_with_at_standstill():
    """Coulomb; with Stribeck and its asymmetry on top, which add up in one direction."""
    assert JointFriction(laws()).level == pytest.approx([0.8, 1.2 + 0.3 + 0.06, 0.0])


def test_the_damping_is_the_slope_where_stribeck_has_faded():
    """Viscous friction, with its asymmetry on top in one direction."""
    assert JointFriction(laws()).damping == pytest.approx([0.35, 0.5 + 0.04, 0.0], rel=1e-9)


def test_a_change_is_added_in_the_joints_it_names():
    before = JointFriction(laws())
    after = before.changed({'coulomb': np.array([0.1, -0.2, 0.3])})
    expected = torque(before) + np.sign(V)[:, None] * [0.1, -0.2, 0.3]
    assert torque(after) == pytest.approx(expected, abs=1e-14)
    # What it was made from stays.
    assert torque(before) == pytest.approx(torque(JointFriction(laws())), abs=0.0)


def test_a_change_adds_the_term_that_no_joint_had():
    bare = JointFriction([None, None, None])
    after = bare.changed({'viscous': np.array([0.0, 0.4, 0.0])})
    assert torque(after) == pytest.approx(V[:, None] * [0.0, 0.4, 0.0], abs=1e-15)
    again = after.changed({'viscous': np.array([0.1, 0.1, 0.0])})
    assert torque(again) == pytest.approx(V[:, None] * [0.1, 0.5, 0.0], abs=1e-15)


def test_a_change_of_nothing_adds_no_term():
    bare = JointFriction([None, None, None])
    after = bare.changed({'no_term_at_all': np.zeros(3)})
    assert not torque(after).any()
