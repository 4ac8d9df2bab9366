# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The inverse-model fit: published numbers, signals it must recover, and what it must not say."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binom

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.identification.inverse_model import fit_inverse_model
from sosml_friction.model.model_folder import read_model
from sosml_friction.plain_document import to_plain
from sosml_friction.share import share_directory
from sosml_friction.study.plant import study_robot

MASS, VISCOUS, COULOMB, BIAS = 80.0, 150.0, 15.0, -2.0


def slider():
    return read_model(share_directory() / 'config/emps').make_robot()


def slider_log(viscous=(VISCOUS, VISCOUS), bias=BIAS, duration=24.0, noise=0.0, seed=0):
    """Return a slider of another mass than the model's, moved by two sines, effort exact."""
    t = np.arange(0.0, duration, 0.004)
    q, v, a = np.zeros((3, len(t)))
    for size, w in ((0.05, 1.3), (0.004, 9.0)):
        q += size * np.sin(w * t)
        v += size * w * np.cos(w * t)
        a -= size * w**2 * np.sin(w * t)
    way = np.where(v > 0.0, *viscous)
    tau = MASS * a + way * v + COULOMB * np.sign(v) + bias
    tau += np.random.default_rng(seed).normal(0.0, noise, len(t))
    t_ns = np.rint(t * 1e9).astype(np.int64)
    columns = (q[:, None], np.full((len(t), 1), np.nan), tau[:, None])
    return JointLog(('slider',), t_ns, *columns)


@pytest.fixture(scope='module')
def emps(emps_log):
    return fit_inverse_model(emps_log, slider()).joints['slider']


def test_emps_gives_the_published_numbers(emps):
    """data/README: 95.1089 kg, 203.5034 N s/m, 20.3935 N, -3.1648 N; 4.0834 %, 2.1843 N."""
    fit = emps['symmetric']
    for name, unit, published, tolerance in (
        ('inertia', 'kg', 95.109, 0.1),
        ('viscous', 'N s/m', 203.5, 0.5),
        ('coulomb', 'N', 20.39, 0.05),
        ('bias', 'N', -3.165, 0.02),
    ):
        parameter = fit.parameters[name]
        assert parameter.value == pytest.approx(published, abs=tolerance)
        assert parameter.unit == unit
        assert parameter.interval[0] < published < parameter.interval[1]
    assert fit.relative_error == pytest.approx(4.08, abs=0.05)
    assert fit.residual_std == pytest.approx(2.1843, abs=0.02)


def test_emps_by_direction_gives_the_published_numbers(emps):
    """data/README: 95.154 kg, 166.706 and 240.424 N s/m, 20.144 and 20.628 N; 3.1117 %."""
    fit = emps['asymmetric']
    for name, published, tolerance in (
        ('inertia', 95.154, 0.1),
        ('viscous_positive', 166.7, 0.5),
        ('viscous_negative', 240.4, 0.5),
        ('coulomb_positive', 20.144, 0.05),
        ('coulomb_negative', 20.628, 0.05),
    ):
        assert fit.parameters[name].value == pytest.approx(published, abs=tolerance)
    assert fit.relative_error == pytest.approx(3.11, abs=0.06)


def test_exact_signals_give_back_their_parameters():
    """
    Whatever the model says of the mass.

    Within 1 %: filtering turns the corners of the sign, which the filtered regressors do not have.
    """
    fits = fit_inverse_model(slider_log(), slider())
    p = fits.joints['slider']['symmetric'].parameters
    assert p['inertia'].value == pytest.approx(MASS, rel=0.01)
    assert p['viscous'].value == pytest.approx(VISCOUS, rel=0.01)
    assert p['coulomb'].value == pytest.approx(COULOMB, rel=0.01)
    assert p['bias'].value == pytest.approx(BIAS, rel=0.01)


def test_friction_that_differs_by_direction_is_seen_by_the_asymmetric_form_only():
    fits = fit_inverse_model(slider_log((100.0, 200.0)), slider()).joints['slider']
    p = fits['asymmetric'].parameters
    assert p['viscous_positive'].value == pytest.approx(100.0, rel=0.02)
    assert p['viscous_negative'].value == pytest.approx(200.0, rel=0.02)
    # The bias is one of the Coulomb terms' difference: f(v > 0) = C + bias, f(v < 0) = -C + bias.
    assert p['coulomb_positive'].value == pytest.approx(COULOMB + BIAS, rel=0.02)
    assert p['coulomb_negative'].value == pytest.approx(COULOMB - BIAS, rel=0.02)
    assert fits['asymmetric'].residual_std < 0.2 * fits['symmetric'].residual_std


def test_intervals_cover_the_truth_as_often_as_they_say():
    """In as many of 60 seeds as a coverage of 90 % gives but in 1 of 100 such campaigns."""
    robot, seeds = slider(), 60
    truth = {'inertia': MASS, 'viscous': VISCOUS, 'coulomb': COULOMB, 'bias': BIAS}
    inside = dict.fromkeys(truth, 0)
    for seed in range(seeds):
        log = slider_log(noise=30.0, seed=seed, duration=16.0)
        p = fit_inverse_model(log, robot).joints['slider']['symmetric'].parameters
        for name, value in truth.items():
            inside[name] += p[name].interval[0] <= value <= p[name].interval[1]
    assert min(inside.values()) >= binom.ppf(0.01, seeds, 0.90), inside


def test_two_joints_get_factors_on_inertia_and_gravity():
    """Effort of an arm of 1.1 times the inertia and 0.9 times the gravity, friction added."""
    robot = study_robot()
    t = np.arange(0.0, 20.0, 0.004)
    phase = np.array([0.0, 1.0])
    w = np.array([2.1, 3.3])
    q = np.array([-0.6, 0.9]) + 0.5 * np.sin(np.outer(t, w) + phase)
    v = 0.5 * w * np.cos(np.outer(t, w) + phase)
    a = -0.5 * w**2 * np.sin(np.outer(t, w) + phase)
    g = np.array([robot.gravity(x) for x in q])
    rigid = np.array([robot.inverse_dynamics(*state) for state in zip(q, v, a, strict=True)])
    tau = 1.1 * (rigid - g) + 0.9 * g + 0.3 * v + 0.7 * np.sign(v)
    log = JointLog(robot.names, np.rint(t * 1e9).astype(np.int64), q, v, tau)
    fits = fit_inverse_model(log, robot)
    for name in robot.names:
        p = fits.joints[name]['symmetric'].parameters
        assert p['inertia_scale'].value == pytest.approx(1.1, abs=0.01)
        assert p['gravity_scale'].value == pytest.approx(0.9, abs=0.01)
        assert p['viscous'].value == pytest.approx(0.3, abs=0.01)
        assert p['coulomb'].value == pytest.approx(0.7, abs=0.01)
        assert p['inertia_scale'].unit == '1'


def test_a_hole_in_the_recording_changes_nothing_but_the_number_of_samples():
    log = slider_log()
    keep = (log.time < 9.0) | (log.time > 9.5)
    holed = replace(log, t_ns=log.t_ns[keep], q=log.q[keep], v=log.v[keep], tau=log.tau[keep])
    whole, pieces = (
        fit_inverse_model(x, slider()).joints['slider']['symmetric'] for x in (log, holed)
    )
    assert pieces.samples < whole.samples
    assert pieces.parameters['inertia'].value == pytest.approx(
        whole.parameters['inertia'].value, rel=2e-3
    )


def test_one_direction_leaves_coulomb_and_bias_not_identifiable():
    """Only their sum is in the effort; what else is in it is still told."""
    t = np.arange(0.0, 16.0, 0.004)
    v = 0.1 + 0.05 * np.sin(5.0 * t)
    q, a = 0.1 * t - 0.01 * np.cos(5.0 * t), 0.25 * np.cos(5.0 * t)
    tau = MASS * a + VISCOUS * v + COULOMB + BIAS
    log = JointLog(
        ('slider',), np.rint(t * 1e9).astype(np.int64), q[:, None], v[:, None], tau[:, None]
    )
    p = fit_inverse_model(log, slider()).joints['slider']['symmetric'].parameters
    for name in ('coulomb', 'bias'):
        assert np.isnan(p[name].value)
        assert p[name].flags == ('not_identifiable',)
    assert p['inertia'].value == pytest.approx(MASS, rel=1e-2)
    assert p['viscous'].value == pytest.approx(VISCOUS, rel=1e-2)


def test_steady_speed_leaves_inertia_not_identifiable():
    """The acceleration at the turns is a fraction of the noise: a range, no number."""
    t = np.arange(0.0, 16.0, 0.004)
    v = 1e-3 * np.cos(0.4 * t)
    q, a = 1e-3 / 0.4 * np.sin(0.4 * t), -4e-4 * np.sin(0.4 * t)
    tau = MASS * a + COULOMB * np.sign(v)
    tau += np.random.default_rng(1).normal(0.0, 30.0, len(t))
    log = JointLog(
        ('slider',), np.rint(t * 1e9).astype(np.int64), q[:, None], v[:, None], tau[:, None]
    )
    inertia = fit_inverse_model(log, slider()).joints['slider']['symmetric'].parameters['inertia']
    assert inertia.flags == ('not_identifiable',)
    assert np.isnan(inertia.value)
    assert inertia.interval[0] == 0.0 < MASS < inertia.interval[1]


def test_what_cannot_be_fitted_is_said():
    log, robot = slider_log(), slider()
    silent = replace(log, tau=np.full_like(log.tau, np.nan))
    still = replace(log, q=np.full_like(log.q, 0.1))
    short = replace(log, **{k: getattr(log, k)[:10] for k in ('t_ns', 'q', 'v', 'tau')})
    one_stamp = replace(log, t_ns=np.full_like(log.t_ns, 5))
    for case, reason in (
        (silent, 'has no effort of it'),
        (still, 'it did not move'),
        (short, 'record longer'),
        (one_stamp, 'record longer'),
    ):
        fits = fit_inverse_model(case, robot)
        assert fits.joints == {}
        assert reason in fits.unavailable['slider']


def test_the_entry_is_json_without_nan():
    fits = fit_inverse_model(slider_log(noise=1.0), slider())
    entry = json.loads(json.dumps(to_plain({'fits': fits}), allow_nan=False))['fits']
    assert set(entry['joints']['slider']) == {'symmetric', 'asymmetric'}
    assert entry['joints']['slider']['symmetric']['parameters']['inertia']['unit'] == 'kg'
