# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Proposals for tables whose columns are known: any order, layout, unit and name."""

import math
import re
from datetime import datetime, timedelta, timezone

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from sosml_friction.bags.tables.data_file import DataFile
from sosml_friction.bags.tables.guess import guess_mapping
from sosml_friction.bags.tables.header_words import read_header, read_headers
from sosml_friction.bags.tables.importer import read_recording
from sosml_friction.bags.tables.mapping import FILL_IN, parse_mapping
from sosml_friction.bags.tables.stated_columns import Columns, map_columns
from sosml_friction.exceptions import ConfigurationError, DataError, SosmlFrictionError

SPEEDS = {'rad/s': 1.0, 'deg/s': math.pi / 180, 'rpm': math.pi / 30, 'turns/s': 2 * math.pi}
ANGLES = {'rad': 1.0, 'deg': math.pi / 180, 'turns': 2 * math.pi}


def joint(seed, samples=2500, rate=250.0):
    """Return t, q [rad], v and effort [Nm] of a joint with friction, gravity and noise."""
    rng = np.random.default_rng(seed)
    t = np.arange(samples) / rate
    w, phase = rng.uniform(1.0, 4.0, 3), rng.uniform(0.0, 6.0, 3)
    size = np.array([0.9, 0.5, 0.3])
    q = np.sum(size * np.sin(np.outer(t, w) + phase), axis=1)
    v = np.sum(size * w * np.cos(np.outer(t, w) + phase), axis=1)
    a = np.sum(-size * w**2 * np.sin(np.outer(t, w) + phase), axis=1)
    tau = 0.1 * a + 1.5 * np.sin(q) + 0.8 * np.sign(v) + 0.2 * v
    noise = rng.normal(0.0, 1.0, (3, samples))
    return t, q + 2e-5 * noise[0], v + 0.01 * noise[1], tau + 0.05 * noise[2]


def save(folder, columns, header=None):
    path = folder / 'x.csv'
    text = '' if header is None else ','.join(header) + '\n'
    rows = [','.join(repr(float(x)) for x in row) for row in zip(*columns, strict=True)]
    path.write_text(text + '\n'.join(rows) + '\n')
    return DataFile(path)


def roles(guess):
    """Return the variables by joint and quantity."""
    return {
        name: {quantity: entry['variable'] for quantity, entry in own.items()}
        for name, own in guess.content['joints'].items()
    }


@given(
    order=st.permutations(range(4)),
    speed=st.sampled_from(list(SPEEDS)),
    seed=st.integers(0, 50),
    time=st.sampled_from([('s', 1.0), ('ms', 1e3), ('us', 1e6), ('ns', 1e9)]),
)
@settings(max_examples=25)
def test_columns_without_names_are_told_by_their_numbers(
    tmp_path_factory, order, speed, seed, time
):
    t, q, v, tau = joint(seed)
    columns = [t * time[1] + 5.0 * time[1], q, v / SPEEDS[speed], tau]
    data = save(tmp_path_factory.mktemp('guess'), [columns[k] for k in order])
    guess = guess_mapping(data)
    assert guess.content['time'] == {'variable': order.index(0), 'unit': time[0]}
    (own,) = guess.content['joints'].values()
    assert own['position'] == {'variable': order.index(1), 'unit': 'rad'}
    assert own['velocity'] == {'variable': order.index(2), 'unit': speed}
    assert own['effort']['variable'] == order.index(3)
    assert guess.left_open == ['joints.joint.effort.unit']


@pytest.mark.parametrize('layout', ['blocks', 'interleaved'])
@pytest.mark.parametrize('count', [2, 3, 7])
def test_joints_without_names_are_told_apart(tmp_path, layout, count):
    parts = [joint(seed) for seed in range(count)]
    own = [list(part[1:]) for part in parts]
    columns = [parts[0][0]]
    for k in range(3):
        columns += [x[k] for x in own] if layout == 'blocks' else []
    columns += [x for part in own for x in part] if layout == 'interleaved' else []
    guess = guess_mapping(save(tmp_path, columns))
    step = (1, count) if layout == 'blocks' else (3, 1)
    assert roles(guess) == {
        f'joint_{j + 1}': {
            quantity: 1 + j * step[0] + k * step[1]
            for k, quantity in enumerate(('position', 'velocity', 'effort'))
        }
        for j in range(count)
    }


def test_a_count_of_the_samples_is_no_time(tmp_path):
    t, q, v, tau = joint(2)
    late = t + 1e-4 * np.random.default_rng(0).random(len(t))
    guess = guess_mapping(save(tmp_path, [np.arange(len(t)), late, q, v, tau]))
    assert guess.content['time'] == {'variable': 1, 'unit': 's'}
    assert roles(guess) == {'joint': {'position': 2, 'velocity': 3, 'effort': 4}}


def test_a_count_alone_is_no_time_until_it_is_said(tmp_path):
    t, q, _, tau = joint(2)
    data = save(tmp_path, [np.arange(len(t)), q, tau], ['frame', 'q', 'tau'])
    guess = guess_mapping(data)
    assert guess.left_open == ['time.unit']
    assert 'a count of the samples' in guess.reasons['time']
    columns = {'position': ['q'], 'effort': ['tau']}
    with pytest.raises(DataError, match='or a count of the samples: say which'):
        map_columns(data, Columns(columns))
    assert map_columns(data, Columns(columns, time='frame:ms')).content['time']['unit'] == 'ms'


@pytest.mark.parametrize('clock', [None, 'frame', 'time'])
def test_a_stated_rate_is_the_time_of_a_table(tmp_path, clock):
    t, q, v, tau = joint(2, rate=200.0)
    # A shaft that turns one way grows all the time, and is no time.
    columns = {'q': 0.02 * q + 0.3 * t, 'dq': 0.02 * v + 0.3, 'tau': tau}
    clocks = {None: {}, 'frame': {'frame': np.arange(len(t))}, 'time': {'time': np.floor(t)}}
    columns = {**clocks[clock], **columns}
    data = save(tmp_path, columns.values(), list(columns))
    guess = guess_mapping(data, rate=200.0)
    assert guess.content['sample_rate'] == 200.0
    assert guess.content['joints']['joint']['velocity'] == {'variable': 'dq', 'unit': 'rad/s'}
    assert roles(guess) == {'joint': {'position': 'q', 'velocity': 'dq', 'effort': 'tau'}}
    assert guess.sentences()[0] == 'sample_rate is 200 Hz: stated'
    assert not any('makes' in remark for remark in guess.remarks)
    stated = map_columns(data, Columns({'position': ['q'], 'effort': ['tau']}, rate=200.0))
    log = read_recording(data.path, parse_mapping(stated.content, data.path))
    np.testing.assert_array_equal(np.diff(log.t_ns), 5_000_000)


def test_time_and_rate_are_one_too_many_and_none_is_too_few(tmp_path):
    t, q, v, tau = joint(2)
    data = save(tmp_path, [t, q, v, tau], ['t', 'q', 'dq', 'tau'])
    columns = {'position': ['q'], 'effort': ['tau']}
    with pytest.raises(ConfigurationError, match='--time and --rate both say when'):
        map_columns(data, Columns(columns, time='t', rate=250.0))
    with pytest.raises(ConfigurationError, match='a rate of 0 Hz is none: give the samples per'):
        map_columns(data, Columns(columns, rate=0.0))
    guess = guess_mapping(data, rate=100.0)
    assert guess.remarks[0].startswith('t makes 250 Hz of it, and the rate of 100 Hz that was')
    without = save(tmp_path, [q, v, tau], ['q', 'dq', 'tau'])
    with pytest.raises(DataError, match='how many samples a second has, as --rate 500'):
        map_columns(without, Columns(columns))
    guess = guess_mapping(without)
    assert guess.left_open == ['sample_rate']
    assert guess.reasons['sample_rate'].endswith('or --rate HZ')


@pytest.mark.parametrize('stated', [False, True])
def test_seconds_and_nanoseconds_are_one_time(tmp_path, stated):
    t, q, v, tau = joint(2)
    ns = np.rint((t + 1.7e9 - 0.3) * 1e9).astype(np.int64)
    np.savez(tmp_path / 'x.npz', sec=ns // 10**9, nanosec=ns % 10**9, q=q, dq=v, tau=tau)
    data = DataFile(tmp_path / 'x.npz')
    guess = guess_mapping(data)
    if stated:
        guess = map_columns(data, Columns({'position': ['q'], 'effort': ['tau']}, time='sec'))
    assert guess.content['time'] == {'variable': 'sec', 'unit': 's', 'nanoseconds': 'nanosec'}
    log = read_recording(data.path, parse_mapping(guess.content, data.path))
    np.testing.assert_array_equal(log.t_ns, ns)


def test_samples_that_were_written_twice_change_nothing(tmp_path):
    columns = [np.insert(x, 100, x[100]) for x in joint(5)]
    own = roles(guess_mapping(save(tmp_path, [columns[k] for k in (0, 1, 3)])))['joint']
    assert own == {'position': 1, 'effort': 2}


def test_joints_without_velocities_are_halves(tmp_path):
    parts = [joint(seed) for seed in range(3)]
    columns = [parts[0][0], *(p[1] for p in parts), *(p[3] for p in parts)]
    guess = guess_mapping(save(tmp_path, columns))
    assert list(roles(guess).values()) == [{'position': k, 'effort': k + 3} for k in (1, 2, 3)]


def test_joints_that_rest_keep_their_place(tmp_path):
    t, *moved = joint(3)
    rng = np.random.default_rng(0)
    still = [1e-5 * rng.integers(-2, 3, len(t)) + x for x in (0.3, -1.2, 0.7)]
    columns = [t]
    for part in moved:
        columns += [still[0], part, still[1], still[2]]
    guess = guess_mapping(save(tmp_path, columns))
    assert [own['position'] for own in roles(guess).values()] == [1, 2, 3, 4]
    assert [own['velocity'] for own in roles(guess).values()] == [5, 6, 7, 8]
    assert 'it rests' in guess.reasons['joints.joint_1.position']


@given(
    angle=st.sampled_from(list(ANGLES)),
    speed=st.sampled_from(list(SPEEDS)),
    seed=st.integers(0, 50),
)
@settings(max_examples=15)
def test_written_units_and_those_of_the_slope_make_the_same_log(
    tmp_path_factory, angle, speed, seed
):
    t, q, v, tau = joint(seed)
    columns = [t, q / ANGLES[angle], v / SPEEDS[speed], 1e3 * tau]
    header = ['time', f'Joint angle [{angle}]', 'joint_speed', 'Torque (mNm)']
    data = save(tmp_path_factory.mktemp('guess'), columns, header)
    guess = guess_mapping(data)
    assert guess.left_open == []
    log = read_recording(data.path, parse_mapping(guess.content, data.path))
    np.testing.assert_allclose(log.q[:, 0], q, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(log.v[:, 0], v, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(log.tau[:, 0], tau, rtol=1e-9, atol=1e-12)


def test_names_of_joints_and_wishes_are_read(tmp_path):
    one, two = joint(1), joint(2)
    columns = [one[0], two[3], one[1], two[1], two[1] + 0.001, one[2], two[2], one[3]]
    header = ['stamp', 'elbow_torque', 'wrist_position', 'elbow_position', 'elbow_position_cmd']
    header += ['wrist_velocity', 'elbow_velocity', 'wrist_torque']
    guess = guess_mapping(save(tmp_path, columns, header))
    quantities = {'position': 'position', 'velocity': 'velocity', 'effort': 'torque'}
    assert roles(guess) == {
        name: {quantity: f'{name}_{word}' for quantity, word in quantities.items()}
        for name in ('wrist', 'elbow')
    }
    assert any('not used: elbow_position_cmd' in remark for remark in guess.remarks)


LOGGERS = {
    'ur_rtde': 'timestamp,target_q_{},actual_q_{},actual_qd_{},actual_joint_voltage_{},'
    'actual_current_{},target_moment_{}',
    'franka': 'time,q_d[{}],q[{}],dq[{}],,tau_J[{}],tau_J_d[{}]',
    'bagpy': 'Time,,position_{},velocity_{},,effort_{},',
    'plotjuggler': '__time,,/js/joint{}/position,/js/joint{}/velocity,,/js/joint{}/effort,',
}


@pytest.mark.parametrize('logger', LOGGERS)
def test_the_headers_of_known_loggers_are_read(tmp_path, logger):
    time, *names = LOGGERS[logger].split(',')
    joints = [joint(k) for k in range(3)]
    header, columns = [time], [joints[0][0] + 1.7e9]
    for k, name in enumerate(names):
        for number, (t, q, v, tau) in enumerate(joints):
            wanted = np.interp(t + 0.01, t, q)
            kinds = (wanted, q, v, 24.0 + 0.1 * v, tau, tau + 0.1)
            if name:
                header.append(name.format(number))
                columns.append(kinds[k])
    guess = guess_mapping(save(tmp_path, columns, header))
    assert guess.content['time'] == {'variable': time, 'unit': 's'}
    expected = [names[k] for k in (1, 2, 4)]
    assert list(roles(guess).values()) == [
        {
            quantity: name.format(number)
            for quantity, name in zip(('position', 'velocity', 'effort'), expected, strict=True)
        }
        for number in range(3)
    ]


def test_of_two_positions_the_later_one_was_measured(tmp_path):
    t, q, _, tau = joint(4)
    wanted = np.interp(t + 0.012, t, q)
    guess = guess_mapping(save(tmp_path, [t, wanted, q, tau]))
    assert roles(guess) == {'joint': {'position': 2, 'effort': 3}}
    assert any(remark.startswith('1 is nearly 2') for remark in guess.remarks)


def test_a_velocity_that_no_unit_explains_is_left_open_with_its_factor(tmp_path):
    t, q, v, tau = joint(5)
    data = save(tmp_path, [t, q, 0.5 * v, tau], ['t', 'q', 'qd', 'tau'])
    guess = guess_mapping(data)
    assert guess.left_open == ['joints.joint.velocity.scale']
    assert 'a scale of 2' in guess.reasons['joints.joint.velocity']


def test_a_wrap_gives_the_unit(tmp_path):
    t, q, _, tau = joint(6)
    wrapped = np.rad2deg((4.0 * q + math.pi) % (2 * math.pi) - math.pi)
    guess = guess_mapping(save(tmp_path, [t, wrapped, tau], ['t', 'q', 'tau']))
    position = guess.content['joints']['joint']['position']
    assert position == {'variable': 'q', 'unit': 'deg', 'wrap': 360.0}


def test_what_is_left_open_is_refused_until_it_is_filled_in(tmp_path):
    t, q, _, current = joint(7)
    data = save(tmp_path, [t, 0.01 * q, current], ['t', 'q', 'i'])
    guess = guess_mapping(data)
    places = ['joints.joint.position.unit', 'joints.joint.effort.scale']
    assert guess.left_open == places
    text = guess.to_yaml('x')
    with pytest.raises(ConfigurationError, match=r'position\.unit, .*effort\.scale is left open'):
        parse_mapping(yaml.safe_load(text), data.path)
    filled = text.replace(f'unit: {FILL_IN}', 'unit: rad').replace(FILL_IN, '1.8')
    log = read_recording(data.path, parse_mapping(yaml.safe_load(filled), data.path))
    np.testing.assert_allclose(log.tau[:, 0], 1.8 * current)


def test_a_unit_that_is_not_known_is_asked_for(tmp_path):
    t, q, _, tau = joint(4)
    data = save(
        tmp_path, [t / 60.0, 10.0 * q, tau], ['t [beats]', 'angle [grad]', 'torque [st ft]']
    )
    guess = guess_mapping(data)
    assert guess.left_open == [
        'time.unit',
        'joints.joint.position.unit',
        'joints.joint.effort.unit',
    ]
    assert '[grad] in its name is no unit' in guess.reasons['joints.joint.position']
    position, effort = 'angle [grad]', 'torque [st ft]'
    for columns, sentence in (
        (
            Columns({'position': [position], 'effort': [effort]}),
            '[beats] in its name is no unit that is known (s, ms,',
        ),
        (
            Columns({'position': [position], 'effort': [effort]}, time='t [beats]:ms'),
            "cm, um, in): say which, as --position 'angle [grad]:deg'; "
            "in another unit --position 'angle [grad]:counts' --counts-per-turn",
        ),
        (
            Columns({'position': [f'{position}:mm'], 'effort': [effort]}, time='t [beats]:ms'),
            'kgf, lbf): if it is N, --effort '
            "'torque [st ft]:N'; in another unit --effort 'torque [st ft]:counts' --kt",
        ),
    ):
        with pytest.raises(SosmlFrictionError, match=re.escape(sentence)):
            map_columns(data, columns)


def test_a_torque_is_no_position_where_that_has_another_length(tmp_path):
    (t, q, _, tau), (_, _, _, other) = joint(4), joint(5)
    np.savez(tmp_path / 'x.npz', t=t, q=np.array([q, q])[:, 1:], tau=np.array([tau, other]))
    data = DataFile(tmp_path / 'x.npz')
    sentence = 'position of a joint; q has 2499 values, and most have 2500: write the mapping'
    with pytest.raises(DataError, match=sentence):
        guess_mapping(data)


def test_a_velocity_that_is_no_slope_is_left_open_and_out(tmp_path):
    t, q, v, tau = joint(4)
    data = save(tmp_path, [t, q, q + 0.01 * v, tau], ['t', 'q', 'qd', 'tau'])
    guess = guess_mapping(data)
    assert guess.left_open == ['joints.joint.velocity.scale']
    stated = map_columns(data, Columns({'position': ['q'], 'velocity': ['qd'], 'effort': ['tau']}))
    assert 'velocity' not in stated.content['joints']['joint']
    assert stated.remarks == ['velocity qd is left out: stated, but it is not the slope of q']


def test_joints_have_the_names_of_the_urdf_behind_that_of_the_robot(tmp_path):
    (t, q, _, tau), (_, q2, _, tau2) = joint(4), joint(5)
    names = ['t', 'elbow/position', 'elbow/effort', 'tool/position', 'tool/effort']
    urdf = arm('left_elbow_joint', 'left_grip')
    guess = guess_mapping(save(tmp_path, [t, q, tau, q2, tau2], names), urdf)
    assert list(guess.content['joints']) == ['left_elbow_joint', 'tool']
    assert (
        'tool: not in the URDF, which has left_elbow_joint, left_grip; call each joint as it does'
        in guess.remarks
    )


def arm(*names):
    """Return a URDF of joints that turn, in this order."""
    joints = ''.join(
        f'<link name="l{k}"/><joint name="{name}" type="continuous"><axis xyz="0 1 0"/>'
        f'<parent link="base"/><child link="l{k}"/></joint>'
        for k, name in enumerate(names)
    )
    return f'<robot name="r"><link name="base"/>{joints}</robot>'


@pytest.mark.parametrize('form', ['columns', 'list', 'records', 'without names'])
def test_joints_have_the_names_that_stand_in_the_file(tmp_path, form):
    (t, q, v, tau), (_, q2, v2, tau2) = joint(4), joint(5)
    rows = np.round(np.column_stack([t, q, q2, v, v2, tau, tau2]), 6).tolist()
    path = tmp_path / ('x.jsonl' if form == 'records' else 'x.csv')
    text = 't,name0,name1,position0,position1,velocity0,velocity1,effort0,effort1\n'
    if form == 'records':
        text = ''
    if form == 'list':
        text = 't,name,position,velocity,effort\n'
    if form == 'without names':
        text = ''
    for s, *x in rows:
        if form == 'list':
            text += f"""{s},"['wrist', 'elbow']","{x[:2]}","{x[2:4]}","{x[4:]}"\n"""
        elif form == 'records':
            text += (
                f'{{"t": {s}, "name": ["wrist", "elbow"], "position": {x[:2]}, '
                f'"velocity": {x[2:4]}, "effort": {x[4:]}}}\n'
            )
        else:
            text += ','.join([str(s), 'wrist', 'elbow', *map(str, x)]) + '\n'
    path.write_text(text)
    urdf = arm('elbow', 'wrist')
    guess = guess_mapping(DataFile(path), urdf)
    log = read_recording(path, parse_mapping(guess_filled(guess), path))
    assert log.names == ('wrist', 'elbow')
    np.testing.assert_allclose(log.q[:, 0], q, atol=1e-6)
    assert 'the names of the joints stand in the file: wrist, elbow' in guess.remarks
    one, two = [own['position'] for own in roles(guess).values()]
    for positions, names in (((one, two), ['wrist', 'elbow']), ((two, one), ['elbow', 'wrist'])):
        stated = Columns({'position': [str(name) for name in positions]})
        assert list(map_columns(DataFile(path), stated, urdf).content['joints']) == names


def test_some_places_of_a_list_have_the_names_of_their_places(tmp_path):
    (t, q, _, _), (_, q2, _, _) = joint(4), joint(5)
    rows = [
        f"""{s:.6f},"['tool', 'wrist', 'elbow']","[{0.5}, {a:.6f}, {b:.6f}]"\n"""
        for s, a, b in zip(t, q, q2, strict=True)
    ]
    (tmp_path / 'x.csv').write_text('t,name,position\n' + ''.join(rows))
    stated = Columns({'position': ['position[1]', 'position[2]']})
    content = map_columns(DataFile(tmp_path / 'x.csv'), stated, arm('elbow', 'wrist')).content
    assert {n: own['position']['variable'] for n, own in content['joints'].items()} == {
        'wrist': 'position[1]',
        'elbow': 'position[2]',
    }


def test_columns_with_numbers_in_brackets_are_no_list(tmp_path):
    (t, q, _, _), (_, q2, _, _) = joint(4), joint(5)
    data = save(tmp_path, [t, q, q2], ['t', 'state.q[0]', 'state.q[1]'])
    stated = Columns({'position': ['state.q[0]', 'state.q[1]']})
    assert list(map_columns(data, stated, arm('b', 'a')).content['joints']) == ['b', 'a']


def guess_filled(guess):
    """Return the content with Nm where the unit of an effort is open."""
    for own in guess.content['joints'].values():
        own['effort']['unit'] = 'Nm'
    return guess.content


def test_joints_that_differ_in_their_number_are_those_of_the_urdf(tmp_path):
    (t, q, v, tau), (_, q2, v2, tau2) = joint(4), joint(5)
    header = ['t', 'j0_pos', 'j0_vel', 'j0_tau', 'j1_pos', 'j1_vel', 'j1_tau']
    data = save(tmp_path, [t, q, v, tau, q2, v2, tau2], header)
    for urdf, names in ((arm('b', 'a'), ['b', 'a']), (arm('m2', 'm1'), ['m1', 'm2'])):
        found = roles(guess_mapping(data, urdf))
        assert [own['effort'] for own in map(found.get, names)] == ['j0_tau', 'j1_tau']
    assert list(roles(guess_mapping(data))) == ['j0', 'j1']


@pytest.mark.parametrize(
    ('name', 'other'),
    [
        ('current_motor', lambda v, tau: np.abs(tau)),
        ('bus_current', lambda v, tau: np.abs(tau * v) / 24.0),
        ('current_limit_a', lambda v, tau: 0.0 * tau + 12.0),
        ('torque_enable', lambda v, tau: 0.0 * tau + 1.0),
    ],
)
def test_what_is_called_an_effort_and_does_not_follow_the_motion_is_none(tmp_path, name, other):
    t, q, v, tau = joint(4)
    columns = [t, q, v, other(v, tau), tau]
    data = save(tmp_path, columns, ['t', 'position', 'velocity', name, 'q_axis_current'])
    assert roles(guess_mapping(data))['joint']['effort'] == 'q_axis_current'


@pytest.mark.parametrize('other', ['SR', ''])
def test_what_is_short_for_a_set_point_may_be_a_joint(tmp_path, other):
    (t, q, v, tau), (_, q2, v2, tau2) = joint(4), joint(5)
    words = ('q', 'qd', 'tau')
    header = ['t', *(f'{word}_{other}'.strip('_') for word in words), *(f'{w}_SP' for w in words)]
    found = roles(guess_mapping(save(tmp_path, [t, q, v, tau, q2, v2, tau2], header)))
    assert list(found) == ([other, 'SP'] if other else ['joint'])


@pytest.mark.parametrize('name', ['duration', 'SampleCount', 'tick'])
@pytest.mark.parametrize(('per_count', 'unit'), [(1.0, 'ms'), (0.37, ''), (1e-3, '')])
def test_a_count_is_milliseconds_where_velocities_are_slopes_in_them(
    tmp_path, name, per_count, unit
):
    t, q, v, tau = joint(4, rate=1000.0)
    columns = [np.arange(len(t)) + 5230, q, v * per_count, tau]
    data = save(tmp_path, columns, [name, 'q', 'dq', 'tau'])
    assert guess_mapping(data).content['time'] == {'variable': name, 'unit': unit or FILL_IN}
    stated = Columns({'position': ['q'], 'velocity': ['dq'], 'effort': ['tau']})
    reason = guess_mapping(data).reasons['time']
    assert ('velocities are the slopes of positions in ms' in reason) == bool(unit)
    if unit:
        assert map_columns(data, stated).content['time']['unit'] == unit
    else:
        with pytest.raises(DataError, match='say which column is time and its unit'):
            map_columns(data, stated)


def test_a_step_that_makes_another_rate_than_the_slopes_is_open(tmp_path):
    t, q, v, tau = joint(4, rate=500.0)
    columns = [np.round(t * 1e7), q, v, tau]
    data = save(tmp_path, columns, ['ElapsedTicks', 'position', 'velocity', 'torque'])
    guess = guess_mapping(data)
    assert guess.left_open == ['time.unit']
    assert 'in steps of 1e-07 s' in guess.reasons['time']
    rated = map_columns(data, Columns({'position': ['position']}, rate=500.0))
    assert rated.content['sample_rate'] == 500.0


def test_each_signal_may_have_a_time_of_its_own(tmp_path):
    t, q, v, tau = joint(4)
    header = ['Time_q', 'q', 'Time_dq', 'dq', 'Time_tau', 'tau']
    guess = guess_mapping(save(tmp_path, [t, q, t + 1e-4, v, t + 2e-4, tau], header))
    assert guess.content['time']['variable'] == 'Time_q'
    assert roles(guess) == {'joint': {'position': 'q', 'velocity': 'dq', 'effort': 'tau'}}


def test_velocities_in_counts_are_slopes_of_positions_in_counts(tmp_path):
    t, q, v, tau = joint(4)
    columns = [t, np.round(q * 2e4), np.round(v * 2e4), tau]
    data = save(tmp_path, columns, ['t', 'pos [cnt]', 'vel', 'tau'])
    stated = Columns({'position': ['pos'], 'velocity': ['vel']}, counts_per_turn=2e4 * math.tau)
    log = read_recording(data.path, parse_mapping(map_columns(data, stated).content, data.path))
    np.testing.assert_allclose(log.v[:, 0], v, atol=1e-4)


def test_a_time_that_falls_may_be_a_torque(tmp_path):
    t, q, v, tau = joint(4)
    guess = guess_mapping(save(tmp_path, [t * 1e9, q, v, tau], ['stamp_ns', 'p', 'v', 't']))
    assert guess.content['time']['variable'] == 'stamp_ns'
    assert roles(guess) == {'joint': {'position': 'p', 'velocity': 'v', 'effort': 't'}}


def test_a_plan_without_effort_is_no_joint(tmp_path):
    t, q, v, tau = joint(4)
    header = ['t', 'q_plan_0', 'dq_plan_0', 'q_actual_0', 'dq_actual_0', 'tau_actual_0']
    guess = guess_mapping(save(tmp_path, [t, q + 0.001, v, q, v, tau], header))
    assert [own['position'] for own in roles(guess).values()] == ['q_actual_0']
    assert 'q_plan_0 is nearly q_actual_0 and has no effort' in ' '.join(guess.remarks)


@pytest.mark.parametrize(
    ('names', 'has_velocity'),
    [
        (('observation.state[{}]', 'observation.velocity[{}]', 'observation.effort[{}]'), True),
        (('q_current_{}', 'dq_{}', 'tau_{}'), True),
        (('J{}', '', 'Torque{}'), False),
        (('$AXIS_ACT.A{}', '', '$TORQUE_AXIS_ACT[{}]'), False),
    ],
)
def test_what_has_names_tells_the_positions_that_have_none(tmp_path, names, has_velocity):
    joints = [joint(k) for k in (4, 5)]
    header, columns = ['t'], [joints[0][0]]
    for quantity in (1, 2, 3):
        if quantity != 2 or has_velocity:
            header += [names[quantity - 1].format(k) for k in (1, 2)]
            columns += [own[quantity] for own in joints]
    header.append('q_cmd_1')
    columns.append(joints[0][1] + 0.001)
    found = list(roles(guess_mapping(save(tmp_path, columns, header))).values())
    assert [[own['position'], own['effort']] for own in found] == [
        [names[0].format(k), names[2].format(k)] for k in (1, 2)
    ]


def test_a_velocity_with_a_name_finds_the_position_without_one(tmp_path):
    t, q, v, tau = joint(4)
    guess = guess_mapping(save(tmp_path, [t, q, v, tau], ['t', 'a0', 'speed', 'u']))
    assert roles(guess) == {'joint': {'position': 'a0', 'velocity': 'speed', 'effort': 'u'}}


def test_of_two_positions_of_a_named_velocity_the_later_one_was_measured(tmp_path):
    t, q, v, tau = joint(4)
    columns = [t, np.interp(t + 0.02, t, q), q, v, tau]
    guess = guess_mapping(save(tmp_path, columns, ['t', 'a0', 'a1', 'speed', 'u']))
    assert roles(guess)['joint'] == {'position': 'a1', 'velocity': 'speed', 'effort': 'u'}


def test_what_moves_a_slide_is_no_torque_by_its_name(tmp_path):
    t, q, _, tau = joint(4)
    data = save(tmp_path, [t, q, tau], ['t', 'x [m]', 'tau'])
    assert guess_mapping(data).content['joints']['x']['effort']['unit'] == FILL_IN
    stated = map_columns(data, Columns({'position': ['x'], 'effort': ['tau']}))
    assert stated.content['joints']['joint']['effort']['unit'] == 'N'


def test_two_positions_that_are_nearly_the_same_are_told(tmp_path):
    t, q, v, tau = joint(4)
    data = save(tmp_path, [t, q, q + 0.01 * v, tau], ['t', 'q_m', 'q_r', 'u'])
    assert 'q_m and q_r are nearly the same' in ' '.join(guess_mapping(data).remarks)


@pytest.mark.parametrize('number', ['', '[0]'])
def test_a_letter_that_another_column_has_otherwise_is_no_unit(number):
    names = [f'pos_m{number}', f'pos_l{number}', f'tau{number}']
    words = read_headers(names)
    assert [words[name].unit for name in names] == ['', '', 'Nm']
    assert read_headers(names[::2])[names[0]].unit == 'm'


def test_an_encoder_of_the_motor_beside_that_of_the_joint_is_told(tmp_path):
    t, q, _, tau = joint(4)
    names = ['t', 'motor_position [rad]', 'output_position [rad]', 'output_torque [Nm]']
    guess = guess_mapping(save(tmp_path, [t, 9.0 * q, q, tau], names))
    assert '[rad] times 0.1111: two encoders of one joint' in ' '.join(guess.remarks)
    two = guess_mapping(save(tmp_path, [t, joint(5)[1], q, tau], names))
    assert 'two encoders' not in ' '.join(two.remarks)


def test_noise_is_no_robot(tmp_path):
    rng = np.random.default_rng(0)
    data = save(tmp_path, [np.zeros(50), np.ones(50)])
    with pytest.raises(DataError, match='nothing that looks like the position of a joint'):
        guess_mapping(data)
    guess = guess_mapping(save(tmp_path, rng.normal(size=(3, 500))))
    assert 'sample_rate' in guess.left_open


@pytest.mark.parametrize(
    ('name', 'quantity', 'unit', 'joint', 'is_wish'),
    [
        ('t', 'time', '', '', False),
        ('timestamp_ms', 'time', 'ms', '', False),
        ('q1', 'position', '', '1', False),
        ('actual_q_0', 'position', '', '0', False),
        ('target_qd_5', 'velocity', '', '5', True),
        ('shoulder_pan_joint/velocity [deg/s]', 'velocity', 'deg/s', 'shoulder_pan', False),
        ('elbowPosition', 'position', '', 'elbow', False),
        ('velocity_rad_s', 'velocity', 'rad/s', '', False),
        ('tau_mNm', 'effort', 'mNm', '', False),
        ('Current (mA)', 'effort', 'mA', '', False),
        ('motor_current_a', 'effort', 'A', '', False),
        ('mos_temperature', 'temperature', '', 'mos', False),
        ('x [mm]', 'position', 'mm', 'x', False),
        ('pulses_N', 'injected', 'N', '', False),
        ('vir', '', '', 'vir', False),
        ('theta_dot_2', 'velocity', '', '2', False),
        ('axis0.motor.Iq_measured', 'effort', 'A', 'axis0', False),
        ('i_q', 'effort', 'A', '', False),
        ('tau_J_d[3]', 'effort', 'Nm', 'J_3', True),
        ('present_position', 'position', '', '', False),
        ('Drehzahl [1/min]', 'velocity', 'rpm', '', False),
        ('actual_torque [%]', 'effort', 'percent', '', False),
        ('Motor Torque (N-m)', 'effort', 'Nm', '', False),
        ('Angle (left) [deg]', 'position', 'deg', 'left', False),
        ('elapsed time (milliseconds)', 'time', 'ms', 'elapsed', False),
        ('Torque [N·m]', 'effort', 'Nm', '', False),
        ('Speed [U/min]', 'velocity', 'rpm', '', False),
        ('vel[deg/sec]', 'velocity', 'deg/s', '', False),
        ('Timestamp [µs]', 'time', 'us', '', False),
        ('Iq (Arms)', 'effort', 'A', '', False),
        ('torque [lbf ft]', 'effort', 'lbf.ft', '', False),
        ('torque [oz-in]', 'effort', 'ozf.in', '', False),
        ('torque (kg·cm)', 'effort', 'kgf.cm', '', False),
        ('torque [st ft]', 'effort', '', '', False),
        ('position [rev]', 'position', 'turns', '', False),
        ('T [K]', 'temperature', 'K', '', False),
        ('q [º]', 'position', 'deg', '', False),
        ('speed [cnt/sec]', 'velocity', 'counts/s', '', False),
        ('J2Position', 'position', '', 'J2', False),
        ('q [A]', 'effort', 'A', '', False),
        ('q [rpm]', 'velocity', 'rpm', '', False),
        ('position_in', 'position', '', 'in', False),
        ('current (measured)', 'effort', 'A', '', False),
        ('elbow_eff', 'effort', '', 'elbow', False),
        ('actual_TCP_force_0', 'effort', 'N', '0', True),
        ('motor_state[1].q', 'position', '', '1', False),
        ('Soll Winkel [deg]', 'position', 'deg', '', True),
        ('Strom Istwert', 'effort', 'A', '', False),
        ('ACTUAL_JOINT_POSITIONS (J2)', 'position', '', 'J2', False),
        ('present_load', 'effort', '', '', False),
        ('load_position', 'position', '', 'load', False),
        ('theta_m', 'position', '', 'm', False),
        ('pos_m', 'position', 'm', '', False),
        ('mot_ang', 'position', '', '', False),
        ('motor_rpm', 'velocity', 'rpm', '', False),
        ('q_hat', 'position', '', '', False),
        ('battery_current', 'effort', 'A', '', True),
        ('millis', 'time', 'ms', '', False),
        ('encoder_pulses', 'position', 'counts', '', False),
        ('j1_deg', 'position', 'deg', 'j1', False),
        ('t2_Nm', 'effort', 'Nm', '2', False),
        ('j3_mm', 'position', 'mm', 'j3', False),
        ('duty_percent', '', '', 'duty_percent', False),
        ('qfrc_actuator[0]', 'effort', '', 'actuator_0', False),
        ('cur_mA[0]', 'effort', 'mA', '0', False),
        ('log.q_deg[12]', 'position', 'deg', 'log_12', False),
        ('log[0].cur_mA[1]', 'effort', 'mA', 'log_0_1', False),
        ('arm_Nm[0]', 'effort', 'Nm', 'arm_0', False),
        ('vel_rad_s[1]', 'velocity', 'rad/s', '1', False),
        # The number of a motor, which m stands for, is in no bracket.
        ('theta_m1', 'position', '', 'm1', False),
        ('Sollwinkel [deg]', 'position', 'deg', '', True),
        ('Istposition', 'position', '', '', False),
        ('Motorstrom [mA]', 'effort', 'mA', '', False),
        ('Referenz [deg]', 'position', 'deg', '', True),
        ('Vorgabewinkel [deg]', 'position', 'deg', '', True),
        ('Isti', '', '', 'Isti', False),
        ('distance', '', '', 'distance', False),
    ],
)
def test_names_say_quantity_unit_and_joint(name, quantity, unit, joint, is_wish):
    assert read_header(name)[:4] == (quantity, unit, joint, is_wish)


@pytest.mark.parametrize(
    ('name', 'unit', 'joint'),
    [
        ('q_turn', '', 'turn'),
        ('ActPosTurn', '', 'Turn'),
        ('turn_pos_deg', 'deg', 'turn'),
        ('turn_turns', 'turns', 'turn'),
        ('pos_turn [deg]', 'deg', 'turn'),
        ('pos_m', '', 'm'),
        ('vel_deg', '', 'deg'),
        ('pos_tip', '', 'tip'),
        ('pos_rad', 'rad', ''),
    ],
)
def test_the_name_of_a_joint_is_no_unit(name, unit, joint):
    (word,) = read_headers([name], ['arm_turn_joint', 'deg', 'm', 'tip']).values()
    assert (word.unit, word.joint) == (unit, joint)


@pytest.mark.parametrize('name', ['turn', 'deg', 'm', 'tip'])
def test_a_column_with_the_name_of_a_joint_is_in_the_unit_that_its_numbers_tell(tmp_path, name):
    (t, q, v, tau), (_, p, w, torque) = joint(8), joint(9)
    names = ['t', 'pos_lift', f'pos_{name}', 'vel_lift', f'vel_{name}', 'tau_lift', f'tau_{name}']
    data = save(tmp_path, [t, q, p, v, w, tau, torque], names)
    columns = {
        quantity: [f'{j}={short}_{j}' for j in ('lift', name)]
        for quantity, short in {'position': 'pos', 'velocity': 'vel', 'effort': 'tau'}.items()
    }
    urdf = arm('lift', name)
    guessed = guess_mapping(data, urdf)
    for guess in (
        guessed, map_columns(data, Columns(columns), urdf), map_columns(data, Columns(columns))
    ):  # fmt: skip
        own = {quantity: x['unit'] for quantity, x in guess.content['joints'][name].items()}
        assert own == {'position': 'rad', 'velocity': 'rad/s', 'effort': 'Nm'}
        assert guess.content['joints'][name]['position']['variable'] == f'pos_{name}'


@given(st.text(max_size=30))
def test_any_name_can_be_read(name):
    assert read_header(name).quantity in (
        '', 'time', 'position', 'velocity', 'acceleration', 'effort', 'temperature', 'injected',
    )  # fmt: skip


STATED = [
    (Columns({'position': ['x']}), "has no series 'x': it has t, q, i"),
    (Columns({'position': ['q:furlong']}), "unknown unit 'furlong': known are rad, deg"),
    (Columns({'position': ['q'], 'effort': ['i', 'i']}), '2 columns of effort are stated and 1'),
    (Columns({'position': ['q'], 'effort': ['q']}), 'q is stated twice, and each is one quantity'),
    (Columns({'position': ['q'], 'effort': ['i']}), 'effort i is in A: give the Nm .* as --kt'),
    (
        Columns({'position': ['q'], 'effort': ['i:Nm']}, scales=[1.8]),
        '--kt is given and effort i is in Nm: leave --kt out',
    ),
    (Columns({'position': ['q']}, time='q:s'), r'q was stated as time and goes back \d+ times, '),
]


@pytest.mark.parametrize(('columns', 'sentence'), STATED)
def test_wrong_columns_are_one_sentence(tmp_path, columns, sentence):
    t, q, _, current = joint(8)
    data = save(tmp_path, [t, q, current], ['t', 'q', 'i'])
    with pytest.raises(SosmlFrictionError, match=sentence) as caught:
        read_recording(data.path, parse_mapping(map_columns(data, columns).content, data.path))
    assert '\n' not in str(caught.value)


def test_each_quantity_may_name_the_joints_of_its_columns_in_its_own_order(tmp_path):
    (t, q, _, tau), (_, p, _, torque) = joint(8), joint(9)
    data = save(tmp_path, [t, q, p, tau, torque], ['t', 'a', 'b', 'c', 'd'])
    efforts = ['upper=c:Nm', 'fore=d:Nm']
    stated = Columns({'position': ['fore=b:rad', 'upper=a:rad'], 'effort': efforts}, time='t:s')
    content = map_columns(data, stated, arm('upper', 'fore')).content
    found = {
        name: (own['position']['variable'], own['effort']['variable'])
        for name, own in content['joints'].items()
    }
    assert found == {'upper': ('a', 'c'), 'fore': ('b', 'd')}
    half = Columns({'position': ['a:rad', 'b:rad'], 'effort': efforts}, time='t:s')
    with pytest.raises(ConfigurationError, match='stated for upper, fore, those of position for '):
        map_columns(data, half, arm('upper', 'fore'))


@pytest.mark.parametrize('entry', ['a=i:Nm', 'joint=a=i:Nm'])
def test_a_column_may_have_an_equals_sign_in_its_name(tmp_path, entry):
    t, q, _, current = joint(8)
    data = save(tmp_path, [t, q, current], ['t', 'q', 'a=i'])
    position = 'q:rad' if entry.startswith('a') else 'joint=q:rad'
    content = map_columns(data, Columns({'position': [position], 'effort': [entry]})).content
    assert content['joints']['joint']['effort'] == {'variable': 'a=i', 'unit': 'Nm'}


def test_a_span_that_no_joint_has_in_rad_is_asked_for(tmp_path):
    t, q, _, current = joint(9)
    data = save(tmp_path, [t, np.rad2deg(q), current], ['t', 'q', 'i'])
    with pytest.raises(DataError, match=r'may be rad, deg.*: say which, as --position q:deg'):
        map_columns(data, Columns({'position': ['q'], 'effort': ['i']}, scales=[1.0]))
    stated = Columns({'position': ['q:deg'], 'effort': ['i']}, scales=[2.0])
    log = read_recording(data.path, parse_mapping(map_columns(data, stated).content, data.path))
    np.testing.assert_allclose(log.q[:, 0], q)
    np.testing.assert_allclose(log.tau[:, 0], 2.0 * current)


def test_the_joint_whose_span_makes_a_unit_doubtful_is_named(tmp_path):
    (t, q, _, tau), (_, p, _, torque) = joint(8), joint(9)
    data = save(tmp_path, [t, q, np.rad2deg(p), tau, torque], ['t', 'q1', 'q2', 'tau1', 'tau2'])
    columns = Columns({'position': ['base=q1', 'mid=q2'], 'effort': ['base=tau1', 'mid=tau2']})
    with pytest.raises(DataError, match=r'position q1: it moves [\d.]+, and mid \d+, which may'):
        map_columns(data, columns, arm('base', 'mid'))


def test_what_slides_leaves_the_unit_of_what_turns(tmp_path):
    (t, q, _, tau), (_, p, _, torque) = joint(8), joint(9)
    data = save(tmp_path, [t, 100.0 * q, p, tau, torque], ['t', 'q1', 'q2', 'tau1', 'tau2'])
    urdf = arm('lift', 'base').replace('continuous', 'prismatic', 1)
    content = map_columns(data, Columns({'position': ['q1', 'q2']}), urdf).content
    units = {name: own['position']['unit'] for name, own in content['joints'].items()}
    assert units == {'lift': 'mm', 'base': 'rad'}


def test_whole_numbers_of_what_slides_are_counts_where_no_slide_is_so_long(tmp_path):
    t, q, v, tau = joint(8)
    position, speed = np.rint(1e5 * q), 1e5 * v
    data = save(tmp_path, [t, position, speed, tau], ['t', 'q1', 'v1', 'tau1'])
    urdf = arm('lift').replace('continuous', 'prismatic', 1)
    content = guess_mapping(data, urdf).content['joints']['lift']
    assert content['position']['unit'] == 'counts'
    assert content['position']['counts_per_unit'] == content['velocity']['counts_per_unit']
    assert content['velocity']['unit'] == 'counts/s'


def test_dates_are_times(tmp_path):
    t, q, _, current = joint(9)
    begin = datetime(2025, 3, 30, 0, 59, 50, tzinfo=timezone.utc)
    for k, zone in enumerate(('', 'Z', '+02:00')):
        stamps = [
            (begin + timedelta(seconds=x)).replace(tzinfo=None).isoformat(' ', 'microseconds')
            for x in t
        ]
        lines = [f'{x}{zone},{y:.9f},{z:.9f}' for x, y, z in zip(stamps, q, current, strict=True)]
        path = tmp_path / f'{k}.csv'
        path.write_text('\n'.join(['date,q,i', *lines]))
        content = guess_mapping(DataFile(path)).content
        assert content['time'] == {'variable': 'date', 'unit': 's'}
        np.testing.assert_allclose(np.ptp(DataFile(path)['date']), np.ptp(t), atol=1e-5)


def test_the_effort_of_a_joint_is_called_as_its_position(tmp_path):
    t, q, _, tau = joint(9)
    columns = {
        't': t,
        'frame_index': np.arange(len(t)),
        'q_0': q,
        'load_torque_0': tau,
        'i_0': tau,
    }
    guess = guess_mapping(save(tmp_path, columns.values(), list(columns)))
    assert roles(guess) == {'joint_0': {'position': 'q_0', 'effort': 'i_0'}}


@pytest.mark.parametrize(('per_ampere', 'told'), [(1000.0, True), (0.1, False)])
def test_a_current_of_large_whole_numbers_is_told(tmp_path, per_ampere, told):
    t, q, _, tau = joint(9)
    data = save(tmp_path, [t, q, np.rint(per_ampere * tau)], ['t', 'q', 'current'])
    columns = Columns({'position': ['q'], 'effort': ['current:A']}, scales=[1.8])
    for guess in (guess_mapping(data), map_columns(data, columns)):
        assert any('if it is mA, percent or counts' in remark for remark in guess.remarks) == told


@pytest.mark.parametrize(('start', 'unit'), [(46352.25, 'd'), (740312.25, 'd'), (1.3e17, '')])
def test_days_of_a_spreadsheet_are_counted_from_the_first_sample(tmp_path, start, unit):
    t, q, _, tau = joint(9)
    stamps = start + (t / 86400.0 if unit else 1e7 * t)
    guess = guess_mapping(save(tmp_path, [stamps, q, tau], ['t', 'q', 'tau']))
    assert guess.content['time']['unit'] == (unit or FILL_IN)
    if unit:
        log = read_recording(tmp_path / 'x.csv', parse_mapping(guess.content, tmp_path / 'x'))
        np.testing.assert_allclose(log.time, t, atol=1e-5)
        assert log.t_ns[0] == 0


def test_a_velocity_without_position_is_refused_with_what_to_do(tmp_path):
    t, _, v, tau = joint(9)
    data = save(tmp_path, [t, v, tau], ['t', 'velocity', 'torque'])
    with pytest.raises(DataError, match='velocity does not say where the joint is, on which'):
        guess_mapping(data)
    content = {
        'sample_rate': 500,
        'joints': {'arm': {'velocity': {'variable': 'v', 'unit': 'rpm'}}},
    }
    with pytest.raises(ConfigurationError, match='has no position: its velocity does not say'):
        parse_mapping(content, tmp_path / 'x.yaml')


@pytest.mark.parametrize(('name', 'unit'), [('temp', 'degC'), ('T [K]', 'K'), ('temp [K]', 'K')])
def test_a_temperature_has_the_unit_of_its_name(tmp_path, name, unit):
    t, q, v, tau = joint(9)
    data = save(tmp_path, [t, q, v, tau, 300.0 + t], ['t', 'q', 'dq', 'tau', name])
    content = guess_mapping(data).content
    assert content['joints']['joint']['temperature'] == {'variable': name, 'unit': unit}


def test_times_of_a_day_are_times_and_dates_that_may_be_two_are_named(tmp_path):
    t, q, _, current = joint(9)
    begin = datetime(2025, 4, 3, 23, 59, 55, tzinfo=timezone.utc)
    for k, form in enumerate(('%H:%M:%S.%f', '%d.%m.%Y %H:%M:%S.%f', '%d/%m/%Y %H:%M:%S.%f')):
        stamps = [(begin + timedelta(seconds=x)).strftime(form) for x in t]
        lines = [f'{x},{y:.9f},{z:.9f}' for x, y, z in zip(stamps, q, current, strict=True)]
        (tmp_path / f'{k}.csv').write_text('\n'.join(['time,q,i', *lines]))
    for k in (0, 1):
        assert guess_mapping(DataFile(tmp_path / f'{k}.csv')).content['time']['unit'] == 's'
    data = DataFile(tmp_path / '2.csv')
    sentence = "line 2, column 'time': '03/04/2025 23:59:55.000000' may have the day first or"
    assert sentence in guess_mapping(data).reasons['sample_rate']
    for time in ('', 'time'):
        with pytest.raises(DataError, match=sentence):
            map_columns(data, Columns({'position': ['q'], 'effort': ['i']}, time, [1.0]))


def test_a_time_with_too_few_digits_is_named(tmp_path):
    t, q, _, current = joint(9)
    guess = guess_mapping(save(tmp_path, [np.floor(t / 0.1) * 0.1, q, current], ['t', 'q', 'i']))
    assert re.search(r't repeats \d+(\.\d)? % of its stamps', ' '.join(guess.sentences()))


def test_stated_stamps_most_of_which_repeat_are_told(tmp_path):
    """Their median step is 0, which is none in s nor in ms."""
    t, q, _, current = joint(9)
    data = save(tmp_path, [np.floor(t / 0.1) * 0.1, q, current], ['t', 'q', 'i'])
    told = r'x.csv, time t: stated; it repeats 96 % of its stamps.*without a time.* as --rate 500'
    with pytest.raises(DataError, match=told):
        map_columns(data, Columns({'position': ['q'], 'effort': ['i']}, 't', [1.0]))


@pytest.mark.parametrize(
    ('rows', 'sentence'),
    [
        (np.r_[1, 0, 2:2500], '1 time, first at row 2 of the data, from 0.004 to 0.0: sort'),
        (np.r_[:1250, :1250], '1 time, first at row 1251 of the data, from 4.996 to 0.0: sort'),
        (np.r_[0:2500:2, 1:2500:2][::-1], '2498 times, first at row 2 of the data'),
    ],
)
def test_the_row_at_which_a_stated_time_goes_back_is_told(tmp_path, rows, sentence):
    t, q, _, current = joint(9)
    data = save(tmp_path, [t[rows], q, current], ['t', 'q', 'i'])
    for time in ('t', 't:s'):
        with pytest.raises(DataError, match=sentence) as caught:
            map_columns(data, Columns({'position': ['q'], 'effort': ['i']}, time, [1.0]))
        assert 'split the file where a new recording begins' in str(caught.value)


def test_a_time_that_goes_back_is_named(tmp_path):
    t, q, _, current = joint(9)
    guess = guess_mapping(save(tmp_path, [t % 5.0, q, current], ['t', 'q', 'i']))
    assert (
        'no column grows all the time: t goes back at index 1250' in guess.reasons['sample_rate']
    )


def test_velocities_in_one_another_s_columns_are_told(tmp_path):
    (t, q, v, i), (_, q2, v2, i2) = joint(9), joint(10)
    names = ['t', 'q1', 'q2', 'dq1', 'dq2', 'tau1', 'tau2']
    told = ' '.join(guess_mapping(save(tmp_path, [t, q, q2, v2, v, i, i2], names)).sentences())
    assert 'dq1 [rad/s]: its name says so, but it is the slope of q2: look whether' in told
    assert 'rests' not in told


MEASURED = {
    'ur10e/30sec_12harm.csv': {
        f'joint_{k}': {'position': k, 'velocity': k + 6, 'effort': k + 12} for k in range(1, 7)
    },
    'ur10e/joint_2.csv': {
        f'joint_{k}': {'position': k, 'velocity': k + 6, 'effort': k + 12} for k in range(1, 7)
    },
    'emps/DATA_EMPS.mat': {'joint': {'position': 'qm', 'effort': 'vir'}},
    'emps/DATA_EMPS_PULSES.mat': {'joint': {'position': 'qm', 'effort': 'vir'}},
    'damiao/motor_03_run_01.npz': {
        'joint': {
            'position': 'position',
            'velocity': 'velocity',
            'effort': 'torque_feedback',
            'temperature': 'mos_temperature',
        }
    },
    'odrive_cogging/slow2_nocomp_0.npy': {'joint': {'position': 1, 'effort': 2}},
}


@pytest.mark.parametrize('name', MEASURED)
def test_measured_files_are_understood(data_directory, name):
    file = data_directory / name
    if not file.is_file():
        pytest.skip(f'no {file}')
    guess = guess_mapping(DataFile(file))
    assert roles(guess) == MEASURED[name]
    assert guess.content['time']['unit'] == 's'


def test_a_column_that_cannot_be_read_is_told(tmp_path):
    t, q, _, tau = joint(4)
    cells = [str(x) for x in tau]
    cells[70] = 'ERR'
    lines = ['time,q,tau', *(f'{a},{b},{c}' for a, b, c in zip(t, q, cells, strict=True))]
    (tmp_path / 'x.csv').write_text('\n'.join(lines))
    (sentence,) = [x for x in guess_mapping(DataFile(tmp_path / 'x.csv')).remarks if 'ERR' in x]
    assert sentence.startswith('not used: ')
    assert "line 72, column 'tau': 'ERR' is not a number" in sentence


def test_a_time_with_an_empty_cell_is_named(tmp_path):
    t, q, _, tau = joint(4)
    t = np.where(np.arange(len(t)) == 3, np.nan, t)
    np.savez(tmp_path / 'x.npz', time=t, q=q, tau=tau)
    with pytest.raises(DataError, match='grows all the time: time has no number at index 3: say'):
        map_columns(DataFile(tmp_path / 'x.npz'), Columns({'position': ['q']}))


def test_positions_of_several_joints_alone_have_no_effort_among_them(tmp_path):
    series = [joint(seed) for seed in range(5)]
    columns = {'t': series[0][0], **{f'arm{k}': q for k, (_, q, *_) in enumerate(series)}}
    guess = guess_mapping(save(tmp_path, columns.values(), list(columns)))
    (own,) = guess.content['joints'].values()
    assert list(own) == ['position']
    assert any('positions of several joints, it seems, and no effort' in r for r in guess.remarks)


@pytest.mark.parametrize('name', ['Torque actual value', 'load'])
def test_an_effort_of_large_whole_numbers_has_no_unit_until_it_is_said(tmp_path, name):
    t, q, _, tau = joint(9)
    names = ['timestamp', 'Position actual value', name]
    data = save(tmp_path, [t, q, np.rint(100.0 * tau)], names)
    guess = guess_mapping(data)
    assert guess.left_open == ['joints.joint.effort.unit']
    assert 'whole numbers up to' in guess.reasons['joints.joint.effort']
    with pytest.raises(
        ConfigurationError, match='per mille or counts, it seems: if it is Nm, --ef'
    ):
        map_columns(data, Columns({'position': ['1'], 'effort': [name]}))
    stated = map_columns(data, Columns({'position': ['1'], 'effort': [f'{name}:Nm']}))
    assert stated.content['joints']['joint']['effort']['unit'] == 'Nm'


def test_words_without_a_mark_between_them_are_told_by_their_capitals(tmp_path):
    t, q, _, tau = joint(9)
    whole = 1_700_000_000 + np.floor(t)
    columns = {
        'ZeitInSec': whole.astype(int),
        'ZeitInNanoSec': np.rint((t % 1.0) * 1e9).astype(int),
        'axisQMsr_J1': q,
        'axisQCmd_J1': q + 1e-4,
        'axisTauMsr_J1': tau,
        'axisTauExtMsr_J1': 0.1 * tau,
    }
    path = tmp_path / 'x.txt'
    rows = zip(*(map(str, x.tolist()) for x in columns.values()), strict=True)
    path.write_text('\n'.join(map(' '.join, [columns, *rows])) + '\n')
    guess = guess_mapping(DataFile(path))
    (own,) = roles(guess).values()
    assert own == {'position': 'axisQMsr_J1', 'effort': 'axisTauMsr_J1'}
    stamps = {'variable': 'ZeitInSec', 'unit': 's', 'nanoseconds': 'ZeitInNanoSec'}
    assert guess.content['time'] == stamps


def test_the_number_of_a_motor_in_brackets_is_no_unit(tmp_path):
    t, *one = joint(9)
    _, *other = joint(10)
    header = [
        f'[ID:00{k}] Present {x}' for k in (1, 2) for x in ('Position', 'Velocity', 'Torque')
    ]
    guess = guess_mapping(save(tmp_path, [t, *one, *other], ['Time(ms)', *header]))
    assert list(guess.content['joints']) == ['ID_001', 'ID_002']
    assert roles(guess)['ID_002']['effort'] == '[ID:002] Present Torque'


def test_seconds_and_nanoseconds_without_names_are_the_time(tmp_path):
    t, q, v, tau = joint(9)
    stamps = [(1_700_000_000 + int(x), round((x % 1.0) * 1e9)) for x in t.tolist()]
    rows = [
        f'{sec},{nanosec},base,elbow,{a},{b},{c}'
        for (sec, nanosec), a, b, c in zip(
            stamps, q.tolist(), v.tolist(), tau.tolist(), strict=True
        )
    ]
    (tmp_path / 'x.csv').write_text('\n'.join(rows) + '\n')
    guess = guess_mapping(DataFile(tmp_path / 'x.csv'))
    assert guess.content['time'] == {'variable': 0, 'unit': 's', 'nanoseconds': 1}
    assert roles(guess) == {'joint': {'position': 4, 'velocity': 5, 'effort': 6}}


@pytest.mark.parametrize('speed', ['rad/s', 'rpm'])
def test_a_small_angle_in_degrees_is_told_by_its_slope_in_another_unit(tmp_path, speed):
    t, q, v, tau = joint(9)
    # It moves 5 degrees, which rad would be too.
    size = 5.0 * math.pi / 180.0 / np.ptp(q)
    columns = [t, size * q / ANGLES['deg'], size * v / SPEEDS[speed], tau]
    guess = guess_mapping(save(tmp_path, columns, ['t', 'angle', 'velocity', 'tau']))
    (own,) = guess.content['joints'].values()
    assert own['position'] == {'variable': 'angle', 'unit': 'deg'}
    assert own['velocity'] == {'variable': 'velocity', 'unit': speed}


def test_of_two_encoders_of_a_joint_each_has_its_own_velocity(tmp_path):
    t, q, v, tau = joint(9)
    columns = {'t': t, 'qm': q, 'ql': q + 1e-3 * np.sin(t), 'dqm': v, 'dql': v, 'tau': tau}
    columns['dql'] = v + 1e-3 * np.cos(t)
    columns['dqm'] = v + 2e-2 * np.cos(5.0 * t)
    guess = guess_mapping(save(tmp_path, columns.values(), list(columns)))
    assert {own['position']: own['velocity'] for own in roles(guess).values()} == {
        'qm': 'dqm',
        'ql': 'dql',
    }
    assert any('qm and ql are nearly the same' in remark for remark in guess.remarks)


@pytest.mark.parametrize('name', ['/ee_pose/pose/position/x', 'imu.position.x', 'odom_position_x'])
def test_the_pose_of_a_body_is_no_joint(name):
    assert read_header(name).is_wish


@pytest.mark.parametrize('is_inverse', [False, True])
def test_of_tables_of_as_many_columns_one_has_positions_and_one_their_efforts(
    tmp_path, is_inverse
):
    series = [joint(seed) for seed in range(4)]
    q, v, tau = (np.array([one[k] for one in series]) for k in (1, 2, 3))
    slope = np.gradient(v, series[0][0], axis=1)
    content = {'u': np.vstack([q, v, slope]) if is_inverse else tau, 'y': tau if is_inverse else q}
    order = sorted(content, reverse=is_inverse)
    np.savez(tmp_path / 'x.npz', time=series[0][0], **{name: content[name] for name in order})
    found = list(roles(guess_mapping(DataFile(tmp_path / 'x.npz'))).values())
    position, effort = ('u', 'y') if is_inverse else ('y', 'u')
    assert [own['position'] for own in found] == [f'{position}[{k}]' for k in range(4)]
    assert [own['effort'] for own in found] == [f'{effort}[{k}]' for k in range(4)]


def test_the_voltage_of_a_supply_is_no_effort(tmp_path):
    t, q, _, tau = joint(9)
    volts = 12.0 + 0.1 * np.random.default_rng(1).normal(size=len(t))
    guess = guess_mapping(
        save(tmp_path, [t, q, volts, tau], ['time', 'position', 'input_volts', 'control'])
    )
    assert roles(guess) == {'joint': {'position': 'position', 'effort': 'control'}}
    assert any('the voltage of a supply, it seems' in remark for remark in guess.remarks)


def test_a_table_without_an_effort_is_told(tmp_path):
    t, q, v, tau = joint(9)
    guess = guess_mapping(save(tmp_path, [t, q, v], ['t', 'position', 'speed']))
    assert any('nothing here is the effort of a joint' in remark for remark in guess.remarks)
    guess = guess_mapping(save(tmp_path, [t, q, tau], ['t', 'position', 'tau_cmd']))
    assert any('what was commanded, tau_cmd, may stand' in remark for remark in guess.remarks)


def test_a_column_that_is_left_is_no_effort_of_a_second_encoder(tmp_path):
    t, q, _, tau = joint(9)
    volts = np.random.default_rng(1).normal(24.0, 0.1, len(t))
    names = ['t', 'motor_angle', 'output_angle', 'iq', 'vbus_V']
    found = roles(guess_mapping(save(tmp_path, [t, 9.0 * q, q, tau, volts], names)))
    assert [own.get('effort') for own in found.values()] == ['iq', None]


def test_what_is_as_smooth_as_a_position_may_be_no_effort(tmp_path):
    t, q, *_ = joint(9)
    # As wide as a motion of another joint that a part of its speed goes with.
    other = 0.3 * np.gradient(q, t) + 0.2 * q
    other = np.convolve(np.pad(other, 25, mode='edge'), np.ones(51) / 51, mode='valid')
    guess = guess_mapping(save(tmp_path, [t, q, other], ['t', 'q', 'x']))
    assert any('may be the position of another joint' in remark for remark in guess.remarks)


@pytest.mark.parametrize('rate', [None, 250.0])
def test_recordings_behind_one_another_are_told(tmp_path, rate):
    t, q, _, tau = joint(9)
    stamps = np.tile(t[: len(t) // 2], 2)
    data = save(tmp_path, [stamps, q, tau], ['timestamp', 'q', 'tau'])
    guess = guess_mapping(data, rate=rate)
    assert any('timestamp goes back at index 1250' in remark for remark in guess.remarks)
    stated = map_columns(data, Columns({'position': ['q'], 'effort': ['tau']}, rate=250.0))
    assert any('recordings behind one another' in remark for remark in stated.remarks)


@pytest.mark.parametrize(('name', 'value'), [('dt', 0.004), ('data.fs', 250.0)])
def test_a_number_that_speaks_for_the_rate_is_named_where_it_is_asked_for(tmp_path, name, value):
    _, q, _, tau = joint(9)
    np.savez(tmp_path / 'x.npz', q=q, tau=tau, **{name: value})
    guess = guess_mapping(DataFile(tmp_path / 'x.npz'))
    speaks = f'as --rate 250, which {name} = {value:g} speaks for'
    assert speaks in guess.reasons['sample_rate']
    with pytest.raises(DataError, match=speaks):
        map_columns(DataFile(tmp_path / 'x.npz'), Columns({'position': ['q'], 'effort': ['tau']}))


def test_of_two_positions_at_once_none_is_a_reference(tmp_path):
    t, q, _, tau = joint(9)
    data = save(tmp_path, [t, q, q + 1e-4, tau], ['t', 'a', 'b', 'c'])
    remarks = guess_mapping(data).remarks
    assert any('which of them was measured is not told' in remark for remark in remarks)


def test_the_velocity_of_a_body_is_not_that_of_the_joint_of_its_number(tmp_path):
    t, q, v, tau = joint(9)
    turn = np.random.default_rng(1).normal(size=len(t))
    columns = {'t': t, 'q_mes[0]': q, 'v_mes[0]': v, 'tau[0]': tau, 'baseVelocity[0]': turn}
    (own,) = roles(guess_mapping(save(tmp_path, columns.values(), list(columns)))).values()
    assert own == {'position': 'q_mes[0]', 'velocity': 'v_mes[0]', 'effort': 'tau[0]'}


def test_an_effort_is_of_the_joint_whose_words_it_has(tmp_path):
    columns = {'t': joint(1)[0]}
    for seed, name in enumerate(('HeadYaw', 'HeadPitch')):
        _, q, v, tau = joint(seed)
        columns |= {
            f'{name}/Position/Sensor': q,
            f'{name}/Position/Actuator': q + 0.01 * v,
            f'{name}/ElectricCurrent/Sensor': tau,
        }
    found = roles(guess_mapping(save(tmp_path, columns.values(), list(columns))))
    assert [own['effort'] for own in found.values()] == [
        'HeadYaw/ElectricCurrent/Sensor',
        'HeadPitch/ElectricCurrent/Sensor',
    ]


@pytest.mark.parametrize(
    ('effort', 'other'), [('effort', 'motorCurrent'), ('applied_torque', 'computed_torque')]
)
def test_a_torque_comes_before_a_current_and_a_measured_one_before_a_computed(
    tmp_path, effort, other
):
    t, q, _, tau = joint(9)
    guess = guess_mapping(save(tmp_path, [t, q, 0.5 * tau, tau], ['t', 'position', other, effort]))
    assert roles(guess) == {'joint': {'position': 'position', 'effort': effort}}


def test_objects_of_matlab_are_to_be_saved_as_numbers(tmp_path):
    savemat(tmp_path / 'x.mat', {'text': 'a'})
    with pytest.raises(DataError, match='save objects of MATLAB, such as timeseries, as structs'):
        guess_mapping(DataFile(tmp_path / 'x.mat'))


@pytest.mark.parametrize('more', [{}, {'time': np.arange(500) / 250.0}])
def test_an_array_of_several_recordings_is_refused_with_its_shape(tmp_path, more):
    np.savez(tmp_path / 'x.npz', q=np.zeros((3, 500, 2)), **more)
    data = DataFile(tmp_path / 'x.npz')
    sentence = r'q has the shape \(3, 500, 2\): give one recording of it'
    with pytest.raises(DataError, match=sentence):
        guess_mapping(data)
    with pytest.raises(DataError, match=sentence):
        map_columns(data, Columns({'position': ['q[0]']}))


@pytest.mark.parametrize(
    ('rate', 'per_second', 'unit'),
    [
        (10.0, 1.0, 's'),
        (9.7, 1.0, 's'),
        (5.0, 1.0, FILL_IN),
        (2000.0, 1e3, FILL_IN),
        (1000.0, 1e3, 'ms'),
        (250.0, 1e3, 'ms'),
    ],
)
def test_a_step_that_may_be_one_in_s_or_in_ms_is_open(tmp_path, rate, per_second, unit):
    _, q, _, tau = joint(9)
    # Stamps of MATLAB, 0:0.1:250, whose steps are rounded to either side.
    stamps = np.linspace(0.0, (len(q) - 1) / rate, len(q)) * per_second
    guess = guess_mapping(save(tmp_path, [stamps, q, tau], ['time', 'q', 'tau']))
    assert guess.content['time']['unit'] == unit


def test_a_long_recording_in_fractions_of_ms_is_no_day_in_seconds(tmp_path):
    t, q, _, tau = joint(9, samples=20000)
    guess = guess_mapping(save(tmp_path, [125.0 * t, q, tau], ['time', 'q', 'tau']))
    assert guess.content['time']['unit'] == 'ms'


def test_one_effort_beside_two_positions_is_of_that_which_explains_it(tmp_path):
    t, other, *_ = joint(8)
    _, q, _, tau = joint(9)
    data = save(tmp_path, [t, other, q, tau], ['t', 'theta_pole', 'theta_arm', 'torque'])
    found = roles(guess_mapping(data))
    assert found['arm'] == {'position': 'theta_arm', 'effort': 'torque'}
    assert found['pole'] == {'position': 'theta_pole'}


def test_an_arm_beside_a_gripper_has_the_names_of_the_urdf(tmp_path):
    series = [joint(seed) for seed in range(2)]
    columns = {'t': series[0][0], 'gripper_position': series[0][1] * 0.01}
    columns |= {f'joint_positions[{k}]': one[1] for k, one in enumerate(series)}
    columns |= {f'joint_torques[{k}]': one[3] for k, one in enumerate(series)}
    np.savez(tmp_path / 'x.npz', **columns)
    urdf = '<robot name="x"><link name="a"/>{}</robot>'.format(
        ''.join(
            f'<link name="{child}"/><joint name="{name}" type="continuous">'
            f'<parent link="{parent}"/><child link="{child}"/></joint>'
            for parent, child, name in (('a', 'b', 'shoulder'), ('b', 'c', 'elbow'))
        )
    )
    found = roles(guess_mapping(DataFile(tmp_path / 'x.npz'), urdf))
    assert list(found) == ['gripper', 'shoulder', 'elbow']
    assert found['elbow']['effort'] == 'joint_torques[1]'


def test_what_a_model_or_an_observer_tells_is_no_measured_effort(tmp_path):
    t, q, v, tau = joint(9)
    names = ['t', 'q', 'q_hat', 'tau_g', 'tau_friction', 'tau_hat', 'current']
    columns = [t, q, q + 1e-4, 1.5 * np.sin(q), 0.8 * np.sign(v) + 0.2 * v, tau, tau / 2.0]
    found = roles(guess_mapping(save(tmp_path, columns, names)))
    assert found == {'joint': {'position': 'q', 'effort': 'current'}}
    columns[-1] = tau
    found = roles(guess_mapping(save(tmp_path, columns, [*names[:3], 'u_g', 'u_ff', 'u_f', 'u'])))
    assert found['joint']['effort'] == 'u'


def test_a_current_in_a_stated_unit_comes_before_a_raw_one(tmp_path):
    t, q, _, tau = joint(9)
    columns = [t, q, np.rint(40.0 * tau), 100.0 * tau]
    found = roles(guess_mapping(save(tmp_path, columns, ['t', 'q', 'raw_cur', 'cur_mA'])))
    assert found['joint']['effort'] == 'cur_mA'


def test_the_last_letter_of_two_sides_is_no_unit(tmp_path):
    t, q, v, tau = joint(9)
    names = ['t', 'pos_m', 'pos_l', 'vel_m', 'torque_m']
    guess = guess_mapping(save(tmp_path, [t, 50.0 * q, q, 50.0 * v, tau / 50.0], names))
    assert guess.content['joints']['m']['position']['unit'] == FILL_IN
    assert roles(guess)['m']['effort'] == 'torque_m'
    (alone,) = guess_mapping(save(tmp_path, [t, q], names[:2])).content['joints'].values()
    assert alone['position']['unit'] == 'm'


def test_efforts_find_their_joint_by_a_part_of_its_name(tmp_path):
    (t, q, _, tau), (_, p, _, force) = joint(1), joint(2)
    names = ['t']
    for leg in ('knee', 'ank'):
        names += [f'{leg}.output_position', f'{leg}.motor_current', f'{leg}.joint_torque']
    noise = np.random.default_rng(0).normal(size=len(t))
    columns = [t, q, 9.0 * tau + 5.0 * noise, tau, p, 9.0 * force, force + noise]
    found = roles(guess_mapping(save(tmp_path, columns, names)))
    assert [own['effort'] for own in found.values()] == ['knee.joint_torque', 'ank.joint_torque']


def test_a_body_with_the_number_of_a_joint_takes_no_effort_from_it(tmp_path):
    t, q, _, tau = joint(1)
    _, p, _, force = joint(2)
    tables = {'joint_pos': np.c_[q, p, q + p], 'root_pos': np.c_[p * q, q * q]}
    torques = np.c_[tau, force, tau + force]
    tables |= {'applied_torque': torques, 'computed_torque': torques + 1.0}
    np.savez(tmp_path / 'x.npz', time=t, **tables)
    found = roles(guess_mapping(DataFile(tmp_path / 'x.npz')))
    assert found['joint_0']['effort'] == 'applied_torque[0]'


def test_another_effort_of_a_joint_is_not_that_of_its_second_encoder(tmp_path):
    t, q, v, tau = joint(9)
    names = ['t', 'motor_pos', 'motor_current', 'motor_voltage', 'link_pos', 'gyroz']
    found = roles(guess_mapping(save(tmp_path, [t, q, tau, v, 0.1 * q, np.rint(50.0 * v)], names)))
    assert found['link'] == {'position': 'link_pos'}


def test_a_joint_behind_a_free_base_has_its_own_effort(tmp_path):
    (t, q, v, tau), (_, p, w, force) = joint(1), joint(2)
    turn = np.stack([np.cos(0.1 * q), np.sin(0.1 * q), 0.0 * q, 0.0 * q])
    base = np.c_[p, q, p * q, turn.T]
    np.savez(
        tmp_path / 'x.npz',
        time=t,
        qpos=np.c_[base, q, p],
        qvel=np.c_[np.zeros((len(t), 6)), v, w],
        tau=np.c_[tau, force],
    )
    guess = guess_mapping(DataFile(tmp_path / 'x.npz'))
    own = {'position': 'qpos[8]', 'velocity': 'qvel[7]', 'effort': 'tau[1]'}
    assert roles(guess)['joint_1'] == own
    assert len(roles(guess)) == 2
    assert 'qpos[0] to qpos[6] are a free base and no joints: left out' in guess.remarks


def test_what_hardly_changes_is_no_velocity_of_a_clock(tmp_path):
    t, q, _, tau = joint(9)
    noise = np.random.default_rng(0).normal(size=len(t))
    t = t + 2e-4 * np.sin(np.arange(len(t)))
    guess = guess_mapping(save(tmp_path, [t, 1e6 * t * 1.0001, q, tau, 24.0 + 0.05 * noise]))
    assert all('velocity' not in own for own in roles(guess).values())


def test_a_count_that_begins_anew_is_no_position(tmp_path):
    t, q, _, tau = joint(9)
    count = np.arange(len(t)) % 600
    guess = guess_mapping(save(tmp_path, [t, count, q, tau], ['t', 'frame', 'x', 'y']))
    assert roles(guess)['joint'] == {'position': 'x', 'effort': 'y'}


def test_a_slope_that_is_none_by_name_comes_before_one_that_is_called_so(tmp_path):
    t, q, v, tau = joint(9)
    _, other, *_ = joint(3)
    found = roles(
        guess_mapping(save(tmp_path, [t, q, v, other, tau], ['t', 'Q', 'Qp', 'Qd', 'Tau']))
    )
    assert found['joint']['velocity'] == 'Qp'


def test_a_velocity_with_repeated_samples_is_no_effort(tmp_path):
    t, q, v, tau = joint(9, rate=200.0)
    rng = np.random.default_rng(0)
    again = np.sort(np.r_[np.arange(len(t)), rng.choice(len(t), len(t) // 10)])
    found = roles(guess_mapping(save(tmp_path, [x[again] for x in (q, v, tau)])))
    assert found['joint'] == {'position': 0, 'velocity': 1, 'effort': 2}


def test_one_effort_of_two_joints_without_names_is_found(tmp_path):
    (t, q, v, tau), (_, p, w, _) = joint(1), joint(2)
    found = roles(guess_mapping(save(tmp_path, [t, q, p, v, w, tau])))
    assert found['joint_1']['effort'] == 5
    assert 'effort' not in found['joint_2']


def test_pulses_that_a_speed_is_the_slope_of_are_a_position(tmp_path):
    t, q, v, tau = joint(9)
    names = ['ms', 'Servo speed', 'Torque', 'Cumulative pulses']
    columns = [1e3 * t, 9.55 * v, tau, np.rint(4096.0 * q)]
    guess = guess_mapping(save(tmp_path, columns, names))
    assert guess.content['time']['unit'] == 'ms'
    (own,) = guess.content['joints'].values()
    assert own['position']['variable'] == 'Cumulative pulses'
    assert own['position']['unit'] == 'counts'


def test_setpoints_of_an_arm_whose_names_do_not_say_so_are_left_out(tmp_path):
    series = [joint(seed) for seed in range(2)]
    columns = {'t': series[0][0]}
    for k, (t, q, _, tau) in enumerate(series, 1):
        early = np.interp(t + 0.012, t, q)
        columns |= {f'AIPos.A{k}': q, f'ASPos.A{k}': early, f'MACur.A{k}': tau}
    guess = guess_mapping(save(tmp_path, list(columns.values()), list(columns)))
    assert [own['position'] for own in roles(guess).values()] == ['AIPos.A1', 'AIPos.A2']
    assert roles(guess)['AI_A2']['effort'] == 'MACur.A2'
    assert any('ASPos.A1 is nearly AIPos.A1 and comes' in told for told in guess.remarks)


def test_a_shaft_that_turns_one_way_is_no_time(tmp_path):
    _t, _q, v, tau = joint(9)
    turned = np.cumsum(np.abs(v) + 0.01) / 250.0
    guess = guess_mapping(save(tmp_path, [turned, tau], ['position', 'torque']))
    assert guess.content['sample_rate'] == FILL_IN
    assert roles(guess)['joint'] == {'position': 'position', 'effort': 'torque'}


def test_an_external_torque_may_not_stand_for_an_effort(tmp_path):
    t, q, _, tau = joint(9)
    data = save(tmp_path, [t, q, tau], ['t', 'q', 'tau_ext'])
    guess = guess_mapping(data)
    assert roles(guess) == {'joint': {'position': 'q'}}
    assert not any('may stand for it' in told for told in guess.remarks)
    stated = map_columns(data, Columns({'position': ['q'], 'effort': ['tau_ext']}))
    assert any('not what drives the joint' in told for told in stated.remarks)


def test_units_behind_names_of_axes_are_read(tmp_path):
    (t, q, _, tau), (_, p, _, force) = joint(1), joint(2)
    names = ['time', 'j1_deg', 'j2_mm', 't1_Nm', 'f2_N']
    guess = guess_mapping(save(tmp_path, [t, 57.3 * q, 100.0 * p, tau, 9.0 * force], names))
    own = guess.content['joints']
    assert own['j1']['position']['unit'] == 'deg'
    assert own['j1']['effort'] == {'variable': 't1_Nm', 'unit': 'Nm'}
    assert own['j2']['position']['unit'] == 'mm'
    assert roles(guess)['j2']['effort'] == 'f2_N'


@pytest.mark.parametrize(
    ('unit', 'size', 'expected'), [('deg', 57.3, FILL_IN), ('rad', 1.0, 'rad')]
)
@pytest.mark.parametrize('rests', [False, True])
def test_small_motions_in_deg_about_a_posture_are_not_in_rad(
    tmp_path, unit, size, expected, rests
):
    t, q, _, tau = joint(9)
    near = size * (0.05 if unit == 'deg' else 1.0) * q
    columns = [t, near if rests else near + 1.57 * size, 0.0 * q + 1.57 * size, tau]
    guess = guess_mapping(save(tmp_path, columns, ['t', 'q1', 'q2', 'tau1']))
    assert guess.content['joints']['joint_1']['position']['unit'] == expected


def test_a_shaft_at_one_speed_tells_the_unit_of_its_velocity(tmp_path):
    t = np.arange(2500) / 250.0
    noise = np.random.default_rng(0).normal(size=(2, 2500))
    columns = [t, 720.0 * t + 0.01 * noise[0], 120.0 + 0.5 * noise[1], 0.3 + 0.01 * noise[0]]
    guess = guess_mapping(save(tmp_path, columns, ['t', 'pos_deg', 'speed', 'tau']))
    assert guess.content['joints']['joint']['velocity'] == {'variable': 'speed', 'unit': 'rpm'}


def test_the_question_for_a_rate_quotes_a_line_that_may_say_it(tmp_path):
    _, q, _, tau = joint(9)
    rows = '\n'.join(f'{x:.6f},{y:.6f}' for x, y in zip(q, tau, strict=True))
    path = tmp_path / 'x.csv'
    for line, said in (('Sampling period is 100000 nSec', True), ('dt of q2', False)):
        path.write_text(f'{line}\nq,tau\n{rows}\n')
        told = guess_mapping(DataFile(path)).reasons['sample_rate']
        assert (f'as --rate HZ; its line {line!r} may say it' in told) is said


def test_each_joint_is_told_how_far_it_moves_itself(tmp_path):
    t = np.arange(0.0, 10.0, 0.01)
    rows = zip(t, np.sin(t), 0.3 * np.sin(2.0 * t), np.cos(t), np.cos(3.0 * t), strict=True)
    path = tmp_path / 'x.csv'
    np.savetxt(path, list(rows), delimiter=',', header='t,q1,q2,tau1,tau2', comments='')
    turns = [
        f'<joint name="j{k}" type="revolute"><parent link="l{k - 1}"/><child link="l{k}"/>'
        '<axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="9" velocity="9"/></joint>'
        for k in (1, 2)
    ]
    links = '<link name="l0"/><link name="l1"/><link name="l2"/>'
    guess = guess_mapping(DataFile(path), f'<robot name="x">{links}{"".join(turns)}</robot>')
    assert 'and moves 2' in guess.reasons['joints.j1.position']
    assert guess.reasons['joints.j2.position'].endswith('and moves 0.6, and j1 2')


def test_counts_are_told_by_the_travel_of_each_joint_and_names_as_they_are_written(tmp_path):
    t, one, _, effort = joint(0)
    own = [np.rint(4096 * x) for x in (one, 0.5 * one)]
    header = ['t', '位置 enc', 'q2 enc', 'tau1', 'tau2']
    guess = guess_mapping(save(tmp_path, [t, *own, effort, effort], header))
    text = guess.to_yaml('x')
    assert '"位置 enc"' in text
    for counts in own:
        assert f'whole numbers, {np.ptp(counts):.0f} from end to end' in text
