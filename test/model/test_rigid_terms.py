# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The compiled terms of the momentum against Pinocchio's, on every shape of arm."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.model.model_folder import read_model
from sosml_friction.model.robot import Robot
from sosml_friction.share import share_directory
from sosml_friction.study.mismatched_robot import MismatchedRobot


def tree(parents, kinds, seed=0, mimic=''):
    """Return a URDF of skew axes and bodies with products of inertia; link 0 is the base."""
    rng = np.random.default_rng(seed)
    text = '<robot name="tree"><link name="l0"/>'
    for k, (parent, kind) in enumerate(zip(parents, kinds, strict=True), start=1):
        axis, turn, way, centre = rng.normal(size=(4, 3))
        root = rng.normal(size=(3, 3))
        # Principal moments that a body can have: of a sum of squares, its trace less itself.
        spread = 0.01 * root @ root.T
        inertia = np.trace(spread) * np.eye(3) - spread
        follows = mimic if k == len(parents) else ''
        x, r, a, c = (
            ' '.join(map(repr, u.tolist())) for u in (0.3 * way, turn, axis, 0.1 * centre)
        )
        moments = (
            ' '.join(
                f'i{"xyz"[i]}{"xyz"[j]}="{inertia[i, j]!r}"' for i in range(3) for j in range(i, 3)
            )
            .replace('np.float64(', '')
            .replace(')', '')
        )
        text += (
            f'<link name="l{k}"><inertial><origin xyz="{c}" rpy="{r}"/>'
            f'<mass value="{rng.uniform(0.5, 3.0)}"/><inertia {moments}/></inertial></link>'
            f'<joint name="j{k}" type="{kind}"><parent link="l{parent}"/><child link="l{k}"/>'
            f'<origin xyz="{x}" rpy="{r}"/><axis xyz="{a}"/>{follows}'
            '<limit lower="-3" upper="3" effort="9" velocity="9"/></joint>'
        )
    return text + '</robot>'


SKEW = tree(range(7), ['revolute'] * 7)
BRANCHED = tree(
    [0, 1, 1, 3, 0, 2],
    ['revolute', 'prismatic', 'continuous', 'revolute', 'prismatic', 'revolute'],
)
LED = tree(
    [0, 1, 2, 2],
    ['revolute', 'prismatic', 'revolute', 'prismatic'],
    mimic='<mimic joint="j1" multiplier="-0.4" offset="0.2"/>',
)
ARMS = {
    'exoskeleton': lambda: read_model(share_directory() / 'config/exoskeleton').make_robot(),
    'skew': lambda: Robot(SKEW, [f'j{k}' for k in range(1, 8)], np.linspace(0.0, 0.3, 7)),
    'turned round': lambda: Robot(SKEW, [f'j{k}' for k in (4, 1, 7, 2, 6, 3, 5)], [0.1] * 7),
    'branched': lambda: Robot(BRANCHED, [f'j{k}' for k in range(1, 7)], [0.05] * 6),
    'locked': lambda: Robot(BRANCHED, ['j6', 'j1', 'j4'], [0.05] * 3, {'j3': 0.7, 'j2': -0.2}),
    'prismatic': lambda: Robot(tree([0], ['prismatic']), ['j1'], [0.4]),
    'led': lambda: Robot(LED, ['j3', 'j1', 'j2'], [0.05, 0.1, 0.2]),
    'changed': lambda: changed(Robot(SKEW, [f'j{k}' for k in range(1, 8)], [0.1] * 7)),
    'mistaken': lambda: MismatchedRobot(SKEW, [f'j{k}' for k in range(1, 8)], [0.1] * 7, 1.1, d),
}
d = np.linspace(-0.2, 0.3, 7)


def changed(robot):
    robot.momentum_terms(np.zeros(7), np.zeros(7))
    bodies = 1.3 * robot.inertial_parameters()
    # A body of no mass is possible: its centre is nowhere.
    bodies[3] = 0.0
    return robot.changed(bodies, np.full(7, 0.2), np.array([1.0, -2.0, -9.0]))


@pytest.mark.parametrize('arm', list(ARMS))
def test_the_compiled_terms_are_those_of_pinocchio_to_1e_12(arm):
    robot = ARMS[arm]()
    rng = np.random.default_rng(1)
    for q, v in zip(
        rng.uniform(-3.0, 3.0, (50, robot.n)), rng.normal(size=(50, robot.n)), strict=True
    ):
        p, drift, M = robot.momentum_terms(q, v)
        C, g = robot.coriolis(q, v), robot.gravity(q)
        truth = robot.inertia(q)
        for ours, theirs in ((M, truth), (p, truth @ v), (drift, C.T @ v - g)):
            np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12 * np.abs(theirs).max())
        np.testing.assert_array_equal(M, M.T)


@pytest.mark.parametrize('arm', list(ARMS))
def test_the_compiled_statics_are_those_of_pinocchio_to_1e_12(arm):
    robot = ARMS[arm]()
    q = np.random.default_rng(3).uniform(-3.0, 3.0, (50, robot.n))
    M, g = robot.statics(q)
    theirs = np.array([robot.inertia(x) for x in q]), np.array([robot.gravity(x) for x in q])
    for ours, their in zip((M, g), theirs, strict=True):
        np.testing.assert_allclose(ours, their, rtol=0, atol=1e-12 * np.abs(their).max())


@pytest.mark.parametrize('arm', sorted({*ARMS} - {'mistaken'}))
def test_gravity_that_points_elsewhere_is_that_of_pinocchio_to_1e_12(arm):
    robot, down = ARMS[arm](), np.array([3.0, -1.0, 2.0])
    q = np.random.default_rng(4).uniform(-3.0, 3.0, (50, robot.n))
    theirs = np.array([robot.gravity_under(x, down) for x in q])
    ours = robot.statics(q, down)[1]
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12 * max(np.abs(theirs).max(), 1.0))


@pytest.mark.parametrize('arm', sorted({*ARMS} - {'mistaken'}))
def test_the_compiled_regressor_is_that_of_pinocchio_to_1e_12(arm):
    robot = ARMS[arm]()
    rng = np.random.default_rng(2)
    q = rng.uniform(-3.0, 3.0, (50, robot.n))
    v, a = rng.normal(size=(2, 50, robot.n))
    theirs = np.array([robot.torque_regressor(*x) for x in zip(q, v, a, strict=True)])
    ours = robot.torque_regressors(q, v, a)
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12 * np.abs(theirs).max())


def test_a_base_far_from_the_origin_loses_no_more_than_its_square():
    """The terms are summed about the base's origin: 10 m of it cost two digits of fourteen."""
    near = tree([0, 1], ['revolute'] * 2)
    plain = Robot(near, ['j1', 'j2'], [0.1, 0.1])
    moved = Robot(
        near.replace('<link name="l0"/>', '<link name="world"/><link name="l0"/>').replace(
            '</robot>',
            '<joint name="stand" type="fixed"><parent link="world"/><child link="l0"/>'
            '<origin xyz="10 -5 3"/></joint></robot>',
        ),
        ['j1', 'j2'],
        [0.1, 0.1],
    )
    q, v = np.array([0.3, -1.0]), np.array([2.0, -1.5])
    for ours, theirs in zip(moved.momentum_terms(q, v), plain.momentum_terms(q, v), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-11 * np.abs(theirs).max())
