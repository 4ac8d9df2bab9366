# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
MuJoCo as a plant that hides effects: a judge that shares no code with the package's simulation.

An arm of two skew joints in a document of its own, steps of 1 ms, friction by MuJoCo's constraint
with levels that are written down here, native springs, ripple and gears. PD and feed-forward of
the nominal at 500 Hz. Every nominal parameter is off by a Gaussian of 2 %, those of a body largely
alike. What a user has is the document of the nominal, whose friction is a guess.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import mujoco
import numpy as np
from scipy.signal import lfilter

from sosml_friction.bags.joint_log import JointLog
from validation.motion import JOINTS, reference
from validation.trial import Truth

PERIOD, STEP = 2e-3, 1e-3
#: Noise of effort, white and coloured, and its quanta [Nm]; of position [rad], of speed [rad/s].
WHITE, COLOURED, LSB = np.array([0.08, 0.03]), np.array([0.02, 0.006]), np.array([0.02, 0.005])
POSITION_LSB, SPEED_NOISE, COLOUR_S = 2.0 * np.pi / 65536, 2e-3, 0.25
#: Band in which SNR is stated [Hz], as validation/snr.py's.
_BAND = 22.5
KP, KD = np.array([400.0, 120.0]), np.array([25.0, 6.0])
SOFT_KP, SOFT_KD = np.array([120.0, 40.0]), np.array([1.6, 1.0])
#: Standard deviation of a nominal parameter's error, and the share of its square that the numbers
#: of a body have in common: a body that is denser or larger is so in all of them.
NUISANCE, ALIKE = 0.02, 0.7

#: Ten effects of the table, then others that can be hidden; typical sizes, shoulder and elbow.
TEN = {
    'stribeck': (0.3, 0.1), 'asymmetric_friction': (0.1, 0.04),
    'load_dependent_friction': (0.06, 0.06), 'position_dependent_friction': (0.2, 0.06),
    'cogging': (0.12, 0.04), 'spring': (0.4, 0.15), 'payload': (0.25, 0.25),
    'inertia': (0.05, 0.015), 'effort_scale': (0.08, 0.08), 'effort_delay': (4e-3, 4e-3),
}  # fmt: skip
MORE = {
    'gravity': (0.1, 0.1), 'gravity_tilt': (0.06, 0.06), 'effort_bias': (0.15, 0.06),
    'joint_coupling': (0.08, 0.08), 'joint_elasticity': (1500.0, 500.0),
}  # fmt: skip
#: What no name of the catalogue is right for.
OUTSIDE = {
    'root_friction': (0.3, 0.1), 'quadratic_drag': (0.1, 0.03), 'saturating_spring': (0.3, 0.1),
    'beat': (0.15, 0.05), 'cross_friction': (0.2, 0.06), 'friction_step': (0.12, 0.05),
    'lagged_friction': (0.3, 0.1), 'cross_viscous': (0.1, 0.04),
}  # fmt: skip
#: Smallest share of a typical size, of a scale another: less is within what a nominal may be off
#: by, and no cause; as LEAST of validation/trial.py.
LEAST, LEAST_SCALE = 0.4, 0.5
GLOBAL = ('payload', 'effort_delay', 'gravity_tilt')


@dataclass
class Arm:
    """Hold the numbers of the arm; the defaults are the nominal ones."""

    mass: np.ndarray = field(default_factory=lambda: np.array([2.2, 1.3]))
    centre: np.ndarray = field(default_factory=lambda: np.array([0.14, 0.13]))
    #: Radii of gyration about the centre, along and across.
    gyration: np.ndarray = field(default_factory=lambda: np.array([[0.03, 0.09], [0.02, 0.08]]))
    armature: np.ndarray = field(default_factory=lambda: np.array([0.02, 0.006]))
    coulomb: np.ndarray = field(default_factory=lambda: np.array([0.7, 0.2]))
    viscous: np.ndarray = field(default_factory=lambda: np.array([0.3, 0.08]))
    #: The hidden effect: its name, joint, size, and what else was drawn.
    effect: str = ''
    joint: int = 0
    size: float = 0.0
    shape: tuple[float, float, float] = (0.5, 0.5, 0.5)

    def size_of(self, *names: str) -> float:
        """Return the size of the hidden effect if it is one of these, else 0."""
        return self.size if self.effect in names else 0.0

    def at(self, *names: str) -> np.ndarray:
        """Return the size in the joint that it is in, (2,)."""
        return np.eye(2)[self.joint] * self.size_of(*names)

    def xml(self, friction: tuple[np.ndarray, np.ndarray] | None = None) -> str:
        """Return the document; ``friction``: other levels and slopes than the arm's."""
        level, slope = friction or (self.coulomb, self.viscous)
        rotors = self.armature + np.maximum(self.at('inertia'), -0.8 * self.armature)
        moments = self.centre * (1.0 + self.at('gravity'))
        tilt = 0.35 + self.size_of('gravity_tilt')
        bodies = []
        for i in range(2):
            along, across = self.mass[i] * self.gyration[i] ** 2
            stiff, zero = self.at('spring')[i], 2.0 * self.shape[0] - 1.0
            soft = self.effect == 'joint_elasticity' and self.joint == i
            axis = ('0 1 0', '0.25 0.95 0.1')[i]
            joint = (
                f'<joint name="{JOINTS[i]}" axis="{axis}" armature="{rotors[i]}" '
                f'damping="{slope[i]}" frictionloss="{level[i]}" solreffriction="{2 * STEP} 1" '
                f'solimpfriction=".999 .9999 .001" stiffness="{stiff}" springref="{zero}"/>'
            )
            if soft:
                # The motor turns a hub of nearly nothing, which turns the body by a spring.
                damp = 2.0 * 0.05 * np.sqrt(self.size * 0.05)
                joint += (
                    '<inertial pos="0 0 0" mass="1e-3" diaginertia="1e-6 1e-6 1e-6"/>'
                    f'<body><joint axis="{axis}" stiffness="{self.size}" damping="{damp}"/>'
                )
            load = ''
            if i == 1 and self.size_of('payload'):
                load = (
                    f'<body pos="{0.18 + 0.12 * self.shape[0]} 0 0"><inertial pos="0 0 0" '
                    f'mass="{self.size}" diaginertia="1e-7 1e-7 1e-7"/></body>'
                )
            inertial = (
                f'<inertial pos="{moments[i]} 0.01 0" mass="{self.mass[i]}" '
                f'diaginertia="{along} {across} {across}"/>'
            )
            bodies.append((f'{joint}{inertial}{load}', '</body>' if soft else ''))
        ripple = ''
        if self.size_of('cogging'):
            ripple = (
                f'<actuator><dcmotor joint="{JOINTS[self.joint]}" input="none" motorconst="1e-9" '
                f'resistance="1" cogging="{self.size} {12 + 80 * self.shape[0]} '
                f'{6.28 * self.shape[1]}"/></actuator>'
            )
        (first, end_1), (second, end_2) = bodies
        return (
            f'<mujoco model="arm"><compiler angle="radian"/><option timestep="{STEP}" '
            f'gravity="0 {9.81 * np.sin(tilt)} {-9.81 * np.cos(tilt)}"/><worldbody>'
            f'<body name="upper" pos="0 0 1">{first}<body name="fore" pos="0.3 0 0">{second}'
            f'{end_2}</body>{end_1}</body></worldbody>{ripple}</mujoco>'
        )

    def levels(self, q: np.ndarray, v: np.ndarray, load: np.ndarray, t: float, end: float
               ) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
        """Return what opposes motion and what else acts on the joints (2,), damping left out."""
        i, (x, y, _), fast = self.joint, self.shape, np.abs(v)
        level, push = self.coulomb.copy(), np.zeros(2)
        match self.effect:
            case 'stribeck':
                level[i] += self.size * np.exp(-((fast[i] / (0.05 + 0.2 * x)) ** (0.8 + y)))
            case 'asymmetric_friction':
                push[i] -= self.size * fast[i]
            case 'load_dependent_friction':
                level[i] += self.size * abs(load[i])
            case 'position_dependent_friction':
                size = min(self.size, 0.8 * self.coulomb[i])
                level[i] += size * np.cos((1 if x < 0.5 else 2) * q[i] + 6.28 * y)
            case 'root_friction':
                level[i] += self.size * np.sqrt(fast[i])
            case 'quadratic_drag':
                push[i] -= self.size * v[i] * fast[i]
            case 'saturating_spring':
                push[i] -= self.size * np.tanh((q[i] - (-0.9, 0.9)[i] - 0.6 * x + 0.3) / 0.15)
            case 'beat':
                push[i] += self.size * np.sin(2.0 * np.pi * (0.3 + 7.0 * x) * t + 6.28 * y)
            case 'cross_friction':
                size = min(self.size, 0.8 * self.coulomb[i])
                level[i] += size * np.cos(q[1 - i] + 6.28 * x)
            case 'friction_step':
                level[i] += self.size * (t > (0.3 + 0.4 * x) * end)
            case 'cross_viscous':
                push[i] -= self.size * v[1 - i]
        return level, push


def make_arm(rng: np.random.Generator, size: float = NUISANCE) -> Arm:
    """Return an arm whose every nominal parameter is off, those of a body alike."""
    arm = Arm()
    for i in range(2):
        alike = np.sqrt(ALIKE) * rng.standard_normal()
        own = alike + np.sqrt(1.0 - ALIKE) * rng.standard_normal(4)
        arm.mass[i] *= 1.0 + size * own[0]
        arm.centre[i] *= 1.0 + size * own[1]
        # A moment of inertia goes by its square.
        arm.gyration[i] *= 1.0 + 0.5 * size * own[2:]
        arm.armature[i] *= 1.0 + size * rng.standard_normal()
    return arm


def hide(arm: Arm, effect: str, joint: int, scale: float, rng: np.random.Generator) -> Arm:
    """Return the arm with an effect of ``scale`` times its typical size; elasticity is divided."""
    typical = {**TEN, **MORE, **OUTSIDE}[effect][joint]
    sign = float(rng.choice([-1.0, 1.0]))
    shape = tuple(rng.uniform(size=3))
    if effect not in ('asymmetric_friction', 'effort_scale', 'effort_bias', 'gravity',
                      'gravity_tilt', 'joint_coupling', 'cross_viscous'):  # fmt: skip
        sign = 1.0
    size = sign * (typical / scale if effect == 'joint_elasticity' else typical * scale)
    return replace(arm, effect=effect, joint=joint, size=size, shape=shape)


def truth(arm: Arm) -> Truth:
    """Return what is to be named."""
    everywhere = arm.effect in GLOBAL
    joint = 0 if arm.effect == 'joint_coupling' else arm.joint
    return Truth(arm.effect, '*' if everywhere else JOINTS[joint], arm.size)


def simulate(arm: Arm, motion: tuple[np.ndarray, ...], rng: np.random.Generator,
             noise: float = 1.0) -> JointLog:  # fmt: skip
    """Return what is measured along a reference (N, 2) at 500 Hz."""
    q_r, v_r, a_r = motion
    m, nominal = (mujoco.MjModel.from_xml_string(x.xml()) for x in (arm, Arm()))
    d, ahead = mujoco.MjData(m), mujoco.MjData(nominal)
    dof = [m.joint(name).dofadr[0] for name in JOINTS]
    soft = arm.effect == 'joint_elasticity'
    kp, kd = (SOFT_KP, SOFT_KD) if soft else (KP, KD)
    d.qpos[dof] = q_r[0]
    count, end = len(q_r), len(q_r) * PERIOD
    q, v, u = np.empty((3, count, 2))
    late = np.zeros(2)
    rotors = m.dof_armature[dof]
    for k in range(count):
        q[k], v[k] = d.qpos[dof], d.qvel[dof]
        ahead.qpos[:], ahead.qvel[:], ahead.qacc[:] = q_r[k], v_r[k], a_r[k]
        nominal.dof_frictionloss[:] = 0.0
        mujoco.mj_inverse(nominal, ahead)
        command = ahead.qfrc_inverse + Arm().coulomb * np.tanh(v_r[k] / 0.02)
        command += kp * (q_r[k] - q[k]) + kd * (v_r[k] - v[k])
        u[k] = command
        for _ in range(round(PERIOD / STEP)):
            here, fast = d.qpos[dof], d.qvel[dof]
            # What the gear passes on: all but friction and the rotor, of the step before.
            given = d.qfrc_applied + d.qfrc_passive + d.qfrc_constraint
            load = given[dof] - rotors * d.qacc[dof]
            level, push = arm.levels(here, fast, load, d.time, end)
            if arm.effect == 'lagged_friction':
                # Friction that follows its velocity after 80 ms.
                late += STEP / 0.08 * (np.tanh(fast / 0.05) - late)
                push = push - arm.at('lagged_friction') * late
            m.dof_frictionloss[dof] = np.maximum(level, 1e-6)
            d.qfrc_applied[dof] = command + push
            mujoco.mj_step(m, d)
    t = np.arange(count) * PERIOD
    effort = 0.5 * (u + np.vstack([u[:1], u[:-1]]))
    effort = reported(arm, t, effort)
    white = WHITE * rng.standard_normal(effort.shape)
    a = np.exp(-PERIOD / COLOUR_S)
    drive = rng.standard_normal(effort.shape) * np.sqrt(1.0 - a * a)
    effort = effort + noise * (white + COLOURED * lfilter([1.0], [1.0, -a], drive, axis=0))
    return JointLog(
        JOINTS,
        np.rint(t * 1e9).astype(np.int64),
        POSITION_LSB * np.round(q / POSITION_LSB),
        v + SPEED_NOISE * rng.standard_normal(v.shape),
        LSB * np.round(effort / LSB),
    )


def reported(arm: Arm, t: np.ndarray, effort: np.ndarray) -> np.ndarray:
    """Return what the actuators say of efforts (N, 2)."""
    if arm.effect == 'effort_delay':
        effort = np.column_stack([np.interp(t - arm.size, t, x) for x in effort.T])
    effort = effort.copy()
    effort[:, 0] += arm.size_of('joint_coupling') * effort[:, 1]
    return effort * (1.0 + arm.at('effort_scale')) + arm.at('effort_bias')


def signal_to_noise(
    arm: Arm, plain: Arm, name: str, noise: float = 1.0, beside_friction: bool = False
) -> np.ndarray:
    """
    Return rms of what the effect adds to the effort over that of noise, by joint (2,).

    :param beside_friction: count only what a joint's own Coulomb and viscous friction and bias,
        which a diagnosis of a simulator refits, cannot take.
    """
    motion = [x[::25] for x in reference(name)]
    t = np.arange(len(motion[0])) * 25 * PERIOD
    added = reported(arm, t, _needed(arm, motion, t)) - _needed(plain, motion, t)
    if beside_friction:
        for i, v in enumerate(motion[1].T):
            X = np.column_stack([np.tanh(v / 0.005), v, np.ones_like(v)])
            added[:, i] -= X @ np.linalg.lstsq(X, added[:, i], rcond=None)[0]
    in_band = np.hypot(WHITE * np.sqrt(_BAND * 2.0 * PERIOD), COLOURED)
    return np.sqrt(np.mean(added**2, axis=0)) / (noise * in_band)


def _needed(arm: Arm, motion: list[np.ndarray], t: np.ndarray) -> np.ndarray:
    """Return the effort (N, 2) of a motion, by inverse dynamics and the laws; rigid gears."""
    rigid = replace(arm, effect='') if arm.effect == 'joint_elasticity' else arm
    m = mujoco.MjModel.from_xml_string(rigid.xml())
    m.dof_frictionloss[:] = 0.0
    d = mujoco.MjData(m)
    result = np.empty_like(motion[0])
    late = np.zeros(2)
    for k, (q, v, a) in enumerate(zip(*motion, strict=True)):
        d.qpos[:], d.qvel[:], d.qacc[:] = q, v, a
        mujoco.mj_fwdPosition(m, d)
        mujoco.mj_fwdVelocity(m, d)
        mujoco.mj_fwdActuation(m, d)
        mujoco.mj_inverse(m, d)
        load = d.qfrc_inverse - m.dof_armature * a
        level, push = rigid.levels(q, v, load, float(t[k]), float(t[-1]))
        late += min(1.0, (t[1] - t[0]) / 0.08) * (np.tanh(v / 0.05) - late)
        push = push - arm.at('lagged_friction') * late
        result[k] = d.qfrc_inverse - d.qfrc_actuator + level * np.tanh(v / 0.005) - push
    return result


def scale_for(effect: str, joint: int, wanted: float, seed: int, noise: float = 1.0) -> float:
    """Return the share of the typical size that makes an SNR on the rich motion, or the least."""
    scale, least = 1.0, LEAST_SCALE if effect == 'effort_scale' else LEAST
    if effect == 'joint_elasticity':
        return float(np.clip(wanted, 0.5, 2.0))
    for _ in range(4):
        arm = hide(Arm(), effect, joint, scale, np.random.default_rng(seed))
        both = signal_to_noise(arm, Arm(), 'rich', noise)
        found = float(both.max() if effect in GLOBAL else both[truth_joint(arm)])
        scale = float(np.clip(scale * wanted / max(found, 1e-6), least, 6.0))
    return scale


def truth_joint(arm: Arm) -> int:
    """Return the joint whose effort shows the effect."""
    return 0 if arm.effect == 'joint_coupling' else arm.joint
