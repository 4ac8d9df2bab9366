# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The base of an arm in one plane is tilted: one of the two rotations is felt by no joint."""

from __future__ import annotations

import numpy as np
import pytest
from full_runs import in_full

import sosml_friction as sf
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.model.model_folder import FrictionParameters, JointModel, RobotModelFile
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.robot import Robot

STEP, NOISE, TILT, COULOMB, VISCOUS, ROTOR = 5e-3, 0.05, 0.05, 0.8, 0.5, 0.1
NAMES = ('shoulder', 'elbow')


def arm(rpy: str) -> str:
    """Return the URDF of two bodies that turn about y; frames of joints are turned by ``rpy``."""
    axis = '0 0 1' if rpy != '0 0 0' else '0 1 0'
    text, parent = '<robot name="planar"><link name="base"/>', 'base'
    for name, place, turn in (('shoulder', '0 0 0.5', rpy), ('elbow', '0.4 0 0', '0 0 0')):
        text += (
            f'<joint name="{name}" type="revolute"><parent link="{parent}"/>'
            f'<child link="{name}_l"/>'
            f'<origin xyz="{place}" rpy="{turn}"/><axis xyz="{axis}"/>'
            '<limit lower="-6" upper="6" effort="90" velocity="5"/></joint>'
            f'<link name="{name}_l"><inertial><origin xyz="0.2 0 0"/><mass value="3"/>'
            '<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>'
        )
        parent = f'{name}_l'
    return text + '</robot>'


def log(urdf: str, bodies: float, seed: int) -> JointLog:
    """Return 40 s with gravity turned about y by TILT and bodies that are off by a factor."""
    rng = np.random.default_rng(seed)
    robot = Robot(urdf, NAMES, [ROTOR, ROTOR])
    g = robot.gravity_acceleration
    turned = g * np.cos(TILT) + np.cross([0.0, 1.0, 0.0], g) * np.sin(TILT)
    plant = robot.changed(bodies * robot.inertial_parameters(), np.full(2, ROTOR), turned)
    t = STEP * np.arange(round(40.0 / STEP))
    q, v, a = np.zeros((3, len(t), 2))
    for i in range(2):
        for hertz in (0.11 + 0.02 * i, 0.27, 0.43, 0.71, 1.1):
            w, phase, size = 2.0 * np.pi * hertz, rng.uniform(0.0, 6.28), 0.15 / hertz**0.7
            q[:, i] += size * np.sin(w * t + phase)
            v[:, i] += size * w * np.cos(w * t + phase)
            a[:, i] -= size * w**2 * np.sin(w * t + phase)
    tau = np.array([plant.inverse_dynamics(*x) for x in zip(q, v, a, strict=True)])
    tau += COULOMB * np.tanh(v / 5e-3) + VISCOUS * v + NOISE * rng.standard_normal(v.shape)
    return JointLog(NAMES, np.rint(1e9 * t).astype(np.int64), q, np.full_like(q, np.nan), tau)


@pytest.mark.parametrize(
    'rpy',
    [
        in_full('0 0 0'),
        in_full('-1.5708 0 0'),
        '-1.571 0 0',
    ],
)
def test_the_tilt_that_is_felt_is_named_however_the_angles_of_the_urdf_are_rounded(rpy):
    """Bodies are 2 % heavier than stated: what the tilt is taken from is as unsure."""
    urdf = arm(rpy)
    known = {
        'coulomb': Parameter(COULOMB, 'Nm'),
        'viscous': Parameter(VISCOUS, 'Nm s/rad'),
        'bias': Parameter(0.0, 'Nm'),
    }
    joint = JointModel(
        Parameter(ROTOR, 'kg m2'), FrictionParameters('coulomb_viscous', 0.0, known)
    )
    model = sf.Model(RobotModelFile('planar', dict.fromkeys(NAMES, joint), urdf))
    (cause,) = sf.diagnose(log(arm('0 0 0'), 1.02, 3), model).causes
    assert cause.effect == 'gravity_tilt'
    assert cause.parameters['rotation_x'].value == 0.0
    felt = cause.parameters['rotation_y']
    # 3.5 %, anywhere within it alike, is a standard deviation of 2 %.
    assert felt.std_error > 0.035 / np.sqrt(3.0) * TILT
    assert abs(abs(felt.value) - TILT) < 2.0 * felt.std_error
