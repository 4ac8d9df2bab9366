# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Robots and recordings with exactly known friction."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.model.robot import Robot
from sosml_friction.observers.friction_estimator import FrictionEstimator
from sosml_friction.observers.kinds.first_order import FirstOrder
from sosml_friction.observers.momentum_samples import MomentumSamples
from sosml_friction.observers.observer import Observer
from sosml_friction.study.motion import reversal, slow
from sosml_friction.study.plant import simulate, study_robot

REPOSITORY = Path(__file__).resolve().parents[2]
ENCODER_STEP = 2.0 * np.pi / 65536
#: Integration step of runs [s]: coarser than the study takes, for tests that are short.
PLANT_STEP = 200e-6


@pytest.fixture(scope='session')
def two_joints() -> Robot:
    """Return the arm of the observer study, section 0."""
    return study_robot()


@pytest.fixture(scope='session')
def slider() -> Robot:
    """One axis of 95.1089 kg without gravity: p = m v."""
    urdf = (REPOSITORY / 'urdf/emps.urdf').read_text(encoding='utf-8')
    return Robot(urdf, ['slider'], [0.0])


@pytest.fixture(scope='session')
def drive() -> Callable[..., np.ndarray]:
    """
    Start an observer and run it over momenta, (N, n) or (N,) for one joint.

    Row 0 of ``p`` is the start; ``forcing`` and ``h`` (or one number) are of the intervals that
    end at the others. M is 1 and the integral of p that of the trapezoid, unless given.
    """

    def run(observer, p, forcing, h, integral=None, inertia=None):
        column = np.ndim(p) == 1
        p, forcing = (x[:, None] if column else x for x in (np.asarray(p), np.asarray(forcing)))
        count, n = p.shape
        h = np.broadcast_to(np.asarray(h, dtype=float), count)[1:].copy()
        if integral is None:
            integral = 0.5 * h[:, None] * (p[1:] + p[:-1])
        elif column:
            integral = integral[1:, None]
        else:
            integral = integral[1:]
        if inertia is None:
            inertia = np.broadcast_to(np.eye(n), (count - 1, n, n)).copy()
        observer.start(p[0])
        estimate = observer.run(MomentumSamples(h, p[1:], integral, forcing[1:], inertia))
        return estimate[:, 0] if column else estimate

    return run


@pytest.fixture(scope='session')
def held_momentum() -> Callable[..., np.ndarray]:
    """Give the exact momentum, p_0 = 0, under disturbance and forcing held over intervals."""

    def integrate(disturbance, forcing, h):
        steps = (np.asarray(disturbance) + forcing)[1:] * h
        return np.concatenate([np.zeros_like(steps[:1]), np.cumsum(steps, axis=0)])

    return integrate


@pytest.fixture(scope='session')
def with_encoder() -> Callable[[JointLog, int], JointLog]:
    """
    Measure a recording at 1 kHz with the study's encoder.

    Noise of half a step of 16 bit, then quantisation; the velocity is the backward difference.
    """

    def measure(log: JointLog, seed: int) -> JointLog:
        noise = np.random.default_rng(seed).normal(scale=0.5, size=log.q.shape)
        q = ENCODER_STEP * np.round(log.q / ENCODER_STEP + noise)
        v = np.zeros_like(q)
        v[1:] = np.diff(q, axis=0) / 1e-3
        return replace(log, q=q, v=v)

    return measure


@pytest.fixture(scope='session')
def encoder_noise() -> float:
    """Return the standard deviation of that encoder [rad]."""
    return ENCODER_STEP * np.sqrt(0.25 + 1.0 / 12.0)


@pytest.fixture(scope='session')
def reversal_run(two_joints: Robot) -> tuple[JointLog, np.ndarray]:
    """Return exact signals of the study's reversal, six seconds of it, and the friction."""
    run = simulate(two_joints, reversal, 6.0, PLANT_STEP)
    return run.log, run.friction


@pytest.fixture(scope='session')
def slow_run(two_joints: Robot) -> tuple[JointLog, np.ndarray]:
    """Return exact signals of the study's slow motion, to just before rest, and the friction."""
    run = simulate(two_joints, slow, 11.9, PLANT_STEP)
    return run.log, run.friction


@pytest.fixture(scope='session')
def triple_integrator() -> Callable[[float, float], tuple[np.ndarray, np.ndarray]]:
    """Give F and Q of X' = p, p' = tau, tau' = w over h by Van Loan's matrix exponential."""

    def discrete(h, q):
        chain = np.diag([1.0, 1.0], 1)
        block = np.block([[-chain, np.diag([0.0, 0.0, q])], [np.zeros((3, 3)), chain.T]])
        e = expm(block * h)
        return e[3:, 3:].T, e[3:, 3:].T @ e[:3, 3:]

    return discrete


@pytest.fixture(scope='session')
def crossing_pair() -> tuple[np.ndarray, MomentumSamples]:
    """
    Two coupled joints that reverse under noise and steps of friction: p at the start, 400 samples.

    Nothing is constant: inertia, sampling interval, forcing.
    """
    rng = np.random.default_rng(8)
    count = 401
    h = rng.uniform(5e-4, 2e-3, size=count)
    t = np.cumsum(h)
    M = np.empty((count, 2, 2))
    M[:, 0, 0] = 0.37 + 0.05 * np.cos(3.0 * t)
    M[:, 1, 1] = 0.06
    M[:, 0, 1] = M[:, 1, 0] = 0.08 + 0.02 * np.sin(5.0 * t)
    v = np.stack([0.3 * np.cos(15.0 * t), 0.4 * np.sin(22.0 * t)], axis=1)
    p = np.einsum('kij,kj->ki', M, v)
    force = np.diff(p, axis=0) / h[1:, None]
    forcing = force + np.sign(v[1:]) * [0.8, 0.4]
    reading = 5e-5 * rng.normal(size=(count, 2))
    noise = np.diff(np.einsum('kij,kj->ki', M, reading), axis=0)
    integral = 0.5 * h[1:, None] * (p[1:] + p[:-1]) + noise
    return p[0], MomentumSamples(h[1:], p[1:], integral, forcing, M[1:])


@pytest.fixture(scope='session')
def both_motions(
    two_joints, reversal_run, slow_run, with_encoder
) -> Callable[[Callable[[], Observer]], dict[str, np.ndarray]]:
    """
    Score an observer on the study's two motions, clean and with the encoder at seeds 11, 12, 13.

    RMSE of joint 1 after half a second [mNm]: clean first, then per seed, (4,), for slow (11.9 s)
    and reversal (6 s).
    """
    runs = {}
    for name, (log, truth) in {'slow': slow_run, 'reversal': reversal_run}.items():
        logs = [log] + [with_encoder(log, seed) for seed in (11, 12, 13)]
        estimator = FrictionEstimator(two_joints, [FirstOrder({'cutoff': [1.0, 1.0]})])
        runs[name] = (truth, [estimator.stretches(one) for one in logs])

    def score(make):
        result = {}
        for name, (truth, recordings) in runs.items():
            result[name] = []
            for (stretch,) in recordings:
                observer = make()
                observer.start(stretch.p_start)
                error = -observer.run(stretch.samples) - truth[stretch.rows]
                result[name].append(1e3 * np.sqrt(np.mean(error[500:, 0] ** 2)))
        return {name: np.array(values) for name, values in result.items()}

    return score
