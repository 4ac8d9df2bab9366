# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Importing: units, stamps and names as the mapping says, or a sentence."""

import json
import math
import shutil
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.tables import importer
from sosml_friction.bags.tables.data_file import DataFile
from sosml_friction.bags.tables.importer import import_recording, read_recording
from sosml_friction.bags.tables.mapping import read_mapping
from sosml_friction.bags.tables.units import LINEAR_UNITS, TIME_UNITS, UNITS
from sosml_friction.exceptions import BagError, ConfigurationError, DataError, SosmlFrictionError
from sosml_friction.share import share_directory

T = np.arange(5) * 0.01
Q = np.array([0.0, 0.1, 0.3, 0.2, -0.1])
TAU = np.array([1.0, np.nan, 3.0, -4.0, 0.5])

URDF = """<robot name="r"><link name="base"/><link name="arm"/>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="arm"/>
<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""


def plain():
    return {
        'time': {'variable': 't', 'unit': 's'},
        'joints': {
            'shoulder': {
                'position': {'variable': 'q', 'unit': 'rad'},
                'effort': {'variable': 'tau', 'unit': 'Nm'},
            }
        },
    }


@pytest.fixture
def mapping(tmp_path):
    """Return a writer of a mapping file with changes: dotted key -> value, None removes it."""

    def make(changes=None):
        content = plain()
        for key, value in (changes or {}).items():
            *path, last = key.split('/')
            inner = content
            for part in path:
                inner = inner.setdefault(part, {})
            if value is None:
                inner.pop(last)
            else:
                inner[last] = value
        path = tmp_path / 'mapping.yaml'
        path.write_text(yaml.safe_dump(content))
        return path

    return make


@pytest.fixture
def source(tmp_path):
    """Return a writer of the same recording as MAT, CSV, NPZ or NPY, with further variables."""

    def make(kind='npz', **more):
        path = tmp_path / f'source.{kind}'
        variables = {'t': T, 'q': Q, 'tau': TAU, **more}
        if kind == 'mat':
            scipy.io.savemat(path, variables)
        elif kind == 'npz':
            np.savez(path, **variables)
        elif kind == 'npy':
            np.save(path, np.array(list(variables.values())))
        else:
            rows = zip(*variables.values(), strict=True)
            lines = [
                ','.join('' if math.isnan(x) else repr(float(x)) for x in row) for row in rows
            ]
            path.write_text('\n'.join([','.join(variables), *lines]) + '\n')
        return path

    return make


@pytest.mark.parametrize('kind', ['mat', 'csv', 'npz', 'npy'])
def test_every_kind_of_file_gives_the_same_bag(tmp_path, source, mapping, kind):
    plan = mapping({'rows': ['t', 'q', 'tau']} if kind == 'npy' else None)
    assert import_recording(source(kind), plan, tmp_path / 'bag') == tmp_path / 'bag'
    bag = Bag.open(tmp_path / 'bag')
    assert bag.topics == {'/joint_states': ('sensor_msgs/msg/JointState', 5)}
    log = bag.joint_log()
    assert log.names == ('shoulder',)
    assert log.t_ns.tolist() == [0, 10_000_000, 20_000_000, 30_000_000, 40_000_000]
    np.testing.assert_array_equal(log.q[:, 0], Q)
    np.testing.assert_array_equal(log.tau[:, 0], TAU)
    assert np.isnan(log.v).all()
    assert log.temperature is None
    # Not mapped is an empty array, unknown for a while is NaN.
    assert [len(message.velocity) for _, message in bag.decoded('/joint_states')] == [0] * 5


def test_emps_is_imported_with_force_as_published(data_directory, tmp_path):
    source = data_directory / 'emps' / 'DATA_EMPS.mat'
    if not source.is_file():
        pytest.skip(f'no {source}')
    import_recording(source, share_directory() / 'config/import/emps.yaml', tmp_path / 'emps')
    raw = scipy.io.loadmat(source, squeeze_me=True)
    bag = Bag.open(tmp_path / 'emps')
    log = bag.joint_log()
    assert log.names == ('slider',)
    assert len(log) == 24841
    np.testing.assert_array_equal(log.t_ns, np.rint(raw['t'] * 1e9).astype(np.int64))
    np.testing.assert_array_equal(log.q[:, 0], raw['qm'])
    np.testing.assert_array_equal(log.tau[:, 0], raw['gtau'] * raw['vir'])
    assert np.isnan(log.v).all()
    assert bag.text('robot_description') == (share_directory() / 'urdf/emps.urdf').read_text()


def test_the_emps_urdf_is_one_slider_of_the_published_mass_without_gravity():
    pin = pytest.importorskip('pinocchio')
    model = pin.buildModelFromUrdf(str(share_directory() / 'urdf/emps.urdf'))
    data = model.createData()
    assert list(model.names) == ['universe', 'slider']
    assert model.nq == model.nv == 1
    q = np.array([0.1])
    assert pin.crba(model, data, q)[0, 0] == pytest.approx(95.1089, rel=1e-14)
    assert pin.computeGeneralizedGravity(model, data, q)[0] == 0.0


def test_rosbags_reads_an_imported_bag_without_velocity(tmp_path, source, mapping):
    from rosbags.rosbag2 import Reader
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    import_recording(source(), mapping(), tmp_path / 'bag')
    with Reader(tmp_path / 'bag') as reader:
        messages = [store.deserialize_cdr(cdr, c.msgtype) for c, _, cdr in reader.messages()]
    assert [message.position.tolist() for message in messages] == [[x] for x in Q]
    assert all(message.velocity.size == 0 for message in messages)


@pytest.mark.parametrize(
    ('unit', 'values'),
    [
        ('s', [1.5, 1.501]),
        ('ms', [1500.0, 1501.0]),
        ('us', np.array([1_500_000, 1_501_000])),
        ('ns', np.array([1_500_000_000, 1_501_000_000])),
    ],
)
def test_time_units(source, mapping, unit, values):
    plan = read_mapping(mapping({'time/unit': unit}))
    log = read_recording(source(t=values, q=[1, 2], tau=[1, 2]), plan)
    assert log.t_ns.tolist() == [1_500_000_000, 1_501_000_000]
    assert unit in TIME_UNITS


@pytest.mark.parametrize(
    ('unit', 'step', 'rate'), [('ms', 0.005, '2e+05'), ('s', 10, '0.1'), ('s', 0.005, '')]
)
def test_a_rate_that_no_joint_is_recorded_at_is_told(source, mapping, unit, step, rate):
    # s that are mapped as ms, ms that are mapped as s, and what is right.
    told = []
    plan = read_mapping(mapping({'time/unit': unit}))
    log = read_recording(source(t=np.arange(5) * step), plan, told.append)
    assert len(log) == 5
    assert len(told) == bool(rate)
    assert all(f'makes {rate} samples per second' in sentence for sentence in told)
    assert all('check its unit in the mapping' in sentence for sentence in told)


def test_integer_nanoseconds_keep_every_digit(source, mapping):
    stamps = np.array([1_700_000_000_123_456_789, 1_700_000_000_123_456_790])
    plan = read_mapping(mapping({'time/unit': 'ns'}))
    assert read_recording(source(t=stamps, q=[1, 2], tau=[1, 2]), plan).t_ns.tolist() == list(
        stamps
    )


def test_integer_nanoseconds_of_a_csv_keep_every_digit(tmp_path, mapping):
    path = tmp_path / 'x.csv'
    path.write_text('t;q;tau\n1700000000123456789;1;1\n\n1700000000123456790;2.5;\n')
    log = read_recording(path, read_mapping(mapping({'time/unit': 'ns'})))
    assert log.t_ns.tolist() == [1_700_000_000_123_456_789, 1_700_000_000_123_456_790]
    assert log.q[:, 0].tolist() == [1.0, 2.5]
    assert np.isnan(log.tau[1, 0])


@pytest.mark.parametrize('rate', [400.0, 'fs'])
def test_a_sample_rate_stands_for_time(source, mapping, rate):
    plan = read_mapping(mapping({'time': None, 'sample_rate': rate, 'start_time': 3}))
    log = read_recording(source(fs=400.0), plan)
    assert log.t_ns.tolist() == [3_000_000_000 + k * 2_500_000 for k in range(5)]


@pytest.mark.parametrize(
    ('start', 'ns'), [(0, 0), (1_700_000_000, 17 * 10**17), (0.25, 250_000_000)]
)
def test_start_time_is_added(source, mapping, start, ns):
    log = read_recording(source(), read_mapping(mapping({'start_time': start})))
    assert log.t_ns[0] == ns
    assert log.t_ns[-1] == ns + 40_000_000


@pytest.mark.parametrize(
    ('quantity', 'unit', 'more', 'si'),
    [
        ('position', 'rad', {}, 2.0),
        ('position', 'deg', {}, math.radians(2.0)),
        ('position', 'turns', {}, 4.0 * math.pi),
        ('position', 'm', {}, 2.0),
        ('position', 'mm', {}, 0.002),
        ('position', 'counts', {'counts_per_unit': 1000}, 0.002),
        ('position', 'counts', {'counts_per_turn': 8}, math.pi / 2),
        ('position', 'rad', {'scale': -0.5, 'offset': 3.0}, 2.0),
        ('position', 'deg', {'scale': 'gear', 'offset': 'zero'}, math.radians(2.0) * 36.0 - 1.5),
        ('position', 'mrad', {}, 0.002),
        ('position', 'gon', {}, math.pi / 100.0),
        ('position', 'arcmin', {}, math.radians(2.0 / 60.0)),
        ('position', 'arcsec', {}, math.radians(2.0 / 3600.0)),
        ('position', 'cm', {}, 0.02),
        ('position', 'um', {}, 2e-6),
        ('position', 'in', {}, 0.0508),
        ('velocity', 'mrad/s', {}, 0.002),
        ('velocity', 'cm/s', {}, 0.02),
        ('velocity', 'm/min', {}, 1.0 / 30.0),
        ('velocity', 'mm/min', {}, 1.0 / 30_000.0),
        ('velocity', 'in/s', {}, 0.0508),
        ('effort', 'cNm', {}, 0.02),
        ('effort', 'kNm', {}, 2000.0),
        ('effort', 'kgf.m', {}, 19.6133),
        ('effort', 'kgf.cm', {}, 0.196133),
        ('effort', 'gf.cm', {}, 1.96133e-4),
        ('effort', 'lbf.ft', {}, 2.7116358966),
        ('effort', 'lbf.in', {}, 0.22596965805),
        ('effort', 'ozf.in', {}, 0.014123103628),
        ('effort', 'mN', {}, 0.002),
        ('effort', 'kgf', {}, 19.6133),
        ('effort', 'lbf', {}, 8.896443230521),
        ('velocity', 'rad/s', {}, 2.0),
        ('velocity', 'deg/s', {}, math.radians(2.0)),
        ('velocity', 'rpm', {}, 2.0 * 2.0 * math.pi / 60.0),
        ('velocity', 'turns/s', {}, 4.0 * math.pi),
        ('velocity', 'm/s', {}, 2.0),
        ('velocity', 'mm/s', {}, 0.002),
        ('velocity', 'counts/s', {'counts_per_unit': 1000}, 0.002),
        ('effort', 'Nm', {}, 2.0),
        ('effort', 'mNm', {}, 0.002),
        ('effort', 'N', {}, 2.0),
        ('effort', 'kN', {}, 2000.0),
        ('effort', 'A', {'scale': 0.75}, 1.5),
        ('effort', 'mA', {'scale': 0.75}, 1.5),
        ('effort', 'V', {'scale': 'gear'}, 72.0),
        ('effort', 'mV', {'scale': 0.75}, 1.5),
        ('effort', 'percent', {'scale': 0.75}, 1.5),
        ('effort', 'counts', {'scale': 0.75}, 1.5),
        ('temperature', 'degC', {}, 2.0),
        ('temperature', 'K', {}, -271.15),
    ],
)
def test_units_become_si(source, mapping, quantity, unit, more, si):
    # A joint that slides where the unit under test says so.
    position = {'variable': 'q', 'unit': 'm' if unit in LINEAR_UNITS else 'rad'}
    signals = {'position': position, quantity: {'variable': 'x', 'unit': unit, **more}}
    plan = read_mapping(mapping({'joints': {'j': signals}}))
    log = read_recording(source(x=np.full(5, 2.0), gear=36.0, zero=-1.5), plan)
    field = {'position': 'q', 'velocity': 'v', 'effort': 'tau', 'temperature': 'temperature'}
    np.testing.assert_allclose(getattr(log, field[quantity])[:, 0], si, rtol=1e-10)


def test_every_unit_is_tested_above():
    marks = test_units_become_si.pytestmark[0].args[1]
    assert {(quantity, unit) for quantity, unit, _, _ in marks} == {
        (quantity, unit) for quantity, units in UNITS.items() for unit in units
    }


def test_joints_come_out_of_tables_by_column_and_row(source, mapping):
    table = np.arange(10.0).reshape(5, 2)
    joints = {
        'a': {'position': {'variable': 'table', 'unit': 'rad', 'column': 1}},
        'b': {
            'position': {'variable': 'turned', 'unit': 'rad', 'row': 0},
            'effort': {'variable': 'tau', 'unit': 'Nm'},
        },
    }
    plan = read_mapping(mapping({'joints': joints}))
    log = read_recording(source(table=table, turned=-table.T), plan)
    assert log.q.tolist() == [[2 * k + 1, -2 * k] for k in range(5)]
    assert np.isnan(log.tau[:, 0]).all()
    np.testing.assert_array_equal(log.tau[:, 1], TAU)


SHAFT = 4.0 * math.pi * np.sin(np.linspace(0.0, 9.0, 900))


@pytest.mark.parametrize(
    ('unit', 'per_rad', 'more', 'low'),
    [
        ('rad', 1.0, {}, -math.pi),
        ('deg', 180.0 / math.pi, {}, 0.0),
        ('turns', 0.5 / math.pi, {}, 0.0),
        ('counts', 2048.0 / math.pi, {'counts_per_turn': 4096}, 0.0),
    ],
)
@pytest.mark.parametrize('stated', ['recognised', 'period', 'range'])
def test_a_position_that_wraps_is_unwrapped(source, mapping, unit, per_rad, more, low, stated):
    period = 2.0 * math.pi * per_rad
    wrap = {'period': {'wrap': period}, 'range': {'wrap': [low, low + period]}}.get(stated, {})
    seen = (SHAFT * per_rad - low) % period + low
    position = {'variable': 'q', 'unit': unit, **more, **wrap}
    plan = read_mapping(mapping({'joints': {'shaft': {'position': position}}}))
    told = []
    log = read_recording(source(t=np.arange(900.0) * 0.01, q=seen, tau=seen), plan, told.append)
    np.testing.assert_allclose(log.q[:, 0], SHAFT, atol=1e-9)
    assert len(told) == (stated == 'recognised')
    assert all('wraps at a period of' in sentence for sentence in told)


def test_a_wrap_that_is_denied_stays(source, mapping):
    seen = SHAFT % 6.0
    plan = read_mapping(mapping({'joints/shoulder/position/wrap': False}))
    log = read_recording(source(t=np.arange(900.0) * 0.01, q=seen, tau=seen), plan)
    np.testing.assert_array_equal(log.q[:, 0], seen)


def test_repeated_stamps_are_left_out_and_told(source, mapping):
    t = np.arange(100.0) * 0.01
    t[[20, 50]] = t[[19, 49]]
    told = []
    plan = read_mapping(mapping())
    log = read_recording(source(t=t, q=np.arange(100), tau=np.zeros(100)), plan, told.append)
    assert len(log) == 98
    assert 20 not in log.q
    assert len(told) == 1
    assert '2 of 100 samples repeat the stamp before them' in told[0]


@pytest.mark.parametrize('times', [2, 3])
def test_samples_that_are_logged_again_are_left_out_and_told(source, mapping, times):
    t, q = np.arange(100.0) * 0.01, np.sin(np.arange(100.0))
    q[7] = np.nan
    twice = {name: np.repeat(x, times) for name, x in {'t': t, 'q': q, 'tau': 2.0 * q}.items()}
    told = []
    plan = read_mapping(mapping())
    log = read_recording(source(**twice), plan, told.append)
    np.testing.assert_array_equal(log.q[:, 0], q)
    assert len(told) == 1
    assert f'{100 * times - 100} of {100 * times} samples repeat the sample before' in told[0]
    # Stamps that repeat beside another value are a time that is too coarse.
    twice['tau'] = np.arange(100.0 * times)
    with pytest.raises(DataError, match='does not increase'):
        read_recording(source(**twice), plan)


def test_seconds_and_nanoseconds_of_two_columns_are_added(source, mapping):
    changes = {'time': {'variable': 'sec', 'unit': 's', 'nanoseconds': 'nsec'}}
    sec, nsec = np.array([7, 7, 8, 8, 8]), np.array([5, 999_999_999, 1, 2, 3])
    log = read_recording(source(sec=sec, nsec=nsec), read_mapping(mapping(changes)))
    assert log.t_ns.tolist() == (sec * 10**9 + nsec).tolist()


def test_a_rate_beside_the_mapping_stands_for_time(source, mapping):
    open_time = {'time': {'variable': 'FILL_IN', 'unit': 's'}}
    for changes in ({'time': None}, {'time': None, 'sample_rate': 'FILL_IN'}):
        log = read_recording(source(), read_mapping(mapping(changes), 50.0))
        np.testing.assert_array_equal(np.diff(log.t_ns), 20_000_000)
    for changes in ({}, open_time, {'time': None, 'sample_rate': 5}):
        with pytest.raises(ConfigurationError, match='already: leave the rate out'):
            read_mapping(mapping(changes), 50.0)


def test_json_as_pandas_writes_it_and_cut_off_lines_are_read(tmp_path, mapping):
    columns = {'t': T.tolist(), 'q': Q.tolist(), 'tau': TAU.tolist()}
    numbered = {name: dict(enumerate(x)) for name, x in columns.items()}
    (tmp_path / 'x.json').write_text(json.dumps(numbered))
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    lines = '\n'.join(map(json.dumps, rows)) + '\n{"t": 5.0, "q'
    (tmp_path / 'x.jsonl').write_text(lines)
    for name in ('x.json', 'x.jsonl'):
        log = read_recording(tmp_path / name, read_mapping(mapping()))
        np.testing.assert_array_equal(log.q[:, 0], Q)


def test_an_injected_signal_goes_into_the_bag(tmp_path, source, mapping):
    plan = mapping({'joints/shoulder/injected': {'variable': 'p', 'unit': 'mNm'}})
    path = import_recording(source(p=np.arange(5)), plan, tmp_path / 'bag')
    t_ns, names, effort = Bag.open(path).injected()
    assert t_ns.tolist() == Bag.open(path).joint_log().t_ns.tolist()
    assert names == ('shoulder',)
    np.testing.assert_allclose(effort[:, 0], 1e-3 * np.arange(5))
    assert (
        Bag.open(import_recording(source(), mapping_without(plan), tmp_path / 'x')).injected()
        is None
    )


def mapping_without(plan):
    content = yaml.safe_load(plan.read_text())
    del content['joints']['shoulder']['injected']
    plan.write_text(yaml.safe_dump(content))
    return plan


def test_pulses_of_emps_explain_what_its_loop_does_not(data_directory, tmp_path):
    source = data_directory / 'emps' / 'DATA_EMPS_PULSES.mat'
    if not source.is_file():
        pytest.skip(f'no {source}')
    shipped = share_directory() / 'config/import/emps_pulses.yaml'
    bag = Bag.open(import_recording(source, shipped, tmp_path / 'emps'))
    raw = scipy.io.loadmat(source, squeeze_me=True)
    log, (_, _, wanted), (_, _, added) = bag.joint_log(), bag.reference(), bag.injected()
    q = log.q[:, 0]
    smooth = np.append(q[0], 0.5 * (q[1:] + q[:-1]))
    v = np.append(0.0, np.diff(smooth)) * 1000.0
    law = raw['gtau'] * (raw['kp'] * raw['kv'] * (wanted[:, 0] - q) - raw['kv'] * v)
    left = log.tau[:, 0] - law
    assert np.std((left - added[:, 0])[10:]) < 0.2 * np.std(left[10:])


def test_fields_of_matlab_structs_have_dotted_names(tmp_path, mapping):
    path = tmp_path / 'x.mat'
    scipy.io.savemat(path, {'data': {'t': T, 'arm': {'q': Q}}, 'tau': TAU.reshape(-1, 1)})
    plan = mapping({'time/variable': 'data.t', 'joints/shoulder/position/variable': 'data.arm.q'})
    np.testing.assert_array_equal(read_recording(path, read_mapping(plan)).q[:, 0], Q)


def test_columns_of_an_npy_table_can_be_named(tmp_path, mapping):
    path = tmp_path / 'x.npy'
    np.save(path, np.column_stack([T, Q, TAU]))
    plan = read_mapping(mapping({'columns': ['t', 'q', 'tau']}))
    np.testing.assert_array_equal(read_recording(path, plan).q[:, 0], Q)


def test_descriptions_temperature_and_tags_go_into_the_bag(tmp_path, source, mapping):
    (tmp_path / 'r.urdf').write_text(URDF)
    (tmp_path / 'm.yaml').write_text('joints: {}\n')
    plan = mapping(
        {
            'urdf': 'r.urdf',
            'model': 'm.yaml',
            'tags': {'worn': 'no', 'load': 2},
            'joints/shoulder/temperature': {'variable': 'c', 'unit': 'degC'},
        }
    )
    celsius = [20.0, 20.0, 21.0, 21.0, 20.5]
    import_recording(source(c=celsius), plan, tmp_path / 'deep' / 'bag')
    bag = Bag.open(tmp_path / 'deep' / 'bag')
    assert bag.text('robot_description') == URDF
    assert bag.text('model_description') == 'joints: {}\n'
    assert bag.topics['/joint_temperatures'][1] == 3
    log = bag.joint_log()
    assert log.temperature[:, 0].tolist() == celsius
    assert log.tags == {'worn': 'no', 'load': '2'}


def test_a_controller_and_its_reference_go_into_the_bag(tmp_path, source, mapping):
    loop = {'reference': {'variable': 'w', 'unit': 'deg'}, 'kp': 'gain', 'kv': 2.0}
    plan = mapping({'joints/shoulder/controller': loop})
    path = import_recording(source(w=np.arange(5.0), gain=[7.5]), plan, tmp_path / 'bag')
    bag = Bag.open(path)
    t_ns, names, wanted = bag.reference()
    assert t_ns.tolist() == bag.joint_log().t_ns.tolist()
    assert names == ('shoulder',)
    np.testing.assert_allclose(wanted[:, 0], np.deg2rad(np.arange(5.0)))
    assert json.loads(bag.tags['controller.shoulder']) == {'kp': 7.5, 'kv': 2.0}
    short = mapping(
        {'joints/shoulder/controller': {**loop, 'reference': {'variable': 'gain', 'unit': 'rad'}}}
    )
    with pytest.raises(DataError, match='1 of the reference of shoulder'):
        import_recording(source(gain=[7.5]), short, tmp_path / 'other')


FAULTS = [
    ({'colour': 1}, "the mapping has the unknown key 'colour': known are time, sample_rate"),
    ({'time/offset': 1}, "time has the unknown key 'offset': known are variable"),
    (
        {'joints/shoulder/torque': {}},
        "joints.shoulder has the unknown key 'torque': known are pos",
    ),
    (
        {'joints/shoulder/effort/gain': 1},
        "joints.shoulder.effort has the unknown key 'gain': known are variable, column, row, unit",
    ),
    ({'time/unit': 'y'}, "time has the unknown unit 'y': known are s, ms, us, ns"),
    ({'time/unit': None}, 'time has no unit: known are s, ms, us, ns'),
    (
        {'joints/shoulder/position/unit': 'grad'},
        "joints.shoulder.position has the unknown unit 'grad': known are rad, deg, turns, m, mm",
    ),
    ({'joints/shoulder/effort/unit': 'W'}, "unknown unit 'W': known are Nm, mNm, N, kN, A, mA, V"),
    (
        {'joints/shoulder/effort/unit': 'A'},
        'joints.shoulder.effort is in A and has no scale: give the Nm .or N. per A',
    ),
    ({'joints/shoulder/effort/unit': 'V'}, 'is in V and has no scale: .* there is no default'),
    ({'joints/shoulder/position/unit': 'counts'}, 'is in counts: give counts_per_unit'),
    (
        {'joints/shoulder/position/counts_per_unit': 8},
        'position has counts_per_unit but is in rad: remove one',
    ),
    (
        {
            'joints/shoulder/position/unit': 'counts',
            'joints/shoulder/position/counts_per_turn': 8,
            'joints/shoulder/position/counts_per_unit': 8,
        },
        'is in counts: give counts_per_unit .* or counts_per_turn',
    ),
    (
        {
            'joints/shoulder/position/unit': 'counts',
            'joints/shoulder/position/counts_per_turn': 'cpr',
        },
        "counts_per_turn is 'cpr': a number is needed",
    ),
    ({'joints/shoulder/effort/unit': 'N'}, 'has both rad and N: a joint either turns'),
    ({'joints/shoulder/effort/scale': 0}, 'effort.scale is 0: that would erase'),
    ({'joints/shoulder/effort/scale': [1]}, r'effort.scale is \[1\]: a number is needed'),
    ({'joints/shoulder/effort/scale': math.nan}, 'a finite number is needed'),
    ({'joints/shoulder/effort/variable': None}, 'joints.shoulder.effort has no variable'),
    ({'joints/shoulder/effort/variable': -3}, 'effort.variable is -3: a name is needed'),
    ({'joints/shoulder/effort/column': -1}, 'effort.column is -1: count from 0'),
    (
        {'joints/shoulder/effort/column': 0, 'joints/shoulder/effort/row': 0},
        'effort has both column and row',
    ),
    ({'joints/shoulder/position': None}, 'joints.shoulder has no position'),
    (
        {
            'joints/elbow': {
                'position': {'variable': 'c', 'unit': 'rad'},
                'effort': {'variable': 'tau', 'unit': 'Nm'},
            }
        },
        'joints.shoulder.effort is that of elbow, too: name the one of shoulder',
    ),
    ({'joints': None}, 'the mapping has no joints'),
    ({'joints': []}, r'joints is \[\]: a mapping'),
    ({'joints': {1: {}}}, 'joints has the key 1: put it in quotes'),
    ({'time': None}, 'needs either time or sample_rate, or --rate beside it'),
    ({'sample_rate': 5}, 'needs either time or sample_rate'),
    ({'time': None, 'sample_rate': -5}, 'sample_rate is -5 Hz: it must be positive'),
    ({'start_time': 'noon'}, "start_time is 'noon': a number is needed"),
    ({'joints/shoulder/position/wrap': 0}, 'position.wrap is 0: give the period, .lowest, high'),
    ({'joints/shoulder/position/wrap': [3, 1]}, r'wrap is -2.0: give the period'),
    ({'joints/shoulder/effort/wrap': 1}, "effort has the unknown key 'wrap'"),
    ({'joints/shoulder/injected': {'variable': 'q', 'unit': 'A'}}, 'injected is in A and has no'),
    ({'joints/shoulder/injected': {'variable': 'q', 'unit': 'N'}}, 'has both rad and N: a joint'),
    ({'joints/shoulder/effort/unit': 'FILL_IN'}, 'effort.unit is left open .FILL_IN.: fill it in'),
    ({'urdf': 'no.urdf'}, "urdf is 'no.urdf' and .*no.urdf does not exist"),
    ({'model': 'no.yaml'}, "model is 'no.yaml' and .*no.yaml does not exist"),
    ({'rows': 'abc'}, "rows is 'abc': a list of names is needed"),
    ({'rows': ['a']}, 'name the parts of a table without names, and .*source.npz has'),
    (
        {'joints/shoulder/temperature': {'variable': 'q', 'unit': 'K', 'offset': 1}},
        'is in K and has an offset',
    ),
    ({'joints/shoulder/controller': {'kp': 1, 'kv': 2}}, 'controller has no reference'),
    (
        {'joints/shoulder/controller': {'reference': {'variable': 'q', 'unit': 'rad'}, 'kp': 1}},
        'controller has no kv: the loop cannot be simulated without it',
    ),
    (
        {
            'joints/shoulder/controller': {
                'reference': {'variable': 'q', 'unit': 'm'},
                'kp': 1,
                'kv': 2,
            }
        },
        'has both rad and m: a joint either turns',
    ),
]


@pytest.mark.parametrize(('changes', 'sentence'), FAULTS)
def test_a_wrong_mapping_is_refused_by_name(tmp_path, source, mapping, changes, sentence):
    path = mapping(changes)
    with pytest.raises(ConfigurationError, match=sentence) as caught:
        import_recording(source(), path, tmp_path / 'bag')
    assert '\n' not in str(caught.value)
    assert sorted(p.name for p in tmp_path.iterdir()) == ['mapping.yaml', 'source.npz']


DATA_FAULTS = [
    (
        {'joints/shoulder/effort/variable': 'current'},
        {},
        "has no variable 'current': it has t, q,",
    ),
    ({'joints/shoulder/effort/scale': 'kt'}, {}, "has no variable 'kt': it has t, q, tau"),
    (
        {'joints/shoulder/effort/scale': 'kt'},
        {'kt': [1.0, 2.0]},
        "'kt' of .* has shape .2,.: one f",
    ),
    ({'joints/shoulder/effort/scale': 'kt'}, {'kt': math.nan}, "'kt' of .* one finite number"),
    (
        {},
        {'t': [0, 0.01, 0.01, 0.03, 0.04]},
        'does not increase at index 2 .10000000 ns, then 100',
    ),
    (
        {},
        {'t': [0, 0.02, 0.01, 0.03, 0.04]},
        'does not increase at index 2 .20000000 ns, then 100',
    ),
    ({}, {'t': [0, 0.01, math.nan, 0.03, 0.04]}, "time 't' of .* is nan at index 2: each sample"),
    ({}, {'t': [0, 1, 2, 3, 1e12]}, r'reaches 1e\+12: check its unit'),
    ({'start_time': 0.5}, {'t': T - 1.0}, 'begins 500000000 ns before 0: set start_time'),
    ({}, {'t': T[:4]}, "4 samples of time and 5 of the position of shoulder .'q'.: they must be"),
    ({}, {'t': []}, 'holds no samples'),
    ({'joints/shoulder/effort/column': 0}, {}, "'tau' of .* it is no table, so remove column"),
    (
        {},
        {'tau': np.zeros((5, 2))},
        "'tau' of .* has shape .5, 2.: say in the mapping which column",
    ),
    (
        {'joints/shoulder/effort/column': 2},
        {'tau': np.zeros((5, 2))},
        "'tau' of .* has 2 columns: column 2 .counted from 0. does not exist",
    ),
    ({}, {'tau': np.array(['x'] * 5)}, "'tau' of .* holds <U1: real numbers are needed"),
    ({}, {'tau': np.ones(5) * 1j}, "'tau' of .* holds complex128: real numbers"),
    ({'time': None, 'sample_rate': 'fs'}, {'fs': -1.0}, 'sample rate in .* is -1 Hz'),
]


@pytest.mark.parametrize(('changes', 'more', 'sentence'), DATA_FAULTS)
def test_data_that_does_not_fit_is_refused(tmp_path, source, mapping, changes, more, sentence):
    path = mapping(changes)
    with pytest.raises(DataError, match=sentence) as caught:
        import_recording(source(**more), path, tmp_path / 'bag')
    assert '\n' not in str(caught.value)
    assert sorted(p.name for p in tmp_path.iterdir()) == ['mapping.yaml', 'source.npz']


@pytest.mark.parametrize(
    ('name', 'content', 'sentence'),
    [
        ('x.csv', b'', 'is empty: a CSV file needs rows of numbers'),
        ('x.csv', b't,q,tau\n', 'holds no samples'),
        ('x.csv', b't,q,tau\n0,1,2\n1,2\n', 'line 3 has 2 cells where the header has 3'),
        ('x.csv', b't,q,tau\n0,1,2\n1,2,two\n', "line 3, column 'tau': 'two' is not a number"),
        ('x.csv', b't,q,q\n0,1,2\n', "has two columns 'q' with other numbers: each needs its own"),
        ('x.csv', b't,q,tau\n\xff\xfe,1,2\n', 'is not a number'),
        ('x.mat', b'not a mat file' * 20, 'is no readable MAT file'),
        ('x.npz', b'PK not a zip', 'is no readable NPZ file'),
        (
            'x.xls',
            b'',
            'is not of a kind that can be imported: give one of .mat, .npz, .npy, .parquet',
        ),
        (
            'x.mat',
            b'MATLAB 7.3 MAT-file'.ljust(116) + bytes(8) + b'\x00\x02IM' + b'\x89HDF\r\n\x1a\n',
            r'is of MATLAB version 7.3 \(HDF5\), which needs h5py|is no readable MAT',
        ),
    ],
)
def test_files_that_cannot_be_read_are_one_sentence(tmp_path, mapping, name, content, sentence):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(DataError, match=sentence) as caught:
        import_recording(tmp_path / name, mapping(), tmp_path / 'bag')
    assert '\n' not in str(caught.value)
    assert not (tmp_path / 'bag').exists()


@pytest.mark.parametrize(
    ('table', 'names', 'sentence'),
    [
        (np.zeros((3, 5)), ['t', 'q'], 'has 3 rows and the mapping names 2 .t, q.'),
        (np.zeros((2, 5)), ['t', 't'], 'names 2 .t, t.: give each its own name'),
        (np.zeros(5), ['t'], r'shape \(5,\): a table is needed'),
        (np.array([[{}]], dtype=object), ['t'], 'is no readable NPY file of a plain array'),
    ],
)
def test_tables_without_fitting_names_are_refused(tmp_path, table, names, sentence):
    np.save(tmp_path / 'x.npy', table, allow_pickle=True)
    with pytest.raises(SosmlFrictionError, match=sentence):
        DataFile(tmp_path / 'x.npy', rows=names)


def test_missing_files_are_named(tmp_path, source, mapping):
    with pytest.raises(DataError, match=r'no\.mat does not exist: give the file to import'):
        import_recording(tmp_path / 'no.mat', mapping(), tmp_path / 'bag')
    with pytest.raises(ConfigurationError, match=r'no\.yaml cannot be read .No such file'):
        import_recording(source(), tmp_path / 'no.yaml', tmp_path / 'bag')


@pytest.mark.parametrize('text', ['a: [', '- 1', '', 'just words', '\x00'])
def test_a_mapping_that_is_no_mapping_is_one_sentence(tmp_path, source, text):
    (tmp_path / 'm.yaml').write_text(text)
    with pytest.raises(ConfigurationError, match=r'm\.yaml') as caught:
        import_recording(source(), tmp_path / 'm.yaml', tmp_path / 'bag')
    assert '\n' not in str(caught.value)


@pytest.mark.parametrize(
    ('text', 'changes', 'sentence'),
    [
        ('<robot', {}, 'r.urdf is no readable URDF'),
        (
            URDF.replace('"shoulder"', '"hip"'),
            {},
            'joint shoulder is not in .* which has hip: use',
        ),
        (
            URDF.replace('revolute', 'prismatic'),
            {},
            'joint shoulder is prismatic in .* and its position is in rad: correct the unit',
        ),
        (
            URDF,
            {
                'joints/shoulder/position/unit': 'mm',
                'joints/shoulder/effort/unit': 'A',
                'joints/shoulder/effort/scale': 2,
            },
            'joint shoulder is revolute in .* and its position is in mm',
        ),
    ],
)
def test_a_urdf_that_does_not_fit_is_refused(tmp_path, source, mapping, text, changes, sentence):
    (tmp_path / 'r.urdf').write_text(text)
    path = mapping({'urdf': 'r.urdf', **changes})
    with pytest.raises(ConfigurationError, match=sentence):
        import_recording(source(), path, tmp_path / 'bag')
    assert not (tmp_path / 'bag').exists()


def test_an_existing_bag_is_not_overwritten(tmp_path, source, mapping):
    (tmp_path / 'bag').mkdir()
    with pytest.raises(BagError, match='bag exists and is not overwritten'):
        import_recording(source(), mapping(), tmp_path / 'bag')
    assert list((tmp_path / 'bag').iterdir()) == []


def test_a_failure_while_writing_leaves_nothing_behind(tmp_path, source, mapping, monkeypatch):
    def full(log, folder, *rest):
        Path(folder).mkdir()
        (Path(folder) / 'bag_0.mcap').write_bytes(b'half')
        raise BagError('the disk is full')

    monkeypatch.setattr(importer, 'write_joint_log', full)
    path = mapping()
    recording = source()
    with pytest.raises(BagError, match='the disk is full'):
        import_recording(recording, path, tmp_path / 'new' / 'bag')
    assert sorted(p.name for p in tmp_path.iterdir()) == ['mapping.yaml', 'source.npz']


def test_a_place_that_cannot_be_written_is_named(tmp_path, source, mapping):
    with pytest.raises(BagError, match='cannot be written: Not a directory: choose another place'):
        import_recording(source(), mapping(), tmp_path / 'source.npz' / 'bag')


def test_a_relative_destination_is_made_where_the_user_stands(
    tmp_path, source, mapping, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    assert import_recording(source(), mapping(), 'here/bag') == Path('here/bag')
    assert (tmp_path / 'here/bag/bag_0.mcap').is_file()
    shutil.rmtree(tmp_path / 'here')
    assert sorted(p.name for p in tmp_path.iterdir()) == ['mapping.yaml', 'source.npz']


@given(
    steps=st.lists(st.integers(1, 10**9), min_size=1, max_size=20),
    values=st.lists(st.floats(-1e8, 1e8) | st.just(np.nan), min_size=20, max_size=20),
)
@settings(max_examples=40, deadline=None)
def test_values_and_integer_stamps_pass_unchanged(tmp_path_factory, steps, values):
    folder = tmp_path_factory.mktemp('pass')
    stamps = np.cumsum(steps)
    values = np.array(values[: len(stamps)])
    np.savez(folder / 's.npz', t=stamps, q=values, tau=-values)
    content = plain()
    content['time']['unit'] = 'ns'
    (folder / 'm.yaml').write_text(yaml.safe_dump(content))
    log = Bag.open(
        import_recording(folder / 's.npz', folder / 'm.yaml', folder / 'bag')
    ).joint_log()
    assert log.t_ns.tolist() == stamps.tolist()
    np.testing.assert_array_equal(log.q[:, 0], values)
    np.testing.assert_array_equal(log.tau[:, 0], -values)


def test_time_before_a_trigger_is_counted_from_the_first_sample(tmp_path, source, mapping):
    told = []
    import_recording(source(t=T - 1.0), mapping({}), tmp_path / 'bag', tell=told.append)
    log = Bag.open(tmp_path / 'bag').joint_log()
    assert log.t_ns[0] == 0
    np.testing.assert_allclose(np.diff(log.time), np.diff(T), atol=1e-9)
    assert any('begins 1 s before 0' in sentence for sentence in told)
