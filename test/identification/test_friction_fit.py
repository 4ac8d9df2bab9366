# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""From recordings with known friction to its parameters, by both methods."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.identification.friction_fit import FitSettings, fit_friction
from sosml_friction.model.model_folder import read_model
from sosml_friction.model.robot import Robot
from sosml_friction.motion.trajectory_kinds.speed_ladder import speed_ladder
from sosml_friction.observers.friction_estimator import FrictionEstimator
from sosml_friction.observers.log_conditions import DEFAULT_OBSERVERS, configuration_for
from sosml_friction.observers.recipe import gains_for_bandwidth
from sosml_friction.observers.registry import make_observer
from sosml_friction.plain_document import to_plain
from sosml_friction.share import share_directory

REPOSITORY = Path(__file__).resolve().parents[2]
JOINTS = ('shoulder', 'elbow')
TRUTH = {
    'shoulder': {'coulomb': 0.8, 'viscous': 0.35, 'bias': 0.1},
    'elbow': {'coulomb': 0.4, 'viscous': 0.2, 'bias': -0.05},
}
H = 0.002


@pytest.fixture(scope='module')
def robot():
    urdf = (REPOSITORY / 'urdf/exoskeleton.urdf').read_text(encoding='utf-8')
    return Robot(urdf, JOINTS, (0.0054, 0.004))


def recording(robot, motion, duration, noise=0.05, stribeck=0.0, seed=0):
    """
    Return what drives the arm along ``motion`` exactly, with friction and white effort noise.

    The effort is that at the sample's own time, not held: effort_hold is ``mean``.
    """
    t = np.arange(round(duration / H)) * H
    q, v, a = motion(t), motion(t, 1), motion(t, 2)
    tau = np.array([robot.inverse_dynamics(*state) for state in zip(q, v, a, strict=True)])
    for i, p in enumerate(TRUTH.values()):
        level = p['coulomb'] + stribeck * np.exp(-np.abs(v[:, i]) / 0.03)
        tau[:, i] += level * np.sign(v[:, i]) + p['viscous'] * v[:, i] + p['bias']
    tau += noise * np.random.default_rng(seed).normal(size=tau.shape)
    return JointLog(JOINTS, np.round(t * 1e9).astype(np.int64), q, v, tau)


def analyse(robot, log, settings=None, bandwidth=40.0):
    gains = gains_for_bandwidth(bandwidth, [1e-4, 1e-4])
    observers = [make_observer(name, gains[name]) for name in DEFAULT_OBSERVERS]
    estimator = FrictionEstimator(robot, observers, 'mean')
    return fit_friction(log, estimator.batch(log), robot, estimator.observers, settings)


@pytest.fixture(scope='module')
def ladder_log(robot):
    trajectory = speed_ladder(
        {'shoulder': -1.5, 'elbow': 0.2},
        {'shoulder': -1.3, 'elbow': 0.6},
        (0.05, 0.1, 0.2, 0.35, 0.5),
    )
    return recording(robot, trajectory.spline(), trajectory.duration)


@pytest.fixture(scope='module')
def ladder_fit(robot, ladder_log):
    return analyse(robot, ladder_log)


@pytest.fixture(scope='module')
def sine_log(robot):
    """Motion without a single plateau, both joints out of step."""
    t = np.arange(0.0, 20.001, 0.005)
    w = 2 * np.pi * 0.4
    q = np.column_stack(
        [
            -1.3 + 0.3 * np.sin(w * t),
            0.6 + 0.4 * np.sin(w * t + 0.7) * (1 + 0.2 * np.sin(w * t / 5)),
        ]
    )
    return recording(robot, CubicSpline(t, q), 20.0)


def assert_recovers(fit, coulomb, viscous, method):
    for joint, observers in fit.joints.items():
        assert set(observers) == {'first_order', 'sosml'}
        for observer, result in observers.items():
            where = f'{joint} {observer}'
            assert (result.method, result.fit.law) == (method, 'coulomb_viscous'), where
            p, truth = result.fit.parameters, TRUTH[joint]
            assert p['coulomb'].value == pytest.approx(truth['coulomb'], rel=coulomb), where
            assert p['viscous'].value == pytest.approx(truth['viscous'], rel=viscous), where
            assert p['bias'].value == pytest.approx(truth['bias'], abs=0.005), where
            for name, value in truth.items():
                # Four standard errors: once in 10 000 for each of the 12 numbers.
                assert abs(p[name].value - value) < 4.0 * p[name].std_error, f'{where} {name}'


def test_a_ladder_that_reaches_down_is_fitted_by_its_plateaus(ladder_fit):
    """20 plateaus of 0.6 s with 50 mNm of white effort noise: standard error 0.1 mNm and 1 %."""
    fit = ladder_fit
    assert_recovers(fit, coulomb=0.01, viscous=0.05, method='segments')
    for joint in JOINTS:
        for result in fit.joints[joint].values():
            assert sum(not segment.rejected for segment in result.segments) == 20
            assert len(result.levels) == len(result.segments)
        for result in fit.alternatives[joint].values():
            assert result.method == 'samples'
    assert fit.unavailable == {}


def test_transients_give_the_law_through_the_lag_of_each_observer(robot, sine_log):
    """
    FO and SOSML at 40 rad/s lag by 25 ms, a sine of 0.4 Hz reverses every 1.25 s.

    Without the lag filter the Coulomb level would be missed by some 10 %.
    """
    fit = analyse(robot, sine_log, FitSettings(method='samples'))
    assert_recovers(fit, coulomb=0.015, viscous=0.05, method='samples')


def test_motion_without_plateaus_is_fitted_by_its_samples(robot, sine_log):
    assert_recovers(analyse(robot, sine_log), coulomb=0.015, viscous=0.05, method='samples')
    with pytest.raises(DataError, match='shoulder: only 0 separate pieces of steady motion'):
        analyse(robot, sine_log, FitSettings(method='segments'))


def test_both_methods_agree_on_the_same_recording(ladder_fit):
    fit = ladder_fit
    for joint in JOINTS:
        for observer, chosen in fit.joints[joint].items():
            other = fit.alternatives[joint][observer]
            for name in ('coulomb', 'viscous', 'bias'):
                one, two = chosen.fit.parameters[name], other.fit.parameters[name]
                assert abs(one.value - two.value) < 4.0 * (one.std_error + two.std_error)


def test_a_plateau_counts_only_after_the_slowest_observer_has_settled(robot, ladder_log):
    """
    At 8 rad/s SOSML needs 0.75 s to settle to 5 %, a plateau lasts 0.8 s: none is left.

    The default trim would have kept them, with a third of the transient inside.
    """
    slow = analyse(robot, ladder_log, bandwidth=8.0)
    for results in slow.joints.values():
        for result in results.values():
            assert result.method == 'samples'
            assert all(segment.rejected for segment in result.segments)
    with pytest.raises(DataError, match='no joint can be fitted'):
        analyse(robot, ladder_log, FitSettings(method='segments'), bandwidth=8.0)


def test_samples_find_stribeck_where_it_is(robot):
    trajectory = speed_ladder(
        {'shoulder': -1.3, 'elbow': 0.6},
        {'shoulder': -1.3, 'elbow': 0.6},
        (0.02, 0.03, 0.05, 0.1, 0.2, 0.4),
    )
    log = recording(robot, trajectory.spline(), trajectory.duration, noise=0.01, stribeck=0.3)
    for method in ('segments', 'samples'):
        fit = analyse(robot, log, FitSettings(method=method))
        for joint in JOINTS:
            for result in fit.joints[joint].values():
                p = result.fit.parameters
                assert result.fit.law == 'stribeck'
                assert p['stribeck'].value == pytest.approx(0.3, rel=0.1)
                assert p['stribeck_velocity'].value == pytest.approx(0.03, rel=0.1)
                assert p['coulomb'].value == pytest.approx(TRUTH[joint]['coulomb'], rel=0.03)


def test_a_joint_without_effort_is_unavailable_and_the_other_is_what_it_was(
    robot, ladder_log, ladder_fit
):
    whole = ladder_fit
    tau = ladder_log.tau.copy()
    tau[:, 1] = np.nan
    fit = analyse(robot, replace(ladder_log, tau=tau))
    assert fit.unavailable == {'elbow': 'the recording has no effort of it'}
    assert set(fit.joints) == {'shoulder'}
    for observer, result in fit.joints['shoulder'].items():
        assert repr(result.fit) == repr(whole.joints['shoulder'][observer].fit)


def test_a_joint_that_does_not_move_is_unavailable_with_its_reason(robot, ladder_log):
    t = ladder_log.time

    def motion(x, order=0):
        still = np.full(len(x), 0.6) if order == 0 else np.zeros(len(x))
        moved = 0.3 * np.sin(2 * x + order * np.pi / 2) * 2.0**order
        return np.column_stack([moved - (1.3 if order == 0 else 0.0), still])

    fit = analyse(robot, recording(robot, motion, t[-1]))
    assert set(fit.joints) == {'shoulder'}
    assert 'elbow' in fit.unavailable
    assert 'separate pieces' in fit.unavailable['elbow']


def test_holes_gaps_and_jumps_of_time_cost_little(robot, ladder_log):
    """NaN in effort and position, a gap and a step back in time, 2 % of the recording."""
    q, tau, t_ns = ladder_log.q.copy(), ladder_log.tau.copy(), ladder_log.t_ns.copy()
    rng = np.random.default_rng(0)
    q[rng.integers(0, len(q), 20), 1] = np.nan
    tau[rng.integers(0, len(q), 20), 0] = np.nan
    t_ns[6000:] += 700_000_000
    t_ns[12000:] -= 200_000_000
    damaged = replace(ladder_log, q=q, tau=tau, t_ns=t_ns)
    for method in ('segments', 'samples'):
        fit = analyse(robot, damaged, FitSettings(method=method))
        assert_recovers(fit, coulomb=0.015, viscous=0.06, method=method)


def test_recordings_that_cannot_be_fitted_say_why(robot, ladder_log):
    def first(count):
        return replace(
            ladder_log, **{x: getattr(ladder_log, x)[:count] for x in ('t_ns', 'q', 'v', 'tau')}
        )

    with pytest.raises(DataError, match='1 samples at one stamp'):
        analyse(robot, first(1))
    for count in (2, 10, 300):
        with pytest.raises(DataError, match=r'shoulder: .*; elbow: ') as caught:
            analyse(robot, first(count))
        assert '\n' not in str(caught.value)
    silent = replace(ladder_log, tau=np.full_like(ladder_log.tau, np.nan))
    with pytest.raises(DataError, match='elbow: the recording has no effort of it'):
        analyse(robot, silent)
    with pytest.raises(ConfigurationError, match='use one of auto, segments, samples'):
        FitSettings(method='regression')


def test_the_entry_of_a_fit_is_json_without_nan(ladder_fit):
    fit = ladder_fit
    for results in fit.joints.values():
        for result in results.values():
            entry = json.loads(json.dumps(to_plain({'fit': result}), allow_nan=False))['fit']
            assert entry['parameters']['coulomb']['unit'] == 'Nm'
            assert entry['parameters']['stribeck']['value'] is None
            assert entry['segments_used'] == 20


@pytest.fixture(scope='module')
def emps_fits(emps_log):
    log = emps_log
    robot = read_model(share_directory() / 'config/emps').make_robot()
    configuration = configuration_for(log, robot)
    estimator = configuration.make_estimator(robot)
    return fit_friction(log, estimator.batch(log), robot, estimator.observers).joints['slider']


@pytest.mark.parametrize('observer', ['first_order', 'sosml'])
def test_emps_gives_the_published_friction_within_3_percent(emps_fits, observer):
    """Issue 2: 20.3935 N and 203.5034 N s/m from the observers' output, mass as published."""
    result = emps_fits[observer]
    p = result.fit.parameters
    assert p['coulomb'].value == pytest.approx(20.3935, rel=0.03)
    assert p['viscous'].value == pytest.approx(203.5034, rel=0.03)
    assert p['bias'].value == pytest.approx(-3.1648, abs=0.3)
    assert (p['coulomb'].unit, p['viscous'].unit) == ('N', 'N s/m')
    for name, published in (('coulomb', 20.3935), ('viscous', 203.5034)):
        low, high = p[name].interval
        assert low < published < high


@pytest.mark.parametrize('observer', ['first_order', 'sosml'])
def test_emps_is_not_said_to_have_stribeck_friction(emps_fits, observer):
    """data/README: its friction rises concavely with speed; 'Stribeck effect' here is wrong."""
    assert emps_fits[observer].fit.law == 'coulomb_viscous'
    assert 'not_identifiable' in emps_fits[observer].fit.parameters['stribeck'].flags
