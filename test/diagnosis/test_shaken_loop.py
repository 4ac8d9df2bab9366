# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A slide that something shakes at one frequency while it sweeps slowly."""

from __future__ import annotations

import numpy as np
import pytest
from full_runs import in_full

import sosml_friction as sf
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.model.model_folder import FrictionParameters, JointModel, RobotModelFile
from sosml_friction.model.parameter import Parameter

MASS, COULOMB, VISCOUS, STEP, NOISE = 12.0, 15.0, 90.0, 2e-3, 1.0
URDF = (
    '<robot name="axis"><link name="bed"/><joint name="slide" type="prismatic">'
    '<parent link="bed"/><child link="carriage"/><axis xyz="1 0 0"/>'
    '<limit lower="-1" upper="1" effort="900" velocity="2"/></joint>'
    f'<link name="carriage"><inertial><mass value="{MASS}"/>'
    '<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>'
    '</robot>'
)


def shaken(hertz: float, size: float, seed: int) -> JointLog:
    """Return 50 s under a PD controller that follows a slow sweep, shaken by ``size`` [N]."""
    rng = np.random.default_rng(seed)
    parts, h = 4, STEP / 4.0
    t = h * np.arange(round(50.0 / h))
    wanted = 0.25 * np.sin(2.0 * np.pi * 0.05 * t)
    speed = 0.25 * 2.0 * np.pi * 0.05 * np.cos(2.0 * np.pi * 0.05 * t)
    force = size * np.sin(2.0 * np.pi * hertz * t)
    x, v, seen, effort = 0.0, float(speed[0]), [], []
    for r, u, more in zip(wanted.tolist(), speed.tolist(), force.tolist(), strict=True):
        drive = 2e4 * (r - x) + 700.0 * (u - v)
        seen.append(x)
        effort.append(drive)
        v += h / MASS * (drive + more - COULOMB * np.tanh(v / 1e-3) - VISCOUS * v)
        x += h * v
    tau = np.array(effort)[::parts]
    tau += NOISE * rng.standard_normal(len(tau))
    q = np.array(seen)[::parts] + 1e-6 * rng.standard_normal(len(tau))
    t_ns = np.rint(1e9 * t[::parts]).astype(np.int64)
    nothing = np.full((len(tau), 1), np.nan)
    return JointLog(('slide',), t_ns, q[:, None], nothing, tau[:, None])


@pytest.fixture(scope='module')
def model() -> sf.Model:
    known = {
        'coulomb': Parameter(COULOMB, 'N'),
        'viscous': Parameter(VISCOUS, 'N s/m'),
        'bias': Parameter(0.0, 'N'),
    }
    friction = FrictionParameters('coulomb_viscous', 1e-3, known)
    return sf.Model(
        RobotModelFile('axis', {'slide': JointModel(Parameter(0.0, 'kg'), friction)}, URDF)
    )


@pytest.mark.parametrize('hertz', [in_full(7.0), 9.0])
def test_a_hum_that_moves_the_loop_is_told_and_called_no_cause(model, hertz):
    """The slide moves at the hum: inertia and delay together are the same line."""
    found = sf.diagnose(shaken(hertz, 12.0, 5), model)
    assert found.verdict == 'unknown_structure'
    assert found.causes == ()
    assert f'tone of {hertz:g} Hz' in found.summary()
