# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The friction of the forward simulation is that of the laws."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.model.joint_friction import JointFriction
from sosml_friction.model.laws import FRICTION_LAWS, make_friction_law

VALUES = {
    'coulomb': 0.8, 'viscous': 0.35, 'bias': 0.05, 'stribeck': 0.3, 'stribeck_velocity': 0.07,
    'viscous_asymmetry': 0.04, 'stribeck_asymmetry': 0.06,
}  # fmt: skip


@pytest.mark.parametrize('name', FRICTION_LAWS)
def test_with_the_sign_itself_it_is_the_law(name):
    own = {key: VALUES[key] for key in FRICTION_LAWS[name].parameter_names}
    law = make_friction_law(name, own, 0.0)
    v = np.linspace(-1.0, 1.0, 101)
    friction = JointFriction([law, None])
    tau = friction.torque(np.column_stack([v, v]), np.sign(np.column_stack([v, v])))
    assert tau[:, 0] == pytest.approx(law.torque(v), abs=1e-14)
    assert not tau[:, 1].any()
