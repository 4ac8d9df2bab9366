# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""``sosml fit`` and ``diagnose`` on tables, with a robot that no file describes."""

import json

import numpy as np
import pytest
from slider_bags import COULOMB, EMPS, VISCOUS, checked, record, slider_log

from sosml_friction.bags.bag import Bag

ROBOT = ('--axis', '95.1089')
#: The mass is what the effort was made with: a comparison of bodies is half the time of a fit. The
#: weak form is judged, for which no observer runs.
FIT = ('fit', '--body-tolerance', '0', '--observers', 'sosml')


def write_table(folder, name='axis.csv', header='t,q,f', scale=(1.0, 1.0, 1.0), extra=()):
    log = slider_log()
    columns = [log.time * scale[0], log.q[:, 0] * scale[1], log.tau[:, 0] * scale[2], *extra]
    np.savetxt(folder / name, np.column_stack(columns), delimiter=',', header=header, comments='')
    return folder / name


def friction(text):
    own = checked(text, 'fit')['joints']
    (fits,) = own.values()
    return {n: p['value'] for n, p in fits['weak_form']['parameters'].items()}


@pytest.mark.parametrize(
    ('scale', 'columns'),
    [
        ((1.0, 1.0, 1.0), ('--position', '1', '--effort', '2', '--time', '0')),
        ((1e3, 1e3, 0.1), ('--position', 'q:mm', '--effort', 'f:A', '--kt', '10')),
        ((1e6, 1.0, 0.5), ('--position', 'q', '--current', 'f', '--kt', '2', '--time', 't:us')),
    ],
)
def test_a_table_gives_the_friction_it_was_made_with(sosml, tmp_path, scale, columns):
    table = write_table(tmp_path, scale=scale)
    code, out, err = sosml(*FIT, table, *columns, *ROBOT, '--json')
    assert code == 0
    found = friction(out)
    # The noise of the ladder is 0.3 N; what a bag of it gives agrees as well (test_fit).
    assert found['coulomb'] == pytest.approx(COULOMB, rel=0.03)
    assert found['viscous'] == pytest.approx(VISCOUS, rel=0.05)
    assert 'time is t' in err
    assert 'assumed: the axis is level' in err
    assert sorted(p.name for p in tmp_path.iterdir()) == ['axis.csv', 'axis_fit']


def test_a_table_and_a_bag_of_one_motion_agree_to_the_last_digit(sosml, tmp_path):
    table = write_table(tmp_path)
    bag = record(tmp_path / 'bag', slider_log(), model=False, urdf=False)
    columns = ('--position', 'q', '--effort', 'f')
    assert sosml(*FIT, table, *columns, *ROBOT, '--out', 'a')[0] == 0
    assert sosml(*FIT, bag, *ROBOT, '--out', 'b')[0] == 0
    one, other = (json.loads((tmp_path / x / 'fit.json').read_text()) for x in 'ab')
    (found,), (expected,) = (list(x['joints'].values()) for x in (one, other))
    for name, parameter in expected['weak_form']['parameters'].items():
        value = found['weak_form']['parameters'][name]['value']
        # 18 digits of text; position in the table, velocity besides in the bag.
        assert (value is None) == (parameter['value'] is None)
        if value is not None and name in ('coulomb', 'viscous'):
            assert value == pytest.approx(parameter['value'], rel=1e-6)


def test_several_tables_are_fitted_together(sosml, tmp_path):
    tables = [
        write_table(tmp_path, f'{x}.csv', scale=(1.0, 1.0, y)) for x, y in (('a', 1), ('b', 1.01))
    ]
    code, out, _ = sosml(*FIT, *tables, '--position', 'q', '--effort', 'f', *ROBOT, '--json')
    assert code == 0
    assert [bag['label'] for bag in json.loads(out)['bags']] == ['a', 'b']


def test_the_header_says_in_what_a_current_is(sosml, tmp_path):
    table = write_table(tmp_path, header='t,q,f [mA]', scale=(1.0, 1.0, 1e3))
    code, out, err = sosml(*FIT, table, '--position', 'q', '--current', 'f', '--kt', '1', *ROBOT,
                           '--json')  # fmt: skip
    assert code == 0, err
    assert friction(out)['coulomb'] == pytest.approx(COULOMB, rel=0.03)


def test_a_table_is_simulated_and_tuned_for(sosml, tmp_path):
    table = write_table(tmp_path)
    columns = ('--position', 'q', '--effort', 'f')
    assert sosml(*FIT, table, *columns, *ROBOT, '--out', 'axis')[0] == 0
    for command, schema in (('simulate', 'simulation'), ('tune', 'tune')):
        code, out, err = sosml(command, table, *columns, '--model', 'axis', '--json')
        assert code == 0, err
        assert list(checked(out, schema)['joints']) == ['joint']
    assert sosml('tune', table, *columns, *ROBOT)[0] == 0
    code, _, err = sosml('tune', table, '--position', 'q', '--current', 'f', *ROBOT)
    assert code == 2
    assert '--kt' in err


def test_a_mapping_does_for_the_columns(sosml, tmp_path):
    table = write_table(tmp_path)
    (tmp_path / 'm.yaml').write_text(
        'time: {variable: t, unit: s}\n'
        'joints: {slider: {position: {variable: q, unit: m}, effort: {variable: f, unit: N}}}\n'
    )
    code, out, _ = sosml(*FIT, table, '--map', 'm.yaml', '--model', EMPS, '--json')
    assert code == 0
    assert friction(out)['coulomb'] == pytest.approx(COULOMB, rel=0.03)


def test_the_only_joint_of_a_model_is_the_one_of_the_columns(sosml, tmp_path):
    columns = ('--position', 'q', '--effort', 'f')
    code, out, _ = sosml(*FIT, write_table(tmp_path), *columns, '--model', EMPS, '--json')
    assert code == 0
    assert list(checked(out, 'fit')['joints']) == ['slider']


def test_an_mjcf_is_a_robot_for_a_table(sosml, tmp_path):
    pytest.importorskip('mujoco')
    slide = '<joint name="slide" type="slide" axis="1 0 0" armature="5"/>'
    body = f'<body>{slide}<inertial pos="0 0 0" mass="90.1089" diaginertia="1 1 1"/></body>'
    (tmp_path / 'axis.xml').write_text(f'<mujoco><worldbody>{body}</worldbody></mujoco>')
    columns = ('--position', 'q', '--effort', 'f')
    code, out, err = sosml(
        *FIT, write_table(tmp_path), *columns, '--mjcf', tmp_path / 'axis.xml', '--json'
    )
    assert code == 0
    assert 'slide.position is q [m]' in err
    assert friction(out)['coulomb'] == pytest.approx(COULOMB, rel=0.03)


def test_diagnose_takes_the_same(sosml, tmp_path):
    table = write_table(tmp_path)
    columns = ('--position', 'q', '--effort', 'f')
    trust = ('--trust', 'friction=inf,masses=0.1')
    code, out, err = sosml('diagnose', table, *columns, *ROBOT, *trust, '--out', 'why', '--json')
    assert code == 0
    document = checked(out, 'diagnosis')
    assert document['provenance']['trust'] == {'friction': 'inf', 'masses': 0.1}
    report = (tmp_path / 'why' / 'report.html').read_text()
    assert 'within 3.5 % of their values (friction freely, masses within 10 %)' in report
    # What the plant had is what the model refits: nothing is left to name.
    assert document['verdict'] == 'nothing_above_floor'
    assert 'time is t' in err


WRONG = [
    ((), 'says nothing of the robot: give --pendulum MASS,LENGTH, --axis MASS'),
    (ROBOT, 'is a table, which does not say what is what: name its columns, as --position q'),
    ((*ROBOT, '--position', 'x'), "has no series 'x': it has t, q, f"),
    (
        (*ROBOT, '--position', 'q'),
        'as --effort or --current; positions alone do not tell friction',
    ),
    ((*ROBOT, '--free', '1'), '--axis and --free are two robots: give one'),
    ((*ROBOT, '--model', str(EMPS)), 'are whole models: leave out --model and --urdf'),
    (('--pendulum', '1'), '--pendulum 1 has 1 numbers: give mass,length in kg and m'),
    (('--pendulum', 'a,b'), '--pendulum a,b is no number: give numbers'),
    (('--axis', '-1', '--position', 'q'), 'the mass is -1 kg: give a positive number'),
    (
        (*ROBOT, '--position', 'q:counts', '--effort', 'f'),
        'q is in counts of what slides: say how many a m has, as counts_per_unit in a mapping',
    ),
    (
        ('--pendulum', '1,0.1', '--position', 'q:counts', '--effort', 'f:Nm'),
        'q is in counts: give those of a turn, as --counts-per-turn 4096',
    ),
    (
        (*ROBOT, '--position', 'q:deg', '--effort', 'f:N'),
        'slides and its position q is in deg: correct',
    ),
    (
        ('--pendulum', '1,1', '--position', 'q', '--effort', 'f:N'),
        'turns and its effort f is in N',
    ),
    ((*ROBOT, '--position', 'q', '--effort', 'f:A'), 'effort f is in A: give the Nm (or N)'),
    ((*ROBOT, '--position', 'q', '--effort', 'f', '--current', 'f'), 'both the effort: give one'),
    ((*ROBOT, '--position', 'elbow=q', '--effort', 'f'), 'the robot has joint: say which joint'),
    ((*ROBOT, '--position', 'q', '--kt', 'two', '--current', 'f'), '--kt two is no number'),
]


@pytest.mark.parametrize(('options', 'sentence'), WRONG)
def test_what_is_missing_or_wrong_is_one_sentence(sosml, tmp_path, options, sentence):
    table = write_table(tmp_path)
    code, out, err = sosml(*FIT, table, *options)
    assert (code, out) == (2, '')
    refusal = err.splitlines()[-1]
    assert refusal.startswith('sosml: ')
    assert sentence in refusal
    assert 'sosml_' not in refusal
    assert sorted(p.name for p in tmp_path.iterdir()) == ['axis.csv']


def test_a_bag_in_sqlite_is_as_good_as_one_in_mcap(sosml, tmp_path, slider_bag):
    rosbag2 = pytest.importorskip('rosbags.rosbag2')
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    name = 'sensor_msgs/msg/JointState'
    plugin = rosbag2.StoragePlugin.SQLITE3
    with rosbag2.Writer(tmp_path / 'lite', version=9, storage_plugin=plugin) as writer:
        connection = writer.add_connection('/joint_states', name, typestore=store)
        for stamp, cdr in Bag.open(slider_bag).messages('/joint_states'):
            writer.write(connection, stamp, cdr)
    axis = ('--model', EMPS, '--json')
    found, expected = (
        friction(sosml(*FIT, bag, *axis, '--out', out)[1])
        for bag, out in ((tmp_path / 'lite', 'a'), (slider_bag, 'b'))
    )
    assert found == expected
    code, out, _ = sosml(*FIT, tmp_path / 'lite', *ROBOT, '--json', '--out', 'c')
    assert code == 0
    assert friction(out)['coulomb'] == pytest.approx(expected['coulomb'], rel=0.01)


@pytest.mark.parametrize(
    ('given', 'sentence'),
    [
        ('axes.csv', 'axes.csv does not exist: give the path of a table or a bag'),
        ('folder', 'folder is a folder of tables: name the files, or let sosml fleet fit folder'),
        ('axis.tar.gz', 'axis.tar.gz is neither a table nor a bag: give a table of the kind .mat'),
    ],
)
def test_what_is_no_table_is_told(sosml, tmp_path, given, sentence):
    (tmp_path / 'folder').mkdir()
    write_table(tmp_path / 'folder')
    (tmp_path / 'axis.tar.gz').write_bytes(b'')
    code, _, err = sosml(*FIT, given, '--position', 'q', '--effort', 'f', *ROBOT)
    assert code == 2
    assert sentence in err


@pytest.mark.filterwarnings('error')
@pytest.mark.parametrize('time', [(), ('--time', 't'), ('--time', 't:s'), ('--rate', '500')])
def test_a_header_without_rows_is_one_sentence(sosml, tmp_path, time):
    (tmp_path / 'head.csv').write_text('t,q,f\n')
    columns = ('--position', 'q', '--effort', 'f', *time)
    for command in ('fit', 'diagnose'):
        code, out, err = sosml(command, 'head.csv', *columns, *ROBOT)
        assert (code, out) == (2, '')
        assert err.splitlines()[-1] == 'sosml: head.csv holds no numbers: give a recording'


def test_of_a_table_of_words_the_first_is_told(sosml, tmp_path):
    (tmp_path / 'words.csv').write_text('t,q,f\na,b,c\nd,e,f\n')
    code, _, err = sosml('fit', 'words.csv', '--position', 'q', '--effort', 'f', *ROBOT)
    assert code == 2
    assert "words.csv line 2, column 'q': 'b' is not a number" in err


def test_columns_of_a_bag_are_refused(sosml, tmp_path, slider_bag):
    code, _, err = sosml(*FIT, slider_bag, '--position', 'q')
    assert code == 2
    assert '--position is of a table, and' in err


LINK = '<link name="{}"><inertial><mass value="1"/><inertia {}/></inertial></link>'
TURNS = '<joint name="joint{}" type="continuous"><parent link="{}"/><child link="{}"/></joint>'
INERTIA = 'ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"'
CHAIN = (
    '<robot name="r">'
    + ''.join(LINK.format(name, INERTIA) for name in 'abc')
    + TURNS.format(1, 'a', 'b')
    + TURNS.format(2, 'b', 'c')
    + '</robot>'
)


@pytest.mark.parametrize(
    ('names', 'effort', 'sentence'),
    [
        # What is refused next has the names of the one table.
        (('joint2.csv', 'joint1.csv'), 'f:A', 'effort joint2 f is in A: give the Nm (or N) at'),
        (('joint2.csv', 'joint1.csv'), 'i', "joint2.csv has no variable 'i': it has t, q, f"),
        (('run1.csv', 'run2.csv'), 'f', 'their names do not say which of joint1, joint2'),
    ],
)
def test_files_of_a_joint_each_are_put_side_by_side(sosml, tmp_path, names, effort, sentence):
    tables = [write_table(tmp_path, name) for name in names]
    (tmp_path / 'r.urdf').write_text(CHAIN)
    columns = ('--position', 'q:rad', '--effort', effort, '--time', 't:s')
    code, _, err = sosml(*FIT, *tables, *columns, '--urdf', tmp_path / 'r.urdf')
    assert code == 2
    assert sentence in err
    assert ('joint2 of joint2.csv, joint1 of joint1.csv' in err) == (effort == 'f:A')
