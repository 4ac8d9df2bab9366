# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Sizes hold within their intervals, in a fit and in a diagnosis: friction that falls with speed.

A pendulum whose slowest plateau is below, at and above the Stribeck velocity: the further above,
the less its friction at standstill is known; exponential, Gaussian and broad, that is as
1 / (1 + (v / v_s)^2). 20 seeds each in ``make validate``.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from full_runs import FULL
from numba import njit

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.diagnosis.decision.cause import Cause
from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.diagnosis.wording import SIZE_UNKNOWN, describe
from sosml_friction.identification.fitted_model import preferred_observer
from sosml_friction.identification.log_analysis import analyse_log
from sosml_friction.identification.term_parameters import size_text
from sosml_friction.model.parameter import NOT_IDENTIFIABLE, Parameter
from sosml_friction.model.simple_models import pendulum_model
from sosml_friction.motion.trajectory_kinds.speed_ladder import speed_ladder

SEEDS = 20 if FULL else 1
#: Slowest speeds [rad/s] with an exponent, NaN for the broad knee: in the suite, where the size is
#: known and where not.
BROAD = np.nan
CASES = [(slowest, alpha) for alpha in (1.0, 2.0, BROAD) for slowest in (0.01, 0.03, 0.05, 0.08)]
CASES = CASES if SEEDS > 1 else [(0.03, 1.0), (0.08, 1.0)]
MASS, LENGTH, ARMATURE = 2.0, 0.25, 0.01
COULOMB, VISCOUS, STRIBECK, STRIBECK_VELOCITY = 0.5, 0.3, 0.25, 0.05
PERIOD, SUBSTEPS, BUILD_UP = 2e-3, 10, 1e-4
QUANTUM, NOISE = 2.0 * np.pi / 65536, 0.05


@njit
def swing(reference, speed, acceleration, exponent):
    """Return position and command of a pendulum that is led along a reference at 500 Hz."""
    position, command = np.empty(len(reference)), np.empty(len(reference))
    h, inertia, weight = PERIOD / SUBSTEPS, MASS * LENGTH**2 + ARMATURE, 9.81 * MASS * LENGTH
    q, v, z = reference[0], 0.0, 0.0
    for k in range(len(reference)):
        position[k] = q
        tau = inertia * acceleration[k] + weight * np.sin(reference[k]) + VISCOUS * speed[k]
        tau += COULOMB * np.tanh(speed[k] / 0.005)
        tau += 200.0 * (reference[k] - q) + 10.0 * (speed[k] - v)
        command[k] = tau
        for _ in range(SUBSTEPS):
            x = abs(v) / STRIBECK_VELOCITY
            left = 1.0 / (1.0 + x * x) if np.isnan(exponent) else np.exp(-(x**exponent))
            level = COULOMB + STRIBECK * left
            z = min(max(z + v * h / BUILD_UP * (1.0 - z * np.sign(v)), -1.0), 1.0)
            v += h * (tau - weight * np.sin(q) - level * z - VISCOUS * v) / inertia
            q += h * v
    return position, command


@lru_cache(maxsize=4)
def motion(slowest, exponent):
    speeds = [slowest * factor for factor in (1.0, 1.6, 2.5, 4.0)] + [0.4, 0.7]
    plan = speed_ladder({'joint': 0.3}, {'joint': 0.3}, speeds, 1.5, 0.25)
    t, spline = np.arange(0.0, plan.duration, PERIOD), plan.spline()
    return t, *swing(*(spline(t, k)[:, 0] for k in range(3)), exponent)


def record(slowest, exponent, seed):
    """Return what a 16-bit encoder and a torque sensor of 50 mNm noise say of the pendulum."""
    t, q, command = motion(slowest, exponent)
    rng = np.random.default_rng([77, int(1e3 * slowest), seed])
    tau = 0.5 * (command + np.append(command[:1], command[:-1]))
    tau = tau + NOISE * rng.standard_normal(len(t))
    q = q + 0.3 * QUANTUM * rng.standard_normal(len(t)) + rng.uniform(0.0, QUANTUM)
    q = QUANTUM * np.round(q / QUANTUM)
    v = np.gradient(q, PERIOD)
    return JointLog(
        ('joint',), np.rint(1e9 * t).astype(np.int64), q[:, None], v[:, None], tau[:, None]
    )


@pytest.mark.parametrize(('slowest', 'exponent'), CASES)
def test_fit_and_diagnosis_hold_the_friction_at_standstill_and_agree(slowest, exponent):
    """In 88 % of the seeds or more; wide where the data begin above the Stribeck velocity."""
    model = pendulum_model(MASS, LENGTH, 0.0, ARMATURE)
    held, agree, flagged = {'fit': 0, 'diagnosis': 0}, 0, 0
    for seed in range(1, SEEDS + 1):
        log = record(slowest, exponent, seed)
        fits = analyse_log(log, model).fit.joints['joint']
        of_fit = fits[preferred_observer(fits)].fit.parameters['stribeck']
        causes = diagnose([log], model).causes
        (of_diagnosis,) = (c.parameters['stribeck'] for c in causes if c.effect == 'stribeck')
        ends = [p.interval for p in (of_fit, of_diagnosis)]
        for name, (low, high) in zip(held, ends, strict=True):
            held[name] += low <= STRIBECK <= high
        agree += ends[0][0] <= ends[1][1] and ends[1][0] <= ends[0][1]
        flagged += NOT_IDENTIFIABLE in of_diagnosis.flags
        print(
            f'{slowest} {exponent} {seed}: {np.round(ends, 3).tolist()} {size_text(of_diagnosis)}'
        )
    print(
        f'slowest {slowest} rad/s, exponent {exponent}: held {held}, agree {agree}, '
        f'open {flagged} of {SEEDS}'
    )
    assert min(held.values()) >= 0.88 * SEEDS
    assert agree >= 0.88 * SEEDS
    if slowest < STRIBECK_VELOCITY and np.isfinite(exponent):
        assert flagged == 0


def test_a_size_that_is_not_known_is_told_in_words_and_no_number():
    gap = {'gap': Parameter(2e-3, 'rad', 1e-5), 'stiffness': Parameter(1e4, 'Nm/rad')}
    cause = Cause('backlash', 'elbow', gap, {})
    assert describe(cause) == f'elbow: backlash ({SIZE_UNKNOWN})'
    document = cause.to_dict()
    assert document['size_known'] is False
    assert document['parameters']['gap']['std_error'] is None
    known = replace(cause, effect='spring')
    assert known.to_dict()['size_known']
    assert '0.002000 ± 0.000020 rad' in describe(known)


def test_a_range_is_told_in_the_place_of_an_error_where_sizes_are_known_together_only():
    wide = Parameter(
        0.3, 'Nm', 0.1, (0.1, np.inf), (NOT_IDENTIFIABLE,), 'the data begin later', 'record T3'
    )
    told = describe(Cause('stribeck', 'elbow', {'stribeck': wide}, {}))
    assert 'somewhere from 0.1 up' in told
    assert 'known together only, as the data begin later' in told
    assert '±' not in told
