# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Velocity from position and effort together: what a differentiated position cannot show."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import minimum_filter1d
from scipy.optimize import minimize_scalar

from sosml_friction.arrays import FloatArray, IndexArray
from sosml_friction.identification.motion_filter import smooth_motion
from sosml_friction.identification.segments import unsure_sign
from sosml_friction.model.laws import FrictionLaw
from sosml_friction.observers.momentum_samples import MomentumSamples

#: How often friction is linearised about the velocities found before. Each time they go half of
#: the way, so that an eighth of the first change is left; what errors remain is printed by
#: test/identification/test_rippling_loop.py.
_PASSES = 4
#: Logarithms of the factors on the variances of torque between which the likelihood chooses: from
#: a torque that explains the motion wholly to one that says nothing of it.
_FACTORS = (-9.0, 9.0)
#: Samples in one go, which bounds the memory.
_LONGEST = 4000


@dataclass(frozen=True)
class JointNoise:
    """
    Hold how unsure position and torque of a joint are.

    ``position`` [rad or m]: standard deviation of the encoder, rounding included. ``effort``
    [Nm or N]: of white noise of the torque, from sample to sample. ``friction`` [Nm or N]: of what
    the law leaves, which lasts ``lasting_s`` [s]. ``velocity`` [rad/s or m/s]: of the velocity to
    begin with. ``zero_band`` [rad/s or m/s]: slower, the law's sign is not known.
    """

    position: float
    effort: float
    friction: float
    velocity: float
    zero_band: float
    lasting_s: float


class VelocitySmoother:
    """
    Smooth the velocities of one stretch of a recording by its motor torque and a friction law.

    M v' = u - f(v) - d, q' = v, u = tau + C^T v - g, is linear but for the law f, which is
    linearised about the velocities found before. d is friction that the law leaves: a process of
    Ornstein and Uhlenbeck. A Kalman filter over (q, v, d) of each joint and its way back give v
    and its variance, given every position and torque of the stretch
    (:mod:`~sosml_friction.identification.motion_filter`). The friction of the other joints is that
    of their own velocities.

    The torque shows ripple that a position rounded to a quantum does not, and the position keeps
    the integral of the torque from drifting. A torque that does not explain the motion (a wrong
    inertia, a gear that gives) is noise: the likelihood of the positions says how much of it.

    :param q: position at the beginning of the stretch and at the end of each interval,
        (N + 1, n) [rad or m].
    :param v: velocity to begin with, (N + 1, n) [rad/s or m/s].
    :param laws: of each joint, None where it is not known.
    :param inertia_factor: on all inertial torque of each joint, (n,).
    :param half: samples on either side over which ``v`` is a mean: near a start, stop or reversal
        it does not say on which side a sample is.
    """

    def __init__(
        self,
        samples: MomentumSamples,
        q: FloatArray,
        v: FloatArray,
        laws: Sequence[FrictionLaw | None],
        noise: Sequence[JointNoise],
        inertia_factor: FloatArray,
        half: int,
    ) -> None:
        self.samples, self.q, self.v, self.laws, self.noise = samples, q, v.copy(), laws, noise
        self._before = np.square([x.velocity for x in noise])
        self.variance = self._before * np.ones_like(v)
        self._mobility = samples.mobility / inertia_factor
        # A torque that is not known is any that the recording has, for as long as one lasts.
        known = np.isfinite(samples.forcing)
        self._forcing = np.where(known, samples.forcing, 0.0)
        lasting = np.array([x.lasting_s for x in noise])
        self._unsure = 2.0 * np.mean(self._forcing**2, axis=0) * lasting / samples.h[:, None]
        self._white = np.square([x.effort for x in noise]) + np.where(known, 0.0, self._unsure)
        # The velocities about which friction is linearised, and how far they went last.
        self._about, self._moved = v.copy(), np.zeros_like(v)
        self._factor = np.ones(len(noise))
        step = float(np.median(samples.h))
        self._first = v
        unsure = np.column_stack(
            [unsure_sign(x, each.zero_band, half) for x, each in zip(v.T, noise, strict=True)]
        )
        still = np.abs(v) <= [x.zero_band for x in noise]
        # Where the law does not say what friction is.
        self.free = still | unsure | [law is None for law in laws]
        # A rounded position that is read again and again is one reading, however often.
        again = np.column_stack([repeats(x) for x in q.T])
        self._position = again * np.square([x.position for x in noise])
        # After it the filter has to find its way again.
        lost = round(lasting[0] / step)
        self._counted = minimum_filter1d(~self.free, 2 * lost + 1, axis=0)
        self._counted[1:] &= known
        self._overlap = int(5.0 * lasting[0] / step)

    def run(self) -> tuple[FloatArray, FloatArray]:
        """
        Return velocities and their variances, (N + 1, n) each.

        A joint whose torque says too little of its motion to make its velocity surer keeps the one
        to begin with; its variance is NaN.
        """
        with np.errstate(over='ignore', invalid='ignore'):
            self._settle()
        for i, noise in enumerate(self.noise):
            # Two estimates of no bias differ by the errors of both: what is left is the first's.
            sure = self._counted[:, i] if self._counted[:, i].any() else ~self.free[:, i]
            error, apart = np.inf, 0.0
            if sure.any():
                error = float(np.mean(self.variance[sure, i]))
                apart = float(np.mean(np.square(self.v[sure, i] - self._first[sure, i])))
            # A torque that is known far too seldom for its motion makes the filter run away.
            away = np.isfinite(self._first[:, i]) & ~np.isfinite(self.v[:, i])
            if away.any() or not error < max(noise.velocity**2, apart - error):
                self.v[:, i], self.variance[:, i] = self._first[:, i], np.nan
        return self.v, self.variance

    def _settle(self) -> None:
        """Smooth the velocities with friction linearised about those of the pass before."""
        for number in range(_PASSES):
            problem = self._linearised()
            if number == 2:
                self._weigh(problem)
            for part, kept in self._parts():
                v, variance, _ = self._smoothed(problem, part, True)
                own = kept - part.start
                # Half way: a step that goes too far would come back and never settle.
                self._moved[kept] = 0.5 * (v[own] - self._about[kept])
                self._about[kept] += self._moved[kept]
                # Of nearly exact positions rounding leaves none: no less sure than to begin with.
                known = np.where(variance[own] > 0.0, variance[own], self._before)
                self.v[kept], self.variance[kept] = v[own], known

    def _parts(self) -> Iterator[tuple[slice, IndexArray]]:
        """Yield pieces of bounded length, and which samples of each are kept."""
        count, overlap = len(self.q), self._overlap
        for first in range(0, count, _LONGEST):
            last = min(first + _LONGEST, count)
            yield (
                slice(max(first - overlap, 0), min(last + overlap, count)),
                np.arange(first, last),
            )

    def _linearised(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return torque without slope times v, slope of friction, variance; (N, n) each."""
        middle = 0.5 * (self._about[1:] + self._about[:-1])
        # Where the velocities still move, friction is linearised over as much.
        moved = 0.5 * (self._moved[1:] + self._moved[:-1])
        drive, slope = self._forcing.copy(), np.zeros_like(middle)
        white = self._white.copy()
        for i, law in enumerate(self.laws):
            v = middle[:, i]
            free = self.free[1:, i]
            if law is not None:
                step = np.sqrt(self.variance[1:, i] + moved[:, i] ** 2)
                above, below = law.torque(v + step), law.torque(v - step)
                slope[:, i] = np.where(free, 0.0, (above - below) / (2.0 * step))
                friction = 0.5 * (above + below) - slope[:, i] * v
                drive[:, i] -= np.where(free, 0.0, friction)
            # Where the sign is not known, friction is anything up to the torque.
            white[:, i] += np.where(free, self._unsure[:, i], 0.0)
        return drive, slope, white

    def _smoothed(
        self, problem: tuple[FloatArray, FloatArray, FloatArray], part: slice, back: bool
    ) -> tuple[FloatArray, FloatArray, float]:
        drive, slope, white = (x[part.start : part.stop - 1] for x in problem)
        h = self.samples.h[part.start : part.stop - 1]
        v, variance, likelihood = smooth_motion(
            h,
            self.q[part],
            np.ascontiguousarray(self._mobility[part.start : part.stop - 1]),
            drive,
            slope,
            white * self._factor,
            np.array([x.friction**2 for x in self.noise]) * self._factor,
            np.exp(-h / self.noise[0].lasting_s),
            self._position[part],
            self._first[part],
            self.free[part],
            self._counted[part],
            np.array([x.velocity**2 for x in self.noise]),
            back,
        )
        return v, variance, float(likelihood)

    def _weigh(self, problem: tuple[FloatArray, FloatArray, FloatArray]) -> None:
        """Find the factors on the variances of torque at which the positions are likeliest."""
        # A step costs the cube of the joints, and every joint has a search.
        length = 2 * _LONGEST // len(self.noise)
        parts = [slice(k, k + length) for k in range(0, len(self.q), length)]
        part = max(parts, key=lambda part: int(self._counted[part].sum()))
        for i in range(len(self.noise)):
            if not self._counted[part, i].any():
                continue

            def unlikely(x: float, i: int = i) -> float:
                self._factor[i] = np.exp(x)
                return -self._smoothed(problem, part, False)[2]

            found = minimize_scalar(
                unlikely, bounds=_FACTORS, method='bounded', options={'xatol': 0.5}
            )
            self._factor[i] = np.exp(found.x)


def repeats(q: FloatArray) -> FloatArray:
    """Return how often each position is read in a row (N,): together they are one reading."""
    first = np.flatnonzero(np.append(True, np.diff(q) != 0.0))
    count = np.diff(np.append(first, len(q)))
    return np.repeat(count, count).astype(float)
