# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The tool: what it prints and writes, its exit codes, and one sentence for every mistake."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import yaml

from sosml_friction.bags.bag import Bag
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.bags.recorder import BagRecorder
from sosml_friction.bags.serialization import message_class, serialize, serialize_joint_state
from sosml_friction.model.model_folder import read_model
from sosml_friction.motion.trajectories import TRAJECTORIES
from sosml_friction.motion.trajectory_kinds.speed_ladder import speed_ladder
from sosml_friction.observers.configuration import OBSERVERS, make_observer
from sosml_friction.share import share_directory

SCHEMAS = Path(__file__).resolve().parents[2] / 'docs' / 'schema'
EMPS = share_directory() / 'config' / 'emps'
COULOMB, VISCOUS = 20.0, 200.0


def slider_log(effort=True, names=('slider',)):
    """Return the motion of the EMPS axis on a speed ladder, with friction that is known."""
    robot = read_model(EMPS).make_robot()
    ladder = speed_ladder({'slider': 0.1}, {'slider': 0.12}, [0.01, 0.04, 0.1], plateau_s=0.6)
    spline = ladder.spline()
    t = np.arange(0.0, ladder.duration, 0.004)
    q, v, a = spline(t), spline(t, 1), spline(t, 2)
    noise = np.random.default_rng(3)
    tau = np.array([robot.inverse_dynamics(*state) for state in zip(q, v, a, strict=True)])
    tau += COULOMB * np.sign(v) + VISCOUS * v + noise.normal(0.0, 0.3, v.shape)
    if not effort:
        tau[:] = np.nan
    return JointLog(names, np.rint(t * 1e9).astype(np.int64), q, v, tau)


def record(folder, log, urdf=True, model=True):
    nominal = read_model(EMPS)
    return write_joint_log(
        log,
        folder,
        nominal.urdf if urdf else None,
        (EMPS / 'model.yaml').read_text(encoding='utf-8') if model else None,
    )


@pytest.fixture(scope='session')
def slider_bag(tmp_path_factory):
    return record(tmp_path_factory.mktemp('bags') / 'ladder', slider_log())


@pytest.fixture(scope='session')
def slider_fit(slider_bag, tmp_path_factory):
    """Return (folder written, what fit printed) of one run with --json."""
    folder = tmp_path_factory.mktemp('fits') / 'fit'
    command = [sys.executable, '-m', 'sosml_friction.cli.main', 'fit', str(slider_bag), '--json']
    ran = subprocess.run([*command, '--out', str(folder)], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    assert ran.stderr == ''
    return folder, ran.stdout


def checked(text, name):
    """Return the only JSON object of a text, checked against its schema."""
    document = json.loads(text, parse_constant=pytest.fail)
    jsonschema.validate(
        document,
        json.loads((SCHEMAS / f'{name}.schema.json').read_text()),
        cls=jsonschema.Draft202012Validator,
    )
    return document


def test_fit_prints_one_json_object_that_follows_its_schema(slider_fit):
    folder, out = slider_fit
    document = checked(out, 'fit')
    assert document['output'] == str(folder)
    for observer in ('first_order', 'sosml'):
        parameters = document['joints']['slider'][observer]['parameters']
        assert parameters['coulomb']['value'] == pytest.approx(COULOMB, rel=0.02)
        assert parameters['viscous']['value'] == pytest.approx(VISCOUS, rel=0.02)
        assert parameters['viscous']['unit'] == 'N s/m'
        assert 0.0 < parameters['coulomb']['std_error'] < 1.0
        assert document['alternatives']['slider'][observer]['method'] in ('samples', 'segments')


def test_fit_writes_what_it_prints_a_model_and_a_report(slider_fit):
    folder, out = slider_fit
    printed = json.loads(out)
    del printed['output']
    assert checked((folder / 'fit.json').read_text(), 'fit') == printed
    assert read_model(folder).joint_names == ('slider',)
    assert 'N of Coulomb friction' in (folder / 'report.html').read_text()


def test_fit_prints_a_table_and_writes_beside_the_caller(sosml, slider_bag, tmp_path):
    code, out, err = sosml('fit', slider_bag, '--method', 'samples')
    assert (code, err) == (0, '')
    row = next(line.split() for line in out.splitlines() if 'coulomb' in line)
    assert row[:3] == ['slider', 'coulomb', 'N']
    assert [float(x) for x in row[3:5]] == pytest.approx([COULOMB, COULOMB], rel=0.03)
    assert [p.name for p in tmp_path.iterdir()] == ['ladder_fit']
    assert 'ladder_fit' in out
    fits = json.loads((tmp_path / 'ladder_fit' / 'fit.json').read_text())['joints']['slider']
    assert fits['sosml']['method'] == 'samples'


def test_fit_refits_inertia_and_adds_the_weak_form(sosml, slider_bag, tmp_path):
    """The effort was made with the mass of the model, 95.1089 kg, and 0.3 N of noise."""
    code, out, err = sosml('fit', slider_bag, '--method', 'weak', '--refit-inertia', '--json')
    assert (code, err) == (0, '')
    document = checked(out, 'fit')
    weak = document['joints']['slider']['weak_form']
    assert weak['method'] == 'weak'
    assert weak['parameters']['coulomb']['value'] == pytest.approx(COULOMB, rel=0.02)
    assert weak['parameters']['viscous']['value'] == pytest.approx(VISCOUS, rel=0.02)
    assert weak['inertia']['value'] == pytest.approx(95.1089, rel=0.02)
    assert document['model'] == {'slider': 'weak_form'}
    inverse = document['inverse_model']['joints']['slider']['symmetric']
    assert inverse['parameters']['inertia']['value'] == pytest.approx(95.1089, rel=0.02)
    assert inverse['parameters']['coulomb']['value'] == pytest.approx(COULOMB, rel=0.05)
    folder = tmp_path / 'ladder_fit'
    friction = read_model(folder).joints['slider'].friction
    assert friction.parameters['coulomb'].value == weak['parameters']['coulomb']['value']
    # Reported, not put in: friction was computed with the inertia that the model has.
    assert read_model(folder).urdf == read_model(EMPS).urdf
    report = (folder / 'report.html').read_text()
    assert 'Inertia and friction by the inverse model' in report
    assert 'slider, weak form: inertia' in report


def test_fit_prints_the_refitted_inertia(sosml, slider_bag):
    code, out, _ = sosml('fit', slider_bag, '--refit-inertia')
    assert code == 0
    row = next(line.split() for line in out.splitlines() if ' inertia ' in line)
    assert row[:4] == ['slider', 'symmetric', 'inertia', 'kg']
    assert float(row[4]) == pytest.approx(95.1089, rel=0.02)
    assert 'slider, weak form: inertia' in out


def test_fit_with_a_truth_shows_it(sosml, slider_bag, slider_fit, tmp_path):
    truth = tmp_path / 'truth'
    shutil.copytree(slider_fit[0], truth)
    code, out, _ = sosml('fit', slider_bag, '--truth', truth)
    assert code == 0
    assert 'truth' in out


def test_a_joint_with_effort_that_cannot_be_fitted_is_a_no(sosml, slider_bag, monkeypatch):
    from sosml_friction.identification import log_analysis
    from sosml_friction.identification.friction_fit import FrictionFit

    def without_slider(*_):
        return FrictionFit({}, {}, {'slider': 'the joint moved in one direction only'})

    monkeypatch.setattr(log_analysis, 'fit_friction', without_slider)
    code, out, _ = sosml('fit', slider_bag, '--method', 'segments')
    assert code == 1
    assert 'one direction only' in out


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


def test_import_makes_a_bag_as_the_mapping_says(sosml, tmp_path):
    file, mapping = write_csv(tmp_path)
    code, out, err = sosml('import', file, '--map', mapping, '--out', tmp_path / 'bag')
    assert (code, err) == (0, '')
    assert 'slider (position, effort)' in out
    log = Bag.open(tmp_path / 'bag').joint_log()
    assert np.allclose(log.q, slider_log().q)
    document = checked(sosml('info', tmp_path / 'bag', '--json')[1], 'info')
    assert document['joint_states']['measured'] == {'slider': ['position', 'effort']}


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


def text_message():
    text = message_class('std_msgs/msg/String')()
    text.data = 'hello'
    return serialize(text)


def text_bag(folder, messages=1):
    with BagRecorder(folder) as recorder:
        recorder.add_topic('/greeting', 'std_msgs/msg/String')
        for k in range(messages):
            recorder.write('/greeting', text_message(), k)
    return folder


def test_info_counts_gaps_repeats_and_steps_back(sosml, tmp_path):
    log = slider_log()
    t_ns = log.t_ns + 1_000_000_000
    t_ns[100:] += 40_000_000
    t_ns[201] = t_ns[200]
    t_ns[301] = t_ns[300] - 1
    bag = tmp_path / 'odd'
    with BagRecorder(bag) as recorder:
        recorder.add_topic('/robot_description', 'std_msgs/msg/String')
        recorder.write('/robot_description', text_message(), 0)
        recorder.add_topic('/joint_states', 'sensor_msgs/msg/JointState')
        for k, stamp in enumerate(t_ns.tolist()):
            message = serialize_joint_state(stamp, log.names, log.q[k], [], [])
            recorder.write('/joint_states', message, k)
    code, out, _ = sosml('info', bag, '--json')
    assert code == 0
    motion = checked(out, 'info')['joint_states']
    assert motion['rate_hz'] == pytest.approx(250.0)
    assert motion['repeated_stamps'] == 1
    assert motion['backward_stamps'] == 1
    # The pause, and the steps after the repeated and the backward stamp.
    assert motion['gaps'] == 3
    assert motion['longest_step_s'] == pytest.approx(0.044)
    text = sosml('info', bag)[1]
    assert 'robot_description; not model_description' in text
    assert '1 repeated and 1 backward' in text


def test_info_says_how_much_of_a_cut_off_bag_is_left(sosml, slider_bag, tmp_path):
    whole = Bag.open(slider_bag).messages_read
    cut = tmp_path / 'cut.mcap'
    content = next(slider_bag.glob('*.mcap')).read_bytes()
    cut.write_bytes(content[: len(content) // 2])
    document = checked(sosml('info', cut, '--json')[1], 'info')
    assert document['recovered']
    assert 0 < document['messages'] < whole
    assert str(document['messages']) in document['recovery']
    assert document['recovery'] in sosml('info', cut)[1]


def test_info_of_a_bag_without_motion_says_so(sosml, tmp_path):
    code, out, _ = sosml('info', text_bag(tmp_path / 'text'), '--json')
    assert code == 0
    document = checked(out, 'info')
    assert document['joint_states'] is None
    assert 'joint_states' in document['joint_states_problem']
    assert document['topics'] == {'/greeting': {'type': 'std_msgs/msg/String', 'messages': 1}}
    assert 'No motion' in sosml('info', tmp_path / 'text')[1]


@pytest.mark.parametrize('command', ['fit', 'info'])
def test_a_missing_bag_is_refused(refused, command):
    assert 'nowhere does not exist' in refused(command, 'nowhere')


@pytest.mark.parametrize('command', ['fit', 'info'])
def test_an_unreadable_bag_is_refused(refused, tmp_path, command):
    (tmp_path / 'noise.mcap').write_bytes(bytes(range(256)) * 8)
    assert 'noise.mcap' in refused(command, tmp_path / 'noise.mcap')


@pytest.mark.parametrize('command', ['fit', 'info'])
def test_an_empty_bag_is_refused(refused, tmp_path, command):
    assert 'holds no message' in refused(command, text_bag(tmp_path / 'empty', messages=0))


def test_a_bag_without_joint_states_is_refused(refused, tmp_path):
    assert 'joint_states' in refused('fit', text_bag(tmp_path / 'text'))


def test_a_bag_without_effort_is_refused(refused, tmp_path):
    bag = record(tmp_path / 'mute', slider_log(effort=False))
    assert 'no effort for slider' in refused('fit', bag)


def test_a_missing_urdf_is_refused(refused, slider_bag):
    err = refused('fit', slider_bag, '--urdf', 'nowhere.urdf')
    assert 'nowhere.urdf' in err
    assert 'cannot be read' in err


def test_a_bag_that_knows_no_urdf_is_refused(refused, tmp_path):
    bag = record(tmp_path / 'bare', slider_log(), urdf=False)
    assert '--urdf' in refused('fit', bag)


def test_a_bag_that_knows_no_model_is_refused(refused, tmp_path):
    bag = record(tmp_path / 'bare', slider_log(), model=False)
    assert '--model' in refused('fit', bag)


def test_joint_names_that_differ_are_refused(refused, tmp_path):
    bag = record(tmp_path / 'other', slider_log(names=('carriage',)))
    err = refused('fit', bag)
    assert 'slider' in err
    assert 'carriage' in err


def test_a_model_of_another_robot_is_refused(refused, slider_bag):
    err = refused('fit', slider_bag, '--model', share_directory() / 'config' / 'exoskeleton')
    assert 'shoulder' in err
    assert 'slider' in err


def test_a_truth_of_another_robot_is_refused(refused, slider_bag):
    truth = share_directory() / 'config' / 'emulated_exoskeleton'
    assert 'shoulder' in refused('fit', slider_bag, '--truth', truth)


def test_a_missing_model_or_truth_is_refused(refused, slider_bag):
    for option in ('--model', '--truth'):
        assert 'nowhere' in refused('fit', slider_bag, option, 'nowhere')


def test_a_place_with_something_else_is_refused(refused, slider_bag, tmp_path):
    (tmp_path / 'thesis').mkdir()
    (tmp_path / 'thesis' / 'model.yaml').write_text('mine')
    assert 'not overwritten' in refused('fit', slider_bag, '--out', 'thesis')


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (['fit'], "missing argument 'BAG'"),
        (['fit', 'one', 'two'], 'one does not exist'),
        (['fit', 'bag', '--bandwith', '3'], '--bandwith'),
        (['fit', 'bag', '--bandwidth', 'fast'], '--bandwidth'),
        (['fit', 'bag', '--method', 'guess'], 'auto, segments, samples'),
        (['info'], "missing argument 'BAG'"),
        (['import'], "missing argument 'FILE'"),
        (['record', 'bag'], "no such command 'record'"),
    ],
)
def test_wrong_usage_is_one_sentence(refused, arguments, words):
    assert words in refused(*arguments)


@pytest.mark.parametrize('bandwidth', ['0', '-1', 'nan', 'inf'])
def test_a_bandwidth_that_cannot_be_is_refused(refused, slider_bag, bandwidth):
    assert 'bandwidth' in refused('fit', slider_bag, f'--bandwidth={bandwidth}')


@pytest.mark.parametrize('stage', ['analyse_bag', 'write_report'])
def test_ctrl_c_ends_with_130_and_nothing_half_written(
    sosml, slider_bag, tmp_path, monkeypatch, stage
):
    from sosml_friction.identification import bag_analysis
    from sosml_friction.report.fit import results

    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(bag_analysis if stage == 'analyse_bag' else results, stage, interrupt)
    code, out, err = sosml('fit', slider_bag)
    assert (code, out, err.strip()) == (130, '', 'sosml: interrupted')
    assert list(tmp_path.iterdir()) == []


SMALL_STUDY = (
    'study',
    '--quick',
    '--evaluations=4',
    '--motions=slow',
    '--conditions=nominal,noise',
    '--observers=first_order_capped, sosml',
    '--processes=1',
)


def test_study_prints_one_json_object_and_writes_it(sosml, tmp_path):
    code, out, err = sosml(*SMALL_STUDY, '--bits=19', '--json')
    assert (code, err) == (0, '')
    document = checked(out, 'study')
    assert document['output'] == 'study_output'
    assert document['settings']['evaluations'] == 4
    # --quick where nothing else is said.
    assert document['settings']['scoring_seeds'] == [1, 2]
    assert document['settings']['plant_step_s'] == 200e-6
    assert document['settings']['bits'] == 19
    assert document['settings']['observers'] == ['first_order_capped', 'sosml']
    assert {row['rmse']['n'] for row in document['rows']} == {1, 2}
    del document['output']
    folder = tmp_path / 'study_output'
    assert json.loads((folder / 'study.json').read_text()) == document
    names = {path.name for path in folder.iterdir()}
    pictures = {'figure2_slow_nominal.png', 'figure3_noise.png'}
    assert names == {'study.json', 'study.html', *pictures}


def test_study_prints_tables_and_where_the_report_is(sosml, tmp_path):
    code, out, err = sosml(*SMALL_STUDY, '--conditions=nominal', '--out=here')
    assert (code, err) == (0, '')
    assert 'RMSE [mNm] of the shoulder' in out
    assert 'FO capped' in out
    assert out.rstrip().endswith('study.html, study.json and the figures are in here')
    assert (tmp_path / 'here' / 'study.html').is_file()


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (['--observers', 'sosml,magic'], "observer 'magic' is not in the study: use "),
        (['--motions', 'fast'], "motion 'fast' is not in the study: use slow, reversal"),
        (['--conditions', ''], "condition '' is not in the study"),
        (['--seeds', '0'], 'the number of seeds is 0: use 1 to 100'),
        (['--tuning-seeds', '101'], 'the number of tuning seeds is 101'),
        (['--evaluations', '3'], 'the number of evaluations is 3'),
        (['--evaluations', 'many'], '--evaluations'),
        (['--bits', '40'], 'the number of bits is 40: use 8 to 24'),
        (['--processes', '0'], 'the number of processes is 0'),
    ],
)
def test_a_study_that_cannot_be_is_refused(refused, arguments, words):
    assert words in refused('study', *arguments)


def test_study_does_not_overwrite_something_else(refused, tmp_path):
    (tmp_path / 'thesis').mkdir()
    (tmp_path / 'thesis' / 'study.json').write_text('{"mine": 1}')
    assert 'earlier study' in refused('study', '--out', 'thesis')


@pytest.mark.parametrize('stage', ['run_study', 'write_study'])
def test_ctrl_c_in_a_study_ends_with_130_and_nothing_written(sosml, tmp_path, monkeypatch, stage):
    from sosml_friction.report.study import results as study_results
    from sosml_friction.study import run as study_run

    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(study_run if stage == 'run_study' else study_results, stage, interrupt)
    code, out, err = sosml(*SMALL_STUDY, '--conditions=nominal')
    assert (code, out, err.strip()) == (130, '', 'sosml: interrupted')
    assert list(tmp_path.iterdir()) == []


def test_help_of_every_command_has_an_example(sosml):
    code, out, _ = sosml('--help')
    assert code == 0
    commands = re.findall(r'^  (\w+)  +\S', out[out.index('Commands:') :], re.MULTILINE)
    assert sorted(commands) == [
        'can', 'demo', 'diagnose', 'fit', 'import', 'info', 'plan', 'simulate', 'study',
        'trajectory', 'tune'
    ]  # fmt: skip
    # The commands of can have a test of their own.
    for command in set(commands) - {'can'}:
        code, out, _ = sosml(command, '--help')
        assert code == 0
        assert f'Example: sosml {command} ' in out
        assert '--json' in out


def test_no_command_shows_the_help(sosml):
    code, out, _ = sosml()
    assert code == 2
    assert 'Commands:' in out


def test_help_does_not_wait_for_the_heavy_libraries():
    code = (
        'import sys; from sosml_friction.cli.main import main; main(["fit", "--help"]);'
        'print([m for m in ("numpy", "pinocchio", "matplotlib", "rclpy") if m in sys.modules])'
    )
    ran = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    assert ran.stdout.splitlines()[-1] == '[]'


@pytest.fixture(scope='session')
def encoder_bag(tmp_path_factory):
    """Return the ladder as an encoder of 2 um sees it, with backward differences."""
    log = slider_log()
    q = 2e-6 * np.round(log.q / 2e-6 + np.random.default_rng(8).normal(0.0, 0.3, log.q.shape))
    v = np.diff(q, axis=0, prepend=q[:1]) / 0.004
    folder = tmp_path_factory.mktemp('bags') / 'encoder'
    return record(folder, JointLog(log.names, log.t_ns, q, v, log.tau))


def test_tune_measures_and_proposes_gains_for_every_observer(sosml, encoder_bag):
    code, out, err = sosml('tune', encoder_bag, '--json')
    assert (code, err) == (0, '')
    document = checked(out, 'tune')
    assert document['velocity_span'] == 2
    slider = document['joints']['slider']
    measured = {name: entry['value'] for name, entry in slider['conditions'].items()}
    # 0.3 steps of noise and the rounding, by a median of rounded numbers.
    assert measured['position_noise'] == pytest.approx(2e-6 * (0.3**2 + 1 / 12) ** 0.5, rel=0.3)
    assert measured['friction_jump'] == pytest.approx(2 * (COULOMB + 0.05 * VISCOUS), rel=0.3)
    assert set(slider['observers']) == set(OBSERVERS)
    assert slider['observers']['smoother']['on_line'] is False
    fo, linear = (slider['observers'][name] for name in ('first_order', 'linear_second_order'))
    assert 0.0 < linear['noise'] < fo['noise']
    assert fo['settle_s'] > 0.0


def test_tune_writes_parameters_that_the_observer_node_takes(sosml, encoder_bag, tmp_path):
    chosen = 'first_order,kalman,smoother'
    code, out, err = sosml('tune', encoder_bag, '--observers', chosen, '--out', 'gains.yaml')
    assert (code, err) == (0, '')
    assert 'gains.yaml' in out
    assert 'N' in out
    written = yaml.safe_load((tmp_path / 'gains.yaml').read_text())
    gains = written['/**/observer_node']['ros__parameters']
    # The smoother cannot run in a node.
    assert gains.pop('observers') == ['first_order', 'kalman']
    assert gains.pop('selected') == 'first_order'
    assert gains.pop('effort_hold') == ['start']
    assert set(gains) == {'first_order', 'kalman'}
    for name, values in gains.items():
        assert make_observer(name, values).n == 1
    # A second run replaces it; a file of another kind is left alone.
    assert sosml('tune', encoder_bag, '--out', 'gains.yaml')[0] == 0
    assert [p.name for p in tmp_path.iterdir()] == ['gains.yaml']


def test_what_is_stated_replaces_what_is_measured(sosml, encoder_bag):
    stated = ['--friction-jump', '100', '--reversal-time', 'slider=3']
    _, out, _ = sosml('tune', encoder_bag, *stated, '--json')
    conditions = checked(out, 'tune')['joints']['slider']['conditions']
    assert conditions['friction_jump'] == {'value': 100.0, 'stated': True}
    assert conditions['reversal_time'] == {'value': 3.0, 'stated': True}
    assert conditions['position_noise']['stated'] is False


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (['--observers', 'guess'], "observer 'guess' is unknown"),
        (['--friction-jump', 'elbow=1'], 'names no joint of this robot: it has slider'),
        (['--friction-jump', 'slider=much'], 'has no positive number'),
        (['--reversal-time', '-1'], 'has no positive number'),
        (['--out', 'nowhere/gains.yaml'], 'is no folder'),
        (['--out', '.'], 'cannot be read'),
    ],
)
def test_what_tune_cannot_do_is_said_in_one_sentence(refused, encoder_bag, arguments, words):
    assert words in refused('tune', encoder_bag, *arguments)


def test_tune_overwrites_no_foreign_file(refused, encoder_bag, tmp_path):
    (tmp_path / 'notes.yaml').write_text('mine: 1\n')
    error = refused('tune', encoder_bag, '--out', 'notes.yaml')
    assert 'was not written by sosml tune' in error
    assert (tmp_path / 'notes.yaml').read_text() == 'mine: 1\n'


def test_tune_refuses_a_bag_without_effort(refused, tmp_path_factory):
    bag = record(tmp_path_factory.mktemp('bags') / 'silent', slider_log(effort=False))
    assert 'effort' in refused('tune', bag)


def test_fit_runs_the_observers_that_are_named(sosml, encoder_bag):
    _, out, _ = sosml('fit', encoder_bag, '--observers', 'kalman,smoother', '--json')
    fits = checked(out, 'fit')['joints']['slider']
    assert set(fits) == {'kalman', 'smoother', 'weak_form'}
    for fit in fits.values():
        assert fit['parameters']['coulomb']['value'] == pytest.approx(COULOMB, rel=0.03)


def test_the_observer_that_makes_the_model_is_the_one_that_is_shown(sosml, encoder_bag, tmp_path):
    """SOSML, else the first named; one with a law inside only where there is no other."""
    for names, chosen in (
        ('kalman_imm,kalman', 'kalman_imm'),
        ('kalman,kalman_imm', 'kalman'),
        ('kalman_stribeck,quasi_static', 'quasi_static'),
        ('kalman,sosml', 'sosml'),
    ):
        arguments = ('--observers', names, '--method', 'samples', '--out', 'chosen', '--json')
        _, out, err = sosml('fit', encoder_bag, *arguments)
        fits = checked(out, 'fit')
        assert fits['model'] == {'slider': chosen}
        value = fits['joints']['slider'][chosen]['parameters']['coulomb']['value']
        written = read_model(tmp_path / 'chosen').joints['slider'].friction
        assert written.parameters['coulomb'].value == value
        assert ('friction law inside' in err) == ('kalman_stribeck' in names)


def test_the_hold_of_the_effort_can_be_stated_where_the_bag_does_not(sosml, tmp_path_factory):
    """
    Effort that is reported a period late: viscous friction is right only with --effort-hold end.

    The axis of 95 kg: over a to and fro a shift of half a period, 2 ms, is no viscous friction but
    inertia; what is wrong without it is seen in the residual.
    """
    log = slider_log()
    late = JointLog(
        log.names,
        log.t_ns,
        log.q,
        log.v,
        np.vstack([log.tau[:1], 0.5 * (log.tau[1:] + log.tau[:-1])]),
    )
    bag = record(tmp_path_factory.mktemp('bags') / 'late', late)
    residual = {}
    for hold in ('start', 'end'):
        options = ('--effort-hold', hold, '--observers', 'kalman', '--method', 'samples', '--json')
        _, out, _ = sosml('fit', bag, *options)
        residual[hold] = checked(out, 'fit')['joints']['slider']['kalman']['residual_std']
    assert residual['end'] < 0.7 * residual['start']
    assert 'start' in sosml('fit', bag)[1]
    assert 'effort' in sosml('tune', bag, '--effort-hold', 'never')[2]


def test_fit_refuses_an_observer_it_does_not_know(refused, encoder_bag):
    assert "observer 'guess' is unknown" in refused('fit', encoder_bag, '--observers', 'guess')


@pytest.mark.parametrize('name', list(TRAJECTORIES))
def test_trajectory_draws_writes_and_tells_what_it_asks_of_the_exoskeleton(sosml, tmp_path, name):
    """The options are those of config/exoskeleton.yaml, which belongs to the model folder."""
    code, out, err = sosml('trajectory', name, '--json', '--plot=t.png', '--out=t.csv')
    assert (code, err) == (0, '')
    document = checked(out, 'trajectory')
    assert document['trajectory'] == name
    assert document['fits']
    assert document['beyond'] == []
    assert document['options']['centre'] == pytest.approx([-np.pi / 2, 1.2])
    assert (document['plot'], document['output']) == ('t.png', 't.csv')
    if name == 'speed_ladder':
        assert document['options']['plateau'] == 1.0
    assert (tmp_path / 't.png').read_bytes().startswith(b'\x89PNG')
    with (tmp_path / 't.csv').open() as file:
        header = file.readline().strip().split(',')
        rows = np.loadtxt(file, delimiter=',')
    assert header[:3] == ['time [s]', 'shoulder position [rad]', 'shoulder velocity [rad/s]']
    assert rows[-1, 0] == pytest.approx(document['duration_s'])
    elbow = document['joints']['elbow']
    assert elbow['position']['highest'] == pytest.approx(rows[:, 5].max())
    assert elbow['speed']['peak'] == pytest.approx(np.abs(rows[:, 6]).max())
    assert elbow['effort']['peak'] == pytest.approx(np.abs(rows[:, 8]).max())
    # 15 % of 5 Nm.
    assert elbow['effort']['friction_allowance'] == pytest.approx(0.75)
    robot = read_model(share_directory() / 'config' / 'exoskeleton').make_robot()
    k = len(rows) // 3
    q, v, a, tau = (rows[k, [1 + i, 5 + i]] for i in range(4))
    np.testing.assert_allclose(robot.inverse_dynamics(q, v, a), tau, atol=1e-6)
    # A second run replaces both.
    assert sosml('trajectory', name, '--plot=t.png', '--out=t.csv')[0] == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ['t.csv', 't.png']


def test_a_trajectory_beyond_the_limits_ends_with_1_and_a_sentence(sosml, tmp_path):
    """The picture shows where; samples that nobody should run are not written."""
    beyond = ('trajectory', 'speed_ladder', '--set=centre=0,1', '--plot=t.png', '--out=t.csv')
    code, out, err = sosml(*beyond, '--json')
    assert code == 1
    document = checked(out, 'trajectory')
    assert not document['fits']
    assert 'joint shoulder to a rigid-body effort of' in document['beyond'][0]
    assert document['output'] is None
    assert err.strip() == 'sosml: t.csv is not written: the trajectory is beyond a limit'
    assert [path.name for path in tmp_path.iterdir()] == ['t.png']
    code, out, _ = sosml(*beyond[:3])
    assert code == 1
    assert 'Beyond a limit: the trajectory takes joint shoulder to' in out
    assert '168 %' in out


def test_trajectory_of_a_prismatic_joint_begins_in_the_middle_of_its_range(sosml):
    options = ('--set', 'speeds=0.01,0.05', '--set', 'top_speed=0.1', '--set=scale=0.5')
    code, out, _ = sosml('trajectory', 'speed_ladder', '--model', EMPS, *options, '--json')
    assert code == 0
    slider = checked(out, 'trajectory')['joints']['slider']
    assert slider['unit'] == 'N'
    lowest, highest = slider['position']['lowest'], slider['position']['highest']
    assert 0.5 * (lowest + highest) == pytest.approx(0.125)
    assert slider['speed']['peak'] >= 0.5 * 0.05
    code, out, _ = sosml('trajectory', 'speed_ladder', '--model', EMPS, *options)
    assert 'm/s2' in out
    assert 'All within the limits.' in out


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (['zigzag'], "trajectory 'zigzag' is unknown: use speed_ladder, "),
        (['reversal', '--set', 'cycles'], 'write KEY=VALUE with amplitude, frequency'),
        (['reversal', '--set', 'speeds=1'], "'speeds=1' sets no option of reversal"),
        (['reversal', '--set', 'amplitude=much'], "amplitude is 'much': give a number"),
        (['multisine', '--set', 'seed=1.5'], "seed is '1.5': give a whole number"),
        (['multisine', '--set', 'centre=1'], 'centre has 1 values for the joints shoulder, elbow'),
        (['multisine', '--set', 'acceleration_limit=1,2,3'], '3 values for 2 joints'),
        (['rich', '--plot', 'rich.pdf'], 'does not end in .png'),
        (['rich', '--out', 'nowhere/rich.csv'], 'is no folder'),
        (['rich', '--model', 'nowhere'], 'nowhere'),
        (['rich', '--urdf', 'nowhere.urdf'], 'nowhere.urdf cannot be read'),
    ],
)
def test_a_trajectory_that_cannot_be_is_refused(refused, arguments, words):
    assert words in refused('trajectory', *arguments)


def test_trajectory_overwrites_no_foreign_file(refused, tmp_path):
    (tmp_path / 'thesis.png').write_text('mine')
    assert 'something else' in refused('trajectory', 'reversal', '--plot', 'thesis.png')
    (tmp_path / 'data.csv').write_text('a,b\n')
    assert 'something else' in refused('trajectory', 'reversal', '--out', 'data.csv')


def test_trajectory_takes_its_options_from_the_parameter_file_beside_the_model(
    sosml, refused, tmp_path
):
    """Nested or with a point, under the name of the trajectory; --set has the last word."""
    shutil.copytree(share_directory() / 'config' / 'exoskeleton', tmp_path / 'config' / 'mine')
    shutil.copytree(share_directory() / 'urdf', tmp_path / 'urdf')
    parameters = tmp_path / 'config' / 'mine.yaml'
    text = """/**/identifier_node:
  ros__parameters:
    centre: [-1.4, 1.0]
    acceleration_limit: [9.0]
    reversal: {amplitude: 0.2, cycles: 3.0}
    reversal.frequency: 0.4
"""
    parameters.write_text(text)
    command = ('trajectory', 'reversal', '--model', 'config/mine')
    document = checked(sosml(*command, '--set', 'cycles=2', '--json')[1], 'trajectory')
    options = document['options']
    assert (options['amplitude'], options['frequency'], options['cycles']) == (0.2, 0.4, 2.0)
    assert options['centre'] == [-1.4, 1.0]
    assert document['joints']['elbow']['acceleration']['limit'] == 9.0
    parameters.write_text(text.replace('0.4', 'fast'))
    assert 'reversal.frequency of identifier_node in ' in refused(*command)
    parameters.write_text('{')
    assert 'the parameter file beside the model, cannot be read' in refused(*command)


def test_plan_prints_speeds_that_the_ladder_takes_and_what_they_give(sosml):
    """The command it prints runs, and lasts as long as it says."""
    wanted = ('--std-error', 'coulomb=0.003', '--std-error=stribeck=0.01')
    code, out, err = sosml('plan', *wanted, '--budget', '60', '--json')
    assert (code, err) == (0, '')
    document = checked(out, 'plan')
    assert document['reached']
    assert document['std_errors']['coulomb'] <= 0.003
    assert document['std_errors']['stribeck'] <= 0.01
    assert document['duration_s'] <= 60.0
    code, out, _ = sosml('plan', *wanted, '--budget', '60')
    assert code == 0
    command = out.splitlines()[-1].split()
    assert command[:2] == ['sosml', 'trajectory']
    code, out, _ = sosml(*command[1:], '--json')
    assert code == 0
    again = checked(out, 'trajectory')
    assert again['options']['speeds'] == document['speeds']
    assert again['duration_s'] == pytest.approx(document['duration_s'])


def test_plan_says_when_a_wanted_error_cannot_be_reached_and_what_can(sosml):
    impossible = ('plan', '--std-error', 'stribeck=0.0005', '--budget', '60')
    code, out, err = sosml(*impossible, '--json')
    assert (code, err) == (1, '')
    document = checked(out, 'plan')
    assert document['missed'] == ['stribeck']
    assert document['needed_s'] > 60.0
    code, out, _ = sosml(*impossible)
    assert code == 1
    assert 'Not all can be reached within 60 s: the best is 0.00' in out


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        ([], 'no standard error is wanted'),
        (['--std-error', 'inertia=1'], 'write NAME=NUMBER with coulomb, '),
        (['--std-error', 'coulomb'], 'write NAME=NUMBER'),
        (['--std-error', 'coulomb=-1'], 'give a positive number'),
        (['--std-error', 'coulomb=1', '--budget', '5'], '5 s are too short'),
        (['--std-error', 'coulomb=1', '--budget', 'nan'], 'the budget is nan s'),
        (['--std-error', 'coulomb=1', '--noise', '0'], 'noise is 0.0'),
        (['--std-error', 'coulomb=1', '--plateau', '0.3'], 'a plateau of 0.3 s is too short'),
        (['--std-error', 'coulomb=1', '--slowest', '1'], 'the slowest speed is 1.0'),
        (['--std-error', 'coulomb=1', '--assume', 'stribeck=0'], 'the assumed stribeck is 0.0'),
    ],
)
def test_a_plan_that_cannot_be_is_refused(refused, arguments, words):
    assert words in refused('plan', *arguments)


@pytest.mark.parametrize('command', ['fit', 'tune'])
def test_help_names_every_observer(sosml, command):
    """The names are written out there, so that --help loads nothing."""
    words = ' '.join(sosml(command, '--help')[1].split())
    for name in OBSERVERS:
        assert name in words
