# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Integrate a :class:`~sosml_friction.simulation.forward_model.ForwardModel`, many windows at once.

Inertia and C q' + g are those of Pinocchio in the middle of each sample and held over it: that is
of second order in the sample. The states of friction and of terms follow the displacement since
the step began, however far it is.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import repeat
from typing import NamedTuple

import numpy as np

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.model.dahl import dahl_step
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.simulation.forward_drive import Drive
from sosml_friction.simulation.forward_model import ForwardModel, gear_damping
from sosml_friction.simulation.integrator import runge_kutta_step
from sosml_friction.simulation.simulated import Simulated
from sosml_friction.simulation.window_models import WindowModels, as_window_models

#: Distance from the recorded path beyond which a simulation has diverged [rad or m]. A wheel may
#: be anywhere.
_AWAY = 1e3
#: Time over which the slope of the encoders' map is taken [s].
_TINY = 1e-6
#: Time for which elastic gears are simulated alone before a window starts [s]. Chosen, no
#: measurement.
_SETTLE_S = 0.5
#: Least damping of the gears in that time, as a share of critical damping, outside of a gap. With
#: less, the noise of the measured path makes them ring, and their body starts too fast.
_SETTLE_DAMPING = 0.5


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


def simulate(
    model: ForwardModel | WindowModels,
    start: Start,
    drive: Drive,
    period: float,
    samples: int,
    effort: FloatArray,
    step: Callable[[int], None] = lambda k: None,
    followed: Sequence[int] = (),
) -> Simulated:
    """
    Simulate ``samples`` samples of every window; what runs away is infinite from there on.

    :param effort: largest effort of each joint (n,) [Nm or N], which friction by load scales with.
    :param followed: joints that nothing drives and that follow the path.
    :raises ConfigurationError: if the model cannot be simulated at this rate.
    """
    windows, n = start.q.shape
    models = as_window_models(model, windows)
    # How many samples of each window did not run away.
    sane = np.full(windows, samples)
    state = _Windows(models, start, period, effort, followed)
    out_q, out_v = np.empty((windows, samples, n)), np.empty((windows, samples, n))
    for k in range(samples):
        state.lead(k)
        # What the encoders say of the velocity differs by the slope of their map, of order 1e-3.
        out_q[:, k], out_v[:, k] = models.measured_position(state.q), state.v
        if k == samples - 1:
            break
        step(k)
        drive.begin(k, out_q[:, k])
        lost = state.advance(k, drive)
        sane[lost] = np.minimum(sane[lost], k)
        if not (sane == samples).any():
            break
    gone = np.arange(samples) >= sane[:, None]
    out_q[gone], out_v[gone] = np.inf, np.inf
    return Simulated(out_q, out_v)


class _Known(NamedTuple):
    """What is known of a step: torque and its rate, M^-1 (W, n, n), C q' + g, gear dampers."""

    torque: FloatArray
    rate: FloatArray
    inverse: FloatArray
    bias: FloatArray
    damping: FloatArray


class _Windows:
    """
    Hold the state of W windows: motors at ``q``, ``v`` (W, n), and what moves with them.

    Bodies behind gears that give have places of their own, in the columns after the motors' in
    ``place`` and ``speed`` (W, n + g).
    """

    def __init__(
        self,
        model: WindowModels,
        start: Start,
        period: float,
        effort: FloatArray,
        followed: Sequence[int],
    ) -> None:
        self.model, self.start, self.period, self.n = model, start, period, model.n
        posture = np.median(start.q, axis=0)
        self.count = model.steps(posture, effort, period)
        q = model.true_position(start.q)
        # The encoders' map is one of position: its slope turns their velocity into the motors'.
        v = (
            model.true_position(start.q + _TINY * start.v)
            - model.true_position(start.q - _TINY * start.v)
        ) / (2.0 * _TINY)
        v = np.where(start.v == 0.0, 0.0, v)
        self.sign, self.warm = np.array(start.sign), start.warm
        self.states = [
            model.each(partial(_started, number=k, start=start)) for k in range(len(model.terms))
        ]
        self.motors = model.numbers(lambda own: own.motors(posture))
        self.bent, self.stiffness, self.half_gap = model.bent, model.stiffness, model.half_gap
        twist, rate = np.zeros((2, len(q), 0))
        if self.bent:
            twist, rate = np.moveaxis(model.each(self._settle), 1, 0)
        self.place = np.hstack([q, q[:, self.bent] - twist])
        self.speed = np.hstack([v, v[:, self.bent] - rate])
        self.body_a = np.array(start.acceleration)
        # What the gears pass on: the rotor stands before them.
        self.load = _carried(model.robots, q, v, self.body_a)
        self.led = list(followed)
        self.led_a = np.zeros((len(q), len(self.led)))
        if self.led:
            # Of each model position, velocity and acceleration, (models, 3, N, n).
            self.led_paths = np.array([_derived(own, start.path, period) for own in model.models])
        self.begin = self.place.copy()

    @property
    def q(self) -> FloatArray:
        """Return where the motors are (W, n)."""
        return self.place[:, : self.n]

    @property
    def v(self) -> FloatArray:
        """Return how fast the motors are (W, n)."""
        return self.speed[:, : self.n]

    def _row(self, k: int) -> IndexArray:
        """Return the samples of the recording that sample ``k`` of the windows is, (W,)."""
        return np.asarray(np.minimum(self.start.at + k, len(self.start.time) - 1))

    def _settle(self, model: ForwardModel, windows: IndexArray) -> FloatArray:
        path, at = model.true_position(self.start.path), self.start.at[windows]
        return np.stack(_settled(model, path, at, self.period, self.count), axis=1)

    def lead(self, k: int) -> None:
        """Put the joints that follow the path where it is at sample ``k``."""
        if self.led:
            # Indices on both sides of a slice: windows come first, (W, 3, n).
            led = self.led_paths[self.model.of, :, self._row(k)][:, :, self.led]
            q, v, a = np.moveaxis(led, 1, 0)
            self.q[:, self.led], self.v[:, self.led] = q, v
            self.body_a[:, self.led], self.led_a = a, a

    def advance(self, k: int, drive: Drive) -> IndexArray:
        """Go from sample ``k`` to the next one; return the windows whose state runs away."""
        middle, speed = self._middle()
        # Not a comparison that NaN passes.
        away = np.abs(middle - self.start.path[self._row(k)])
        lost = np.flatnonzero(~(away < _AWAY).all(axis=1))
        if len(lost):
            # They begin anew, so that the others go on beside numbers.
            self.place[lost] = self.begin[lost]
            for state in (self.speed, self.body_a, self.load, self.sign, *self.states):
                state[lost] = 0.0
            middle, speed = self._middle()
        dynamics = self._dynamics(middle, speed)
        at = self._row(k)
        self.time, self.warm = self.start.time[at] + 0.5 * self.period, self.start.warm[at]
        h = self.period / self.count
        for j in range(self.count):
            begin, end = drive.torque(j / self.count, (j + 1) / self.count)
            known = _Known(begin, (end - begin) / h, *dynamics)
            self.before = self.q
            self.place, self.speed = runge_kutta_step(
                self._acceleration, known, self.place, self.speed, h
            )
            self.sign, self.states = self._remembered(self.q - self.before)
        return lost

    def _middle(self) -> tuple[FloatArray, FloatArray]:
        """Return where the bodies are in the middle of a sample, and how fast, (W, n) each."""
        h, speed = self.period, self._bodies(self.speed)
        q = self._bodies(self.place) + 0.5 * h * speed + 0.125 * h**2 * self.body_a
        return q, speed + 0.5 * h * self.body_a

    def _bodies(self, x: FloatArray) -> FloatArray:
        """Return what of ``x`` (W, n + g) is of the bodies, (W, n)."""
        result = x[:, : self.n].copy()
        result[:, self.bent] = x[:, self.n :]
        return result

    def _dynamics(
        self, middle: FloatArray, speed: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return M^-1, C q' + g and the dampers of the gears in the middle of a sample."""
        model, still = self.model, np.zeros(self.n)
        pairs = zip(model.robots, middle, strict=True)
        masses = np.array([robot.inertia(row) for robot, row in pairs]) + model.rigid
        rows = zip(model.robots, middle, speed, strict=True)
        bias = np.array([robot.inverse_dynamics(row, s, still) for robot, row, s in rows])
        if self.led:
            masses[:, self.led] = np.eye(self.n)[self.led]
        carried = masses[:, self.bent, self.bent]
        damping = gear_damping(model.damping, self.stiffness, carried)
        return np.asarray(np.linalg.inv(masses)), bias, damping

    def _remembered(self, dq: FloatArray) -> tuple[FloatArray, list[FloatArray]]:
        """Return the states of friction and of the terms after the motors moved by ``dq``."""
        terms = zip(self.model.terms, self.states, strict=True)
        states = [term.advance(x, dq) if x.shape[1] else x for term, x in terms]
        return np.asarray(dahl_step(self.sign, dq, self.model.displacement)), states

    def _acceleration(
        self, known: _Known, t: float, place: FloatArray, speed: FloatArray
    ) -> FloatArray:
        """Return what the velocities (W, n + g) change by, after ``t`` of a step [per s^2]."""
        q, v, bent = place[:, : self.n], speed[:, : self.n], self.bent
        sign, states = self._remembered(q - self.before) if t > 0.0 else (self.sign, self.states)
        motion = Motion(self.time, q, v, sign, self.load, self.warm)
        net = known.torque + t * known.rate - self.model.friction.torque(v, sign)
        for term, state in zip(self.model.terms, states, strict=True):
            part = term.load(motion, state)
            if part is not None:
                net = net - part
        on_bodies = net - known.bias
        if bent:
            twist = q[:, bent] - place[:, self.n :]
            dead = np.clip(twist, -self.half_gap, self.half_gap)
            slip = v[:, bent] - speed[:, self.n :]
            # The mesh damps the body all the way, as the candidate's does.
            through = self.stiffness * (twist - dead) + known.damping * slip
            on_bodies[:, bent] = through - known.bias[:, bent]
        on_bodies[:, self.led] = self.led_a
        self.body_a = np.einsum('wij,wj->wi', known.inverse, on_bodies)
        self.load = net - self.model.rotors * self.body_a
        if not bent:
            return self.body_a
        self.load[:, bent] = through
        motors = self.body_a.copy()
        motors[:, bent] = (net[:, bent] - through) / self.motors
        return np.hstack([motors, self.body_a[:, bent]])


def _derived(model: ForwardModel, path: FloatArray, period: float) -> FloatArray:
    """Return the path of the motors and its first two derivatives, (3, N, n)."""
    q = model.true_position(path)
    v = np.gradient(q, period, axis=0)
    return np.array([q, v, np.gradient(v, period, axis=0)])


def _started(model: ForwardModel, windows: IndexArray, number: int, start: Start) -> FloatArray:
    """Return the states of a term at the begin of windows."""
    return model.terms[number].start(model.true_position(start.path), start.at[windows])


def _carried(robots: Iterable[Robot], q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
    """Return M q'' + C q' + g without rotors, (W, n)."""
    rows = zip(robots, q, v, a, strict=True)
    return np.array([robot.inverse_dynamics(*row) for robot, *row in rows])


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
    v = np.gradient(path, period, axis=0)
    a = np.gradient(v, period, axis=0)
    M = np.array([np.diag(robot.inertia(path[k]))[bent] for k in at])
    shares = np.array([gear.damping for gear in gears])
    carried = M.mean(axis=0)
    free = gear_damping(shares, K, carried)
    touching = gear_damping(np.maximum(shares, _SETTLE_DAMPING), K, carried)

    def acceleration(load: FloatArray, _: float, d: FloatArray, rate: FloatArray) -> FloatArray:
        twist = d - np.clip(d, -half, half)
        return np.asarray((load - K * twist - np.where(twist == 0.0, free, touching) * rate) / M)

    d, rate = np.zeros((2, *M.shape))
    before = round(_SETTLE_S / period)
    for k in range(-before, 0):
        rows = np.maximum(at + k, 0)
        load = _carried(repeat(robot, len(rows)), path[rows], v[rows], a[rows])[:, bent]
        if k == -before:
            d = load / K + np.sign(load) * half
        for _ in range(count):
            d, rate = runge_kutta_step(acceleration, load, d, rate, period / count)
    return d, rate
