# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""From joint states to friction: sign, accuracy, and every kind of bad sample."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.model.robot import Robot
from sosml_friction.observers.friction_estimator import FrictionEstimator
from sosml_friction.observers.registry import make_observer

H_NS = 2_000_000


def observers(n, cutoff=50.0, s1=5.0):
    return [
        make_observer('first_order', {'cutoff': [cutoff] * n}),
        make_observer(
            'sosml',
            {
                'sliding': [s1] * n,
                'sliding_root': [1.6 * s1**0.5] * n,
                'linear': [cutoff**2] * n,
                'linear_damping': [cutoff] * n,
            },
        ),
    ]


def fast(n, rate):
    """Return observers whose SOSML slides: S1 above the friction's largest rate."""
    first, _ = observers(n, 300.0)
    gains = {'sliding': rate, 'sliding_root': 1.6 * np.sqrt(rate)}
    zero = {'linear': [0.0] * n, 'linear_damping': [0.0] * n}
    return [first, make_observer('sosml', {**gains, **zero})]


def random_log(n=2, count=60, seed=0, names=('shoulder', 'elbow')):
    rng = np.random.default_rng(seed)
    walk = np.cumsum(rng.normal(scale=0.02, size=(3, count, n)), axis=1)
    return JointLog(names, np.arange(count, dtype=np.int64) * H_NS, *walk)


@pytest.mark.parametrize(
    ('run', 'first_order', 'sosml'), [('slow_run', 4.3, 0.6), ('reversal_run', 65.0, 12.0)]
)
def test_exact_signals_reach_the_accuracy_of_the_study(
    request, two_joints, run, first_order, sosml
):
    """
    observer_study.md section 3, nominal: FO (c0 300) 4.0 / 60.3 mNm, SOSML 0.6 / 11.3 mNm.

    The truth has the sign of the plant's own friction, so this is the test of the sign as well.
    """
    log, truth = request.getfixturevalue(run)
    rate = 1.5 * np.abs(np.diff(truth, axis=0)).max(0) * 1e3
    estimates = FrictionEstimator(two_joints, fast(2, rate)).batch(log)
    late = log.time > 0.5
    for name, bound in (('first_order', first_order), ('sosml', sosml)):
        rmse = 1e3 * np.sqrt(np.mean((estimates[name] - truth)[late] ** 2, axis=0))
        assert rmse[0] <= bound, name
        assert rmse[1] <= bound, name
        moving = late & (np.abs(log.v[:, 0]) > 0.03)
        agree = np.sign(estimates[name][moving, 0]) == np.sign(log.v[moving, 0])
        assert agree.mean() > 0.95


@pytest.mark.parametrize(('hold', 'end'), [('start', 0.0), ('mean', 0.5), ('end', 1.0)])
def test_the_forcing_is_the_held_effort_plus_the_trapezoid_of_the_drift(two_joints, hold, end):
    """FO with c0 h = 40 has no memory: tau_f = tau + (C^T q' - g) - p' over the last interval."""
    log = random_log()
    estimates = FrictionEstimator(two_joints, observers(2, 2e4)[:1], hold).batch(log)
    terms = [two_joints.momentum_terms(q, v)[:2] for q, v in zip(log.q, log.v, strict=True)]
    p, drift = np.array(terms).transpose(1, 0, 2)
    tau = (1.0 - end) * log.tau[:-1] + end * log.tau[1:]
    expected = tau + 0.5 * (drift[1:] + drift[:-1]) - np.diff(p, axis=0) / (H_NS * 1e-9)
    np.testing.assert_allclose(estimates['first_order'][1:], expected, rtol=1e-10, atol=1e-10)


def test_friction_of_one_joint_does_not_leak_into_the_other(reversal_run, two_joints):
    """The inertia couples the joints (M12 / M22 is near 2): remove joint 1's effort by 0.3 Nm."""
    log, _ = reversal_run
    pushed = replace(log, tau=log.tau + np.array([0.3, 0.0]))
    rate = [500.0, 500.0]
    plain = FrictionEstimator(two_joints, fast(2, rate)).batch(log)
    other = FrictionEstimator(two_joints, fast(2, rate)).batch(pushed)
    for name in plain:
        change = (other[name] - plain[name])[500:]
        np.testing.assert_allclose(change[:, 0], 0.3, atol=1e-6)
        np.testing.assert_allclose(change[:, 1], 0.0, atol=1e-9)


def test_any_number_of_joints_can_be_estimated():
    """Five pendulums on parallel axes, driven by known efforts: friction is what was added."""
    parts = ['<robot name="comb"><link name="base"/>']
    names = [f'j{k}' for k in range(5)]
    for name in names:
        parts.append(
            f'<link name="{name}_link"><inertial><origin xyz="0 0 0"/><mass value="1"/>'
            '<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>'
            f'<joint name="{name}" type="revolute"><parent link="base"/>'
            f'<child link="{name}_link"/><axis xyz="0 0 1"/>'
            '<limit lower="-9" upper="9" effort="9" velocity="9"/></joint>'
        )
    robot = Robot(''.join(parts) + '</robot>', names, [0.1] * 5)
    friction = np.array([0.1, 0.2, 0.3, 0.4, 0.5])
    t = np.arange(2000) * 2e-3
    # M = 0.2: v = 1 + t by a net effort of 0.2; the rest of tau is friction.
    v = np.repeat(1.0 + t[:, None], 5, axis=1)
    q = np.repeat((t + t**2 / 2)[:, None], 5, axis=1)
    tau = np.broadcast_to(0.2 + friction, v.shape)
    log = JointLog(tuple(names), np.arange(2000, dtype=np.int64) * H_NS, q, v, np.array(tau))
    for estimate in FrictionEstimator(robot, observers(5)).batch(log).values():
        np.testing.assert_allclose(estimate[-1], friction, atol=1e-6)


def test_batch_is_update_bit_for_bit_and_the_callers_arrays_may_be_reused(two_joints):
    log = random_log()
    batch = FrictionEstimator(two_joints, observers(2)).batch(log)
    live = FrictionEstimator(two_joints, observers(2))
    q, v, tau = np.empty(2), np.empty(2), np.empty(2)
    for k in range(len(log)):
        q[:], v[:], tau[:] = log.q[k], log.v[k], log.tau[k]
        result = live.update(int(log.t_ns[k]), q, v, tau)
        q[:], v[:], tau[:] = 1e9, np.nan, -1e9
        for name in batch:
            np.testing.assert_array_equal(result[name], batch[name][k])


def test_a_log_with_its_joints_in_another_order_gives_the_same_bits(two_joints):
    log = random_log()
    batch = FrictionEstimator(two_joints, observers(2)).batch(log)
    turned = FrictionEstimator(two_joints, observers(2)).batch(log.select(('elbow', 'shoulder')))
    for name in batch:
        np.testing.assert_array_equal(turned[name], batch[name])
    with pytest.raises(DataError, match='joint elbow is not in the recording'):
        FrictionEstimator(two_joints, observers(2)).batch(log.select(('shoulder',)))


def test_the_first_sample_is_unknown_and_a_batch_starts_afresh(two_joints):
    estimator = FrictionEstimator(two_joints, observers(2))
    first = estimator.batch(random_log())
    again = estimator.batch(random_log())
    for name in first:
        assert np.isnan(first[name][0]).all()
        assert np.isfinite(first[name][1:]).all()
        np.testing.assert_array_equal(first[name], again[name])


def restarted_at(estimates, fresh, k):
    """Say that ``estimates`` are unknown at k and from there those of a log that begins at k."""
    for name, tau_f in estimates.items():
        assert np.isnan(tau_f[k]).all()
        np.testing.assert_array_equal(tau_f[k:], fresh[name])


def tail(log, k):
    return replace(log, t_ns=log.t_ns[k:], q=log.q[k:], v=log.v[k:], tau=log.tau[k:])


@pytest.mark.parametrize(('shift', 'event'), [(60_000_000, 'gap'), (-1_000_000_000, 'backwards')])
def test_a_gap_or_time_going_backwards_starts_the_observers_again(two_joints, shift, event):
    log = random_log()
    t_ns = log.t_ns.copy()
    t_ns[30:] += shift
    log = replace(log, t_ns=t_ns)
    estimator = FrictionEstimator(two_joints, observers(2))
    estimates = estimator.batch(log)
    told = []
    for k in range(len(log)):
        estimator.update(int(t_ns[k]), log.q[k], log.v[k], log.tau[k])
        told.append(estimator.events)
    assert told == [(event,) if k == 30 else () for k in range(len(log))]
    restarted_at(estimates, FrictionEstimator(two_joints, observers(2)).batch(tail(log, 30)), 30)


def test_a_pause_of_the_largest_gap_is_still_bridged(two_joints):
    log = random_log()
    t_ns = log.t_ns.copy()
    t_ns[30:] += 50_000_000 - H_NS
    estimator = FrictionEstimator(two_joints, observers(2))
    estimates = estimator.batch(replace(log, t_ns=t_ns))
    assert np.isfinite(estimates['sosml'][1:]).all()


@pytest.mark.parametrize('what', ['q', 'v'])
@pytest.mark.parametrize('value', [np.nan, np.inf])
def test_a_position_or_velocity_that_is_not_finite_starts_every_joint_again(
    two_joints, what, value
):
    log = random_log()
    getattr(log, what)[30, 1] = value
    estimator = FrictionEstimator(two_joints, observers(2))
    estimates = estimator.batch(log)
    assert np.isnan(estimates['sosml'][30]).all()
    restarted_at(estimates, FrictionEstimator(two_joints, observers(2)).batch(tail(log, 31)), 31)


@pytest.mark.parametrize(('hold', 'lost'), [('start', [31]), ('end', [30]), ('mean', [30, 31])])
def test_an_effort_that_is_missing_costs_its_joint_the_intervals_that_need_it(
    two_joints, hold, lost
):
    log = random_log()
    whole = FrictionEstimator(two_joints, observers(2), hold).batch(log)
    log.tau[30, 1] = np.nan
    estimator = FrictionEstimator(two_joints, observers(2), hold)
    estimates = estimator.batch(log)
    for name, tau_f in estimates.items():
        np.testing.assert_array_equal(tau_f[:, 0], whole[name][:, 0])
        assert np.flatnonzero(np.isnan(tau_f[:, 1])).tolist() == [0, *lost]
        np.testing.assert_array_equal(tau_f[: lost[0], 1], whole[name][: lost[0], 1])


@pytest.mark.parametrize('hold', ['start', 'mean', 'end'])
def test_a_joint_that_never_reports_effort_is_nan_and_the_other_exact(two_joints, hold):
    log = random_log()
    whole = FrictionEstimator(two_joints, observers(2), hold).batch(log)
    log.tau[:, 1] = np.nan
    estimator = FrictionEstimator(two_joints, observers(2), hold)
    for name, tau_f in estimator.batch(log).items():
        assert np.isnan(tau_f[:, 1]).all()
        np.testing.assert_array_equal(tau_f[:, 0], whole[name][:, 0])


def test_a_repeated_stamp_is_dropped_as_if_it_had_not_come(two_joints):
    log = random_log()
    estimator = FrictionEstimator(two_joints, observers(2))
    plain = FrictionEstimator(two_joints, observers(2)).batch(log)
    for k in range(len(log)):
        sample = (int(log.t_ns[k]), log.q[k], log.v[k], log.tau[k])
        result = estimator.update(*sample)
        np.testing.assert_array_equal(result['sosml'], plain['sosml'][k])
        assert estimator.update(sample[0], log.q[k] + 1.0, log.v[k], log.tau[k]) is None
    twice = replace(
        log, **{x: np.repeat(getattr(log, x), 2, axis=0) for x in ('t_ns', 'q', 'v', 'tau')}
    )
    batch = FrictionEstimator(two_joints, observers(2)).batch(twice)
    np.testing.assert_array_equal(batch['sosml'][::2], plain['sosml'])
    assert np.isnan(batch['sosml'][1::2]).all()


def test_reset_forgets_the_past(two_joints):
    log = random_log()
    estimator = FrictionEstimator(two_joints, observers(2))
    estimator.batch(log)
    estimator.reset()
    fresh = FrictionEstimator(two_joints, observers(2)).batch(log)
    for k in range(len(log)):
        result = estimator.update(int(log.t_ns[k]), log.q[k], log.v[k], log.tau[k])
        np.testing.assert_array_equal(result['sosml'], fresh['sosml'][k])


def staircase(slider, mass=95.1089, h=2e-3, count=400):
    """Return the exact motion of a free mass under a command held from each sample to the next."""
    tau = np.repeat(np.random.default_rng(1).normal(scale=50.0, size=count // 8), 8)
    v = np.concatenate([[0.0], np.cumsum(tau[:-1] * h / mass)])
    q = np.concatenate([[0.0], np.cumsum(h * (v[1:] + v[:-1]) / 2)])
    return np.arange(count, dtype=np.int64) * H_NS, q[:, None], v[:, None], tau[:, None]


def test_effort_hold_says_when_a_sample_of_effort_flowed(slider):
    """
    A command holds from its sample on, a measurement up to it, a sensor's sample around it.

    With the right hold the frictionless mass has no friction to 1e-6 N; with the wrong one the
    steps of 50 N show.
    """
    t_ns, q, v, command = staircase(slider)
    flowed = np.vstack([command[:1], command[:-1]])
    # A sample of an effort that is a ramp between samples: the trapezoid is exact.
    ramp = np.cumsum(np.random.default_rng(2).normal(size=(400, 1)), axis=0)
    v_ramp = np.concatenate(
        [np.zeros((1, 1)), np.cumsum(1e-3 * (ramp[1:] + ramp[:-1]) / 95.1089, axis=0)]
    )
    cases = {'start': (v, command), 'end': (v, flowed), 'mean': (v_ramp, ramp)}
    for right, (velocity, effort) in cases.items():
        log = JointLog(('slider',), t_ns, q, velocity, effort)
        for hold in cases:
            friction = FrictionEstimator(slider, observers(1, s1=0.0), hold).batch(log)
            for tau_f in friction.values():
                largest = np.nanmax(np.abs(tau_f))
                assert largest < 1e-6 if hold == right else largest > 1e-2


def test_each_joint_can_have_its_own_effort_hold(two_joints):
    log = random_log()
    both = {
        hold: FrictionEstimator(two_joints, observers(2), hold).batch(log)
        for hold in ('start', 'end')
    }
    mixed = FrictionEstimator(two_joints, observers(2), ['end', 'start']).batch(log)
    for name, tau_f in mixed.items():
        np.testing.assert_array_equal(tau_f[:, 0], both['end'][name][:, 0])
        np.testing.assert_array_equal(tau_f[:, 1], both['start'][name][:, 1])


def test_velocity_from_position_is_the_backward_difference(two_joints):
    log = random_log()
    v = np.full_like(log.v, np.nan)
    v[1:] = np.diff(log.q, axis=0) / (np.diff(log.t_ns)[:, None] * 1e-9)
    given = FrictionEstimator(two_joints, observers(2)).batch(replace(log, v=v))
    blind = replace(log, v=np.full_like(log.v, np.nan))
    estimator = FrictionEstimator(two_joints, observers(2), velocity_source='position_difference')
    estimates = estimator.batch(blind)
    for name in estimates:
        np.testing.assert_array_equal(estimates[name], given[name])
        assert np.isfinite(estimates[name][2:]).all()


@pytest.mark.parametrize(
    ('options', 'words'),
    [
        ({'effort_hold': 'middle'}, 'use one of start, mean, end'),
        ({'effort_hold': ['start']}, 'one for each of shoulder, elbow'),
        ({'velocity_source': 'guess'}, 'use one of message, position_difference'),
        ({'maximum_gap_s': 0.0}, 'must be positive'),
        ({'maximum_gap_s': float('nan')}, 'must be positive'),
        ({'observers': []}, 'at least one'),
        ({'observers': observers(2)[:1] * 2}, 'give each one once'),
        ({'observers': observers(3)}, 'has gains for 3 joints where the robot has 2'),
    ],
)
def test_options_that_make_no_sense_are_refused_in_one_sentence(two_joints, options, words):
    arguments = {'observers': observers(2), **options}
    with pytest.raises(ConfigurationError, match=words) as caught:
        FrictionEstimator(two_joints, **arguments)
    assert '\n' not in str(caught.value)
