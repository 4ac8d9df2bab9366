# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""``sosml import``: the bag it makes, and the files it cannot use."""

import numpy as np
import pytest
from rosbags.rosbag2 import Writer
from rosbags.typesys import Stores, get_typestore
from slider_bags import checked, slider_log

from sosml_friction.bags.bag import Bag
from sosml_friction.share import share_directory


def write_csv(folder, name='slider.csv'):
    log = slider_log()
    file = folder / name
    rows = np.column_stack([log.time, log.q, log.tau])
    np.savetxt(file, rows, delimiter=',', header='t,q,f', comments='')
    mapping = folder / 'slider.yaml'
    mapping.write_text(
        'time: {variable: t, unit: s}\n'
        'joints: {slider: {position: {variable: q, unit: m}, effort: {variable: f, unit: N}}}\n'
    )
    return file, mapping


def test_emps_from_the_file_to_the_published_friction(sosml, data_directory):
    file = data_directory / 'emps' / 'DATA_EMPS.mat'
    if not file.is_file():
        pytest.skip(f'no {file}')
    code, out, err = sosml('import', file, '--json')
    assert code == 0
    assert err.count('\n') == 1
    assert 'emps.yaml' in err
    imported = checked(out, 'import')
    assert imported['joint_states']['samples'] == 24841
    options = ('--refit-inertia', '--method', 'output_error', '--json')
    code, out, err = sosml('fit', imported['bag'], *options)
    assert (code, err) == (0, '')
    document = checked(out, 'fit')
    inverse = document['inverse_model']['joints']['slider']
    # Published: A. Janot, M. Gautier, M. Brunot, "Data Set and Reference Models of EMPS", 2019.
    published = {
        'symmetric': {
            'inertia': (95.109, 0.1),
            'viscous': (203.5, 0.5),
            'coulomb': (20.39, 0.05),
            'bias': (-3.165, 0.02),
        },
        'asymmetric': {'viscous_positive': (166.7, 0.5), 'viscous_negative': (240.4, 0.5)},
    }
    for form, numbers in published.items():
        for name, (value, tolerance) in numbers.items():
            found = inverse[form]['parameters'][name]['value']
            assert found == pytest.approx(value, abs=tolerance), (form, name)
    assert inverse['symmetric']['relative_error'] == pytest.approx(4.08, abs=0.05)
    assert inverse['asymmetric']['relative_error'] == pytest.approx(3.11, abs=0.06)
    closed_loop = document['output_error']['closed_loop']['slider']
    assert closed_loop['position_error'] <= 0.0138
    assert closed_loop['effort_error'] <= 5.85
    simulated = document['output_error']['joints']['slider']
    assert simulated['mode'] == 'controller'
    assert simulated['position_error'] <= 0.0138
    fits = document['joints']['slider']
    assert set(fits) == {'first_order', 'sosml', 'weak_form', 'output_error'}
    for observer in ('first_order', 'sosml', 'output_error'):
        parameters = fits[observer]['parameters']
        assert parameters['coulomb']['value'] == pytest.approx(20.3935, rel=0.03)
        assert parameters['viscous']['value'] == pytest.approx(203.5034, rel=0.03)


def test_import_makes_a_bag_as_the_mapping_says(sosml, tmp_path):
    file, mapping = write_csv(tmp_path)
    code, out, err = sosml('import', file, '--map', mapping, '--out', tmp_path / 'bag')
    assert (code, err) == (0, '')
    assert 'slider (position, effort)' in out
    log = Bag.open(tmp_path / 'bag').joint_log()
    assert np.allclose(log.q, slider_log().q)
    document = checked(sosml('info', tmp_path / 'bag', '--json')[1], 'info')
    assert document['joint_states']['measured'] == {'slider': ['position', 'effort']}


def test_a_rate_stands_for_time(sosml, refused, tmp_path):
    file, mapping = write_csv(tmp_path)
    assert 'has time already: leave the rate out' in refused(
        'import', file, '--map', mapping, '--rate', '100'
    )
    mapping.write_text(mapping.read_text().split('\n', 1)[1])
    assert '--rate beside it' in refused('import', file, '--map', mapping)
    assert sosml('import', file, '--map', mapping, '--rate', '100', '--out', 'bag')[0] == 0
    np.testing.assert_array_equal(np.diff(Bag.open('bag').joint_log().t_ns), 10_000_000)
    assert 'is a bag, which says itself what it holds' in refused(
        'import', write_sqlite(tmp_path), '--rate', '100'
    )


def write_sqlite(folder):
    (folder / 'x.db3').write_bytes(b'')
    return folder / 'x.db3'


def test_columns_stand_for_a_mapping(sosml, refused, tmp_path):
    file, mapping = write_csv(tmp_path)
    columns = ('--position', 'q:m', '--effort', 'f:N')
    code, out, err = sosml('import', file, *columns, '--out', 'bag')
    assert code == 0, err
    assert 'joint (position, effort)' in out
    np.testing.assert_array_equal(Bag.open('bag').joint_log().q, slider_log().q)
    urdf = share_directory() / 'urdf' / 'emps.urdf'
    assert sosml('import', file, *columns, '--urdf', urdf, '--out', 'with_urdf')[0] == 0
    bag = Bag.open('with_urdf')
    assert bag.joint_log().names == ('slider',)
    assert bag.text('robot_description') == urdf.read_text()
    assert 'a mapping names its own as urdf' in refused(
        'import', file, '--map', mapping, '--urdf', urdf
    )
    assert '--map and --position both say what is in' in refused(
        'import', file, *columns, '--map', mapping
    )
    assert 'leave out --position' in refused('import', write_sqlite(tmp_path), *columns)
    assert 'give one file, and no --map or column' in refused('import', file, '--guess', *columns)


def test_import_without_mapping_lists_the_shipped_ones(refused, tmp_path):
    file, _ = write_csv(tmp_path)
    err = refused('import', file)
    assert '--map' in err
    assert 'emps' in err


def test_import_does_not_overwrite_a_bag(refused, sosml, tmp_path):
    file, mapping = write_csv(tmp_path)
    assert sosml('import', file, '--map', mapping)[0] == 0
    assert 'not overwritten' in refused('import', file, '--map', mapping)


@pytest.mark.parametrize('missing', ['file', 'mapping'])
def test_import_of_what_is_not_there_is_refused(refused, tmp_path, missing):
    file, mapping = write_csv(tmp_path)
    (file if missing == 'file' else mapping).unlink()
    assert (file if missing == 'file' else mapping).name in refused(
        'import', file, '--map', mapping
    )


@pytest.mark.parametrize('name', ['missing.csv', 'emps.mat'])
def test_a_missing_file_is_told_before_a_mapping_is_looked_for(refused, name):
    err = refused('import', name)
    assert f'{name} does not exist' in err
    assert '--map' not in err


def test_several_files_become_as_many_bags(sosml, tmp_path):
    one, mapping = write_csv(tmp_path, 'one.csv')
    two, _ = write_csv(tmp_path, 'two.csv')
    code, out, _ = sosml('import', one, two, '--map', mapping, '--out', 'bags', '--json')
    assert code == 0
    document = checked(out, 'import')
    assert [x['bag'] for x in document['imports']] == ['bags/one', 'bags/two']
    for name in ('one', 'two'):
        assert np.allclose(Bag.open(tmp_path / 'bags' / name).joint_log().q, slider_log().q)


def test_files_of_one_name_are_not_written_over_each_other(refused, tmp_path):
    _, mapping = write_csv(tmp_path)
    (tmp_path / 'other').mkdir()
    write_csv(tmp_path / 'other')
    err = refused('import', 'slider.csv', 'other/slider.csv', '--map', mapping)
    assert 'two files have the same name' in err


def test_guess_writes_a_mapping_that_import_takes(sosml, tmp_path):
    log = slider_log()
    rows = np.column_stack([log.time, log.q, log.tau])
    np.savetxt(
        tmp_path / 'x.csv', rows, delimiter=';', header='t;position [m];force [N]', comments=''
    )
    code, out, err = sosml('import', 'x.csv', '--guess')
    assert (code, err) == (0, '')
    assert 'joint.position is position [m] [m]: its name says so' in out
    assert out.splitlines()[-1] == 'Look through x.yaml, then: sosml import x.csv --map x.yaml'
    assert sosml('import', 'x.csv', '--map', 'x.yaml')[0] == 0
    assert np.allclose(Bag.open(tmp_path / 'x').joint_log().tau, log.tau)


def test_guess_says_what_it_leaves_open(sosml, tmp_path):
    write_csv(tmp_path)
    code, out, _ = sosml('import', 'slider.csv', '--guess', '--out', 'm.yaml', '--json')
    assert code == 0
    document = checked(out, 'import_guess')
    assert document['left_open'] == ['joints.joint.position.unit', 'joints.joint.effort.unit']
    code, _, err = sosml('import', 'slider.csv', '--map', 'm.yaml')
    assert code == 2
    assert 'joints.joint.position.unit, joints.joint.effort.unit is left open (FILL_IN)' in err


def test_guess_takes_names_and_kinds_of_joints_from_the_urdf(sosml, tmp_path):
    write_csv(tmp_path)
    urdf = share_directory() / 'urdf' / 'emps.urdf'
    code, out, _ = sosml('import', 'slider.csv', '--guess', '--urdf', urdf, '--json', '--out', 'm')
    assert code == 0
    document = checked(out, 'import_guess')
    assert list(document['content']['joints']) == ['slider']
    assert document['content']['joints']['slider']['position'] == {'variable': 'q', 'unit': 'm'}
    assert document['left_open'] == ['joints.slider.effort.unit']
    text = (tmp_path / 'm').read_text().replace('FILL_IN', 'N')
    (tmp_path / 'm').write_text(text)
    assert sosml('import', 'slider.csv', '--map', 'm')[0] == 0
    assert Bag.open(tmp_path / 'slider').text('robot_description') == urdf.read_text()


def test_the_command_that_comes_next_can_be_pasted(sosml, tmp_path):
    write_csv(tmp_path)
    (tmp_path / 'slider.csv').rename(tmp_path / 'run 1 (warm).csv')
    out = sosml('import', 'run 1 (warm).csv', '--guess')[1]
    assert "sosml import 'run 1 (warm).csv' --map 'run 1 (warm).yaml'" in ' '.join(out.split())


@pytest.mark.parametrize(
    ('arguments', 'sentence'),
    [
        (('slider.csv', 'slider.csv', '--guess'), '--guess looks at one file'),
        (('slider.csv', '--guess', '--out', 'slider.yaml'), 'slider.yaml exists and is not'),
        (('slider.csv', '--guess', '--out', 'no/m.yaml'), 'cannot be written: No such file'),
        (('slider.csv', '--guess', '--urdf', 'no.urdf', '--out', 'm'), 'no.urdf cannot be read'),
        (('x.mcap', '--guess'), 'x.mcap is a bag, or a folder: a bag of MCAP is used as it is'),
        (('words.csv', '--guess'), 'words.csv holds no numbers: give a recording'),
        (('head.csv', '--guess'), 'head.csv holds no numbers: give a recording'),
    ],
)
@pytest.mark.filterwarnings('error')
def test_what_guess_cannot_do_is_one_sentence(refused, tmp_path, arguments, sentence):
    write_csv(tmp_path)
    (tmp_path / 'x.mcap').write_bytes(b'')
    (tmp_path / 'words.csv').write_text('all,these\nare,words\n')
    (tmp_path / 'head.csv').write_text('time_s,angle\n')
    assert sentence in refused('import', *arguments)


@pytest.mark.parametrize(('what', 'value'), [('position', 0.2), ('effort', 0.0)])
def test_a_position_or_effort_that_never_changes_is_told(sosml, tmp_path, what, value):
    """By import and by info, before a fit refuses it."""
    file = tmp_path / 'run.csv'
    rows = [f'{0.01 * k},{0.01 * k % 1.0},{k % 3}' for k in range(300)]
    column = {'position': 1, 'effort': 2}[what]
    cells = [row.split(',') for row in rows]
    for own in cells:
        own[column] = str(value)
    file.write_text('t,q,f\n' + '\n'.join(map(','.join, cells)))
    code, _, err = sosml('import', file, '--position', 'q:m', '--effort', 'f:N', '--out', 'bag')
    assert code == 0
    (said,) = (line for line in err.splitlines() if 'in all samples' in line)
    assert said.startswith(f'sosml: joint: its {what} is {value:g} in all samples: ')
    assert said.removeprefix('sosml: ') in ' '.join(sosml('info', 'bag')[1].split())
    assert checked(sosml('info', 'bag', '--json')[1], 'info')['joint_states']['constant'] == {
        'joint': {what: value}
    }


def test_a_bag_without_motion_is_copied_and_said_to_have_none(sosml, tmp_path):
    types = get_typestore(Stores.ROS2_JAZZY)
    message = types.types['std_msgs/msg/String']
    with Writer(tmp_path / 'old', version=9) as writer:
        topic = writer.add_connection('/greeting', 'std_msgs/msg/String', typestore=types)
        for k in range(3):
            content = types.serialize_cdr(message(data='hello'), 'std_msgs/msg/String')
            writer.write(topic, k, content)
    code, out, err = sosml('import', tmp_path / 'old', '--out', 'new', '--json')
    assert code == 0, err
    assert checked(out, 'import')['joint_states'] is None
    assert 'has no motion: ' in err
    assert Bag.open('new').topics['/greeting'][1] == 3
