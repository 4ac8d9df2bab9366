# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""An arm of seven joints with a gripper, as a robot comes: dressed, and in an order of its own."""

import numpy as np

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.model.robot import Robot

ARM = tuple(f'j{k}' for k in range(1, 8))
#: What joint_states names, in its order: shuffled, with both fingers.
REPORTED = ('j3', 'finger_b', 'j7', 'j1', 'finger_a', 'j6', 'j2', 'j5', 'j4')
COULOMB = np.array([4.0, 5.0, 3.0, 3.0, 1.5, 1.5, 1.0])
VISCOUS = np.array([8.0, 9.0, 5.0, 5.0, 2.0, 2.0, 1.0])
ROTOR = 0.1
PERIOD_S = 0.005

_GRIPPER = """
<link name="hand"><inertial><mass value="0.7"/><origin xyz="0 0 0.04"/>
  <inertia ixx="0.002" ixy="0" ixz="0" iyy="0.002" iyz="0" izz="0.001"/></inertial>
  <visual><geometry><mesh filename="package://nowhere/hand.dae"/></geometry></visual></link>
<joint name="hand_mount" type="fixed"><parent link="l7"/><child link="hand"/></joint>
<link name="a"><inertial><mass value="0.1"/><origin xyz="0 0 0.1"/>
  <inertia ixx="1e-5" ixy="0" ixz="0" iyy="1e-5" iyz="0" izz="1e-5"/></inertial></link>
<link name="b"><inertial><mass value="0.1"/><origin xyz="0 0 0.1"/>
  <inertia ixx="1e-5" ixy="0" ixz="0" iyy="1e-5" iyz="0" izz="1e-5"/></inertial></link>
<joint name="finger_a" type="prismatic"><parent link="hand"/><child link="a"/>
  <axis xyz="0 1 0"/><limit lower="0" upper="0.04" effort="20" velocity="0.2"/></joint>
<joint name="finger_b" type="prismatic"><parent link="hand"/><child link="b"/>
  <axis xyz="0 -1 0"/><limit lower="0" upper="0.04" effort="20" velocity="0.2"/>
  <mimic joint="finger_a"/></joint>
<transmission name="t"><joint name="j1"/></transmission>
<gazebo><plugin name="control" filename="libcontrol.so"/></gazebo>
</robot>"""


def gripper_arm_urdf(make_serial_arm) -> str:
    """Return the URDF; two joints are continuous, and their limits are above what they do."""
    kinds = ['continuous', *['revolute'] * 5, 'continuous']
    urdf = make_serial_arm(kinds, seed=4).replace('velocity="', 'velocity="5')
    return urdf.replace('effort="', 'effort="5').removesuffix('</robot>') + _GRIPPER


def gripper_arm_log(urdf: str, duration_s: float) -> JointLog:
    """Return a motion of all seven joints, fingers at rest, friction planted, a little noise."""
    t = np.arange(0.0, duration_s, PERIOD_S)
    rng = np.random.default_rng(6)
    q, v, a = np.zeros((3, len(t), 7))
    for k in range(7):
        for cycles in range(1, 7):
            w = 2.0 * np.pi * (cycles * 0.12 + 0.011 * k)
            size, phase = rng.uniform(0.2, 0.35) / cycles, rng.uniform(0.0, 6.28)
            q[:, k] += size * np.sin(w * t + phase)
            v[:, k] += size * w * np.cos(w * t + phase)
            a[:, k] -= size * w**2 * np.sin(w * t + phase)
    robot = Robot(urdf, ARM, [ROTOR] * 7)
    tau = np.array([robot.inverse_dynamics(*x) for x in zip(q, v, a, strict=True)])
    tau += COULOMB * np.tanh(v / 2e-3) + VISCOUS * v + rng.normal(0.0, 0.05, v.shape)
    # One that is continuous counts its turns.
    q[:, 6] += 8.0 * np.pi
    columns = [ARM.index(name) if name in ARM else -1 for name in REPORTED]

    def reported(x):
        return np.column_stack([x, np.zeros(len(t))])[:, columns]

    t_ns = 1_000_000_000 + np.rint(t * 1e9).astype(np.int64)
    return JointLog(REPORTED, t_ns, reported(q), reported(v), reported(tau))
