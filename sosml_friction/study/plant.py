# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The simulated exoskeleton of the paper's study: friction that is known, ideal control."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.model.laws import FrictionLaw, make_friction_law
from sosml_friction.model.robot import Robot
from sosml_friction.share import share_directory
from sosml_friction.simulation.plant import Plant
from sosml_friction.study.motion import Reference

JOINTS = ('shoulder', 'elbow')
#: Reflected inertia of the rotors [kg m2].
ARMATURE = (0.012, 0.004)
#: The friction of the plant, by joint [Nm, Nm s/rad, Nm, rad/s, Nm], and its smoothing velocity.
TRUTH = (
    {'coulomb': 0.80, 'viscous': 0.35, 'stribeck': 0.50, 'stribeck_velocity': 0.03, 'bias': 0.0},
    {'coulomb': 0.40, 'viscous': 0.20, 'stribeck': 0.25, 'stribeck_velocity': 0.03, 'bias': 0.0},
)
SMOOTHING_VELOCITY = 0.005
#: Sampling interval of control and observers, and step of the integration [s].
PERIOD, PLANT_STEP = 1e-3, 50e-6
#: Frequency [rad/s] and damping ratio of the controller's error dynamics.
_WN, _ZETA = 60.0, 1.0


@dataclass(frozen=True)
class StudyRun:
    """
    Hold exact signals at 1 kHz and the friction that acted.

    ``friction`` (N, 2) [Nm] is tau_f at each sample. The effort of a sample is the command that is
    held from it to the next.
    """

    log: JointLog
    friction: FloatArray


def study_urdf() -> str:
    """Return the URDF document of the study's arm, the shipped exoskeleton."""
    return (share_directory() / 'urdf' / 'exoskeleton.urdf').read_text(encoding='utf-8')


def study_robot() -> Robot:
    """Return the rigid body of the study."""
    return Robot(study_urdf(), JOINTS, ARMATURE)


def simulate(
    robot: Robot,
    reference: Callable[[float], Reference],
    duration: float,
    plant_step: float = PLANT_STEP,
    laws: Sequence[FrictionLaw] | None = None,
    disturbance: Callable[[float, FloatArray], FloatArray] | None = None,
) -> StudyRun:
    """
    Follow a reference from its own start, and return the exact signals.

    Computed torque with PD, tau = M (a_r + 2 zeta wn (v_r - v) + wn^2 (q_r - q)) + C v + g, on the
    true state, held over 1 ms. The controller knows no friction: the PD part makes up for it.

    :param plant_step: step of the integration [s], a whole fraction of 1 ms.
    :param laws: friction of the joints; :data:`TRUTH` if None.
    :param disturbance: torque of something else on the joints (n,) [Nm] at a time and position,
        held over 1 ms; it is counted in ``friction``, as an observer counts it.
    """
    start = reference(0.0)
    if laws is None:
        laws = [make_friction_law('stribeck', truth, SMOOTHING_VELOCITY) for truth in TRUTH]
    plant = Plant(robot, laws, start.q, start.v)
    substeps = round(PERIOD / plant_step)
    count = round(duration / PERIOD)
    q, v, tau, friction = (np.empty((count, robot.n)) for _ in range(4))
    for k in range(count):
        q[k], v[k] = plant.q, plant.v
        wanted = reference(k * PERIOD)
        a = wanted.a + 2.0 * _ZETA * _WN * (wanted.v - v[k]) + _WN**2 * (wanted.q - q[k])
        tau[k] = robot.inverse_dynamics(q[k], v[k], a)
        friction[k] = plant.friction_torque(v[k])
        push = np.zeros(robot.n) if disturbance is None else disturbance(k * PERIOD, q[k])
        friction[k] -= push
        for _ in range(substeps):
            plant.step(tau[k] + push, PERIOD / substeps)
    t_ns = np.arange(count, dtype=np.int64) * round(PERIOD * 1e9)
    return StudyRun(JointLog(robot.names, t_ns, q, v, tau), friction)
