# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A wrong report of the torque beside friction that the model does not state."""

from __future__ import annotations

import numpy as np
import pytest
from full_runs import in_full

import sosml_friction as sf
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.regression.report_slopes import ReportSlopes
from sosml_friction.share import share_directory

MASS, COULOMB, VISCOUS = 95.11, 19.8, 203.5


def axis(speeds: list[float], reported: float, seed: int) -> JointLog:
    """
    Return a linear axis to and fro at speeds [m/s], its force reported in proportion.

    m a + C sign(v) + B v, of exact derivatives, with 0.5 N of noise; position in steps of 1 um.
    """
    step, period, ramp = 1e-4, 4.0, 1000
    t = np.arange(0.0, 40.0, step)
    speed = np.array(speeds)[(t // period).astype(int) % len(speeds)]
    window = np.hanning(ramp) / np.hanning(ramp).sum()
    v = np.convolve(speed * np.sign(np.sin(2.0 * np.pi * t / period)), window, 'same')
    q = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * step)])
    force = MASS * np.gradient(v, step) + COULOMB * np.tanh(v / 1e-4) + VISCOUS * v
    t, q, force = t[::10], q[::10], force[::10]
    force = reported * force + np.random.default_rng(seed).normal(0.0, 0.5, len(t))
    unknown = np.full((len(t), 1), np.nan)
    q = 1e-6 * np.round(q / 1e-6)[:, None]
    return JointLog(('slider',), np.round(1e9 * t).astype(np.int64), q, unknown, force[:, None])


@pytest.mark.parametrize(
    ('speeds', 'reported'),
    [in_full([0.1, 0.05, 0.02], 1.1), ([0.2, 0.1], 0.9)],
)
def test_a_wrong_torque_constant_is_told_where_no_friction_is_stated(speeds, reported):
    """
    Friction is refitted as it is reported; a simulation by the torque has the torque's friction.

    With the reported one, 10 % off, the simulation got worse, and the cause was taken back.
    """
    model = sf.Model.read(share_directory() / 'config' / 'emps')
    found = sf.diagnose(axis(speeds, reported, 5), model)
    named = {cause.effect for cause in found.causes}
    rivals = {rival for cause in found.causes for rival in cause.rivals}
    assert 'effort_scale' in named | rivals
    assert named | rivals <= {'effort_scale', 'inertia'}


@pytest.mark.parametrize('reported', [in_full(0.6), in_full(1.1), 1.4])
def test_the_friction_that_is_refitted_beside_a_wrong_report_is_that_of_the_torque(reported):
    """Two percent: what the mass may be off by, as the report is told from it alone."""
    model = sf.Model.read(share_directory() / 'config' / 'emps')
    # By itself the report is as well told as an inertia.
    found = sf.diagnose(axis([0.1, 0.05, 0.02], reported, 6), model, without='inertia')
    assert [cause.effect for cause in found.causes] == ['effort_scale']
    assert found.found.diagnosis.refit['slider coulomb'] == pytest.approx(COULOMB, rel=0.02)
    assert found.found.diagnosis.refit['slider viscous'] == pytest.approx(VISCOUS, rel=0.02)


@pytest.mark.parametrize('variance', [0.0, -1e-12])
def test_errors_of_what_the_data_do_not_tell_apart_stay_what_they_are(variance):
    """As of a rotor and its body's inertia: the variance of a pseudo-inverse may be rounding."""
    plain = ReportSlopes(*(np.zeros(shape) for shape in (2, (2, 2), 2, (2, 2), 2)))
    errors = plain.errors(np.ones(2), np.array([2.0, 3.0]), np.diag([variance, 4.0]))
    np.testing.assert_array_equal(errors, [2.0, 3.0])
