# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Every trajectory: smooth, at rest at both ends, symmetric where it should be, in its band."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from sosml_friction.cli.main import main
from sosml_friction.exceptions import TrajectoryError
from sosml_friction.identification.segments import SegmentSettings, find_segments
from sosml_friction.model.model_folder import read_model
from sosml_friction.motion import trajectory_kinds
from sosml_friction.motion.building_blocks import (
    TrajectoryBuilder,
    begin_motion,
    check_limits,
    fade,
)
from sosml_friction.motion.plan import plan_trajectory
from sosml_friction.motion.trajectories import (
    COMMON,
    LONGEST_S,
    TRAJECTORIES,
    build_trajectory,
    find_kind,
)
from sosml_friction.motion.trajectory_kind import TrajectoryKind
from sosml_friction.motion.trajectory_kinds.multisine import MultisineSettings, multisine
from sosml_friction.motion.trajectory_kinds.reversal import reversal
from sosml_friction.motion.trajectory_kinds.rich import rich
from sosml_friction.motion.trajectory_kinds.slow_ladder import slow_ladder
from sosml_friction.motion.trajectory_kinds.slow_s_shape import slow_s_shape
from sosml_friction.motion.trajectory_kinds.symmetric_reversals import symmetric_reversals
from sosml_friction.motion.trajectory_loads import limit_uses, trajectory_loads
from sosml_friction.motion.trajectory_option import TrajectoryOption
from sosml_friction.share import share_directory

EVERY = tuple(TRAJECTORIES)
#: Of config/exoskeleton.yaml.
CENTRE = {'shoulder': -np.pi / 2, 'elbow': 1.2}
START = {'shoulder': -np.pi / 2, 'elbow': 0.0}


@pytest.fixture(scope='module')
def robot():
    return read_model(share_directory() / 'config' / 'exoskeleton').make_robot()


def sampled(trajectory, step=1e-3):
    """Return t, q, v, a over the whole trajectory."""
    t = np.arange(0.0, trajectory.duration, step)
    spline = trajectory.spline()
    return t, spline(t), spline(t, 1), spline(t, 2)


@pytest.mark.parametrize('name', EVERY)
def test_it_starts_where_the_robot_is_and_ends_at_the_centre_at_rest(name):
    trajectory = build_trajectory(name, START, CENTRE)
    assert trajectory.names == ('shoulder', 'elbow')
    np.testing.assert_array_equal(trajectory.q[0], list(START.values()))
    np.testing.assert_allclose(trajectory.q[-1], list(CENTRE.values()), rtol=0.0, atol=1e-12)
    np.testing.assert_array_equal(trajectory.v[[0, -1]], np.zeros((2, 2)))
    # The spline's own acceleration is off by its fourth derivative times the step squared / 12.
    a = trajectory.spline()(np.array([0.0, trajectory.duration]), 2)
    np.testing.assert_allclose(a, 0.0, atol=0.02)


@pytest.mark.parametrize('name', EVERY)
def test_acceleration_has_no_jump_and_jerk_is_bounded(name):
    """
    C2 as planned: what the cubic between knots adds falls with the square of their distance.

    Between samples 1 ms apart the acceleration moves by at most 5 % of the largest; were velocity
    planned with a corner, it would move by all of it.
    """
    _, q, v, a = sampled(build_trajectory(name, START, CENTRE))
    assert np.abs(np.diff(a, axis=0)).max() <= 0.05 * np.abs(a).max()
    # The trapezoidal rule leaves h^3 / 12 of a jerk below 200.
    np.testing.assert_allclose(np.diff(q, axis=0), 5e-4 * (v[1:] + v[:-1]), atol=1.7e-8)


@pytest.mark.parametrize('step', [0.02, 0.005])
def test_the_step_of_acceleration_at_knots_falls_with_the_distance_of_the_knots(step):
    """Of a ramp and a wave: jumps are of order dt^2, so the motion itself is C2."""

    def shape(t):
        e = fade(t, 2.0, 0.7)
        s, c = np.sin(5.0 * t)[:, None], np.cos(5.0 * t)[:, None]
        return 0.1 * e.x * s, 0.1 * (e.rate * s + 5.0 * e.x * c)

    motion = (
        TrajectoryBuilder(('a',), np.zeros(1), step).ramp(np.ones(1), 0.3).ramp(np.zeros(1), 0.3)
    )
    built = motion.wave(2.0, shape).build()
    spline = built.spline()
    inner = built.t[1:-1]
    jumps = np.abs(spline(inner + 1e-9, 2) - spline(inner - 1e-9, 2))
    # h^2 / 6 times the fourth derivative, 60 / 0.3^3 at most in the ramp, more than in the wave.
    assert jumps.max() < step**2 / 6.0 * 60.0 / 0.3**3 * 1.1 + 1e-4


@pytest.mark.parametrize('name', EVERY)
def test_the_defaults_are_within_the_limits_of_the_exoskeleton(name, robot):
    check_limits(build_trajectory(name, START, CENTRE), robot, 0.85, [7.0])


@pytest.mark.parametrize('name', EVERY)
def test_it_moves_any_number_of_joints_each_by_its_scale(name, seven_joints):
    """Joint 4 rests at its centre; one of the seven is prismatic and moves a tenth as far."""
    scale = (1.0, 1.0, 1.0, 0.0, 1.0, 0.1, 1.0)
    centre = dict.fromkeys(seven_joints.names, 0.1)
    trajectory = build_trajectory(name, centre, centre, {'scale': scale})
    _, q, v, _ = sampled(trajectory, 0.01)
    np.testing.assert_allclose(q[:, 3], 0.1, atol=1e-15)
    if name not in ('multisine', 'rich'):
        # rich has an offset that is not scaled, and the multisine other phases for each joint.
        np.testing.assert_allclose(v[:, 5], 0.1 * v[:, 0], rtol=0.0, atol=1e-12)
    loads = trajectory_loads(trajectory, seven_joints)
    assert loads.tau.shape == (len(loads.t), 7)


def test_reversals_and_s_shape_are_odd_under_reversal_of_time():
    """v(T - t) = -v(t), and with it q(T - t) = q(t), from a start at the centre."""
    for build in (symmetric_reversals, slow_s_shape):
        trajectory = build(CENTRE, CENTRE)
        t, q, v, _ = sampled(trajectory)
        spline = trajectory.spline()
        np.testing.assert_allclose(spline(trajectory.duration - t, 1), -v, atol=1e-11)
        np.testing.assert_allclose(spline(trajectory.duration - t), q, rtol=0.0, atol=1e-12)


def test_every_half_cycle_of_reversals_passes_the_centre_at_its_speed():
    """4 cycles of 2 half-cycles, up and down: 16 passages per speed, 8 in each direction."""
    speeds = (0.02, 0.05)
    _, q, v, _ = sampled(symmetric_reversals(CENTRE, CENTRE, speeds, cycles=4))
    # A little beside the centre, where no sample is exactly.
    away = q[:, 0] - CENTRE['shoulder'] - 1.23e-6
    crossing = np.flatnonzero(away[1:] * away[:-1] < 0.0)
    for speed in speeds:
        for way in (1.0, -1.0):
            assert np.sum(np.isclose(v[crossing, 0], way * speed, rtol=1e-9)) == 8


@pytest.mark.parametrize('build', [slow_ladder, symmetric_reversals])
def test_time_at_each_speed_is_the_same_in_both_directions(build):
    speeds = (0.01, 0.03)
    _, _, v, _ = sampled(build(CENTRE, CENTRE, speeds))
    for speed in speeds:
        there, back = (
            np.sum(np.isclose(v[:, 1], s * speed, rtol=0.0, atol=1e-12)) for s in (1, -1)
        )
        assert there > 500
        # At either end of a plateau a sample may or may not be in it.
        assert abs(int(there) - int(back)) <= 16


def test_slow_plateaus_last_until_they_have_gone_their_way():
    _, _, v, _ = sampled(slow_ladder(CENTRE, CENTRE, (0.01, 0.1), plateau_s=1.0, way=0.03))
    # Each speed has four plateaus; 1 ms of each end is uncertain.
    for speed, length in ((0.01, 3.0), (0.1, 1.0)):
        there = np.sum(np.isclose(np.abs(v[:, 0]), speed, rtol=0.0, atol=1e-12))
        assert there == pytest.approx(4 * length * 1000, abs=8)


@pytest.mark.parametrize(
    ('build', 'speeds', 'windows'),
    [
        (slow_ladder, (0.01, 0.015, 0.02, 0.03, 0.05, 0.08), 24),
        (symmetric_reversals, (0.02, 0.04, 0.08), 36),
        (slow_s_shape, (0.052,), 8),
    ],
)
def test_the_evaluation_uses_every_plateau_with_an_encoder_of_16_bit(build, speeds, windows):
    """At 500 Hz with 50 urad of noise: a window for each plateau, none between them."""
    t, q, _, _ = sampled(build(CENTRE, CENTRE), 0.002)
    step = 2.0 * np.pi / 2**16
    noise = np.random.default_rng(1).normal(0.0, 5e-5, len(t))
    measured = step * np.round((q[:, 0] + noise) / step)
    found = [s.velocity for s in find_segments(t, measured, SegmentSettings()) if not s.rejected]
    assert len(found) == windows
    for speed in speeds:
        for way in (1.0, -1.0):
            # A step of the encoder over the shortest window, 0.3 s, and 5 %: a window reaches a
            # little into the slow beginning of a turn.
            near = np.abs(np.array(found) - way * speed) < step / 0.3 + 0.05 * speed
            assert near.sum() >= windows // (2 * len(speeds))


def test_the_s_shape_has_the_speed_and_the_times_of_the_paper():
    """Plateaus of 3 s at 0.052 rad/s; a turn of 3 s has 15/8 of the mean acceleration."""
    _, _, v, a = sampled(slow_s_shape(CENTRE, CENTRE, cycles=4))
    plateau = np.isclose(np.abs(v[:, 0]), 0.052, rtol=0.0, atol=1e-12)
    assert plateau.sum() == pytest.approx(8 * 3000, abs=16)
    middle = np.diff(np.flatnonzero(plateau))
    turns = middle[(middle > 2000) & (middle < 3100)]
    np.testing.assert_allclose(turns, 3000, atol=3)
    # Through zero velocity with 15/8 of the mean acceleration of a turn.
    through = np.flatnonzero(v[1:, 0] * v[:-1, 0] < 0.0)
    through = through[np.abs(a[through, 0]) > 0.01]  # the others are rests between moves
    assert len(through) == 7
    np.testing.assert_allclose(np.abs(a[through, 0]), 15 / 8 * 0.104 / 3.0, rtol=1e-3)


def test_the_reversal_is_the_sinusoid_between_its_ramps_and_odd_about_its_middle():
    trajectory = reversal(CENTRE, CENTRE, amplitude=0.2, frequency=0.5, cycles=4.0, ramp_s=2.0)
    begin = trajectory.duration - (4.0 / 0.5 + 4.0)
    spline = trajectory.spline()
    middle = begin + 6.0
    t = np.linspace(-4.0, 4.0, 401)
    wanted = CENTRE['elbow'] + 0.2 * np.sin(np.pi * t)
    # Between knots 20 ms apart a cubic is off by h^4 / 384 of the fourth derivative: 8e-9.
    np.testing.assert_allclose(spline(middle + t)[:, 1], wanted, atol=1e-7)
    t = np.linspace(0.0, 6.0, 301)
    away = spline(middle + t) - list(CENTRE.values())
    np.testing.assert_allclose(spline(middle - t) - list(CENTRE.values()), -away, atol=1e-9)


SINES = MultisineSettings(
    amplitude=0.2,
    peak_speed=0.6,
    peak_acceleration=3.0,
    band=(0.2, 0.8),
    period_s=10.0,
    periods=2,
    seed=5,
)


def test_the_multisine_is_periodic_and_has_only_lines_of_its_band():
    """Two periods are the same; outside 0.2 to 0.8 Hz there is nothing; joints share no line."""
    trajectory = multisine(CENTRE, CENTRE, SINES)
    begin = trajectory.duration - (20.0 + 2 * SINES.ramp_s) + SINES.ramp_s
    spline = trajectory.spline()
    t = begin + np.arange(2000) * 0.01
    q = spline(t)
    np.testing.assert_allclose(q[:1000], q[1000:], atol=1e-7)
    spectrum = np.abs(np.fft.rfft(q - q.mean(axis=0), axis=0)) / len(q)
    frequency = np.arange(len(spectrum)) / 20.0
    inside = (frequency > 0.2 - 1e-9) & (frequency < 0.8 + 1e-9)
    # The cubic between knots leaves some 1e-8.
    assert spectrum[~inside].max() < 1e-7
    present = spectrum > 1e-4
    assert present.sum(axis=0).tolist() == [4, 3]
    assert not (present[:, 0] & present[:, 1]).any()
    # The same velocity at each frequency.
    for joint in range(2):
        lines = frequency[present[:, joint]] * spectrum[present[:, joint], joint]
        np.testing.assert_allclose(lines, lines[0], rtol=1e-4)


def test_the_multisine_keeps_its_peaks_and_reaches_one_of_them_on_each_joint():
    for settings in (SINES, MultisineSettings(), MultisineSettings(peak_acceleration=0.5)):
        trajectory = multisine(CENTRE, CENTRE, settings)
        _, q, v, a = sampled(trajectory)
        peaks = np.array([
            np.abs(q - list(CENTRE.values())).max(axis=0) / settings.amplitude,
            np.abs(v).max(axis=0) / settings.peak_speed,
            np.abs(a).max(axis=0) / settings.peak_acceleration,
        ])  # fmt: skip
        # The peak is looked for between 40 points of the shortest cycle: off by (pi / 40)^2 / 2.
        assert peaks.max() < 1.004
        np.testing.assert_allclose(peaks.max(axis=0), 1.0, atol=0.004)


def test_the_seed_of_the_multisine_is_its_phases():
    one, same, other = (
        multisine(CENTRE, CENTRE, MultisineSettings(seed=seed)).q for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(one, same)
    assert np.abs(one - other).max() > 0.05


def test_rich_has_two_postures_with_plateaus_reversals_and_multisine():
    """The reversals decay to 5 %; the postures are the centre and 0.3 rad below it."""
    trajectory = rich(CENTRE, CENTRE)
    t, q, v, _ = sampled(trajectory)
    shoulder = q[:, 0] - CENTRE['shoulder']
    half = t < 0.5 * trajectory.duration
    assert np.median(shoulder[half]) == pytest.approx(0.0, abs=0.02)
    assert np.median(shoulder[~half]) == pytest.approx(-0.3, abs=0.02)
    for speed in (0.02, 0.06, 0.2, 0.5):
        for way in (1.0, -1.0):
            for part in (half, ~half):
                assert np.isclose(v[part, 0], way * speed, rtol=0.0, atol=1e-12).sum() > 1500
    # The turning points after the ladder of the first posture.
    ladder_ends = t[
        np.flatnonzero(np.isclose(np.abs(v[:, 0]), 0.02, rtol=0.0, atol=1e-12) & half)[-1]
    ]
    waves = (t > ladder_ends + 3.5) & (t < ladder_ends + 2.5 * 10 - 3.5)
    turns = np.flatnonzero((v[1:, 0] * v[:-1, 0] < 0.0) & waves[1:])
    heights = np.abs(shoulder[turns])
    assert (np.diff(heights) < 0.0).all()
    # Two turns per cycle, exp(ln(0.05) / 16) from one to the next.
    np.testing.assert_allclose(heights[1:] / heights[:-1], 0.05 ** (1 / 16), rtol=0.02)


@pytest.mark.parametrize('name', EVERY)
def test_a_limit_that_is_not_held_is_a_sentence(name, robot):
    """With joint, value, time and limit, before anything moves: a shoulder close to its stop."""
    close = {'shoulder': -2.299, 'elbow': 1.2}
    trajectory = build_trajectory(name, close, close)
    with pytest.raises(TrajectoryError) as caught:
        check_limits(trajectory, robot)
    text = str(caught.value)
    assert re.search(r'joint shoulder to a position of -2\.\d* at \d+\.\d\d s, ', text)
    assert 'beyond its limit of -2.3: change its centre or speeds' in text
    assert '\n' not in text


def test_acceleration_is_limited_where_a_limit_is_given(robot):
    trajectory = build_trajectory('reversal', CENTRE, CENTRE)
    check_limits(trajectory, robot, 0.85, [4.0])
    # 0.35 rad at 0.5 Hz: 3.45 rad/s2 and somewhat more in the ramps.
    with pytest.raises(TrajectoryError, match='joint elbow to an acceleration of'):
        check_limits(trajectory, robot, 0.85, [4.0, 3.4])
    with pytest.raises(TrajectoryError, match='3 values for 2 joints'):
        check_limits(trajectory, robot, 0.85, [4.0, 3.4, 1.0])


def test_the_effort_that_is_checked_is_that_of_the_rigid_body(robot):
    """At rest it is gravity; the sentence has the limit with the allowance for friction."""
    trajectory = build_trajectory('slow_ladder', CENTRE, CENTRE)
    loads = trajectory_loads(trajectory, robot)
    np.testing.assert_allclose(loads.tau[0], robot.gravity(loads.q[0]), atol=0.01)
    uses = {(u.joint, u.quantity): u for u in limit_uses(loads, robot, 0.5)}
    assert uses['shoulder', 'rigid-body effort'].limit == 4.0
    assert uses['shoulder', 'rigid-body effort'].excess < 0.0
    assert abs(uses['elbow', 'rigid-body effort'].value) == pytest.approx(
        np.abs(loads.tau[:, 1]).max()
    )


@pytest.mark.parametrize(
    ('name', 'values', 'words'),
    [
        ('zigzag', {}, 'is unknown: use speed_ladder, symmetric_reversals, slow_ladder'),
        ('reversal', {'speeds': (0.1,)}, "has no option 'speeds': use amplitude, frequency"),
        ('reversal', {'amplitude': 0.0}, 'amplitude is 0.0: give finite numbers from'),
        ('reversal', {'amplitude': float('nan')}, 'amplitude is nan'),
        ('reversal', {'amplitude': (0.1, 0.2)}, 'give one number'),
        ('multisine', {'seed': 1.5}, 'seed is 1.5: give a whole number'),
        ('multisine', {'band': (1.0, 0.5)}, 'the lowest and the highest frequency'),
        ('multisine', {'band': (0.11, 0.14)}, 'holds 0 multiples of 1 / 20 s for 2 joints'),
        ('speed_ladder', {'speeds': ()}, 'speeds is empty: give at least one number'),
        ('speed_ladder', {'speeds': (0.1, -0.1)}, 'give finite numbers from'),
        ('speed_ladder', {'ramp': 0.0}, 'ramp is 0.0: give finite numbers from'),
        ('symmetric_reversals', {'cycles': 1.5}, 'cycles is 1.5: give a whole number'),
        ('multisine', {'seed': -1}, 'seed is -1: give finite numbers from'),
        ('rich', {'decay': 1.5}, 'decay is 1.5: give finite numbers from'),
        ('rich', {'offset': (float('inf'),)}, 'give finite numbers from'),
        ('slow_ladder', {'scale': (1.0, 2.0, 3.0)}, '3 values for 2 joints'),
        ('slow_s_shape', {'scale': (0.0,)}, 'a positive number to one that moves'),
        ('rich', {'offset': (0.1, 0.2, 0.3)}, 'the offset has 3 values for 2 joints'),
        ('slow_ladder', {'speeds': (1e-4,), 'way': 10.0}, f'more than {LONGEST_S:.0f} s'),
    ],
)
def test_what_cannot_be_built_is_refused(name, values, words):
    with pytest.raises(TrajectoryError) as caught:
        build_trajectory(name, START, CENTRE, values)
    assert words in str(caught.value)
    assert '\n' not in str(caught.value)


def test_numbers_that_the_functions_refuse_themselves():
    with pytest.raises(TrajectoryError, match='name the same joints'):
        reversal(START, {'shoulder': 0.0})
    with pytest.raises(TrajectoryError, match='a wave begins at a speed'):
        TrajectoryBuilder(('a',), np.zeros(1)).ramp(np.ones(1), 0.1).wave(1.0, lambda t: (t, t))


@pytest.mark.parametrize('name', EVERY)
def test_the_default_of_each_option_is_within_its_range_and_reads_back_from_text(name):
    for option in find_kind(name).options:
        value = option.default
        text = ','.join(map(str, value)) if isinstance(value, tuple) else str(value)
        assert option.parse(text) == value
        assert option.description
        with pytest.raises(TrajectoryError, match=f'{option.name} is'):
            option.parse('x')


def test_a_trajectory_goes_by_the_label_of_the_paper_too():
    assert [find_kind(label).name for label in ('T1', 'T2', 'T3')] == [
        'speed_ladder', 'symmetric_reversals', 'slow_ladder',
    ]  # fmt: skip
    with pytest.raises(TrajectoryError, match='is unknown'):
        find_kind('')


@pytest.fixture
def nod():
    """Return a kind of trajectory that is made outside of the package, while the test runs."""

    class Nod(TrajectoryKind):
        name, label, description = 'nod', 'the nod', 'there and back once'
        options = (TrajectoryOption('way', 'way', 0.1, 'how far', 'rad or m', (1e-3, 1.0)),)

        @staticmethod
        def build(start, centre, way, scale):
            motion, middle, factor = begin_motion('the nod', start, centre, scale)
            return motion.move(middle + way * factor, 0.5).move(middle, 0.5).build()

    yield Nod
    TrajectoryKind.registry.remove('nod')


def test_a_kind_from_outside_the_package_is_listed_found_checked_and_built(nod):
    assert TRAJECTORIES['nod'] is nod is find_kind('the nod')
    _, q, _, _ = sampled(build_trajectory('nod', CENTRE, CENTRE, {'way': 0.2}))
    assert np.ptp(q[:, 0]) == pytest.approx(0.2, rel=1e-3)
    with pytest.raises(TrajectoryError, match=r'way is 2\.0: give finite numbers from'):
        build_trajectory('nod', CENTRE, CENTRE, {'way': 2.0})
    with pytest.raises(TrajectoryError, match=r'is unknown: use speed_ladder, .*\bnod\b'):
        find_kind('shake')
    planned = plan_trajectory('nod', None, None, ['way=0.05'])
    assert planned.options['way'] == 0.05


def test_a_kind_that_does_not_say_what_it_must_or_takes_a_name_is_refused():
    said = {'name': 'nod', 'label': 'the nod', 'options': ()}
    with pytest.raises(TypeError, match='does not say its description, build'):
        type('Nod', (TrajectoryKind,), said)
    said |= {'description': 'there and back', 'build': None, 'label': 'T1'}
    with pytest.raises(TypeError, match='has the name or label of SpeedLadder'):
        type('Nod', (TrajectoryKind,), said)
    assert 'nod' not in TRAJECTORIES


@pytest.mark.parametrize('name', EVERY)
def test_every_kind_says_what_programs_need_of_it(name):
    kind = TRAJECTORIES[name]
    assert (kind.name, kind) == (name, find_kind(kind.label))
    assert kind.description
    assert kind.role in ('', 'T1', 'T2', 'T3')
    names = [option.name for option in (*kind.options, *COMMON)]
    keywords = [option.keyword for option in (*kind.options, *COMMON)]
    assert len(set(names)) == len(names)
    assert len(set(keywords)) == len(keywords)
    for option in kind.options:
        assert option.range is not None, 'a node has a range for each of its parameters'
        assert option.check(option.default) == option.default


def test_the_paper_has_a_trajectory_for_each_role_and_all_files_of_kinds_are_registered():
    assert [kind.role for kind in TRAJECTORIES.values() if kind.role] == ['T1', 'T2', 'T3']
    folder = Path(trajectory_kinds.__file__).parent
    assert set(TRAJECTORIES) == {path.stem for path in folder.glob('[!_]*.py')}


def test_the_help_of_the_command_names_every_kind(capsys):
    main(['trajectory', '--help'])
    words = re.sub(r'[\s│]+', ' ', capsys.readouterr().out)
    for name in EVERY:
        assert re.search(rf'\b{name}\b', words)
