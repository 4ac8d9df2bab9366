# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The conditions of the paper's study: what the observers are given of a run."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.model.robot import Robot
from sosml_friction.observers.momentum_sampler import MomentumSampler
from sosml_friction.observers.momentum_samples import MomentumSamples
from sosml_friction.observers.observer import Observer
from sosml_friction.study.mismatched_robot import MismatchedRobot
from sosml_friction.study.plant import ARMATURE, JOINTS, StudyRun, study_urdf

CONDITIONS = ('nominal', 'noise', 'mismatch')
#: Errors of the model in ``mismatch``: scales of M, one run each, and offset of g [Nm].
INERTIA_SCALES = (1.1, 0.9)
GRAVITY_OFFSET = (0.10, 0.05)
#: Noise of the encoder before it is quantised, standard deviation in steps.
_NOISE_STEPS = 0.5


@dataclass(frozen=True)
class Observation:
    """
    Hold what the observers are driven by, and what they should say.

    ``time`` (N,) [s], ``velocity`` (N, n) and ``friction`` (N, n) are the truth at the end of each
    interval of ``samples``; ``floor`` (N, n) is what an ideal observer with the same model would
    report minus the truth: zero unless the model is wrong.
    """

    time: FloatArray
    velocity: FloatArray
    friction: FloatArray
    floor: FloatArray
    p_start: FloatArray
    samples: MomentumSamples

    def estimate(self, observer: Observer) -> FloatArray:
        """Return tau_f (N, n) [Nm] of an observer that starts at the beginning."""
        observer.start(self.p_start)
        return -observer.run(self.samples)


def encoder_step(bits: int) -> float:
    """Return the resolution [rad] of an encoder of ``bits`` per turn."""
    return float(2.0 * np.pi / 2**bits)


def encoder_noise(bits: int) -> float:
    """Return the standard deviation [rad] of a position: noise of half a step, and rounding."""
    return encoder_step(bits) * float(np.sqrt(_NOISE_STEPS**2 + 1.0 / 12.0))


def read_by_encoder(log: JointLog, bits: int, seed: int) -> JointLog:
    """Return the log as encoders report it: noise, quantisation, no velocity."""
    step = encoder_step(bits)
    noise = np.random.default_rng(seed).normal(0.0, _NOISE_STEPS * step, log.q.shape)
    q = np.round((log.q + noise) / step) * step
    return replace(log, q=q, v=np.full(log.v.shape, np.nan))


def observe(
    run: StudyRun, robot: Robot, condition: str, bits: int, seeds: Sequence[int]
) -> list[Observation]:
    """
    Return the observations of a condition.

    * ``nominal``: exact position and velocity; one.
    * ``noise``: position with noise of half a step of the encoder, then quantised; velocity is its
      backward difference. One for each seed.
    * ``mismatch``: exact signals, but a model with inertia x1.1 and x0.9 and gravity
      +(0.10, 0.05) Nm (:class:`~sosml_friction.study.mismatched_robot.MismatchedRobot`);
      two.
    """
    if condition == 'noise':
        return [_observe(run, robot, read_by_encoder(run.log, bits, seed)) for seed in seeds]
    if condition == 'nominal':
        return [_observe(run, robot, run.log)]
    return [
        _observe(run, MismatchedRobot(study_urdf(), JOINTS, ARMATURE, s, GRAVITY_OFFSET), run.log)
        for s in INERTIA_SCALES
    ]


def _observe(run: StudyRun, robot: Robot, log: JointLog) -> Observation:
    source = 'message' if np.isfinite(log.v).all() else 'position_difference'
    (stretch,) = MomentumSampler(robot, 'start', source).stretches(log)
    rows, truth = stretch.rows, run.log
    floor = np.zeros((len(rows), robot.n))
    if isinstance(robot, MismatchedRobot):
        floor = robot.friction_error(truth.q[rows], truth.tau[rows], run.friction[rows])
    driven = stretch.p_start, stretch.samples
    return Observation(truth.time[rows], truth.v[rows], run.friction[rows], floor, *driven)
