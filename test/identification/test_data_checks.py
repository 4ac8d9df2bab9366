# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The checks of a recording: each sees its own fault, and nothing in a good recording."""

from __future__ import annotations

import json
import re
from copy import copy
from dataclasses import replace

import numpy as np
import pytest
from known_robots import recording, sines, slider_model, slider_recording
from scipy.signal import lfilter

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.tables.importer import import_recording
from sosml_friction.diagnosis.data_checks import check_joints
from sosml_friction.exceptions import DataError
from sosml_friction.identification.clean_samples import SHORTEST_S
from sosml_friction.identification.data_checks import check_data
from sosml_friction.identification.data_finding import NOTE
from sosml_friction.identification.joint_relations import Slopes
from sosml_friction.model.model_folder import read_model
from sosml_friction.model.robot import Robot
from sosml_friction.model.simple_models import pendulum_model
from sosml_friction.motion.trajectory_kinds.speed_ladder import speed_ladder
from sosml_friction.report.common.output import to_json
from sosml_friction.share import share_directory

PERIOD = 0.004
COULOMB, VISCOUS = (0.5, 0.3), (0.2, 0.1)
GRAVITY = np.array([0.0, 0.0, -9.81])


@pytest.fixture(scope='module')
def robot():
    return read_model(share_directory() / 'config' / 'exoskeleton').make_robot()


def arm_log(robot, noise=0.01, speeds=(0.05, 0.2, 0.5)) -> JointLog:
    """Return a ladder of both joints of the default arm, with Coulomb and viscous friction."""
    start = {'shoulder': -1.5, 'elbow': 1.2}
    ladder = speed_ladder(start, start, speeds, 0.6)
    spline = ladder.spline()
    t = np.arange(0.0, ladder.duration, PERIOD)
    q, v, a = spline(t), spline(t, 1), spline(t, 2)
    tau = np.array([robot.inverse_dynamics(*state) for state in zip(q, v, a, strict=True)])
    tau += np.sign(v) * COULOMB + v * VISCOUS
    tau += np.random.default_rng(3).normal(0.0, noise, v.shape) if noise else 0.0
    return JointLog(robot.names, np.rint(t * 1e9).astype(np.int64), q, v, tau)


@pytest.fixture(scope='module')
def good(robot):
    return arm_log(robot)


def found(log, robot) -> set[str]:
    """Return the names of the checks that found something."""
    return {finding.check for finding in check_data(log, robot)[1].findings}


def test_a_good_recording_passes_as_it_is(good, robot):
    log, checks = check_data(good, robot)
    assert checks.findings == ()
    assert (checks.samples, checks.used) == (len(good), len(good))
    for what in ('t_ns', 'q', 'v', 'tau'):
        np.testing.assert_array_equal(getattr(log, what), getattr(good, what))
    assert checks.period_s == pytest.approx(PERIOD)
    assert checks.jitter_s == pytest.approx(0.0, abs=1e-9)


def test_samples_between_efforts_that_come_more_slowly_are_left_out(good, robot):
    tau = np.full_like(good.tau, np.nan)
    tau[::5] = good.tau[::5]
    slow = replace(good, tau=tau)
    log, checks = check_data(slow, robot)
    np.testing.assert_array_equal(log.tau, good.tau[::5])
    np.testing.assert_array_equal(log.q, good.q[::5])
    assert checks.period_s == pytest.approx(5 * PERIOD)
    (said,) = (f.sentence for f in checks.findings if f.check == 'sparse_effort')
    assert f'is not in each sample, of shoulder at {0.2 / PERIOD:.3g} Hz' in said
    # A hole of effort alone stays one, and so does what one joint does not tell.
    tau = good.tau.copy()
    tau[1000:1100], tau[1500:1505, 0] = np.nan, np.nan
    log, checks = check_data(replace(good, tau=tau), robot)
    assert len(log) == len(good)
    assert 'without_effort' in {finding.check for finding in checks.findings}


def test_samples_that_repeat_an_effort_are_left_out(good, robot):
    """The elbow's comes at a fifth of the rate, the shoulder's at a third."""
    k = np.arange(len(good))
    tau = np.column_stack([good.tau[k - k % 3, 0], good.tau[k - k % 5, 1]])
    log, checks = check_data(replace(good, tau=tau), robot)
    assert checks.period_s == pytest.approx(5 * PERIOD)
    np.testing.assert_array_equal(log.q, good.q[5::5])
    np.testing.assert_array_equal(log.tau[:, 1], good.tau[5::5, 1])
    between = np.interp(good.time[5::5], good.time[::3], good.tau[::3, 0])
    assert log.tau[1:-1, 0] == pytest.approx(between[1:-1])
    (said,) = (f.sentence for f in checks.findings if f.check == 'held_effort')
    assert f'of {robot.names[1]} at {0.2 / PERIOD:.3g} Hz' in said


def test_samples_that_repeat_a_position_or_all_of_the_one_before_are_left_out(good, robot):
    k = np.arange(len(good))
    slow = replace(good, q=good.q[k - k % 5])
    log, checks = check_data(slow, robot)
    assert checks.period_s == pytest.approx(5 * PERIOD)
    assert np.mean(np.isin(log.t_ns, good.t_ns[::5])) > 0.95
    assert 'held_position' in {finding.check for finding in checks.findings}
    # Eight samples that were lost and filled with the last one, again and again.
    last = np.where(k % 100 < 8, k - k % 100, k)
    filled = replace(good, q=good.q[last], tau=good.tau[last])
    log, checks = check_data(filled, robot)
    assert checks.findings[0].check == 'repeated_samples'
    assert 'a joint went on, and are left out as lost' in checks.findings[0].sentence
    moving = np.abs(np.gradient(good.q[:, 0], PERIOD)) > 0.04
    assert not np.isin(good.t_ns[moving & (last < k)], log.t_ns).any()
    assert np.isin(good.t_ns[last == k], log.t_ns).all()


def test_an_effort_without_its_sign_is_refused_and_one_of_one_sign_by_right_is_not(good, robot):
    """The elbow's weight is more than its friction; the shoulder's effort changes its sign."""
    assert good.tau[:, 1].min() > 0.0 > good.tau[:, 0].min()
    log, checks = check_data(replace(good, tau=np.abs(good.tau)), robot)
    assert set(checks.refused) == {robot.names[0]}
    assert 'never changes its sign, and its motion says that it did' in checks.sentences[0]
    assert np.isnan(log.tau[:, 0]).all()
    assert np.isfinite(log.tau[:, 1]).all()


def pendulum_log(seed, reach):
    """Return a pendulum with a knee, cogging and noise that swings to one side of hanging."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 20.0, PERIOD)
    size, w = rng.uniform(0.2, 1.0), rng.uniform(0.3, 2.0)
    q, v, a = sines(t, [(size, w), (0.1 * size, 3.3 * w)])
    q += size * reach
    tau = 0.08 * a + 9.81 * 0.25 * np.sin(q) + 0.1 * v
    tau += (rng.uniform(0.1, 0.5) + 0.2 * np.exp(-np.abs(v) / 0.05)) * np.sign(v)
    tau += 0.05 * np.sin(10.0 * q) + rng.normal(0.0, 0.01, len(t))
    nothing = np.full((len(t), 1), np.nan)
    stamps = np.rint(t * 1e9).astype(np.int64)
    return JointLog(('joint',), stamps, q[:, None], nothing, tau[:, None])


def test_signs_that_friction_alone_turned_are_missed_beside_a_weight():
    """A pendulum on one side: near hanging alone its friction is more than its weight."""
    robot = pendulum_model(1.0, 0.25, armature=0.0).make_robot()
    for seed in (0, 2, 3, 4, 5, 6, 8, 9):
        log = pendulum_log(seed, 1.0)
        assert 0.05 < np.mean(log.tau < 0.0) < 0.2
        with pytest.raises(DataError, match='never changes its sign'):
            check_data(replace(log, tau=np.abs(log.tau)), robot, '', ('joint',))


def test_one_sign_by_right_is_never_taken_for_a_lost_one():
    """Lifted until it hardly touches 0."""
    robot = pendulum_model(1.0, 0.25, armature=0.0).make_robot()
    for seed in range(20):
        log = pendulum_log(seed, 1.2)
        lifted = replace(log, tau=log.tau - log.tau.min() + 0.001)
        assert check_data(lifted, robot, '', ('joint',))[1].refused == {}


def test_a_glitch_of_an_encoder_is_left_out(good, robot):
    q = good.q.copy()
    q[[500, 1700], 1] += 3.0
    log, checks = check_data(replace(good, q=q), robot)
    (said,) = (f for f in checks.findings if f.check == 'glitch')
    assert said.joint == robot.names[1]
    assert len(log) == len(good) - 2
    assert {f.check for f in checks.findings} == {'glitch', 'gaps'}


@pytest.mark.parametrize(('joint', 'i'), [('shoulder', 0), ('elbow', 1)])
def test_the_friction_level_is_that_at_the_median_speed(good, robot, joint, i):
    """C + B |v|: the median over the windows taken differs by up to 0.15 rad/s from that here."""
    joints = check_data(good, robot)[1].joints
    v = np.abs(good.v[:, i])
    level = COULOMB[i] + VISCOUS[i] * float(np.median(v[v > 0.01]))
    assert joints[joint].friction_level == pytest.approx(level, abs=0.15 * VISCOUS[i])
    assert 0.0 < joints[joint].friction_level_error < 0.02
    assert joints[joint].velocity_factor == pytest.approx(1.0, abs=0.01)
    assert joints[joint].forwards_s == pytest.approx(joints[joint].backwards_s, rel=0.2)


@pytest.mark.parametrize('noise', [0.0, 0.01])
@pytest.mark.parametrize('resolution', [0.0, 0.05])
def test_plateaus_of_an_effort_without_noise_or_of_few_counts_are_no_saturation(
    robot, noise, resolution
):
    """Constant speed is constant effort where gravity is, and its extreme for seconds."""
    log = arm_log(robot, noise)
    if resolution:
        log = replace(log, tau=resolution * np.round(log.tau / resolution))
    assert 'saturation' not in found(log, robot)


def test_a_flat_extreme_is_saturation_and_left_out(good, robot):
    limit = np.quantile(np.abs(good.tau[:, 1]), 0.93)
    tau = good.tau.copy()
    tau[:, 1] = np.clip(tau[:, 1], -limit, limit)
    log, checks = check_data(replace(good, tau=tau), robot)
    share = np.mean(np.abs(tau[:, 1]) >= limit)
    assert checks.joints['elbow'].saturated == pytest.approx(share, rel=0.3)
    assert np.isnan(log.tau[:, 1]).mean() == pytest.approx(checks.joints['elbow'].saturated)
    assert checks.joints['shoulder'].saturated == 0.0
    assert np.isfinite(log.tau[:, 0]).all()


def test_repeated_and_late_samples_leave_what_they_were_without(good, robot):
    """Every tenth twice, every seventh after its successor: the log comes out bit for bit."""
    order = np.arange(len(good))
    at = np.arange(3, len(good) - 1, 7)
    order[at], order[at + 1] = at + 1, at
    rows = np.sort(np.r_[np.arange(len(good)), np.arange(0, len(good), 10)])
    rows = order[rows]
    spoiled = replace(
        good, t_ns=good.t_ns[rows], q=good.q[rows], v=good.v[rows], tau=good.tau[rows]
    )
    log, checks = check_data(spoiled, robot)
    np.testing.assert_array_equal(log.t_ns, good.t_ns)
    np.testing.assert_array_equal(log.tau, good.tau)
    assert checks.repeated_stamps == len(rows) - len(good)
    assert checks.samples == len(rows)
    assert found(spoiled, robot) == {'repeated_stamps', 'backward_stamps'}


def test_jitter_and_gaps_are_measured(good, robot):
    t_ns = good.t_ns + np.random.default_rng(1).integers(-400_000, 400_001, len(good))
    t_ns[len(good) // 2 :] += 500_000_000
    _, checks = check_data(replace(good, t_ns=t_ns), robot)
    # Half of the differences of two uniform deviates of +-0.4 ms are below 0.234 ms.
    assert checks.jitter_s == pytest.approx(0.234e-3, rel=0.1)
    assert checks.gaps == 1
    assert checks.longest_step_s == pytest.approx(0.504, abs=0.001)
    # Scattered stamps of an even sampling are told, and are not used.
    assert [(f.check, f.level) for f in checks.findings] == [('even_stamps', NOTE), ('gaps', NOTE)]


def test_a_time_in_ms_that_was_taken_for_s_is_refused_and_10_hz_are_not(good, robot):
    slow = replace(good, t_ns=1000 * good.t_ns, v=np.full_like(good.v, np.nan))
    told = 'samples are 4 s apart, where joints are recorded at 10 Hz and more: check the unit'
    with pytest.raises(DataError, match=told):
        check_data(slow, robot)
    check_data(replace(slow, t_ns=25 * good.t_ns), robot)


def test_the_resolution_of_an_encoder_is_found(good, robot):
    step = 2.0 * np.pi / 2**14
    _, checks = check_data(replace(good, q=step * np.round(good.q / step)), robot)
    assert checks.joints['shoulder'].position_step == pytest.approx(step)


@pytest.mark.parametrize(('zero', 'load'), [(0.0, 1.0), (0.0, 1.3), (0.5, 1.3), (np.pi, 1.0)])
def test_a_position_that_counts_from_elsewhere_is_told_by_the_phase_of_gravity(zero, load):
    """A servo whose centre is not taken off: its axis was said to have the other sign."""
    t = 0.02 * np.arange(3000)
    q, v, a = sines(t, ((0.9, 0.5, 0.0), (0.3, 2.3, 1.0), (0.1, 5.1, 2.0)))
    tau = 0.011 * a + load * 0.44 * np.sin(q) + 0.15 * np.sign(v) + 0.05 * v
    tau += 0.005 * np.random.default_rng(0).standard_normal(len(t))
    model = pendulum_model(0.44 / (9.81 * 0.15), 0.15, 0.0, 0.004, 'j').make_robot()
    _, checks = check_data(recording(('j',), t, q - zero, tau), model)
    said = [f.sentence for f in checks.findings]
    assert len(said) == bool(zero)
    assert not zero or f'seems to be {zero:.1f}'[:-1] in said[0]


@pytest.mark.parametrize(('size', 'noise'), [(0.2, 0.012), (0.3, 0.024)])
def test_gravity_of_masses_that_are_almost_twice_as_much_is_another_zero(size, noise):
    """Along a short way g(q - 1) times cos 0 / cos 1 = 1.85 is g(q), and no masses are that."""
    t = 0.02 * np.arange(3000)
    q, v, a = sines(t, ((size, 0.5, 0.0), (0.4 * size, 2.3, 1.0)))
    tau = 0.011 * a + 0.44 * np.sin(q) + 0.003 * np.sign(v) + 0.02 * v
    tau += noise * np.random.default_rng(0).standard_normal(len(t))
    model = pendulum_model(0.44 / (9.81 * 0.15), 0.15, 0.0, 0.004, 'j').make_robot()
    log = recording(('j',), t, q + 1.0, tau)
    _, checks = check_data(log, model)
    assert [f.check for f in checks.findings] == ['position_zero']
    assert [c.kind for c in check_joints(log, model)] == ['position']


def test_where_friction_drives_a_joint_that_needs_less_than_nothing_its_effort_is_turned():
    """Gravity alone would say that the URDF has the other sign: of it friction is no part."""
    t = 0.02 * np.arange(3000)
    q, v, a = sines(t, ((0.9, 0.5, 0.0), (0.3, 2.3, 1.0), (0.1, 5.1, 2.0)))
    friction = 0.01 * np.sign(v) + 0.01 * v
    model = pendulum_model(0.44 / (9.81 * 0.15), 0.15, 0.0, 0.15, 'j').make_robot()
    said = []
    for sign in (1.0, -1.0):
        tau = -(0.157 * a + 0.44 * np.sin(q)) + sign * friction
        tau += 1e-3 * np.random.default_rng(0).standard_normal(len(t))
        _, checks = check_data(recording(('j',), t, q, tau), model)
        said += [f.sentence for f in checks.findings if f.check == 'effort_unit']
    assert 'gravity in the URDF has the other sign' in said[0]
    assert 'turn the sign of its effort' in said[1]


@pytest.mark.parametrize('i', [0, 1])
def test_an_effort_of_the_wrong_sign_refuses_its_joint_and_no_other(good, robot, i):
    tau = good.tau.copy()
    tau[:, i] *= -1.0
    log, checks = check_data(replace(good, tau=tau), robot)
    assert list(checks.refused) == [robot.names[i]]
    assert 'friction would drive it' in checks.refused[robot.names[i]]
    # A hand that moves a joint drives it as well.
    assert 'unless something else moves the joint' in checks.refused[robot.names[i]]
    assert np.isnan(log.tau[:, i]).all()
    assert np.isfinite(log.tau[:, 1 - i]).all()


@pytest.mark.parametrize(
    ('factor', 'said'),
    [
        (180.0 / np.pi, 'in degrees per second'),
        (30.0 / np.pi, 'in revolutions per minute'),
        (-1.0, 'with the other sign'),
        (0.5, ''),
        (1.3, ''),
        (0.0, '0 '),
    ],
)
def test_a_velocity_that_is_another_one_is_named_and_the_slope_used(good, robot, factor, said):
    log, checks = check_data(replace(good, v=factor * good.v), robot)
    assert {f.check for f in checks.findings} == {'velocity_unit'}
    assert checks.refused == {}
    sentence = checks.sentences[1]
    if said:
        assert f'joint elbow is {said}' in sentence or said in sentence
    else:
        number = re.search(r'joint elbow is ([\d.]+) ± ', sentence)
        assert float(number[1]) == pytest.approx(factor, rel=1e-3)
    moving = np.abs(good.v) > 0.1
    assert np.median(np.abs(log.v - good.v)[moving]) < 1e-3


def test_a_velocity_and_an_effort_that_are_exchanged_refuse_their_joint(good, robot):
    v, tau = good.v.copy(), good.tau.copy()
    v[:, 1], tau[:, 1] = good.tau[:, 1], good.v[:, 1]
    _, checks = check_data(replace(good, v=v, tau=tau), robot)
    assert set(checks.refused) == {'elbow'}
    assert 'exchange the columns of both' in checks.refused['elbow']


def test_effort_of_damping_beside_a_speed_without_sign_is_no_exchange(good, robot):
    v, tau = good.v.copy(), good.tau.copy()
    v[:, 1], tau[:, 1] = np.abs(good.v[:, 1]), 2.0 * good.v[:, 1]
    _, checks = check_data(replace(good, v=v, tau=tau), robot)
    assert 'exchanged' not in {finding.check for finding in checks.findings}


def test_a_velocity_within_a_fifth_of_the_slope_is_as_it_is(good, robot):
    log, checks = check_data(replace(good, v=1.15 * good.v), robot)
    assert checks.findings == ()
    np.testing.assert_array_equal(log.v, 1.15 * good.v)


def test_a_late_velocity_and_a_late_effort_are_told_with_their_delay(good, robot):
    rows = np.maximum(np.arange(len(good)) - 6, 0)
    late = check_data(replace(good, v=good.v[rows]), robot)[1]
    assert {f.check for f in late.findings} == {'velocity_lag'}
    assert '24 ms late' in late.findings[0].sentence
    late = check_data(replace(good, tau=good.tau[rows]), robot)[1]
    assert {f.check for f in late.findings} == {'effort_lag'}


def test_an_effort_that_is_later_than_fits_undo_is_told_with_its_delay(good, robot):
    rows = np.maximum(np.arange(len(good)) - 20, 0)
    late = check_data(replace(good, tau=good.tau[rows]), robot)[1]
    assert {f.check for f in late.findings} == {'effort_too_late'}
    for told in late.findings:
        assert told.level == 'warning'
        delay_ms = float(re.search(r'is (\S+) ms late', told.sentence)[1])
        assert delay_ms == pytest.approx(80.0, abs=8.0)
        assert 'shift it in the table' in told.sentence


def sticking(dwell: float, late: int) -> JointLog:
    """
    Return a pendulum that sticks for ``dwell`` [s] where it turns around, then breaks away.

    As long as it sticks its effort is that of the motion before; it comes ``late`` samples later.
    """
    rng, here, parts, ways = np.random.default_rng(0), 0.0, [], []
    for k in range(24):
        to = (0.6 if k % 2 == 0 else -0.6) * rng.uniform(0.5, 1.0)
        u = np.arange(0.0, 1.0, PERIOD / (2.5 * abs(to - here)))
        rest = np.full(round(dwell / PERIOD), to)
        parts.append(np.append(here + (to - here) * u**3 * (10.0 - 15.0 * u + 6.0 * u**2), rest))
        ways.append(np.full(len(parts[-1]), np.sign(to - here)))
        here = to
    q, way = np.concatenate(parts), np.concatenate(ways)
    v = np.gradient(q, PERIOD)
    a = np.gradient(v, PERIOD)
    mass, length, armature = 0.36, 0.3, 0.1
    tau = (armature + mass * length**2) * a + mass * 9.81 * length * np.sin(q)
    tau += 2.0 * way + 0.3 * v + 0.02 * rng.standard_normal(len(q))
    rows = np.maximum(np.arange(len(q)) - late, 0)
    t_ns = np.rint(1e9 * PERIOD * np.arange(len(q))).astype(np.int64)
    return JointLog(('joint',), t_ns, q[:, None], v[:, None], tau[rows, None])


def test_a_joint_that_sticks_where_it_turns_around_has_no_late_effort():
    """Friction turns around after the velocity: 100 ms of sticking were told as 48 ms late."""
    pendulum = pendulum_model(0.36, 0.3, 0.0, 0.1, 'joint').make_robot()
    for dwell in (0.05, 0.1, 0.2):
        assert 'effort_lag' not in found(sticking(dwell, 0), pendulum)
    for dwell in (0.1, 0.2):
        told = check_data(sticking(dwell, 6), pendulum)[1].findings
        (sentence,) = (f.sentence for f in told if f.check == 'effort_lag')
        assert '24 ms late' in sentence


def in_unit(log, q=1.0, tau=1.0):
    """Return a log with positions and velocities, or efforts, in another unit."""
    return replace(log, q=q * log.q, v=q * log.v, tau=tau * log.tau)


@pytest.fixture(scope='module')
def swing(robot):
    """Return thirty seconds of sines: gravity and inertia tell of units what steps do not."""
    t = np.arange(0.0, 30.0, PERIOD)
    w, p = np.array([1.3, 2.1]), np.array([0.0, 1.0])
    q = np.array([-1.0, 1.2]) + 0.5 * np.sin(w * t[:, None] + p) + 0.1 * np.sin(4.1 * t[:, None])
    v = np.gradient(q, t, axis=0)
    a = np.gradient(v, t, axis=0)
    tau = np.array([robot.inverse_dynamics(*state) for state in zip(q, v, a, strict=True)])
    tau += np.tanh(v / 0.01) * COULOMB + v * VISCOUS
    tau += np.random.default_rng(3).normal(0.0, 0.01, v.shape)
    return JointLog(robot.names, np.rint(t * 1e9).astype(np.int64), q, v, tau)


def unlimited(robot):
    """Return the same robot without a limit that would tell."""
    free = copy(robot)
    free.limits = tuple(type(x)(-np.inf, np.inf, 0.0, 0.0) for x in robot.limits)
    return free


@pytest.mark.parametrize(('unit', 'factor'), [('degrees', 180 / np.pi), ('turns', 0.5 / np.pi)])
def test_positions_in_another_unit_are_told_by_gravity_without_any_limit(
    swing, robot, unit, factor
):
    with pytest.raises(DataError, match=f'shoulder is in {unit}.*elbow is in {unit}'):
        check_data(in_unit(swing, q=factor), unlimited(robot))


@pytest.mark.parametrize(('factor', 'said'), [(0.1, '0.099'), (1e3, '99[0-9]')])
def test_an_effort_in_another_unit_is_told_by_gravity_and_inertia(swing, robot, factor, said):
    with pytest.raises(DataError, match=f'{said}.* times what .*not in Nm'):
        check_data(in_unit(swing, tau=factor), robot)


@pytest.mark.parametrize(('limit', 'refused'), [(250.0, True), (1200.0, False), (1.0, False)])
def test_an_effort_far_beyond_its_limit_is_in_another_unit(limit, refused):
    """A joint of friction alone, 40 Nm that are read as 40 000; a limit of 1 is none."""
    t = np.arange(0.0, 30.0, PERIOD)
    q, v, _ = sines(t, [(0.9, 0.8), (0.3, 2.1)])
    tau = 1e3 * (38.0 * np.sign(v) + 2.0 * v)
    robot = copy(pendulum_model(1e-3, 0.1, armature=0.0).make_robot())
    robot.limits = (type(robot.limits[0])(-np.inf, np.inf, 0.0, limit),)
    log = recording(robot.names, t, q, tau)
    if not refused:
        assert 'allows' not in ' '.join(check_data(log, robot)[1].sentences)
        return
    with pytest.raises(DataError, match='where its URDF allows 250 Nm: it is not in Nm'):
        check_data(log, robot)


@pytest.mark.parametrize(('gear', 'said'), [(2.0, 'before a gear of 2'), (0.5, 'behind a gear')])
def test_a_gear_of_2_is_told_by_the_shape_of_gravity(gear, said):
    t = np.arange(0.0, 30.0, PERIOD)
    q, v, a = sines(t, [(0.9, 0.8), (0.3, 2.1)])
    tau = 0.0625 * a + 9.81 * 0.25 * np.sin(q) + 0.2 * np.sign(v) + 0.1 * v
    tau += np.random.default_rng(7).normal(0.0, 0.02, len(t))
    robot = pendulum_model(1.0, 0.25, armature=0.0).make_robot()
    nothing = np.full((len(t), 1), np.nan)
    stamps = np.rint(t * 1e9).astype(np.int64)
    log = JointLog(('joint',), stamps, q[:, None], nothing, tau[:, None])
    assert found(log, robot) == set()
    with pytest.raises(DataError, match=f'is in rad {said}'):
        check_data(replace(log, q=gear * log.q), robot)
    # A spring and a mass of its own have a similar shape, and are no gear.
    own = replace(log, tau=log.tau + log.q - 0.6 * 9.81 * 0.25 * np.sin(log.q))
    assert 'position_unit' not in found(own, robot)


def test_an_effort_that_is_off_by_a_torque_constant_is_told_and_used(swing, robot):
    log, checks = check_data(in_unit(swing, tau=1 / 1.8), robot)
    assert {f.check for f in checks.findings} == {'effort_unit'}
    assert '0.55' in checks.sentences[0]
    np.testing.assert_array_equal(log.tau, in_unit(swing, tau=1 / 1.8).tau)


def test_a_good_swing_is_accused_of_nothing(swing, robot):
    assert check_data(swing, robot)[1].findings == ()


def test_masses_that_are_off_by_half_are_no_other_unit(swing, robot):
    """Effort of a robot twice as heavy is none of A, mNm or degrees."""
    heavy = robot.changed(2.0 * robot.inertial_parameters(), np.array(robot.armature), GRAVITY)
    assert check_data(swing, heavy)[1].refused == {}


def test_a_resting_joint_is_named_and_the_other_goes_on(swing, robot):
    q, v = swing.q.copy(), swing.v.copy()
    rng = np.random.default_rng(4)
    q[:, 1] = 1.2 + 1e-4 * np.rint(5e-4 * swing.tau[:, 0] / 1e-4)
    v[:, 1] = rng.normal(0.0, 0.02, len(v))
    log, checks = check_data(replace(swing, q=q, v=v), robot)
    assert list(checks.resting) == ['elbow']
    assert checks.refused == {}
    assert 'as resting' in checks.resting['elbow']
    assert np.isnan(log.tau[:, 1]).all()
    assert np.isfinite(log.tau[:, 0]).all()


def test_a_turned_sign_needs_to_be_seen_in_motions_of_both_directions(good, robot):
    """One turn forwards, a twitch back: what differs by place is no friction."""
    t = good.time
    q = np.column_stack([0.1 * t - 1.0 * (t > 17.0) * (t - 17.0), 1.2 + 0.0 * t])
    tau = np.column_stack([np.sin(7.0 * q[:, 0]), 0.0 * t])
    log = replace(good, q=q - [2.0, 0.0], v=np.full_like(q, np.nan), tau=tau)
    with pytest.raises(DataError, match='one direction only'):
        check_data(log, robot)


def test_a_position_that_is_off_by_its_zero_is_in_no_other_unit(good, robot):
    with pytest.raises(DataError, match='correct its zero'):
        check_data(replace(good, q=good.q + 20.0), robot)


def test_inches_that_were_read_as_millimetres_are_a_reason_why_effort_is_25_times_too_large():
    log, robot = slider_recording(), slider_model().make_robot()
    assert 'effort_unit' not in found(log, robot)
    said = ' '.join(check_data(replace(log, q=log.q / 25.4), robot)[1].sentences)
    assert 'Either its position is not in m, its effort is not in N, or the masses are' in said


def test_positions_in_counts_are_said_to_be_whole_numbers(good, robot):
    counts = np.rint(good.q * 4096.0 / (2.0 * np.pi)) + 2048.0
    with pytest.raises(DataError, match='whole numbers, as counts of an encoder are'):
        check_data(replace(good, q=counts), robot)


def test_a_drive_at_the_limit_of_its_speed_is_told_and_its_effort_left_out(robot):
    """Moves at 0.5 to 1 rad/s in both directions; at the fastest the effort collapses."""
    t = np.arange(0.0, 60.0, PERIOD)
    w = np.repeat([0.5, -0.5, 0.7, -0.7, 0.8, -0.8, 0.9, -0.9, 1.0, -1.0] * 2, 3.0 / PERIOD)
    v = np.column_stack([w, 0.2 * np.sin(2.0 * t)])
    q = np.cumsum(v, axis=0) * PERIOD + [-1.5, 1.2]
    rng = np.random.default_rng(0)
    log = JointLog(robot.names, np.rint(t * 1e9).astype(np.int64), q, v, 0.0 * q)
    a = np.nan_to_num(Slopes.of(log).a)
    tau = np.array([robot.inverse_dynamics(*state) for state in zip(q, v, a, strict=True)])
    tau += np.sign(v) * COULOMB + v * VISCOUS + rng.normal(0.0, 0.05, v.shape)
    log, free = replace(log, tau=tau), unlimited(robot)
    assert 'speed_limit' not in found(log, free)
    fast = np.abs(w) > 0.95
    tau[fast, 0] -= np.sign(w[fast]) * rng.uniform(0.0, 0.8, fast.sum())
    left, checks = check_data(replace(log, tau=tau), free)
    assert 'its drive is at the limit of its speed' in ''.join(checks.sentences)
    assert np.isnan(left.tau[fast, 0]).mean() > 0.9
    assert np.isfinite(left.tau[~fast, 0]).mean() > 0.95


def test_the_weight_of_a_wrong_mass_is_no_limit_of_speed():
    """Two speeds of a pendulum: those next to the highest are of its turns alone."""
    period = 0.001
    wanted = np.repeat([0.1, -0.1, 0.3, -0.3], np.rint([8e3, 16e3, 5333, 700]).astype(int))
    v = lfilter([0.02], [1.0, -0.98], wanted)
    q = np.cumsum(v) * period
    tau = 0.0645 * np.gradient(v, period) + 9.81 * 0.25 * np.sin(q) + 0.3 * np.sign(v)
    tau += np.random.default_rng(0).normal(0.0, 0.01, len(q))
    stamps = np.arange(len(q)) * 10**6
    log = JointLog(('joint',), stamps, q[:, None], v[:, None], tau[:, None])
    for length in (0.25, 0.255, 0.26):
        robot = Robot(pendulum_model(1.0, length).urdf, ['joint'], [0.002])
        assert 'speed_limit' not in found(log, robot)


def test_without_any_velocity_nothing_is_said_of_it(good, robot):
    log = replace(good, v=np.full_like(good.v, np.nan))
    assert check_data(log, robot)[1].findings == ()


def test_an_elbow_without_effort_is_no_fault(good, robot):
    """Its actuator reports none: that is said elsewhere, as ever."""
    tau = good.tau.copy()
    tau[:, 1] = np.nan
    assert check_data(replace(good, tau=tau), robot)[1].findings == ()


def test_too_short_is_refused_with_its_length(good, robot):
    rows = good.time < 0.9 * SHORTEST_S
    log = replace(good, t_ns=good.t_ns[rows], q=good.q[rows], v=good.v[rows], tau=good.tau[rows])
    with pytest.raises(DataError, match=r'usable samples over 1\.8 s'):
        check_data(log, robot)


def test_the_order_of_joints_in_the_recording_does_not_matter(good, robot):
    turned = good.select(robot.names[::-1])
    log, checks = check_data(turned, robot)
    assert log.names == robot.names
    assert checks == check_data(good, robot)[1]


def test_the_document_is_plain(good, robot):
    _, checks = check_data(replace(good, v=np.full_like(good.v, np.nan)), robot)
    document = json.loads(to_json({'data_checks': checks}))['data_checks']
    assert set(document['joints']) == set(robot.names)
    assert document['joints'][robot.names[0]]['velocity_factor'] is None


def test_the_measured_emps_axis_passes(data_directory, tmp_path):
    file = data_directory / 'emps' / 'DATA_EMPS.mat'
    if not file.is_file():
        pytest.skip(f'no {file}')
    config = share_directory() / 'config'
    bag = import_recording(file, config / 'import' / 'emps.yaml', tmp_path / 'emps')
    emps = read_model(config / 'emps').make_robot()
    _, checks = check_data(Bag.open(bag).joint_log(), emps)
    assert checks.findings == ()
    # Published: 20.4 N and 203.5 N s/m, at a median speed of 0.082 m/s 37 N.
    assert checks.joints['slider'].friction_level == pytest.approx(37.0, rel=0.05)


def test_positions_and_efforts_at_stamps_of_their_own_are_interpolated(good, robot):
    q, tau = good.q.copy(), good.tau.copy()
    q[1::2], tau[::2] = np.nan, np.nan
    log, checks = check_data(replace(good, q=q, tau=tau), robot)
    # Those of the positions, which is as often as efforts come.
    np.testing.assert_array_equal(log.q, good.q[::2])
    assert log.tau[1:-1] == pytest.approx(0.5 * (good.tau[1:-3:2] + good.tau[3:-1:2]))
    assert {f.check for f in checks.findings} >= {'sparse_position', 'sparse_effort'}


def test_behind_a_joint_that_counts_from_elsewhere_no_other_does(good, robot):
    """The gravity of the elbow turns with the shoulder."""
    q = good.q + np.array([0.5 * np.pi, 0.0])
    _, checks = check_data(replace(good, q=q), robot)
    assert [f.joint for f in checks.findings if f.check == 'position_zero'] == ['shoulder']
    assert [robot.carriers(i) for i in range(2)] == [(), (0,)]
