# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A wrong number is never given for more than 0.1 s without being marked, whatever went wrong."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.signal import lfilter

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.model.model_folder import read_model
from sosml_friction.nodes.observer_health import ObserverHealth
from sosml_friction.observers.estimate_error import EstimateError
from sosml_friction.observers.friction_estimator import FrictionEstimator
from sosml_friction.observers.plausibility import Plausibility
from sosml_friction.observers.recipe import recipe_gains
from sosml_friction.observers.registry import OBSERVERS, make_observer
from sosml_friction.observers.watched_estimator import WatchedEstimator
from sosml_friction.share import share_directory

HZ = 250
#: The fault is there from then to then [s].
BEGIN, END, WHOLE = 2.0, 3.5, 5.0
FAULTY = slice(round(BEGIN * HZ), round(END * HZ))
FIRST_NS = 1_000_000_000
JOINTS = ('shoulder', 'elbow')


@dataclass
class Stream:
    """What comes on joint_states, and the friction that is true."""

    t_ns: np.ndarray
    q: np.ndarray
    v: np.ndarray
    tau: np.ndarray
    true: np.ndarray
    source: np.ndarray


@pytest.fixture(scope='module')
def robot():
    return read_model(share_directory() / 'config' / 'exoskeleton').make_robot()


@pytest.fixture(scope='module')
def good(robot) -> Stream:
    """Return both joints to and fro with an encoder's steps, a current's noise and friction."""
    rng = np.random.default_rng(0)
    t = np.arange(round(WHOLE * HZ)) / HZ
    phase = np.array([[0.0, 1.0]]) + 2.0 * np.pi * np.outer(t, [0.4, 0.55])
    swing, centre = np.array([0.5, 0.6]), np.array([-1.4, 1.2])
    q = centre + swing * np.sin(phase)
    speed = 2.0 * np.pi * np.array([0.4, 0.55])
    v = swing * speed * np.cos(phase)
    a = -swing * speed**2 * np.sin(phase)
    true = np.array([0.7, 0.4]) * np.tanh(v / 0.02) + 0.2 * v
    tau = np.array([robot.inverse_dynamics(*x) for x in zip(q, v, a, strict=True)]) + true
    step = 2.0 * np.pi / 36000.0
    return Stream(
        FIRST_NS + np.round(t * 1e9).astype(np.int64),
        np.round(q / step) * step,
        v + 2e-3 * rng.standard_normal(v.shape),
        np.round((tau + 0.01 * rng.standard_normal(v.shape)) / 0.0125) * 0.0125,
        true,
        np.full(len(t), 'driver'),
    )


@pytest.fixture(scope='module')
def usual(robot, good) -> np.ndarray:
    """Return the greatest error of each joint where nothing is wrong: the lag at reversals."""
    return np.max(np.abs(run(robot, good)[0] - good.true)[HZ // 2 :], axis=0)


def changed(stream: Stream) -> Stream:
    return Stream(*(np.array(getattr(stream, name)) for name in stream.__dataclass_fields__))


def watched(robot, **options) -> WatchedEstimator:
    gains = recipe_gains(robot, 40.0)
    observers = [make_observer(name, gains[name]) for name in ('first_order', 'sosml')]
    return WatchedEstimator(FrictionEstimator(robot, observers, 'end'), 'sosml', **options)


def run(robot, stream: Stream, **options):
    """Return the estimates, their errors and the causes, sample by sample."""
    watch = watched(robot, **options)
    estimates = np.full(stream.q.shape, np.nan)
    errors = np.full(stream.q.shape, np.nan)
    causes: list[dict[str, str]] = []
    for k in range(len(stream.t_ns)):
        sample = (x[k] for x in (stream.q, stream.v, stream.tau))
        taken = watch.update(int(stream.t_ns[k]), *sample, str(stream.source[k]))
        causes.append({} if taken is None else taken.causes)
        if taken is not None:
            estimates[k], errors[k] = taken.estimates['sosml'], taken.error
    return estimates, errors, causes


def spike(column, value, count=1):
    def change(stream: Stream) -> None:
        first = FAULTY.start
        getattr(stream, column)[first : first + count, 0] = value

    return change


def held(column, value=None):
    """Hold a column of the shoulder, where it was or at a value."""

    def change(stream: Stream) -> None:
        x = getattr(stream, column)
        x[FAULTY, 0] = x[FAULTY.start, 0] if value is None else value

    return change


def scaled(column, factor):
    def change(stream: Stream) -> None:
        getattr(stream, column)[FAULTY, 0] *= factor

    return change


def frozen_with_its_velocity(stream: Stream) -> None:
    held('q')(stream)
    held('v', 0.0)(stream)


def message_repeated(stream: Stream) -> None:
    for x in (stream.q, stream.v, stream.tau):
        x[FAULTY] = x[FAULTY.start]


def interleaved(stream: Stream) -> None:
    """Another robot's driver, at rest elsewhere, speaks every second message."""
    other = slice(FAULTY.start, FAULTY.stop, 2)
    stream.q[other] = [-1.0, 1.0]
    stream.v[other] = 0.0
    stream.tau[other] = [1.0, 0.5]
    stream.source[other] = 'other'


def silent(stream: Stream) -> None:
    for name in ('t_ns', 'q', 'v', 'tau', 'true', 'source'):
        x = getattr(stream, name)
        setattr(stream, name, np.delete(x, FAULTY, axis=0))


def time_goes_back(stream: Stream) -> None:
    stream.t_ns[FAULTY.start :] -= 2_000_000_000


def jumped(stream: Stream) -> None:
    stream.q[FAULTY, 0] += 0.4


FAULTS = {
    'ten efforts of 60 Nm': (spike('tau', 60.0, 10), 'effort 60 Nm where the URDF limits it to 8'),
    'one effort of 1e9': (spike('tau', 1e9), 'effort 1e+09 Nm'),
    'one effort of -1e300': (spike('tau', -1e300), 'effort -1e+300 Nm'),
    'one infinite effort': (spike('tau', np.inf), 'effort inf Nm'),
    'effort in mNm': (scaled('tau', 1000.0), 'check its unit'),
    'effort exactly 0': (held('tau', 0.0), 'effort is exactly 0.0 while the joint moves'),
    'effort lost': (held('tau', np.nan), 'no effort of it'),
    'encoder frozen, velocity goes on': (held('q'), 'position stands still to the last bit'),
    'encoder frozen with its velocity': (frozen_with_its_velocity, 'position stands still'),
    'one message again and again': (message_repeated, 'position stands still'),
    'velocity lost': (held('v', np.nan), 'no velocity of shoulder'),
    'velocity 0': (held('v', 0.0), 'velocity stays at 0 to the last bit'),
    'velocity stuck': (held('v'), 'velocity stays at'),
    'velocity in deg/s': (scaled('v', 57.3), 'velocity'),
    'one velocity of 1e6': (spike('v', 1e6), 'where the URDF limits it to 3'),
    'position in degrees': (scaled('q', 57.3), 'where the URDF allows -2.3 to 0.7'),
    'one position a turn off': (spike('q', 5.0), 'where the URDF allows'),
    'one position 0.4 rad off': (spike('q', -0.4), 'position jumped by'),
    'position NaN': (held('q', np.nan), 'no position of shoulder'),
    'two publishers by turns': (interleaved, 'two publishers'),
    'silence': (silent, 'a gap in joint_states'),
    'time goes back': (time_goes_back, 'time went back'),
}


def longest(flags) -> int:
    best = now = 0
    for flag in flags:
        now = now + 1 if flag else 0
        best = max(best, now)
    return best


def test_what_is_good_gives_the_numbers_of_the_estimator_to_the_last_bit(robot, good):
    estimates, errors, causes = run(robot, good)
    log = JointLog(JOINTS, good.t_ns, good.q, good.v, good.tau)
    np.testing.assert_array_equal(estimates, watched(robot).estimator.batch(log)['sosml'])
    assert [k for k, cause in enumerate(causes) if cause] == [0]
    assert np.isfinite(errors[HZ:]).all()


@pytest.mark.parametrize('fault', FAULTS)
def test_no_wrong_number_stands_unmarked_for_a_tenth_of_a_second(robot, good, usual, fault):
    change, sentence = FAULTS[fault]
    bad = changed(good)
    change(bad)
    estimates, errors, causes = run(robot, bad)
    wrong = np.abs(estimates - bad.true) > 1.1 * usual + 0.1
    for joint in range(2):
        # What is marked is NaN, which compares as not wrong.
        assert longest(wrong[HZ // 2 :, joint]) <= 0.1 * HZ, fault
        # An error is given for no number that is wrong, but for those before it can be told.
        told = wrong[:, joint] & np.isfinite(errors[:, joint])
        assert longest(told[HZ // 2 :]) <= 0.1 * HZ
    said = [text for cause in causes for text in cause.values()]
    assert any(sentence in text for text in said), sorted(set(said))
    # It recovers: what follows the fault is known and right again.
    after = slice(-round((WHOLE - END - 1.0) * HZ), None)
    assert np.isfinite(estimates[after]).all()
    assert not wrong[after].any()


@pytest.mark.parametrize('factor', [3.0, -1.0, 0.3, 0.1])
def test_a_velocity_that_is_another_than_the_change_of_position_is_told(robot, good, factor):
    """Below the limits of the URDF: v x3 was used for as long as it lasted, as was v x -1."""
    bad = changed(good)
    bad.q[:] = good.q[0] + 0.5 * (good.q - good.q[0])
    bad.v[:] *= 0.5
    bad.v[FAULTY] *= factor
    estimates, _, causes = run(robot, bad)
    seen = [k for k, cause in enumerate(causes) if 'by more than half' in ' '.join(cause.values())]
    assert seen[0] < FAULTY.start + 0.6 * HZ
    assert len(seen) > 0.6 * (END - BEGIN) * HZ
    assert np.isnan(estimates[seen]).all()


@pytest.mark.parametrize('value', [None, 8.0])
def test_an_effort_that_hangs_or_is_saturated_is_told(robot, good, value):
    """It was used for as long as it lasted, with errors of several Nm, as all but 0.0 was."""
    bad = changed(good)
    held('tau', value)(bad)
    estimates, _, causes = run(robot, bad)
    hangs = [k for k, c in enumerate(causes) if 'to the last bit' in c.get('shoulder', '')]
    assert hangs == list(range(hangs[0], FAULTY.stop))
    assert hangs[0] < FAULTY.start + 0.3 * HZ
    assert np.isnan(estimates[hangs, 0]).all()
    assert np.isfinite(estimates[hangs, 1]).all()
    assert np.isfinite(estimates[FAULTY.stop + 1 :]).all()


@pytest.mark.parametrize(('count', 'every'), [(0.5, 1), (0.0125, 25), (0.0, 50)])
def test_an_effort_that_is_coarse_or_slow_does_not_hang(robot, good, count, every):
    """One that is the same for 0.2 s at times, 0.0 among them, as it is on a slow plateau."""
    slow = changed(good)
    for x in (slow.q, slow.v, slow.true):
        x[:] = x[0]
    t = np.arange(len(slow.t_ns)) / HZ
    slow.v[:] = np.where(np.arange(len(t)) // HZ % 2 == 0, 0.2, -0.2)[:, np.newaxis]
    slow.q[:] = [-1.2, 1.2] + np.cumsum(slow.v, axis=0) / HZ
    slow.true[:] = 0.6 * np.sign(slow.v)
    tau = np.array([robot.gravity(q) for q in slow.q]) + slow.true
    tau = np.repeat(tau[::every], every, axis=0)[: len(t)]
    slow.tau[:] = np.round(tau / count) * count if count else tau
    _, _, causes = run(robot, slow)
    said = {text for cause in causes[1:] for text in cause.values()}
    assert not said


def test_an_effort_that_is_0_from_the_start_is_not_known_even_at_rest(robot, good):
    still = changed(good)
    still.q[:], still.v[:], still.tau[:, 0] = good.q[0], 0.0, 0.0
    estimates, _, causes = run(robot, still)
    assert np.isnan(estimates[HZ // 10 :, 0]).all()
    assert 'exactly 0.0 since the start' in causes[-1]['shoulder']
    assert np.isfinite(estimates[HZ // 10 :, 1]).all()


def test_two_publishers_that_nothing_tells_apart_are_found_by_where_they_are(robot, good):
    """A hundredth of a radian apart: no jump that the limit of the velocity would forbid."""
    two = changed(good)
    two.q[FAULTY.start : FAULTY.stop : 2] += 0.01
    watch = watched(robot)
    unknown = []
    for k in range(len(two.t_ns)):
        watch.several = k > HZ // 2
        taken = watch.update(int(two.t_ns[k]), two.q[k], two.v[k], two.tau[k])
        unknown.append(np.isnan(taken.estimates['sosml']).any())
    assert np.flatnonzero(unknown)[1] == FAULTY.start + 2
    assert all(unknown[FAULTY.start + 2 : FAULTY.stop])
    assert not any(unknown[FAULTY.stop + 2 * HZ :])


@pytest.mark.parametrize('noise', [0.0, 1e-3])
@pytest.mark.parametrize('every', [1, 10])
@pytest.mark.parametrize('source', ['message', 'position_difference'])
def test_a_second_publisher_that_sends_none_of_these_joints_changes_nothing(
    robot, good, noise, every, source
):
    gains = recipe_gains(robot, 40.0)
    estimator = FrictionEstimator(
        robot, [make_observer('sosml', gains['sosml'])], 'end', source, 0.2
    )
    watch = WatchedEstimator(estimator, 'sosml')
    watch.several = True
    q = good.q + noise * np.random.default_rng(3).standard_normal(good.q.shape)
    # A leap is none either, whatever else it is.
    for leap in range(HZ, len(q), HZ // 3):
        q[leap:] += 0.05 * (-1.0) ** leap
    for k in range(0, len(q), every):
        taken = watch.update(int(good.t_ns[k]), q[k], good.v[k], good.tau[k])
        assert not any('two publishers' in cause for cause in taken.causes.values())


def test_an_encoder_that_freezes_with_its_velocity_is_found_at_a_slow_speed(robot):
    """A velocity was granted 4 % of its limit, here 0.12 rad/s: below it nothing was found."""
    judge = Plausibility(robot)
    rng = np.random.default_rng(7)
    seen = []
    for k in range(2 * HZ):
        if k < HZ:
            q = np.round((np.array([-1.2, 1.2]) + 0.05 * k / HZ) / 1.7e-4) * 1.7e-4
            v = 0.05 + 1e-3 * rng.standard_normal(2)
        tau = robot.gravity(q) + 0.5 + 1e-3 * rng.standard_normal(2)
        seen.append('stands still' in judge.judge(k * 4_000_000, q, v, tau).causes.get(0, ''))
    found = np.flatnonzero(seen)
    assert HZ < found[0] <= 1.1 * HZ
    assert found.tolist() == list(range(found[0], 2 * HZ))


def remarks_of(robot, stream) -> list[str]:
    """Return what is told of the shoulder, sample by sample, '' where nothing is."""
    watch = watched(robot)
    rows = zip(stream.t_ns, stream.q, stream.v, stream.tau, strict=True)
    return [watch.update(int(t), *sample).remarks.get('shoulder', '') for t, *sample in rows]


@pytest.mark.parametrize(
    'change',
    [
        lambda x: scaled('tau', -1.0)(x),
        lambda x: scaled('tau', 0.4)(x),
        lambda x: x.tau.__setitem__((FAULTY, 0), x.tau[FAULTY, 1]),
    ],
    ids=['sign', 'scale', 'of another joint'],
)
def test_friction_that_gives_energy_is_told(robot, good, change):
    """None of the three was: the number was given, OK, with an error of the size of gravity."""
    bad = changed(good)
    change(bad)
    told = [k for k, text in enumerate(remarks_of(robot, bad)) if 'takes energy' in text]
    assert told
    # Of the last second of motion: so long it may stand after the fault as well.
    assert FAULTY.start < told[0]
    assert told[-1] <= FAULTY.stop + 1.2 * HZ


@pytest.mark.parametrize('off', [0.95, 1.05])
@pytest.mark.parametrize('speed', [0.3, 1.0, 8.0])
def test_friction_of_a_model_that_is_off_by_a_twentieth_takes_energy(robot, good, off, speed):
    """A joint of little friction, lifted, let down and shaken at 3 Hz; two seconds each."""
    stream = changed(good)
    t = np.arange(len(stream.t_ns)) / HZ * speed
    phase = np.array([[0.0, 1.0]]) + 2.0 * np.pi * np.outer(t, [0.4, 0.4])
    swing, rate = np.array([0.5, 0.5]) / max(1.0, speed), 2.0 * np.pi * 0.4 * speed
    stream.q[:] = np.array([-1.0, 1.2]) + swing * np.sin(phase)
    v, a = swing * rate * np.cos(phase), -swing * rate**2 * np.sin(phase)
    noise = np.random.default_rng(9).standard_normal((2, *v.shape))
    stream.v[:] = v + 2e-3 * noise[0]
    nominal = np.array([robot.inverse_dynamics(*x) for x in zip(stream.q, v, a, strict=True)])
    stream.tau[:] = off * nominal + 0.1 * np.sign(v) + 0.01 * noise[1]
    assert not any('takes energy' in text for text in remarks_of(robot, stream))


def test_a_position_that_leapt_and_stays_is_told_until_a_reset(robot, good):
    bad = changed(good)
    bad.q[FAULTY.start :, 0] += 0.4
    told = remarks_of(robot, bad)
    assert 'position leapt by 0.4' in told[-1]
    assert not any('leapt' in text for text in told[: FAULTY.start])
    watch = watched(robot)
    for k in range(FAULTY.stop):
        watch.update(int(bad.t_ns[k]), bad.q[k], bad.v[k], bad.tau[k])
    watch.reset()
    for k in range(FAULTY.stop, FAULTY.stop + HZ // 2):
        taken = watch.update(int(bad.t_ns[k]), bad.q[k], bad.v[k], bad.tau[k])
    assert not taken.remarks


def repeats_said(robot, good, every) -> str:
    """Return what is said where each measurement is published ``every`` times."""
    watch, health = watched(robot), ObserverHealth(JOINTS)
    for k in range(3 * HZ):
        measured = k // every * every
        sample = (x[measured] for x in (good.q, good.v, good.tau))
        taken = watch.update(int(good.t_ns[k]), *sample)
        estimate = taken.estimates['sosml']
        health.estimated(k / HZ, int(good.t_ns[k]), estimate, {}, {}, taken.repeats)
    said = health.judge(3.0, 0.05)[0]
    return said.message if said.level == 'warn' else ''


@pytest.mark.parametrize('every', [2, 4, 10])
def test_a_driver_that_measures_less_often_than_it_publishes_is_told(robot, good, every):
    said = repeats_said(robot, good, every)
    hz = float(said.split('measures at ')[1].split(' Hz')[0])
    assert hz == pytest.approx(HZ / every, rel=0.05)


def test_a_driver_that_publishes_what_it_measures_is_not_told_to(robot, good):
    assert not repeats_said(robot, good, 1)
    coarse = changed(good)
    step = 2.0 * np.pi / 1024.0
    coarse.q[:] = np.round(coarse.q / step) * step
    coarse.v[:] = np.round(coarse.v / 0.2) * 0.2
    coarse.tau[:] = np.round(coarse.tau)
    assert not repeats_said(robot, coarse, 1)


def test_slips_of_a_joint_that_sticks_are_no_frozen_encoder(robot):
    """Of 10 slips of 40 ms no friction in motion is known, and nothing is compared with it."""
    judge = Plausibility(robot)
    rng = np.random.default_rng(4)
    q = np.array([-1.4, 1.2])
    for k in range(5 * HZ):
        slips = k % (HZ // 2) < HZ // 25
        v = np.array([0.5 if slips else 0.0, 0.0])
        q = q + v / HZ
        tau = robot.gravity(q) + [1.0, 0.3] + 1e-3 * rng.standard_normal(2)
        verdict = judge.judge(k * 4_000_000, q, v, tau)
        judge.learn(np.array([1.0, 0.3]), np.full(2, 0.01))
        assert not verdict.causes


def test_what_stops_a_joint_is_judged_by_the_corrected_effort(robot):
    """An effort told as four times the torque: friction of 0.5 Nm stops a joint that creeps."""
    judge = Plausibility(robot, excess=10.0, correct=lambda tau: 0.25 * tau)
    friction = np.array([0.5, 0.5])
    q = np.array([-0.3, 0.3])
    for k in range(3 * HZ):
        v = np.full(2, 0.02 if k < 2 * HZ else 0.0)
        q = q + v / HZ
        verdict = judge.judge(k * 4_000_000, q, v, 4.0 * (robot.gravity(q) + friction))
        judge.learn(friction, np.full(2, 0.01))
        assert not any('position' in cause for cause in verdict.causes.values())


def test_the_gap_follows_a_rate_that_rises_again(robot, good):
    watch = watched(robot, follows_rate=True)
    stamps = np.cumsum([0.2] * 12 + [1e-3] * 50)
    for t in stamps:
        watch.update(FIRST_NS + round(t * 1e9), good.q[0], good.v[0], good.tau[0])
        if t == stamps[11]:
            assert watch.estimator.maximum_gap_s == pytest.approx(0.6)
    assert watch.estimator.maximum_gap_s == 0.05


@pytest.mark.parametrize('frame_s', [0.02, 0.05])
def test_a_position_that_is_held_between_frames_has_not_jumped(robot, frame_s):
    """1 kHz, 14 bits, up to 2.5 rad/s where the limit is 3, twice of which is granted."""
    judge = Plausibility(robot)
    t = np.arange(3000) * 1e-3
    seen = np.floor(t / frame_s) * frame_s
    step = 2.0 * np.pi / 2**14
    for now, then in zip(t, seen, strict=True):
        q = np.array([-0.8, 1.2]) + 0.4 * np.sin(6.25 * then)
        v = np.full(2, 2.5 * np.cos(6.25 * now))
        verdict = judge.judge(round(now * 1e9), np.round(q / step) * step, v, np.ones(2))
        assert not any('jumped' in cause for cause in verdict.causes.values())


def test_an_effort_somewhat_beyond_its_limit_is_used_and_told(robot, good):
    """Limits are often those of continuous duty."""
    bad = changed(good)
    spike('tau', 9.0)(bad)
    watch = watched(robot)
    for k in range(FAULTY.start + 1):
        taken = watch.update(int(bad.t_ns[k]), bad.q[k], bad.v[k], bad.tau[k])
    assert np.isfinite(taken.estimates['sosml']).all()
    assert 'effort 9 Nm where the URDF limits it to 8' in taken.remarks['shoulder']
    heard = Heard()
    heard.estimates(2.0)
    heard.health.estimated(heard.now, 1, np.ones(2), {}, taken.remarks)
    assert [s.level for s in heard.said()] == ['warn', 'warn', 'ok']


def test_a_joint_without_an_actuator_is_estimated_where_it_is_named(robot, good):
    free = changed(good)
    free.tau[:, 0] = 0.0
    estimates, _, _ = run(robot, free, passive=['shoulder'])
    assert np.isfinite(estimates[1:]).all()


def test_a_slow_stream_is_estimated_by_a_gap_that_follows_its_rate(robot, good):
    """15 Hz: with the gap of a fast stream each sample would be a fresh start."""
    every = HZ // 15
    slow = Stream(*(getattr(good, name)[::every] for name in good.__dataclass_fields__))
    assert np.isnan(run(robot, slow)[0]).all()
    estimates, _, _ = run(robot, slow, follows_rate=True)
    assert np.isfinite(estimates[11:]).all()


@pytest.mark.parametrize('observer', ['first_order', 'linear_second_order'])
def test_the_standard_error_is_the_scatter_of_the_estimate(robot, observer):
    """At rest with white noise of velocity and effort: within a tenth, over 20 s."""
    rng = np.random.default_rng(1)
    gains = recipe_gains(robot, 40.0)[observer]
    watch = WatchedEstimator(
        FrictionEstimator(robot, [make_observer(observer, gains)], 'end'), observer
    )
    q = np.array([-0.8, 1.2])
    estimates, errors = [], []
    for k in range(20 * HZ):
        noise = rng.standard_normal((2, 2))
        v, tau = 2e-3 * noise[0], robot.gravity(q) + 0.05 * noise[1]
        taken = watch.update(FIRST_NS + k * 4_000_000, q + 1e-6 * rng.standard_normal(2), v, tau)
        estimates.append(taken.estimates[observer])
        errors.append(taken.error)
    scatter = np.std(np.array(estimates)[HZ:], axis=0)
    np.testing.assert_allclose(np.median(np.array(errors)[HZ:], axis=0), scatter, rtol=0.1)


def fed(observer, stamps, tau, v=0.0):
    """Return the errors of a watch of the noise alone, of one joint of inertia 1."""
    error, nothing = EstimateError(observer), np.zeros(1)
    return [
        error.update(t, np.atleast_1d(v), np.atleast_1d(effort), np.eye(1), nothing)[0]
        for t, effort in zip(stamps, tau, strict=True)
    ]


def test_the_error_costs_no_more_where_stamps_come_in_bunches_or_nanoseconds():
    """An impulse response of 5 s in steps of 1 ns would take 40 GB."""
    first_order = make_observer('first_order', {'cutoff': [40.0]})
    tau = np.random.default_rng(5).standard_normal(400)
    bunched = np.repeat(np.arange(100) * 0.04, 4) + np.tile(np.arange(4) * 1e-6, 100)
    evenly = np.arange(400) * 0.01
    ends = [fed(first_order, stamps, tau)[-1] for stamps in (bunched, evenly)]
    assert ends[0] == pytest.approx(ends[1], rel=0.05)
    assert len(fed(first_order, np.arange(400) * 1e-9, tau)) == 400


def test_a_resolution_that_hides_the_noise_is_part_of_the_error():
    first_order = make_observer('first_order', {'cutoff': [40.0]})
    tau = np.repeat([0.0, 0.5], 400)
    errors = fed(first_order, np.arange(800) * 4e-3, tau)
    a = np.exp(-40.0 * 4e-3)
    # As noise it passes the filter, and as an offset that stays it passes whole.
    passed = np.sqrt((1 - a) / (1 + a) + 1.0)
    assert errors[-1] == pytest.approx(0.5 / np.sqrt(12.0) * passed)


def test_without_noise_and_resolution_no_error_is_known():
    first_order = make_observer('first_order', {'cutoff': [40.0]})
    assert np.isnan(fed(first_order, np.arange(800) * 4e-3, np.ones(800))).all()


@pytest.mark.parametrize('kind', ['held', 'filtered'])
def test_noise_that_is_not_white_is_in_the_error(kind):
    """Effort at 25 Hz in a stream of 250 Hz, or behind 20 ms, at rest: 95 % within two errors."""
    observer = make_observer('first_order', {'cutoff': [40.0]})
    rng = np.random.default_rng(11)
    noise = 0.05 * rng.standard_normal(60 * HZ)
    if kind == 'held':
        tau = np.repeat(noise[::10], 10)
    else:
        tau = lfilter([1 - np.exp(-0.2)], [1, -np.exp(-0.2)], noise)
    a = np.exp(-40.0 / HZ)
    estimates = lfilter([1 - a], [1, -a], tau)
    error, good = EstimateError(observer), []
    for k, (effort, estimate) in enumerate(zip(tau, estimates, strict=True)):
        v, measured = 1e-9 * rng.standard_normal(1), np.atleast_1d(effort)
        said = error.update(k / HZ, v, measured, np.eye(1), np.atleast_1d(estimate))[0]
        if k > 10 * HZ:
            good.append(abs(estimate) < 2.0 * said)
    assert np.mean(good) > 0.9


def test_an_observer_without_a_filter_has_no_error_that_is_known():
    sliding = make_observer(
        'sosml',
        {name: [0.0] for name in OBSERVERS['sosml'].gain_units} | {'sliding': [1.0]},
    )
    noise = np.random.default_rng(6).standard_normal(400)
    assert np.isnan(fed(sliding, np.arange(400) * 4e-3, noise)).all()


class Heard:
    """Feed a health with estimates at the rate HZ on a clock of its own."""

    def __init__(self) -> None:
        self.health = ObserverHealth(JOINTS)
        self.now = 100.0

    def estimates(self, seconds, known=(True, True), cause='broken', stamp_ns=None):
        for _ in range(round(seconds * HZ)):
            self.now += 1.0 / HZ
            estimate = np.where(known, 1.0, np.nan)
            causes = {n: cause for n, k in zip(JOINTS, known, strict=True) if not k}
            t_ns = round(self.now * 1e9) if stamp_ns is None else stamp_ns
            self.health.estimated(self.now, t_ns, estimate, causes)

    def said(self, later=0.0):
        self.now += later
        return self.health.judge(self.now, 0.05)


def test_nothing_heard_is_stale_and_says_what_to_do():
    said = Heard().said(3.0)
    assert {s.level for s in said} == {'stale'}
    assert 'no joint_states yet: start the driver' in said[0].message


def test_a_dead_publisher_is_an_error_that_says_since_when_and_it_recovers():
    heard = Heard()
    heard.estimates(3.0)
    assert [s.level for s in heard.said()] == ['ok', 'ok', 'ok']
    dead = heard.said(6.0)
    assert {s.level for s in dead} == {'error'}
    assert 'no joint_states for 6.0 s: see whether the driver runs' in dead[0].message
    heard.estimates(1.5)
    assert [s.level for s in heard.said()] == ['ok', 'ok', 'ok']


def test_what_is_not_known_is_never_ok_and_the_cause_is_said():
    heard = Heard()
    heard.estimates(3.0)
    heard.estimates(2.0, (False, False), 'no velocity')
    said = heard.said()
    assert {s.level for s in said} == {'error'}
    assert 'nothing is estimated: no velocity' in said[0].message
    heard.estimates(2.0, (False, True), 'no effort')
    assert [s.level for s in heard.said()] == ['warn', 'error', 'ok']
    assert 'shoulder: no effort' in heard.said()[0].message


@pytest.mark.parametrize('kind', ['gap', 'lost', 'repeated', 'backwards'])
def test_an_event_is_told_for_a_second_and_no_longer(kind):
    heard = Heard()
    heard.estimates(2.0)
    heard.health.event(heard.now, kind)
    assert heard.said()[0].level == 'warn'
    heard.estimates(1.1)
    assert heard.said()[0].level == 'ok'


def test_the_rate_is_that_of_the_last_second():
    heard = Heard()
    heard.estimates(3.0)
    heard.said(20.0)
    heard.estimates(1.0)
    assert heard.said()[0].values['rate by stamps [Hz]'] == pytest.approx(HZ, rel=0.01)


def test_a_stream_that_is_slower_than_a_message_a_second_is_estimated():
    heard = Heard()
    for _ in range(5):
        heard.now += 2.0
        heard.health.estimated(heard.now, round(heard.now * 1e9), np.ones(2), {})
    heard.now += 1.5
    assert [s.level for s in heard.health.judge(heard.now, 6.0)] == ['ok', 'ok', 'ok']


def test_stamps_that_are_all_zero_are_said():
    heard = Heard()
    heard.health.heard(heard.now, 0)
    assert 'all stamps of joint_states are 0' in heard.said()[0].message
    assert heard.said()[0].level == 'error'
