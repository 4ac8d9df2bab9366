# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Noise, friction and motion measured in recordings in which they are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.observers.log_conditions import configuration_for, measure_conditions


def sine_log(noise_v=0.0, noise_q=0.0, with_velocity=True, n=20_000, seed=0):
    rng = np.random.default_rng(seed)
    t = np.arange(n) * 1e-3
    q = 0.1 * np.sin(2 * np.pi * 0.5 * t) + noise_q * rng.normal(size=n)
    v = 0.1 * np.pi * np.cos(2 * np.pi * 0.5 * t) + noise_v * rng.normal(size=n)
    if not with_velocity:
        v = np.full(n, np.nan)
    t_ns = np.arange(n, dtype=np.int64) * 1_000_000
    return JointLog(('slider',), t_ns, q[:, None], v[:, None], np.zeros((n, 1)))


@pytest.mark.parametrize('sigma', [1e-4, 1e-3, 1e-2])
def test_the_measured_momentum_noise_is_the_injected_white_one(slider, sigma):
    """p = 95.1 kg v: within 20 %; 5000 second differences know their median to about 2 %."""
    configuration = configuration_for(sine_log(noise_v=sigma), slider, bandwidth=40.0)
    s1 = configuration.gains['sosml']['sliding'][0]
    assert s1 / (0.1 * 1600.0) == pytest.approx(95.1089 * sigma, rel=0.2)
    assert configuration.velocity_source == 'message'


def test_two_coupled_joints_have_the_noise_of_their_rows_of_the_inertia(two_joints):
    """Velocity noise of joint 1 alone enters both momenta, by M11 and M21."""
    rng = np.random.default_rng(1)
    n, q0 = 20_000, np.array([-0.9, 1.1])
    v = np.column_stack([0.01 * rng.normal(size=n), np.zeros(n)])
    q = np.broadcast_to(q0, (n, 2)).copy()
    t_ns = np.arange(n, dtype=np.int64) * 1_000_000
    log = JointLog(('shoulder', 'elbow'), t_ns, q, v, np.zeros((n, 2)))
    s1 = np.array(configuration_for(log, two_joints).gains['sosml']['sliding'])
    expected = 0.1 * 1600.0 * 0.01 * two_joints.inertia(q0)[:, 0]
    np.testing.assert_allclose(s1, expected, rtol=0.2)


def test_a_recording_without_velocity_gets_differences_and_their_noise(slider):
    """
    Differences of white position noise s have sqrt(2) s / h, neighbours opposed.

    The second difference is then the third of position, std sqrt(20) s / h: over sqrt(6) that is
    1.83 s / h, 29 % above sqrt(2), on the safe side. 20 % on that number.
    """
    sigma = 1e-6
    log = sine_log(noise_q=sigma, with_velocity=False)
    configuration = configuration_for(log, slider)
    assert configuration.velocity_source == 'position_difference'
    s1 = configuration.gains['sosml']['sliding'][0]
    expected = 95.1089 * np.sqrt(20.0 / 6.0) * sigma / 1e-3
    assert s1 / (0.1 * 1600.0) == pytest.approx(expected, rel=0.2)


def test_repeated_stamps_and_holes_do_not_disturb_the_measured_noise(slider):
    log = sine_log(noise_v=1e-3)
    log.t_ns[5000:] -= 1_000_000
    log.q[9000:9500] = np.nan
    s1 = configuration_for(log, slider).gains['sosml']['sliding'][0]
    assert s1 / 160.0 == pytest.approx(95.1089e-3, rel=0.2)


@pytest.mark.parametrize(('count', 'hole'), [(9, None), (200, 2)])
def test_a_recording_in_which_noise_cannot_be_measured_is_refused(slider, count, hole):
    log = sine_log(n=count)
    if hole:
        log.q[::hole] = np.nan
    with pytest.raises(DataError, match='ten or more, one after the other'):
        configuration_for(log, slider)


def test_slow_recordings_have_their_gap_measured_in_their_own_steps(slider):
    """A gap is 25 periods, at least 0.05 s."""
    log = sine_log(noise_v=1e-3)
    assert configuration_for(log, slider).maximum_gap_s == 0.05
    slow = JointLog(log.names, log.t_ns * 10, log.q, log.v, log.tau)
    assert configuration_for(slow, slider).maximum_gap_s == pytest.approx(0.25)


def slope(q, span, step):
    """Return the least-squares slope of the last ``span`` positions, by polyfit."""
    t = np.arange(span) * step
    v = np.full(len(q), np.nan)
    windows = np.lib.stride_tricks.sliding_window_view(q, span)
    v[span - 1 :] = np.polyfit(t, windows.T, 1)[0]
    v[: span - 1] = v[span - 1]
    return v


def ladder(noise, resolution=0.0, span=2, friction=20.0, seed=0, period=2.0):
    """Return 20 s of the slider to and fro, friction C = ``friction``, effort held at the end."""
    n, step = 10_000, 2e-3
    t = np.arange(n) * step
    w = np.pi / period
    q, a = -0.2 / w * np.cos(w * t), 0.2 * w * np.cos(w * t)
    tau = 95.1089 * a + friction * np.sign(np.sin(w * t))
    measured = q + noise * np.random.default_rng(seed).normal(size=n)
    if resolution:
        measured = resolution * np.round(measured / resolution)
    v = slope(measured, span, step)
    t_ns = np.round(t * 1e9).astype(np.int64)
    return JointLog(('slider',), t_ns, measured[:, None], v[:, None], tau[:, None])


@pytest.mark.parametrize('span', [2, 5, 11, 30])
def test_a_velocity_that_is_a_slope_of_positions_is_recognised_with_its_noise(slider, span):
    """sqrt(12 / (N (N^2 - 1))) s / T; the position noise itself is known to about 2 %."""
    c = measure_conditions(ladder(1e-5, span=span), slider)
    assert c.velocity_span == span
    assert c.position_noise[0] == pytest.approx(1e-5, rel=0.08)
    expected = 1e-5 * np.sqrt(12.0 / (span * (span**2 - 1.0))) / 2e-3
    assert c.velocity_noise[0] == pytest.approx(expected, rel=0.08)


def test_a_velocity_of_another_origin_has_its_own_noise(slider):
    log = ladder(1e-5)
    rng = np.random.default_rng(5)
    t = log.time[:, None]
    v = 0.2 * np.sin(0.5 * np.pi * t) + 3e-3 * rng.normal(size=t.shape)
    c = measure_conditions(replace(log, v=v), slider)
    assert c.velocity_span == 0
    assert c.velocity_noise[0] == pytest.approx(3e-3, rel=0.08)


@pytest.mark.parametrize('noise', [0.0, 1e-6])
def test_a_resolution_counts_as_noise_where_it_is_all_there_is(slider, noise):
    """r / sqrt(12), or what the third difference of a rounded motion has, which is no less."""
    c = measure_conditions(ladder(noise, resolution=1e-4, span=11), slider)
    assert 0.99e-4 / np.sqrt(12.0) <= c.position_noise[0] <= 2.0e-4 / np.sqrt(12.0)


def test_friction_jump_reversal_time_and_speed_are_those_of_the_motion(slider):
    c = measure_conditions(ladder(1e-5, span=5, period=1.5), slider, ('end',))
    assert c.friction_jump[0] == pytest.approx(40.0, rel=0.05)
    assert c.reversal_time[0] == pytest.approx(1.5, rel=0.1)
    assert c.top_speed[0] == pytest.approx(0.2, rel=0.05)


def test_without_velocity_the_backward_difference_is_meant(slider):
    log = ladder(1e-5)
    c = measure_conditions(replace(log, v=np.full(log.v.shape, np.nan)), slider)
    assert c.velocity_span == 2
    assert c.velocity_noise[0] == pytest.approx(np.sqrt(2.0) * 1e-5 / 2e-3, rel=0.08)


def test_a_joint_that_does_not_move_has_no_gains_but_a_sentence(slider):
    log = ladder(1e-5)
    still = replace(log, q=0.0 * log.q, v=0.0 * log.v)
    with pytest.raises(DataError, match='position_noise of joint slider cannot be measured'):
        measure_conditions(still, slider).conditions(slider)
    silent = replace(log, tau=np.full(log.tau.shape, np.nan))
    with pytest.raises(DataError, match='friction_jump of joint slider cannot be measured'):
        measure_conditions(silent, slider).conditions(slider)


def test_named_observers_get_gains_from_what_was_measured(slider):
    log = ladder(1e-5, span=5)
    configuration = configuration_for(log, slider, None, ('end',), ['kalman', 'first_order'])
    assert list(configuration.gains) == ['kalman', 'first_order']
    assert configuration.effort_hold == ('end',)
    assert configuration.gains['kalman']['position_noise'][0] == pytest.approx(1e-5, rel=0.08)
    with pytest.raises(ConfigurationError, match='kalman has no gains by bandwidth'):
        configuration_for(log, slider, 40.0, (), ['kalman'])
    with pytest.raises(ConfigurationError, match="observer 'guess' is unknown"):
        configuration_for(log, slider, None, (), ['guess'])


@pytest.mark.parametrize('bits', [12, 14, 16])
def test_the_friction_jump_does_not_depend_on_the_encoder(slider, bits):
    """40 N to 10 %; one count of 12 bits over 2 m is half a millimetre, a spike of 23 kg m/s."""
    c = measure_conditions(ladder(0.0, resolution=2.0 / 2**bits), slider, ('end',))
    assert c.friction_jump[0] == pytest.approx(40.0, rel=0.1)


def test_a_joint_that_is_held_does_not_turn_round_with_its_noise(slider):
    """Whatever its noise crosses for a moment, it is not asked for its friction."""
    log = ladder(1e-5)
    q = 0.1 + 1e-5 * np.random.default_rng(1).normal(size=log.q.shape)
    v = np.diff(q, axis=0, prepend=q[:1]) / 2e-3
    c = measure_conditions(replace(log, q=q, v=v), slider, ('end',))
    assert np.isnan(c.friction_jump[0])
    assert np.isnan(c.reversal_time[0])


def test_repeated_stamps_are_no_standstill(slider):
    log = ladder(1e-5, span=5)
    twice = np.repeat(np.arange(len(log)), 2)
    doubled = JointLog(log.names, log.t_ns[twice], log.q[twice], log.v[twice], log.tau[twice])
    ours, truth = (measure_conditions(one, slider, ('end',)) for one in (doubled, log))
    for name in ('position_noise', 'velocity_noise', 'friction_jump', 'reversal_time'):
        np.testing.assert_array_equal(getattr(ours, name), getattr(truth, name))


def test_a_quantised_velocity_has_the_noise_of_its_resolution(slider):
    log = ladder(1e-5)
    v = 0.01 * np.round(0.2 * np.sin(0.5 * np.pi * log.time[:, None]) / 0.01)
    c = measure_conditions(replace(log, v=v), slider, ('end',))
    assert c.velocity_span == 0
    assert c.velocity_noise[0] == pytest.approx(0.01 / np.sqrt(12.0), rel=0.01)


def test_friction_of_the_wrong_sign_is_told_as_such(slider):
    log = ladder(1e-5)
    with pytest.raises(DataError, match='check the sign of its effort'):
        measure_conditions(replace(log, tau=-log.tau), slider, ('end',)).conditions(slider)
