# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
An arm of seven joints, recorded: bodies by MuJoCo's inverse dynamics, friction in closed form.

Nothing is controlled: the motion is given, and effort is what it needs. A sum of sines, slow where
it turns around, or moves from place to place with rests between them. The sign of friction is
tanh(v / v0), as simulators have it, and at rest it is 0. Each body, rotor and friction is off from
the nominal by a Gaussian of 1 %, cut off at 3 %: all are within the tolerance.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import mujoco
import numpy as np

from sosml_friction.bags.joint_log import JointLog

NAMES = tuple(f'j{k + 1}' for k in range(7))
#: Axis and place of each joint [m], about as of the arms that are sold; mass [kg], centre [m] and
#: moment of inertia [kg m2] of what it moves, rotor at the joint [kg m2], largest effort [Nm].
_AXES = ('0 0 1', '0 1 0', '0 0 1', '0 -1 0', '0 0 1', '0 -1 0', '0 0 1')
_PLACES = ('0 0 .33', '0 0 0', '0 0 .32', '.08 0 0', '-.08 0 .38', '0 0 0', '.088 0 0')
MASS = np.array([4.9, 4.5, 3.4, 3.2, 3.0, 1.7, 0.9])
CENTRE = np.array(
    [
        [0.004, 0.01, -0.05],
        [0.01, -0.03, 0.03],
        [0.03, 0.04, -0.05],
        [-0.05, 0.08, 0.03],
        [-0.01, 0.04, -0.1],
        [0.06, -0.01, -0.01],
        [0.01, 0.005, 0.07],
    ]
)
MOMENT = np.array([0.03, 0.03, 0.025, 0.025, 0.02, 0.008, 0.004])
ROTOR = np.array([0.6, 0.6, 0.5, 0.5, 0.25, 0.2, 0.15])
EFFORT = np.array([87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0])
#: Coulomb [Nm] and viscous [Nm s/rad] friction.
COULOMB = np.array([1.0, 1.33, 0.67, 0.67, 0.17, 0.1, 0.06])
VISCOUS = np.array([4.0, 4.0, 3.0, 3.0, 1.0, 0.8, 0.5])
#: White noise of effort as a share of the largest, and the angle of one count of a position [rad].
NOISE, COUNT = 1e-3, 2.0 * np.pi / 2**19
#: Widths v0 of the sign of friction [rad/s], and rates [Hz], of which one is drawn.
WIDTHS, RATES = (0.001, 0.002, 0.004), (250.0, 500.0)
#: A payload is a point somewhere about the flange, in the last link's frame [m].
_NEAREST, _FARTHEST = np.array([-0.08, -0.08, 0.05]), np.array([0.08, 0.08, 0.25])
#: Derivatives of the motion are taken at so many times the rate.
_OVER = 8
#: Size of each effect [least, most]: shares of Coulomb friction, or as said.
CATALOGUE: dict[str, tuple[float, float]] = {
    'stribeck': (0.4, 0.9),
    'load_dependent_friction': (0.06, 0.12),  # share of the load
    'position_dependent_friction': (0.2, 0.4),
    'asymmetric_friction': (0.15, 0.3),  # share of viscous friction
    'cogging': (0.15, 0.3),
    'spring': (0.5, 1.5),  # Coulomb friction per rad
    'payload': (0.3, 0.8),  # kg
    'inertia': (0.4, 0.6),  # share of the rotor
    'effort_scale': (0.08, 0.12),  # share of effort
    'effort_delay': (0.003, 0.006),  # s
}
OUTSIDE: dict[str, tuple[float, float]] = {
    'quadratic_drag': (1.0, 2.0),  # viscous friction at 1 rad/s
    'hum': (0.2, 0.4),
}
#: Effects of the robot as a whole.
OF_ROBOT = ('payload', 'effort_delay')


@dataclass(frozen=True)
class Arm:
    """Hold the numbers of an arm, as the module's, and a point mass on its last link."""

    mass: np.ndarray
    centre: np.ndarray
    moment: np.ndarray
    rotor: np.ndarray
    coulomb: np.ndarray
    viscous: np.ndarray
    payload: float = 0.0
    place: tuple[float, ...] = (0.0, 0.0, 0.0)

    @classmethod
    def nominal(cls) -> Arm:
        """Return the arm that the diagnosis is told."""
        return cls(MASS, CENTRE, MOMENT, ROTOR, COULOMB, VISCOUS)

    def off(self, rng: np.random.Generator) -> Arm:
        """Return one whose numbers are all off."""
        parts = (self.mass, self.centre, self.moment, self.rotor, self.coulomb, self.viscous)
        drawn = (np.clip(0.01 * rng.standard_normal(x.shape), -0.03, 0.03) for x in parts)
        return Arm(*(x * (1.0 + own) for x, own in zip(parts, drawn, strict=True)))

    def urdf(self) -> str:
        """Return its bodies and joints."""
        parts = ['<robot name="seven"><link name="base"/>']
        for k, name in enumerate(NAMES):
            centre = ' '.join(f'{x:.17g}' for x in self.centre[k])
            whole, flat = self.moment[k], 0.8 * self.moment[k]
            parent = f'l{k - 1}' if k else 'base'
            parts.append(
                f'<link name="l{k}"><inertial><origin xyz="{centre}"/>'
                f'<mass value="{self.mass[k]:.17g}"/><inertia ixx="{whole:.17g}" '
                f'iyy="{whole:.17g}" izz="{flat:.17g}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
                f'<joint name="{name}" type="revolute"><parent link="{parent}"/>'
                f'<child link="l{k}"/><origin xyz="{_PLACES[k]}"/><axis xyz="{_AXES[k]}"/>'
                f'<limit lower="-2.9" upper="2.9" effort="{EFFORT[k]}" velocity="2.5"/></joint>'
            )
        if self.payload:
            place = ' '.join(f'{x:.17g}' for x in self.place)
            parts.append(
                f'<link name="payload"><inertial><origin xyz="{place}"/>'
                f'<mass value="{self.payload:.17g}"/><inertia ixx="1e-9" iyy="1e-9" izz="1e-9" '
                f'ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="flange" type="fixed">'
                f'<parent link="l6"/><child link="payload"/></joint>'
            )
        return ''.join([*parts, '</robot>'])

    def effort(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Return the effort of bodies and rotors (N, 7) [Nm], by MuJoCo."""
        model = mujoco.MjModel.from_xml_string(self.urdf())
        model.dof_armature[:] = self.rotor
        # Limits and contacts are none of the motion's.
        model.opt.disableflags = mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        data, result = mujoco.MjData(model), np.empty_like(q)
        for k in range(len(q)):
            data.qpos[:], data.qvel[:], data.qacc[:] = q[k], v[k], a[k]
            mujoco.mj_inverse(model, data)
            result[k] = data.qfrc_inverse
        return result


def place_of(payload: float) -> tuple[float, ...]:
    """Return where a payload is, by numbers of its own: the rest is drawn as without it."""
    own = np.random.default_rng(round(1e6 * payload))
    return tuple(own.uniform(_NEAREST, _FARTHEST).tolist())


def sines(rng: np.random.Generator, t: np.ndarray) -> np.ndarray:
    """Return positions (N, 7) that are sums of five sines each."""
    q = np.zeros((len(t), 7))
    for column in q.T:
        base = rng.uniform(0.05, 0.08)
        for k in range(1, 6):
            size, phase = rng.uniform(0.1, 0.45) / k, rng.uniform(0.0, 2.0 * np.pi)
            column += size * np.sin(2.0 * np.pi * base * k * t + phase)
    return q


def places(rng: np.random.Generator, t: np.ndarray) -> np.ndarray:
    """Return positions (N, 7) that move from place to place with the least jerk, and rest."""
    q, at, now = np.empty((len(t), 7)), 0, np.zeros(7)
    step = t[1] - t[0]
    while at < len(t):
        length, rest = rng.uniform(1.0, 2.5), rng.uniform(0.1, 0.4)
        reach = 0.68 * length  # 1.3 rad/s at the most
        there = np.clip(rng.uniform(-1.0, 1.0, 7), now - reach, now + reach)
        s = np.linspace(0.0, 1.0, round(length / step))[:, None]
        way = now + (there - now) * (10.0 * s**3 - 15.0 * s**4 + 6.0 * s**5)
        way = np.vstack([way, np.repeat(there[None], round(rest / step), axis=0)])[: len(t) - at]
        q[at : at + len(way)], at, now = way, at + len(way), there
    return q


MOTIONS = {'sines': sines, 'places': places}


def recording(
    rng: np.random.Generator, motion: str, length_s: float, effect: str = ''
) -> tuple[JointLog, int, float]:
    """Return a recording of an arm that is off, the joint of the effect in it, and its size."""
    arm, rate, width = Arm.nominal().off(rng), rng.choice(RATES), rng.choice(WIDTHS)
    # The same is drawn with an effect as without one.
    i, share, way = int(rng.integers(7)), rng.uniform(), rng.choice([-1.0, 1.0])
    low, high = {**CATALOGUE, **OUTSIDE}.get(effect, (0.0, 0.0))
    size = float(low + share * (high - low))
    fine = 1.0 / (rate * _OVER)
    t = np.arange(0.0, length_s, fine)
    q = MOTIONS[motion](rng, t)
    v = np.gradient(q, fine, axis=0)
    a = np.gradient(v, fine, axis=0)
    t, q, v, a = (x[::_OVER] for x in (t, q, v, a))
    if effect == 'payload':
        arm = replace(arm, payload=size, place=place_of(size))
    if effect == 'inertia':
        arm.rotor[i] *= 1.0 + size * way
    load = arm.effort(q, v, a)
    sign = np.tanh(v / width)
    tau = load + arm.coulomb * sign + arm.viscous * v
    C, s, speed, phase = arm.coulomb[i], sign[:, i], np.abs(v[:, i]), rng.uniform(0.0, 2.0 * np.pi)
    tau[:, i] += {
        'stribeck': size * C * s * np.exp(-speed / 0.06),
        'load_dependent_friction': size * np.abs(load[:, i] - arm.rotor[i] * a[:, i]) * s,
        'position_dependent_friction': size * C * s * np.sin(q[:, i] + phase),
        # That of Coulomb friction is a bias in motion, and no bias is known.
        'asymmetric_friction': size * arm.viscous[i] * speed,
        'cogging': size * C * np.sin(rng.integers(20, 80) * q[:, i] + phase),
        'spring': size * C * (q[:, i] - 0.2),
        'effort_scale': size * tau[:, i],
        'quadratic_drag': size * arm.viscous[i] * speed * v[:, i],
        'hum': size * C * np.sin(2.0 * np.pi * rng.uniform(3.0, 8.0) * t),
    }.get(effect, 0.0)
    if effect == 'effort_delay':
        tau = np.column_stack([np.interp(t - size, t, own) for own in tau.T])
    tau = tau + NOISE * EFFORT * rng.standard_normal(tau.shape)
    q = COUNT * np.round(q / COUNT)
    stamps = np.rint(1e9 * t).astype(np.int64)
    return JointLog(NAMES, stamps, q, np.full_like(q, np.nan), tau), i, size
