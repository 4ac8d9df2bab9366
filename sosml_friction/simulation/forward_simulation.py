# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Integrate a :class:`~sosml_friction.simulation.forward_model.ForwardModel`, many windows at once.

The leapfrog rule, of second order: positions at the half steps, velocities at the whole ones;
what depends on velocity takes it half a step ahead by the last acceleration. Inertia and C q' + g
are those of Pinocchio in the middle of each sample, and held over it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sosml_friction.simulation.dahl import dahl_step
from sosml_friction.simulation.forward_model import ForwardModel, gear_damping
from sosml_friction.simulation.forward_term import Motion

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.int64]

#: A simulation that is so far away has run away [rad or m].
_AWAY = 1e3
#: Gears that give are simulated alone for so long before a window starts [s].
_SETTLE_S = 0.5


class Drive(ABC):
    """Say which torque acts."""

    @abstractmethod
    def begin(self, k: int, q: FloatArray) -> None:
        """Begin sample ``k`` with the encoders at ``q`` (W, n)."""

    @abstractmethod
    def torque(self, share: float) -> FloatArray:
        """Return the torque (W, n) [Nm or N] when ``share`` of the sample is over, 0..1."""


class RecordedDrive(Drive):
    """
    Drive by effort that was reported, on lines between its samples.

    :param torque: (N, n) at the samples of the recording: already the torque, delays undone.
    :param at: first sample of each window (W,).
    """

    def __init__(self, torque: FloatArray, at: IndexArray) -> None:
        self._torque = torque
        self._at = at
        self._now = torque[at]
        self._next = torque[at]

    def begin(self, k: int, q: FloatArray) -> None:
        """Look up the sample and the next one."""
        last = len(self._torque) - 1
        self._now = self._torque[np.minimum(self._at + k, last)]
        self._next = self._torque[np.minimum(self._at + k + 1, last)]

    def torque(self, share: float) -> FloatArray:
        """Return the torque between the two."""
        return np.asarray(self._now + share * (self._next - self._now))


@dataclass(frozen=True)
class Start:
    """
    Hold the measured state that windows start from, (W, n): of the encoders.

    ``acceleration`` makes the first guess of the load; ``sign`` is the state of friction.
    ``path`` (N, n): measured position of the recording, as smooth as its second derivative needs;
    ``at`` (W,): where in it they start. ``time`` (N,) [s] and ``warm`` (N, n) [degC, NaN]: of the
    recording's samples.
    """

    q: FloatArray
    v: FloatArray
    acceleration: FloatArray
    sign: FloatArray
    path: FloatArray
    at: IndexArray
    time: FloatArray
    warm: FloatArray


@dataclass(frozen=True)
class Simulated:
    """Hold position and velocity of the encoders at each sample, (W, L, n)."""

    q: FloatArray
    v: FloatArray


def simulate(
    model: ForwardModel,
    start: Start,
    drive: Drive,
    period: float,
    samples: int,
    effort: FloatArray,
    step: Callable[[int], None] = lambda k: None,
    followed: Sequence[int] = (),
) -> Simulated:
    """
    Simulate ``samples`` samples of every window.

    :param period: time between samples [s].
    :param effort: largest effort of each joint (n,) [Nm or N], which friction by load scales with.
    :param step: called with the number of each sample.
    :param followed: joints that nothing drives and that follow the path.
    :raises ConfigurationError: if the model cannot be simulated at this rate.
    """
    windows, n = start.q.shape
    robot, gears = model.robot, model.gears
    bent = [gear.joint for gear in gears]
    led = list(followed)
    count = model.steps(np.median(start.q, axis=0), effort, period)
    h = period / count
    q = model.true_position(start.q)
    # The encoders' map is one of position: its slope turns their velocity into the motors'.
    tiny = 1e-6
    v = (
        model.true_position(start.q + tiny * start.v)
        - model.true_position(start.q - tiny * start.v)
    ) / (2.0 * tiny)
    v = np.where(start.v == 0.0, 0.0, v)
    a = np.array(start.acceleration)
    z = np.array(start.sign)
    path = model.true_position(start.path)
    states = [term.start(path, start.at) for term in model.terms]
    rigid = np.diag(model.rigid_rotors())
    # Bodies behind gears that give: x is where they are, u how fast.
    x, u = q.copy(), v.copy()
    stiffness = np.array([gear.stiffness for gear in gears])
    half_gap = np.array([0.5 * gear.gap for gear in gears])
    motors = model.motors(np.median(start.q, axis=0))
    through = np.zeros((windows, len(gears)))
    load = _carried(model, q, v, a) + model.rotors * a
    if bent:
        twist, rate = _settled(model, path, start.at, period, count)
        x[:, bent] -= twist
        u[:, bent] -= rate
    damping = np.zeros(len(gears))
    out_q, out_v = np.empty((windows, samples, n)), np.empty((windows, samples, n))
    friction, terms, displacement = model.friction, model.terms, model.displacement
    body_a = a.copy()
    motion = Motion(start.time[start.at], q, v, z, load, start.warm[start.at])

    def drift(dt: float) -> None:
        nonlocal q, x, z
        dq = dt * v
        q = q + dq
        x = x + dt * u if bent else q
        z = dahl_step(z, dq, displacement)
        for j, term in enumerate(terms):
            if states[j].shape[1]:
                states[j] = term.advance(states[j], dq)

    led_v = np.gradient(path, period, axis=0) if led else path
    led_a = np.gradient(led_v, period, axis=0) if led else path
    for k in range(samples):
        at = np.minimum(start.at + k, len(start.time) - 1)
        if led:
            q[:, led], v[:, led], a[:, led] = (y[at][:, led] for y in (path, led_v, led_a))
        out_q[:, k], out_v[:, k] = model.measured_position(q), v
        if k == samples - 1:
            break
        step(k)
        drive.begin(k, out_q[:, k])
        middle = x + 0.5 * period * u + 0.125 * period**2 * body_a
        speed = u + 0.5 * period * body_a
        if not np.abs(middle).max() < _AWAY:
            out_q[:, k:], out_v[:, k:] = np.inf, np.inf
            break
        masses = np.array([robot.inertia(row) for row in middle])
        still = np.zeros(n)
        bias = np.array(
            [robot.inverse_dynamics(row, s, still) for row, s in zip(middle, speed, strict=True)]
        )
        masses = masses + rigid
        if led:
            masses[:, led] = np.eye(n)[led]
        inverse = np.linalg.inv(masses)
        motion.time, motion.warm = start.time[at] + 0.5 * period, start.warm[at]
        if bent:
            carried_mass = masses[:, bent, bent].mean(axis=0)
            damping = np.array(
                [gear_damping(g, float(m)) for g, m in zip(gears, carried_mass, strict=True)]
            )
        for j in range(count):
            drift(h if j else 0.5 * h)
            ahead = v + 0.5 * h * a
            motion.q, motion.v, motion.sign, motion.load = q, ahead, z, load
            net = drive.torque((j + 0.5) / count) - friction.torque(ahead, z)
            for term, state in zip(terms, states, strict=True):
                part = term.load(motion, state)
                if part is not None:
                    net = net - part
            on_bodies = net - bias
            if bent:
                twist = q[:, bent] - x[:, bent]
                dead = np.clip(twist, -half_gap, half_gap)
                slip = ahead[:, bent] - (u + 0.5 * h * body_a)[:, bent]
                # The mesh damps the body all the way, as the candidate's does.
                through = stiffness * (twist - dead) + damping * slip
                on_bodies[:, bent] = through - bias[:, bent]
            on_bodies[:, led] = a[:, led]
            body_a = np.einsum('wij,wj->wi', inverse, on_bodies)
            a = body_a
            if bent:
                a = body_a.copy()
                a[:, bent] = (net[:, bent] - through) / motors
                u = u + h * body_a
            # M q'' + C q' + g with the rotor, before a gear as behind it.
            load = net
            v = v + h * a
            if not bent:
                u = v
        drift(0.5 * h)
    # What the encoders say of the velocity differs by the slope of their map, of order 1e-3.
    return Simulated(out_q, out_v)


def _carried(model: ForwardModel, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
    """Return M q'' + C q' + g without rotors, (W, n)."""
    return np.array([model.robot.inverse_dynamics(*x) for x in zip(q, v, a, strict=True)])


def _settled(
    model: ForwardModel, path: FloatArray, at: IndexArray, period: float, count: int
) -> tuple[FloatArray, FloatArray]:
    """
    Return by how much the gears are twisted at the samples ``at``, and how fast, (W, g) each.

        M d'' + c d' + K dead(d) = load,  d = motor - body,

    for a while before, in which the motors follow the path and the ringing dies down.
    """
    gears, robot = model.gears, model.robot
    bent = [gear.joint for gear in gears]
    K = np.array([gear.stiffness for gear in gears])
    half = np.array([0.5 * gear.gap for gear in gears])
    before = round(_SETTLE_S / period)
    v = np.gradient(path, period, axis=0)
    a = np.gradient(v, period, axis=0)
    M = np.array([np.diag(robot.inertia(path[k]))[bent] for k in at])
    c = np.array([gear_damping(g, float(m)) for g, m in zip(gears, M.mean(axis=0), strict=True)])
    h = period / count
    d, rate = np.zeros(M.shape), np.zeros(M.shape)
    for k in range(-before, 0):
        rows = np.maximum(at + k, 0)
        load = _carried(model, path[rows], v[rows], a[rows])[:, bent]
        if k == -before:
            d = load / K + np.sign(load) * half
        for _ in range(count):
            twist = d - np.clip(d, -half, half)
            rate = (rate + h * (load - K * twist) / M) / (1.0 + h * c / M)
            d = d + h * rate
    return d, rate
