# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Several real bags of one slider: through the tool, and in what they are said to disagree."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from full_runs import only_full

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.bags.source import bag_labels
from sosml_friction.cli import main as cli
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.identification.friction_fit import FitSettings
from sosml_friction.identification.several.bags_analysis import analyse_bags
from sosml_friction.model.laws import make_friction_law
from sosml_friction.model.model_folder import (
    FrictionParameters,
    RobotModelFile,
    read_model,
)
from sosml_friction.model.parameter import Parameter
from sosml_friction.motion.trajectories import build_trajectory
from sosml_friction.share import share_directory

SCHEMA = Path(__file__).resolve().parents[3] / 'docs' / 'schema' / 'fit.schema.json'
V0 = 0.0005
TRUTH = {
    'coulomb': 20.0, 'viscous': 100.0, 'stribeck': 10.0, 'stribeck_velocity': 0.01, 'bias': 0.0,
}  # fmt: skip
UNITS = {
    'coulomb': 'N', 'viscous': 'N s/m', 'stribeck': 'N', 'stribeck_velocity': 'm/s', 'bias': 'N',
}  # fmt: skip
MOTIONS = {
    't1': ('speed_ladder', {'speeds': (0.02, 0.04, 0.07, 0.12, 0.2), 'plateau': 0.6}),
    't2': ('symmetric_reversals', {'speeds': (0.01, 0.025), 'plateau': 0.6}),
    't3': ('slow_ladder', {'speeds': (0.004, 0.008, 0.015, 0.03), 'way': 0.004}),
}


@pytest.fixture(scope='module')
def nominal() -> RobotModelFile:
    """Return the slider; the width of its friction's sign is known, the numbers are not."""
    model = read_model(share_directory() / 'config' / 'emps')
    guess = {name: Parameter(1.0, unit) for name, unit in UNITS.items()}
    friction = FrictionParameters('stribeck', V0, guess)
    joints = {name: replace(joint, friction=friction) for name, joint in model.joints.items()}
    return replace(model, joints=joints)


@pytest.fixture(scope='module')
def record(nominal, tmp_path_factory):
    """Return a maker of bags: a motion, with a factor on C, a bias, a seed, another model."""
    robot = nominal.make_robot()

    def make(name, coulomb=1.0, bias=0.0, seed=0, model=None, tags=None):
        kind, values = MOTIONS[name]
        path = build_trajectory(kind, {'slider': 0.1}, {'slider': 0.1}, values)
        h = 0.004
        t = np.arange(0.0, path.duration, h)
        spline = path.spline()
        noise = np.random.default_rng([seed, list(MOTIONS).index(name)])
        # Effort is held from a sample to the next: that of the middle does what the motion needs.
        state = (spline(np.minimum(t + 0.5 * h, path.duration), k) for k in range(3))
        q, v, a = state
        tau = np.array([robot.inverse_dynamics(*x) for x in zip(q, v, a, strict=True)])
        law = make_friction_law(
            'stribeck', {**TRUTH, 'coulomb': coulomb * TRUTH['coulomb'], 'bias': bias}, V0
        )
        tau += law.torque(v) + noise.normal(0.0, 0.5, v.shape)
        q = spline(t) + noise.normal(0.0, 2e-7, v.shape)
        log = JointLog(
            robot.names, np.rint(t * 1e9).astype(np.int64), q, spline(t, 1), tau, None, tags or {}
        )
        folder = tmp_path_factory.mktemp('bags') / name
        chosen = model or nominal
        return write_joint_log(log, folder, chosen.urdf, chosen.to_yaml())

    return make


@pytest.fixture(scope='module')
def bags(record):
    return {name: record(name) for name in MOTIONS}


def consolidated(paths, **options):
    settings = FitSettings(method='weak')
    result = analyse_bags(paths, settings=settings, observers=['sosml'], **options)
    return result.consolidation.joints['slider']['weak_form']


def test_three_bags_through_the_tool(bags, tmp_path, monkeypatch, capsys):
    """The joint fit holds the truth in its intervals, and files say what it was made of."""
    monkeypatch.chdir(tmp_path)
    arguments = [
        'fit',
        *map(str, bags.values()),
        '--role',
        't3=T3',
        '--observers',
        'sosml',
        '--json',
    ]
    assert cli.main(arguments) == 0
    captured = capsys.readouterr()
    document = json.loads(captured.out, parse_constant=pytest.fail)
    jsonschema.validate(
        document, json.loads(SCHEMA.read_text()), cls=jsonschema.Draft202012Validator
    )
    folder = tmp_path / document['output']
    assert {path.name for path in folder.iterdir()} == {
        'robot.urdf', 'model.yaml', 'report.html', 'fit.json', 'segments.csv',
    }  # fmt: skip
    found = document['consolidation']['joints']['slider']['weak_form']
    assert (found['preferred'], found['disagreements']) == ('joint', []), found['reason']
    for name, truth in TRUTH.items():
        low, high = found['joint']['parameters'][name]['interval']
        assert low <= truth <= high, name
    assert found['joint']['parameters']['coulomb']['value'] == pytest.approx(20.0, rel=0.01)
    assert found['joint']['parameters']['stribeck']['value'] == pytest.approx(10.0, rel=0.05)
    sources = found['rule']['sources']
    assert set(sources['coulomb']) <= {'t1', 't3'}
    assert 't1' in sources['coulomb']
    assert sources['bias'] == ['t3']
    assert found['rule']['parameters']['coulomb']['value'] == pytest.approx(20.0, rel=0.05)
    roles = document['consolidation']['roles']
    assert [(roles[k]['role'], roles[k]['source']) for k in bags] == [
        ('T1', 'motion'), ('T2', 'motion'), ('T3', 'stated'),
    ]  # fmt: skip
    assert document['joints']['slider']['weak_form']['parameters'] == found['parameters']
    assert document['model'] == {'slider': 'weak_form'}
    assert [entry['label'] for entry in document['bags']] == list(bags)
    provenance = document['provenance']
    assert provenance['command'].startswith('sosml fit ')
    assert provenance['settings']['method'] == 'auto'
    for entry in provenance['bags']:
        assert len(entry['sha256']) == 64
        assert entry['end_ns'] > entry['start_ns']
    assert 'numpy' in provenance['versions']
    model = read_model(folder)
    friction = model.joints['slider'].friction
    assert friction.parameters['coulomb'].value == found['parameters']['coulomb']['value']
    assert model.provenance['bags'][1]['sha256'] == provenance['bags'][1]['sha256']
    assert model.provenance['consolidation']['joints']['slider']['preferred'] == 'joint'
    assert provenance['bags'][0]['sha256'][:12] in (folder / 'report.html').read_text()


def test_ten_percent_more_coulomb_in_a_bag_is_said_to_be_that(bags, record):
    changed = record('t3', coulomb=1.1, seed=1)
    found = consolidated([bags['t1'], bags['t2'], changed])
    (only,) = found.agreement.disagreements
    assert (only.parameter, only.bag) == ('coulomb', 't3')
    assert only.difference == pytest.approx(2.0, abs=4.0 * only.std_error)
    assert only.sigmas > 5.0
    assert only.sentence in found.reason


@only_full
def test_an_offset_in_a_bag_is_said_to_be_a_bias_and_friction_stays(bags, record):
    changed = record('t1', bias=2.0, seed=1)
    found = consolidated([changed, bags['t2'], bags['t3']])
    (only,) = found.agreement.disagreements
    assert (only.parameter, only.bag) == ('bias', 't1')
    assert only.difference == pytest.approx(2.0, abs=4.0 * only.std_error)
    assert found.own_bias
    assert found.parameters['coulomb'].value == pytest.approx(20.0, rel=0.01)


def test_one_bag_is_itself_and_lacks_what_the_rule_needs(bags):
    result = analyse_bags([bags['t1']], settings=FitSettings(method='weak'), observers=['sosml'])
    found = result.consolidation.joints['slider']['weak_form']
    assert 'There is one bag' in found.reason
    assert found.rule.missing == ('T2', 'T3')
    assert 'record it, or say which bag it is with --role' in found.rule.reason
    alone = found.fits['t1'].fit.parameters['viscous']
    assert found.parameters['viscous'].value == pytest.approx(alone.value, abs=alone.std_error)


def test_bags_of_different_robots_are_refused(bags, record, nominal):
    heavier = {
        name: replace(joint, armature=Parameter(5.0, 'kg'))
        for name, joint in nominal.joints.items()
    }
    other = record('t2', model=replace(nominal, joints=heavier))
    with pytest.raises(ConfigurationError, match='not of the same robot: the armature of slider'):
        analyse_bags([bags['t1'], other])
    urdf = nominal.urdf.replace('<mass value="', '<mass value="1')
    assert urdf != nominal.urdf
    with pytest.raises(ConfigurationError, match='not of the same robot: their URDFs differ'):
        analyse_bags([bags['t1'], record('t2', model=replace(nominal, urdf=urdf))])


def test_mistakes_are_one_sentence_and_nothing_is_written(bags, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    one, two = str(bags['t1']), str(bags['t2'])
    for arguments, words in (
        ([one, one], 'is given twice'),
        ([one, two, '--role', 't1=T5'], '--role t1=T5 is not BAG=ROLE'),
        ([one, '--role', 't1=T1'], 'says how several bags are put together'),
        ([one, two, '--law', 'quadratic'], "law is 'quadratic'"),
        ([one, '--trim', '-1'], 'segment setting trim_s is -1'),
        ([one, two, '--zero-band', 'wide'], 'zero-band'),
        ([one, str(tmp_path / 'none')], 'does not exist'),
    ):
        assert cli.main(['fit', *arguments]) == 2
        captured = capsys.readouterr()
        assert captured.out == ''
        assert captured.err.count('\n') == 1
        assert words in captured.err
    assert list(tmp_path.iterdir()) == []


def test_ctrl_c_leaves_the_earlier_fit(bags, tmp_path, monkeypatch, capsys):
    from sosml_friction.identification.several import bags_analysis

    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(bags_analysis, 'consolidate', interrupt)
    earlier = tmp_path / 't1_fit'
    earlier.mkdir()
    (earlier / 'fit.json').write_text('{"format": "sosml_friction/fit/1"}')
    arguments = [str(bags['t1']), str(bags['t2']), '--observers', 'quasi_static']
    assert cli.main(['fit', *arguments, '--method', 'segments']) == 130
    assert capsys.readouterr().out == ''
    assert [path.name for path in tmp_path.iterdir()] == ['t1_fit']
    assert [path.name for path in earlier.iterdir()] == ['fit.json']


def test_a_bag_that_cannot_be_used_is_named(bags, record, nominal, tmp_path):
    still = np.zeros((500, 1))
    log = JointLog(('slider',), np.arange(500) * 4_000_000, still, still, still)
    path = write_joint_log(log, tmp_path / 'still', nominal.urdf, nominal.to_yaml())
    with pytest.raises(DataError, match='bag still: '):
        analyse_bags([bags['t1'], path])


def test_bags_of_the_same_name_go_by_their_path(tmp_path):
    labels = bag_labels([tmp_path / 'a' / 'bag', tmp_path / 'b' / 'bag', tmp_path / 'c.mcap'])
    assert list(labels) == [str(tmp_path / 'a' / 'bag'), str(tmp_path / 'b' / 'bag'), 'c']


def test_a_copy_of_a_recording_does_not_count_twice(bags, tmp_path):
    copy = tmp_path / 'copy'
    shutil.copytree(bags['t1'], copy)
    with pytest.raises(ConfigurationError, match='t1 and copy are copies of one recording'):
        analyse_bags([bags['t1'], copy])
