# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
A plant that shares nothing with the diagnosis: what the blind tests hide their effects in.

Two-joint arm in closed form (not Pinocchio), semi-implicit steps of 0.2 ms, friction by four
Maxwell-slip elements (not Dahl's state), optional two-mass joints with a gap, everything in
another parameterisation than the candidates. PD and feed-forward at 500 Hz, 16-bit position,
velocity with 2 mrad/s of noise, effort with white and coloured noise and 20 / 5 mNm of resolution.
Damping of a mesh is 5 % of critical for a body of 0.05 kg m2.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.signal import lfilter

from sosml_friction.compiled import compiled

PERIOD, SUBSTEPS = 2e-3, 10
#: First moments and inertias about the joint of each body, length of the upper arm, gravity.
M1, M2, L1 = 2.5, 1.8, 0.30
C1, C2 = M1 * 0.15, M2 * 0.135
I1, I2 = 0.01875 + M1 * 0.15**2, 0.010935 + M2 * 0.135**2
GRAVITY = 9.81 * np.cos(np.radians(20.0))
ARMATURE = np.array([0.0054, 0.004])
COULOMB, VISCOUS = np.array([0.8, 0.15]), np.array([0.35, 0.06])
SLIP = 0.3e-3
WHITE, COLOURED, LSB = np.array([0.10, 0.03]), np.array([0.025, 0.006]), np.array([0.02, 0.005])
POSITION_LSB = 2.0 * np.pi / 65536
SPEED_NOISE = 2e-3

#: Order of the numbers in the parameter vector of the compiled plant, two of each.
FIELDS = (
    'coulomb', 'viscous', 'stribeck', 'stribeck_velocity', 'stribeck_exponent',
    'asymmetry', 'asymmetry_viscous', 'load', 'position', 'position_phase', 'position_cycles',
    'cogging', 'cogging_phase', 'cogging_cycles', 'slip', 'warm_viscous', 'warm_coulomb',
    'warm_time', 'spring', 'spring_zero', 'armature', 'stiffness', 'gap', 'power', 'power_gain',
    'quadratic', 'wire', 'wire_zero', 'wire_width', 'cross', 'cross_phase', 'hose', 'hose_slip',
)  # fmt: skip


@dataclass
class Plant:
    """Hold the plant's numbers; the defaults are the nominal model's."""

    joint: dict[str, np.ndarray] = field(default_factory=dict)
    first: float = C1
    second: float = C2
    inertia: tuple[float, float] = (I1, I2)
    mass_2: float = M2
    tilt: float = 0.0
    payload: float = 0.0
    payload_distance: float = 0.27
    scale: np.ndarray = field(default_factory=lambda: np.ones(2))
    bias: np.ndarray = field(default_factory=lambda: np.zeros(2))
    #: Torque that no current exceeds: the measured effort is e artanh(torque / e).
    saturation: np.ndarray = field(default_factory=lambda: np.full(2, np.inf))
    coupling: float = 0.0
    delay: float = 0.0
    eccentricity: np.ndarray = field(default_factory=lambda: np.zeros(2))
    eccentricity_phase: np.ndarray = field(default_factory=lambda: np.zeros(2))
    contacts: list[tuple[int, float, float, float]] = field(default_factory=list)
    #: Torques on the body in time: joint, size [Nm], frequency [Hz], phase.
    beats: list[tuple[int, float, float, float]] = field(default_factory=list)
    two_mass: bool = False
    #: The gains that a two-mass joint needs; a rigid plant can have them too, to compare.
    soft: bool = False

    def __post_init__(self) -> None:
        start = {
            'coulomb': COULOMB, 'viscous': VISCOUS, 'stribeck_velocity': 0.1,
            'stribeck_exponent': 1.0, 'slip': SLIP, 'warm_time': 60.0, 'armature': ARMATURE,
            'stiffness': 3e4, 'position_cycles': 1.0, 'cogging_cycles': 20.0, 'power': 0.5,
            'wire_width': 1.0, 'hose_slip': 1.0,
        }  # fmt: skip
        for name in FIELDS:
            value = np.broadcast_to(np.asarray(start.get(name, 0.0), dtype=float), (2,)).copy()
            self.joint.setdefault(name, value)

    def body(self) -> np.ndarray:
        """Return first moments, inertias and the mass of the second body, with the payload."""
        m, d = self.payload, self.payload_distance
        i1, i2 = self.inertia
        return np.array([self.first, self.second + m * d, i1, i2 + m * d**2, self.mass_2 + m])


@dataclass(frozen=True)
class Noise:
    """
    Say what measuring adds: nothing, not even quanta, where ``exact``.

    ``white`` and ``coloured`` are factors on the usual sizes, ``time`` [s] the colour's.
    """

    white: float = 1.0
    coloured: float = 1.0
    time: float = 0.25
    exact: bool = False


@dataclass(frozen=True)
class Run:
    """Hold time (N,) [s] and measured position, velocity and effort (N, 2)."""

    t: np.ndarray
    q: np.ndarray
    v: np.ndarray
    tau: np.ndarray


@compiled
def inertia(body, elbow):
    """Return m11, m12 and m22 of bodies without rotors, at a position of the elbow."""
    _, second, i1, i2, m2 = body
    across = L1 * second * np.cos(elbow)
    return i1 + i2 + m2 * L1**2 + 2.0 * across, i2 + across, i2


@compiled
def forces(body, q, v, tilt):
    """Return what Coriolis effect and gravity need (2,) of bodies whose base is tilted."""
    first, second, _, _, m2 = body
    h = L1 * second * np.sin(q[1])
    hang = GRAVITY * second * np.cos(q[0] + q[1] + tilt)
    upper = GRAVITY * (first + m2 * L1) * np.cos(q[0] + tilt)
    return upper + hang - h * (2.0 * v[0] * v[1] + v[1] ** 2), hang + h * v[0] ** 2


@compiled
def effort_of(body, q, v, a, armature):
    """Return the effort (2,) of a motion without friction, rotors included."""
    m11, m12, m22 = inertia(body, q[1])
    b0, b1 = forces(body, q, v, 0.0)
    return (
        (m11 + armature[0]) * a[0] + m12 * a[1] + b0,
        m12 * a[0] + (m22 + armature[1]) * a[1] + b1,
    )


@compiled
def _run(reference, speed, acceleration, par, body, tilt, two_mass, extra, nominal, kp, kd):
    """Return position and speed of the motors and the effort at the controller's samples."""
    count = len(reference)
    q_out, v_out, tau_out = np.empty((count, 2)), np.empty((count, 2)), np.empty((count, 2))
    h = PERIOD / SUBSTEPS
    share = np.array([0.4, 0.3, 0.2, 0.1])
    width = np.array([0.5, 1.0, 1.6, 2.5])
    z, bent = np.zeros((2, 4)), np.zeros((2, 4))
    qm, vm = reference[0].copy(), np.zeros(2)
    ql, vl = reference[0].copy(), np.zeros(2)
    if two_mass:
        # It starts at rest on its springs.
        hang0, hang1 = forces(body, qm, vm, 0.0)
        ql[0] -= hang0 / par[0, 21]
        ql[1] -= hang1 / par[1, 21]
        for i in range(2):
            ql[i] += 0.5 * par[i, 22] * np.sign(ql[i] - qm[i])
    tau = np.zeros(2)
    friction = np.zeros(2)
    passed = np.zeros(2)
    for k in range(count):
        q_out[k], v_out[k] = qm, vm
        # Computed feed-forward with the nominal model, and PD.
        r, rv, ra = reference[k], speed[k], acceleration[k]
        tau[0], tau[1] = effort_of(nominal, r, rv, ra, ARMATURE)
        for i in range(2):
            tau[i] += COULOMB[i] * np.tanh(rv[i] / 0.02) + VISCOUS[i] * rv[i]
            tau[i] += kp[i] * (r[i] - qm[i]) + kd[i] * (rv[i] - vm[i])
        tau_out[k] = tau
        t = k * PERIOD
        for _ in range(SUBSTEPS):
            q = ql if two_mass else qm
            v = vl if two_mass else vm
            m11, m12, m22 = inertia(body, q[1])
            b0, b1 = forces(body, q, v, tilt)
            for i in range(2):
                p = par[i]
                # Spring of a cable, contact: on the body.
                load = p[18] * (q[i] - p[19]) - extra[k, i]
                # A spring that saturates.
                load += p[26] * p[28] * np.tanh((q[i] - p[27]) / p[28])
                if i == 0:
                    b0 += load
                else:
                    b1 += load
            for i in range(2):
                p = par[i]
                dx = vm[i] * h
                state = 0.0
                for j in range(4):
                    w = width[j] * p[14]
                    z[i, j] = min(max(z[i, j] + dx, -w), w)
                    state += share[j] * z[i, j] / w
                warm = 1.0 - np.exp(-t / p[17])
                speed_abs = abs(vm[i])
                level = p[0] * (1.0 + p[16] * warm)
                level += p[2] * np.exp(-((speed_abs / p[3]) ** p[4]))
                level += p[8] * np.cos(p[10] * qm[i] + p[9])
                level += p[7] * abs(passed[i])
                level += p[24] * speed_abs ** p[23]
                # Friction that follows where the other joint is.
                level += p[29] * np.cos(qm[1 - i] + p[30])
                friction[i] = (
                    level * state
                    + p[1] * (1.0 + p[15] * warm) * vm[i]
                    + p[5] * abs(state)
                    + p[6] * speed_abs
                    + p[25] * vm[i] * speed_abs
                )
                friction[i] += p[11] * np.cos(p[13] * qm[i] + p[12])
                # A hose that bends and slips, element by element.
                for j in range(4):
                    w = width[j] * p[32]
                    bent[i, j] = min(max(bent[i, j] + dx, -w), w)
                    friction[i] += p[31] * share[j] * bent[i, j] / w
            if two_mass:
                for i in range(2):
                    p = par[i]
                    twist = qm[i] - ql[i]
                    half = 0.5 * p[22]
                    damp = 2.0 * 0.05 * np.sqrt(p[21] * 0.05)
                    if twist > half:
                        passed[i] = p[21] * (twist - half) + damp * (vm[i] - vl[i])
                    elif twist < -half:
                        passed[i] = p[21] * (twist + half) + damp * (vm[i] - vl[i])
                    else:
                        passed[i] = 0.0
                f0, f1 = passed[0] - b0, passed[1] - b1
                det = m11 * m22 - m12**2
                vl[0] += h * (m22 * f0 - m12 * f1) / det
                vl[1] += h * (m11 * f1 - m12 * f0) / det
                ql += h * vl
                for i in range(2):
                    vm[i] += h * (tau[i] - friction[i] - passed[i]) / par[i, 20]
                qm += h * vm
            else:
                f0, f1 = tau[0] - friction[0] - b0, tau[1] - friction[1] - b1
                m11 += par[0, 20]
                m22 += par[1, 20]
                det = m11 * m22 - m12**2
                a0, a1 = (m22 * f0 - m12 * f1) / det, (m11 * f1 - m12 * f0) / det
                vm[0] += h * a0
                vm[1] += h * a1
                qm += h * vm
                passed[0] = tau[0] - friction[0] - par[0, 20] * a0
                passed[1] = tau[1] - friction[1] - par[1, 20] * a1
    return q_out, v_out, tau_out


def simulate(
    plant: Plant,
    reference: np.ndarray,
    speed: np.ndarray,
    acceleration: np.ndarray,
    rng: np.random.Generator,
    noise: Noise = Noise(),
) -> Run:
    """
    Return what is measured of the plant along a reference (N, 2) at 500 Hz.

    Measured effort is the command's mean over the interval around its sample, delayed, coupled,
    saturated, scaled, biased, with noise, in quanta.
    """
    par = np.array([[plant.joint[name][i] for name in FIELDS] for i in range(2)])
    t = np.arange(len(reference)) * PERIOD
    extra = np.zeros_like(reference)
    for joint, start, length, size in plant.contacts:
        inside = (t > start) & (t < start + length)
        extra[inside, joint] += size * np.sin(np.pi * (t[inside] - start) / length)
    for joint, size, frequency, phase in plant.beats:
        extra[:, joint] += size * np.sin(2.0 * np.pi * frequency * t + phase)
    kp, kd = np.array([400.0, 120.0]), np.array([25.0, 6.0])
    if plant.two_mass or plant.soft:
        # The motor alone is light: at 500 Hz more damping than J / T is unstable.
        kp, kd = np.array([120.0, 40.0]), np.array([1.6, 1.0])
    q, v, tau = _run(
        reference, speed, acceleration, par, plant.body(), plant.tilt, plant.two_mass, extra,
        Plant().body(), kp, kd,
    )  # fmt: skip
    # The command is held from its sample to the next: its measurement is in the middle.
    effort = 0.5 * (tau + np.vstack([tau[:1], tau[:-1]]))
    if plant.delay:
        effort = np.column_stack([np.interp(t - plant.delay, t, x) for x in effort.T])
    effort[:, 0] += plant.coupling * effort[:, 1]
    for i, limit in enumerate(plant.saturation):
        if np.isfinite(limit):
            share = np.clip(effort[:, i] / limit, -0.98, 0.98)
            effort[:, i] = limit * np.arctanh(share)
    effort = effort * plant.scale + plant.bias
    measured = q + plant.eccentricity * np.sin(q + plant.eccentricity_phase)
    if noise.exact:
        return Run(t, measured, v, effort)
    measured = POSITION_LSB * np.round(measured / POSITION_LSB)
    speed_noise = SPEED_NOISE * rng.standard_normal(v.shape)
    white = WHITE * rng.standard_normal(effort.shape)
    a = np.exp(-PERIOD / noise.time)
    drive = rng.standard_normal(effort.shape) * np.sqrt(1.0 - a * a)
    coloured = COLOURED * lfilter([1.0], [1.0, -a], drive, axis=0)
    effort = effort + noise.white * white + noise.coloured * coloured
    return Run(t, measured, v + speed_noise, LSB * np.round(effort / LSB))
