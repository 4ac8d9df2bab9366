# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction of a joint at rest is unknown: it hides no cause, and is called none."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from full_runs import only_full
from known_robots import SLIDER_MASS, recording, slider_model
from lockstep import emulated_exoskeleton
from lockstep_run import run_lockstep

from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.model.dahl import dahl_path
from sosml_friction.model.model_folder import read_model
from sosml_friction.model.terms.kinds.term import DATA_CAUSES
from sosml_friction.motion.trajectory_kinds.speed_ladder import speed_ladder
from sosml_friction.regression.band import Band
from sosml_friction.regression.noise_model import ORDER, NoiseModel
from sosml_friction.regression.rests import (
    WhitenedRests,
    find_rests,
    resting,
    stopping_joints,
)
from sosml_friction.regression.row_bases import RowBases
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare, with_rests
from sosml_friction.share import share_directory

STEP = 2e-3
BAND = Band(12.0, STEP)
LIMIT, TOP = np.array([1.4e-3]), np.array([0.7])
SETTINGS = DiagnosisSettings()


def stop_and_go():
    """Return a position (N, 1) that goes 0.5 s at 0.7 rad/s, stands 0.5 s, and goes on."""
    t = np.arange(0.0, 6.0, STEP)
    v = np.where(t % 1.0 < 0.5, 0.7, 0.0)
    return t, np.cumsum(v)[:, None] * STEP


def test_any_course_of_effort_at_rest_leaves_nothing_and_other_efforts_stay():
    t, q = stop_and_go()
    rests = find_rests(q, BAND, LIMIT, TOP, [0])
    assert len(resting(q[:, 0], BAND, 1e-3)) == 6
    rng = np.random.default_rng(0)
    stands = np.zeros(len(t))
    for begin, end in resting(q[:, 0], BAND, 1e-3):
        # Steps and a random walk: nothing that the knots were made for.
        stands[begin:end] = np.cumsum(rng.normal(0.0, 0.1, end - begin)) + rng.normal()
    assert (np.diff(q[:, 0], append=q[-1, 0])[stands != 0.0] < 1e-9).mean() > 0.85
    before = BAND.apply(stands[:, None])
    after = RowBases(rests).take_out(before.copy(), [0])
    assert np.abs(before).max() > 1.0
    # What the knots are too coarse for is above the band.
    assert np.abs(after).max() < 0.02 * np.abs(before).max()
    # In the middle of its way, where no rest is within reach of the filter, all of it stays.
    seen = np.zeros(BAND.count(len(t)), dtype=bool)
    for rest in rests:
        seen[rest.rows] = True
    other = BAND.apply(rng.normal(size=(len(t), 1)))
    assert (RowBases(rests).take_out(other.copy(), [0]) == other)[~seen].all()
    assert (RowBases(rests).take_out(other.copy(), [1]) == other).all()


@pytest.mark.parametrize('seed', range(4))
def test_rests_that_the_filter_sees_at_once_are_taken_out_together(seed):
    """Of any length and as close to each other as they come."""
    rng = np.random.default_rng(seed)
    v = np.zeros(4000)
    k = 100
    while k < len(v):
        moving = int(rng.integers(1, 120))
        v[k : k + moving] = 0.7
        k += moving + int(rng.integers(50, 400))
    q = v.cumsum()[:, None] * STEP
    rests = find_rests(q, BAND, LIMIT, TOP, [0])
    stands = np.zeros(len(v))
    for sign, (begin, end) in enumerate(resting(q[:, 0], BAND, 1e-3)):
        stands[begin:end] = (-1.0) ** sign * np.linspace(1.0, 0.5, end - begin)
    before = BAND.apply(stands[:, None])
    after = RowBases(rests).take_out(before.copy(), [0])
    assert np.abs(before).max() > 0.5
    assert np.abs(after).max() < 0.02 * np.abs(before).max()


def test_a_chain_of_rests_is_parted_where_it_is_long_and_every_rest_is_taken_out():
    """A joint stops five times a second for minutes: a base has 512 rows and one rest more."""
    rng = np.random.default_rng(7)
    v = np.zeros(200_000)
    for k in range(100, len(v), 100):
        v[k : k + 40] = 0.7 * (-1.0) ** (k // 1000)
    q = v.cumsum()[:, None] * STEP
    rests = find_rests(q, BAND, LIMIT, TOP, [0])
    rows = BAND.count(len(v))
    longest = max(rest.rows.stop - rest.rows.start for rest in rests if rest.base is not None)
    assert rows > 2000
    assert longest < 512 + 3 * BAND.half // BAND.factor + 60
    stands = np.zeros(len(v))
    for begin, end in resting(q[:, 0], BAND, 1e-3):
        stands[begin:end] = rng.uniform(-1.0, 1.0)
    before = BAND.apply(stands[:, None])
    after = RowBases(rests).take_out(before.copy(), [0])
    assert np.abs(before).max() > 0.5
    assert np.abs(after).max() < 0.02 * np.abs(before).max()
    model = NoiseModel(np.append([1.6, -0.8], np.zeros(ORDER - 2)), 0.1)
    known = WhitenedRests([rests], [rows], [model.whitening])
    whitened = model.whiten(before[:, 0])[:, None]
    left = known.take_out(whitened.copy(), [0])
    assert np.abs(left).max() < 0.02 * np.abs(whitened).max()
    # What is lost by parting is little: some rows of each 512.
    alone = rows - sum(
        r.rows.stop - r.rows.start if r.base is None else r.base.shape[1] for r in rests
    )
    assert 0.8 * alone < float(known.known()[0]) <= rows


def test_whitened_rows_do_not_know_what_was_at_rest_and_noise_in_motion_stays_noise():
    """
    Noise of AR(2), as drawn; the whitening filter amplifies what is cut out before it 20 times.

    Of white rows no projection can make more than there are.
    """
    t, q = stop_and_go()
    rests = find_rests(q, BAND, LIMIT, TOP, [0])
    model = NoiseModel(np.append([1.6, -0.8], np.zeros(ORDER - 2)), 0.1)
    rows, rng = BAND.count(len(t)), np.random.default_rng(1)
    known = WhitenedRests([rests], [rows], [model.whitening])
    stands = np.zeros(len(t))
    for begin, end in resting(q[:, 0], BAND, 1e-3):
        stands[begin:end] = np.cumsum(rng.normal(0.0, 0.1, end - begin)) + rng.normal()
    energies = []
    for _ in range(200):
        noise = model.draw(rows, rng)
        with_rests = noise + BAND.apply(stands[:, None])[:, 0]
        a, b = (
            known.take_out(model.whiten(x)[:, None].copy(), [0])[:, 0] for x in (noise, with_rests)
        )
        energies.append(float(a @ a))
    # The courses are smooth between rows of the band: 2 % of them is left, as above.
    assert np.abs(a - b).max() < 0.02 * np.abs(model.whiten(BAND.apply(stands[:, None]))).max()
    # chi2 of as many as say something; 5 standard errors of the mean of 200.
    count = float(known.known()[0])
    assert np.mean(energies) == pytest.approx(count, abs=5.0 * math.sqrt(2.0 * count / 200))
    assert 0 < count < rows


def test_rows_that_rests_do_not_reach_stay_as_they_are():
    t, q = stop_and_go()
    rows = BAND.count(len(t))
    model = NoiseModel(np.append([1.6, -0.8], np.zeros(ORDER - 2)), 0.1)
    known = WhitenedRests([find_rests(q, BAND, LIMIT, TOP, [0])], [rows], [model.whitening])
    x = np.random.default_rng(3).normal(size=(rows - ORDER, 1))
    changed = known.take_out(x.copy(), [0]) != x
    reached = known.reached()
    assert not changed[~reached].any()
    # Rows that no course of the effort at rest gets to are few among them.
    assert 0.85 * reached.sum() < changed.sum() < 0.9 * len(x)


def test_friction_that_fades_at_rest_is_no_cause():
    """A slider whose own model is given; what it takes at rest decays from friction to nothing."""
    # Of seeds 0 to 9 one, 0, has a curve over acceleration of 22.2 with a floor of 22.1.
    rng = np.random.default_rng(1)
    t = np.arange(0.0, 40.0, 4e-3)
    q, v, a = np.zeros((3, len(t)))
    here, start = 0.0, 0.3
    still = np.ones(len(t), dtype=bool)
    age = np.zeros(len(t))
    while start < t[-1]:
        there, time = rng.uniform(-0.12, 0.12), 0.8 * rng.uniform(0.7, 1.4)
        rows = (t >= start) & (t < start + time)
        s = (t[rows] - start) / time
        way = there - here
        q[rows] = here + way * (10 * s**3 - 15 * s**4 + 6 * s**5)
        v[rows] = way * (30 * s**2 - 60 * s**3 + 30 * s**4) / time
        a[rows] = way * (60 * s - 180 * s**2 + 120 * s**3) / time**2
        q[t >= start + time], here = there, there
        still[rows] = False
        age[t >= start + time] = t[t >= start + time] - start - time
        start += time + 1.5 * rng.uniform(0.7, 1.3)
    friction = 20.0 * dahl_path(q, 3e-5) * np.where(still, np.exp(-age / 0.3), 1.0)
    tau = SLIDER_MASS * a + friction + 200.0 * v + rng.normal(0.0, 1.0, len(t))
    log = recording(('slider',), t, q, tau)
    found = diagnose([log], slider_model(20.0, 200.0), settings=SETTINGS)
    assert 'rest' in [check.kind for check in found.checks]
    assert found.verdict == 'nothing_above_floor', found.sentence


def test_a_long_hold_takes_no_more_memory_than_its_ends():
    t = np.arange(0.0, 310.0, STEP)
    q = 0.3 * np.minimum(t, 5.0) + 0.3 * np.maximum(t - 305.0, 0.0)
    rests = find_rests(q[:, None], BAND, LIMIT, TOP, [0])
    held = slice(round(5.0 / STEP), round(305.0 / STEP))
    effort = np.zeros((len(t), 1))
    effort[held, 0] = np.sin(np.arange(held.stop - held.start) * 1e-3)
    before = BAND.apply(effort)
    after = RowBases(rests).take_out(before.copy(), [0])
    assert np.abs(after).max() < 0.02 * np.abs(before).max()
    assert sum(rest.base.size for rest in rests if rest.base is not None) < 1e4


def test_a_turn_in_passing_is_no_rest_nor_is_standing_throughout():
    t = np.arange(0.0, 20.0, STEP)
    swing = (0.35 * np.sin(2.0 * t))[:, None]
    still = np.zeros((len(t), 1))
    assert stopping_joints([(swing, BAND), (still, BAND)], LIMIT, TOP) == []
    # Nor where it stops elsewhere: all it takes here would be lost.
    assert find_rests(still, BAND, LIMIT, TOP, [0]) == ()


def test_a_joint_that_stops_anywhere_rests_wherever_it_is_as_slow():
    """A hole that cuts its long stops leaves turns that are as much a rest as before."""
    t, q = stop_and_go()
    # From one motion to the next, a stop of 0.18 s.
    turn = np.cumsum(np.where(np.abs(t - 3.0) < 0.09, 0.0, 0.7))[:, None] * STEP
    assert stopping_joints([(turn, BAND)], LIMIT, TOP) == []
    assert stopping_joints([(turn, BAND), (q, BAND)], LIMIT, TOP) == [0]
    assert len(resting(turn[:, 0], BAND, 1e-3)) == 1


def braking(least, pause_s, gone_on_s=2.0):
    """Return a position (N, 1) that brakes to a speed at 4 rad/s2, stays there, and goes on."""
    t = np.arange(0.0, 2.0 * gone_on_s, STEP)
    away = np.maximum(np.abs(t - gone_on_s) - 0.5 * pause_s, 0.0)
    return np.cumsum(np.minimum(0.7, least + 4.0 * away))[:, None] * STEP


def test_a_joint_that_sticks_does_so_where_it_stops_for_a_moment_too():
    """
    Friction is anything where it stops, whether it goes on to the other side or to the same.

    So it is not where it only goes slower, nor in a plateau of a speed ladder, which is no stop.
    """
    limit = np.array([3e-3])

    def unknown(q):
        rests = find_rests(q, BAND, limit, TOP, [], [0])
        at = (np.array([rest.rows.start + rest.rows.stop for rest in rests]) * 0.5) * BAND.factor
        return at * STEP

    assert stopping_joints([(braking(0.0, 0.03), BAND)], limit, TOP) == []
    stops = unknown(braking(0.0, 0.03))
    assert len(stops)
    assert np.abs(stops + BAND.half * STEP - 2.0).max() < 0.3
    assert len(unknown(braking(0.2, 0.03))) == 0
    assert len(unknown(braking(0.06, 1.0))) == 0


def test_a_joint_that_rests_is_unknown_where_it_stops_in_passing_and_not_where_it_turns():
    """A stop is one however short; evidence of a gear, or of presliding, is at turns."""
    limit, stop = np.array([3e-3]), braking(0.0, 0.03)
    turn = np.minimum(stop, 2.0 * stop[len(stop) // 2] - stop)
    (there,) = find_rests(stop, BAND, limit, TOP, [0])
    middle = 0.5 * (there.rows.start + there.rows.stop) * BAND.factor * STEP
    assert middle + BAND.half * STEP == pytest.approx(2.0, abs=0.3)
    assert find_rests(turn, BAND, limit, TOP, [0]) == ()


def at_speeds(*parts):
    """Return a position (N, 1) of so many seconds at each speed, 0.2 s from one to the next."""
    times, speeds = np.cumsum([0.0, *(x for s, _ in parts for x in (s, 0.2))]), []
    for _, v in parts:
        speeds += [v, v]
    t = np.arange(0.0, times[-1], STEP)
    return np.cumsum(np.interp(t, times[:-1], speeds))[:, None] * STEP


def unknown_samples(q, limit):
    """Return the samples (N,) in the middle of rows that see nothing but a rest."""
    unknown = np.zeros(len(q), dtype=bool)
    for rest in find_rests(q, BAND, limit, TOP, [0]):
        rows = (rest.rows.start * BAND.factor, (rest.rows.stop - 1) * BAND.factor + 1)
        unknown[slice(*(row + BAND.half for row in rows))] = True
    return unknown


@pytest.mark.parametrize(('speed', 'slow'), [(4e-3, False), (1.2e-2, False), (4e-4, True)])
def test_a_slow_plateau_is_a_motion_and_a_hold_or_what_creeps_is_none(speed, slow):
    """
    Both are below 2 % of the top speed, 14 mm/s; over 4 s one goes 80 displacements of its sign.

    A Stribeck term was not seen, as the plateaus that show it were left out as rests.
    """
    limit = np.array([2e-4])
    q = at_speeds((1.0, 0.7), (4.0, speed), (1.0, 0.7), (1.0, 0.0), (1.0, 0.7))
    rests = unknown_samples(q, limit)
    plateau, hold = (slice(round(a / STEP), round(b / STEP)) for a, b in ((1.4, 5.0), (6.8, 7.4)))
    assert rests[plateau].all() == rests[plateau].any() == slow
    assert rests[hold].all()
    # 2 mm/s that fade within 0.4 s are 4 displacements.
    t = np.arange(0.0, 4.0, STEP)
    creep = np.cumsum(np.where(t < 1.0, 0.7, 2e-3 * np.exp(-(t - 1.0) / 0.4)))[:, None] * STEP
    assert unknown_samples(creep, limit)[round(1.2 / STEP) : round(3.8 / STEP)].all()


def test_a_hold_at_the_end_of_a_recording_is_a_stop():
    """It sticks there as anywhere, for as long as the effort says nothing of motion."""
    assert stopping_joints([(at_speeds((2.0, 0.7), (2.0, 0.0)), BAND)], LIMIT, TOP) == [0]
    assert stopping_joints([(at_speeds((2.0, 0.0), (2.0, 0.7)), BAND)], LIMIT, TOP) == []


def test_another_recording_rests_where_this_one_stops():
    """What is left out of a fit is left out of the data that it is measured on."""
    t, q = stop_and_go()
    turn = np.cumsum(np.where(np.abs(t - 3.0) < 0.09, 0.0, 0.7))[:, None] * STEP
    tau = 1.0 + 0.0 * t
    model = slider_model()
    logs = [recording(('slider',), t, 0.1 * x[:, 0], tau) for x in (q, turn)]
    stops, passes = (prepare([log], model, model.make_robot(), SETTINGS) for log in logs)
    assert [s.rests for s in with_rests(passes)] == [()]
    (alone,), (like,) = with_rests(stops), with_rests(passes, stops)
    assert len(alone.rests) > 1
    assert {rest.joint for rest in like.rests} == {0}


@pytest.fixture(scope='module')
def recorded():
    """Return a short T1 on the emulated exoskeleton, in emulated time: samples are even."""
    ladder = speed_ladder(
        {'shoulder': -0.5 * math.pi, 'elbow': 0.0},
        {'shoulder': -0.5 * math.pi, 'elbow': 1.2},
        [0.05, 0.1, 0.4],
        plateau_s=0.8,
    )
    return run_lockstep(ladder, emulated_exoskeleton(seed=7))


def diagnosed(log, name):
    """Return the diagnosis with a shipped model, and the causes that are not of the data."""
    found = diagnose([log], read_model(share_directory() / 'config' / name), settings=SETTINGS)
    return found, [cause for cause in found.causes if cause.effect not in DATA_CAUSES]


def test_the_emulators_own_model_explains_its_recording(recorded):
    """
    Nothing is named, and free curves find nothing.

    Its joints creep where they stop, with less and less friction; as long as the sign of the last
    motion was taken for friction at rest, this was unknown_structure.
    """
    found, causes = diagnosed(recorded, 'emulated_exoskeleton')
    assert causes == []
    assert found.verdict != 'unknown_structure'
    assert 'rest' in [check.kind for check in found.checks]
    assert abs(found.refit['shoulder coulomb']) < 0.02 * 0.8
    assert abs(found.refit['elbow coulomb']) < 0.02 * 0.4


def check_stribeck(found, causes):
    """Ask for a Stribeck term in each joint, with its friction at the slowest plateau."""
    assert found.verdict == 'named'
    named = {cause.joint: cause.parameters for cause in causes if cause.effect == 'stribeck'}
    assert len(named) == len(causes) == 2
    for joint, stribeck in (('shoulder', 0.5), ('elbow', 0.25)):
        p = {name: parameter.value for name, parameter in named[joint].items()}
        # S alone is at standstill, where no data are: at the slowest plateau it is known.
        fade = (0.05 / p['stribeck_velocity']) ** p['exponent']
        assert p['stribeck'] * math.exp(-fade) == pytest.approx(
            stribeck * math.exp(-0.05 / 0.03), rel=0.15
        )


@only_full
def test_a_model_without_friction_lacks_a_stribeck_term_in_both_joints(recorded):
    check_stribeck(*diagnosed(recorded, 'exoskeleton'))


def test_a_hole_in_the_recording_changes_no_name(recorded):
    """
    What is longer than half a period of the band cuts it, after 12 s.

    As long as each piece was asked for a long stop of its own, and short pieces of noise made an
    unstable filter, a coupling of the joints was named beside.
    """
    first = int(np.searchsorted(recorded.time, 12.0))
    lost = np.arange(first, first + round(0.05 / recorded.step))
    holed = recorded.rows(np.delete(np.arange(len(recorded)), lost))
    found, causes = diagnosed(holed, 'exoskeleton')
    lab = found.laboratory
    assert len(lab.signals) == 2
    bare = [replace(signals, rests=()) for signals in lab.signals]
    for one, other in zip(lab.seen_alike(bare), lab.signals, strict=True):
        assert one.rests
        assert [rest.rows for rest in one.rests] == [rest.rows for rest in other.rests]
    check_stribeck(found, causes)
