# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Integrate a :class:`~sosml_friction.simulation.forward_model.ForwardModel`, many windows at once.

The leapfrog rule, of second order: positions at the half steps, velocities at the whole ones;
what depends on velocity takes it half a step ahead by the last acceleration. Inertia and C q' + g
are those of Pinocchio in the middle of each sample, and held over it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sosml_friction.model.dahl import dahl_step
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.simulated_term import Gear
from sosml_friction.simulation.forward_drive import Drive
from sosml_friction.simulation.forward_model import ForwardModel, gear_damping
from sosml_friction.simulation.forward_start import Start

FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.int64]

#: A simulation that is so far away has run away [rad or m].
_AWAY = 1e3
#: Time over which the slope of the encoders' map is taken [s].
_TINY = 1e-6
#: Gears that give are simulated alone for so long before a window starts [s].
_SETTLE_S = 0.5
#: Share of critical damping that they have meanwhile at least, outside of a gap, where they would
#: ring with the noise of the measured path, and their body start too fast.
_SETTLE_DAMPING = 0.5


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
    state = _Integrator(model, start, period, effort, followed)
    out_q, out_v = np.empty((windows, samples, n)), np.empty((windows, samples, n))
    for k in range(samples):
        state.lead(k)
        # What the encoders say of the velocity differs by the slope of their map, of order 1e-3.
        out_q[:, k], out_v[:, k] = model.measured_position(state.q), state.v
        if k == samples - 1:
            break
        step(k)
        drive.begin(k, out_q[:, k])
        if not state.advance(k, drive):
            out_q[:, k:], out_v[:, k:] = np.inf, np.inf
            break
    return Simulated(out_q, out_v)


class _Integrator:
    """
    Hold the state of W windows: motors at ``q``, ``v`` (W, n), and what moves with them.

    Bodies behind gears that give are at x and as fast as u; elsewhere these are q and v.
    """

    def __init__(
        self,
        model: ForwardModel,
        start: Start,
        period: float,
        effort: FloatArray,
        followed: Sequence[int],
    ) -> None:
        self.model, self.start, self.period = model, start, period
        posture = np.median(start.q, axis=0)
        self.count = model.steps(posture, effort, period)
        self.h = period / self.count
        self.q = model.true_position(start.q)
        # The encoders' map is one of position: its slope turns their velocity into the motors'.
        v = (
            model.true_position(start.q + _TINY * start.v)
            - model.true_position(start.q - _TINY * start.v)
        ) / (2.0 * _TINY)
        self.v = np.where(start.v == 0.0, 0.0, v)
        self.a = np.array(start.acceleration)
        self.sign = np.array(start.sign)
        path = model.true_position(start.path)
        self.states = [term.start(path, start.at) for term in model.terms]
        self.rigid = np.diag(model.rigid_rotors())
        self.motors = model.motors(posture)
        self.bent = [gear.joint for gear in model.gears]
        self.stiffness = np.array([gear.stiffness for gear in model.gears])
        self.half_gap = np.array([0.5 * gear.gap for gear in model.gears])
        self.damping = np.zeros(len(self.bent))
        self.x, self.u, self.body_a = self.q.copy(), self.v.copy(), self.a.copy()
        if self.bent:
            twist, rate = _settled(model, path, start.at, period, self.count)
            self.x[:, self.bent] -= twist
            self.u[:, self.bent] -= rate
        # M q'' + C q' + g with the rotor, before a gear as behind it.
        self.load = _carried(model, self.q, self.v, self.a) + model.rotors * self.a
        self.led = list(followed)
        led_v = np.gradient(path, period, axis=0) if self.led else path
        led_a = np.gradient(led_v, period, axis=0) if self.led else path
        self.led_path = (path, led_v, led_a)

    def _row(self, k: int) -> IndexArray:
        """Return the samples of the recording that sample ``k`` of the windows is, (W,)."""
        return np.asarray(np.minimum(self.start.at + k, len(self.start.time) - 1))

    def lead(self, k: int) -> None:
        """Put the joints that follow the path where it is at sample ``k``."""
        if self.led:
            at = self._row(k)
            for state, path in zip((self.q, self.v, self.a), self.led_path, strict=True):
                state[:, self.led] = path[at][:, self.led]

    def advance(self, k: int, drive: Drive) -> bool:
        """Go from sample ``k`` to the next one; return whether the state is still a sane one."""
        middle = self.x + 0.5 * self.period * self.u + 0.125 * self.period**2 * self.body_a
        if not np.abs(middle).max() < _AWAY:
            return False
        inverse, bias = self._bodies(middle, self.u + 0.5 * self.period * self.body_a)
        at = self._row(k)
        motion = Motion(
            self.start.time[at] + 0.5 * self.period,
            self.q, self.v, self.sign, self.load, self.start.warm[at],
        )  # fmt: skip
        for j in range(self.count):
            self._drift(self.h if j else 0.5 * self.h)
            self._kick(motion, drive.torque((j + 0.5) / self.count), inverse, bias)
        self._drift(0.5 * self.h)
        return True

    def _bodies(self, middle: FloatArray, speed: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return M^-1 (W, n, n) and C q' + g (W, n) in the middle of a sample."""
        robot, still = self.model.robot, np.zeros(middle.shape[1])
        masses = np.array([robot.inertia(row) for row in middle]) + self.rigid
        bias = np.array(
            [robot.inverse_dynamics(row, s, still) for row, s in zip(middle, speed, strict=True)]
        )
        if self.led:
            masses[:, self.led] = np.eye(len(still))[self.led]
        carried = masses[:, self.bent, self.bent].mean(axis=0)
        self.damping = _damping(self.model.gears, carried)
        return np.asarray(np.linalg.inv(masses)), bias

    def _drift(self, dt: float) -> None:
        """Move everything by its velocity for a time ``dt``."""
        dq = dt * self.v
        self.q = self.q + dq
        self.x = self.x + dt * self.u if self.bent else self.q
        self.sign = dahl_step(self.sign, dq, self.model.displacement)
        for j, term in enumerate(self.model.terms):
            if self.states[j].shape[1]:
                self.states[j] = term.advance(self.states[j], dq)

    def _kick(
        self, motion: Motion, torque: FloatArray, inverse: FloatArray, bias: FloatArray
    ) -> None:
        """Change the velocities by one step of what acts."""
        h, bent = self.h, self.bent
        ahead = self.v + 0.5 * h * self.a
        motion.q, motion.v, motion.sign, motion.load = self.q, ahead, self.sign, self.load
        net = torque - self.model.friction.torque(ahead, self.sign)
        for term, state in zip(self.model.terms, self.states, strict=True):
            part = term.load(motion, state)
            if part is not None:
                net = net - part
        on_bodies = net - bias
        if bent:
            twist = self.q[:, bent] - self.x[:, bent]
            dead = np.clip(twist, -self.half_gap, self.half_gap)
            slip = ahead[:, bent] - (self.u + 0.5 * h * self.body_a)[:, bent]
            # The mesh damps the body all the way, as the candidate's does.
            through = self.stiffness * (twist - dead) + self.damping * slip
            on_bodies[:, bent] = through - bias[:, bent]
        on_bodies[:, self.led] = self.a[:, self.led]
        self.a = self.body_a = np.einsum('wij,wj->wi', inverse, on_bodies)
        if bent:
            self.a = self.body_a.copy()
            self.a[:, bent] = (net[:, bent] - through) / self.motors
            self.u = self.u + h * self.body_a
        self.load = net
        self.v = self.v + h * self.a
        if not bent:
            self.u = self.v


def _damping(gears: Sequence[Gear], carried: FloatArray) -> FloatArray:
    """Return the damping of gears that give (g,), each with the inertia that it carries."""
    pairs = zip(gears, carried, strict=True)
    return np.array([gear_damping(gear, float(mass)) for gear, mass in pairs])


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
    calm = [replace(g, damping=max(g.damping, _SETTLE_DAMPING)) for g in gears]
    free, touching = (_damping(these, M.mean(axis=0)) for these in (gears, calm))
    h = period / count
    d, rate = np.zeros(M.shape), np.zeros(M.shape)
    for k in range(-before, 0):
        rows = np.maximum(at + k, 0)
        load = _carried(model, path[rows], v[rows], a[rows])[:, bent]
        if k == -before:
            d = load / K + np.sign(load) * half
        for _ in range(count):
            twist = d - np.clip(d, -half, half)
            c = np.where(twist == 0.0, free, touching)
            rate = (rate + h * (load - K * twist) / M) / (1.0 + h * c / M)
            d = d + h * rate
    return d, rate
