# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What a person in a notebook has: on logs and models alone, the same numbers as the tool's."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import sosml_friction as sf
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.identification.bag_analysis import analyse_bag
from sosml_friction.motion.trajectory_kinds.speed_ladder import speed_ladder
from sosml_friction.one_thread import in_one_thread
from sosml_friction.share import share_directory

ROOT = Path(__file__).resolve().parents[2]
COULOMB, VISCOUS = 20.0, 200.0
MAPPING = """\
time: {variable: time, unit: ms}
joints:
  slider:
    position: {variable: position, unit: mm}
    effort: {variable: current, unit: A, scale: 35.0}
"""


def record(model, seed, asymmetry=0.0):
    """Return a log of the slider whose friction is known, [N] at [m/s]."""
    robot = model.content.make_robot()
    ladder = speed_ladder({'slider': 0.1}, {'slider': 0.12}, [0.01, 0.04, 0.1], plateau_s=0.6)
    spline = ladder.spline()
    t = np.arange(0.0, ladder.duration, 0.004)
    q, v, a = spline(t), spline(t, 1), spline(t, 2)
    tau = np.array([robot.inverse_dynamics(*state) for state in zip(q, v, a, strict=True)])
    tau += COULOMB * np.tanh(v / 5e-4) + VISCOUS * v + asymmetry * np.abs(v)
    # A sample of effort holds until the next one: what it was on average over that time.
    tau[:-1] = 0.5 * (tau[:-1] + tau[1:])
    tau += np.random.default_rng(seed).normal(0.0, 0.3, v.shape)
    return sf.JointLog(robot.names, np.rint(t * 1e9).astype(np.int64), q, v, tau)


@pytest.fixture(scope='module')
def model():
    return sf.Model.read(share_directory() / 'config' / 'emps')


@pytest.fixture(scope='module')
def log(model):
    return record(model, 3)


@pytest.fixture(scope='module')
def fitted(log, model):
    return sf.fit(log, model)


def valid(document, schema):
    """Return whether a document is of a schema of the tool, and ready for JSON."""
    text = json.dumps(document, allow_nan=False)
    rules = json.loads((ROOT / 'docs' / 'schema' / f'{schema}.schema.json').read_text())
    jsonschema.validate(json.loads(text), rules, cls=jsonschema.Draft202012Validator)
    return True


def is_short(result):
    return len(repr(result)) < 160 and '\n' not in repr(result)


def test_importing_the_package_loads_nothing_but_itself():
    program = (
        'import sys; import sosml_friction as sf; sf.__version__; dir(sf); '
        'print([x for x in sys.modules if x in ("numpy", "scipy", "pinocchio", "yaml") '
        'or x.startswith("sosml_friction.")])'
    )
    told = subprocess.run(
        [sys.executable, '-c', program], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert told.stdout.strip() == '[]'


def test_every_name_is_offered_to_python_and_to_an_editor_alike():
    assert set(sf.__all__) <= set(dir(sf))
    assert all(getattr(sf, name) is not None for name in sf.__all__)
    tree = ast.parse((ROOT / 'sosml_friction' / '__init__.py').read_text())
    typed = {
        f'{node.module}.{alias.name}'
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.module.startswith('sosml_friction')
        for alias in node.names
    }
    homes = {f'sosml_friction.{home}.{name}' for name, home in sf._HOMES.items()}
    assert typed == homes
    assert set(sf._HOMES) | {'__version__'} == set(sf.__all__)


def test_a_name_that_is_not_there_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'identify'"):
        sf.identify


def test_a_table_and_a_bag_hold_the_same_log(log, model, tmp_path):
    content = model.content
    bag = sf.load(write_joint_log(log, tmp_path / 'bag', content.urdf, content.to_yaml()))
    np.testing.assert_array_equal(bag.q, log.q)
    np.testing.assert_array_equal(bag.tau, log.tau)
    (tmp_path / 'map.yaml').write_text(MAPPING)
    lines = zip(log.t_ns[:, None] // 1000000, 1e3 * log.q, log.tau / 35.0, strict=True)
    rows = [','.join(repr(x.item()) for x in line) for line in lines]
    (tmp_path / 'log.csv').write_text('\n'.join(['time,position,current', *rows]))
    np.savez(
        tmp_path / 'log.npz',
        time=log.t_ns // 1000000,
        position=1e3 * log.q[:, 0],
        current=log.tau[:, 0] / 35.0,
    )
    for name in ('log.csv', 'log.npz'):
        table = sf.load(tmp_path / name, tmp_path / 'map.yaml')
        np.testing.assert_array_equal(table.t_ns, log.t_ns)
        np.testing.assert_allclose(table.q, log.q, rtol=1e-12)
        np.testing.assert_allclose(table.tau, log.tau, rtol=1e-12)
    assert sf.Model.from_bag(tmp_path / 'bag').joints == ('slider',)
    (tmp_path / 'timeless.yaml').write_text(MAPPING.split('\n', 1)[1])
    even = sf.load(tmp_path / 'log.csv', tmp_path / 'timeless.yaml', rate=100.0)
    np.testing.assert_array_equal(np.diff(even.t_ns), 10_000_000)
    with pytest.raises(ConfigurationError, match='give a mapping file'):
        sf.load(tmp_path / 'log.csv')
    with pytest.raises(ConfigurationError, match='leave the mapping out'):
        sf.load(tmp_path / 'bag', tmp_path / 'map.yaml')


def test_a_file_of_no_known_kind_is_no_bag(tmp_path):
    (tmp_path / 'x.xls').write_bytes(b'')
    (tmp_path / 'm.yaml').write_text(
        '{sample_rate: 100, joints: {j: {position: {variable: 0, unit: rad}}}}'
    )
    with pytest.raises(DataError, match=r'x\.xls is not of a kind that can be imported: give one'):
        sf.load(tmp_path / 'x.xls', tmp_path / 'm.yaml')


def test_a_model_is_made_from_a_urdf_written_and_read_again(model, fitted, tmp_path):
    made = sf.Model.from_urdf(model.urdf, {'slider': 0.5}, 'axis')
    assert (made.name, made.joints) == ('axis', ('slider',))
    armature = made.content.joints['slider'].armature
    assert (armature.value, armature.unit) == (0.5, 'kg')
    assert made.parameters() == {'slider': {}}
    assert np.isnan(made.friction([0.1, 0.2])).all()
    (tmp_path / 'axis.urdf').write_text(model.urdf)
    for path in (tmp_path / 'axis.urdf', str(tmp_path / 'axis.urdf')):
        assert sf.Model.from_urdf(path, {'slider': 0.5}, 'axis').content == made.content
    with pytest.raises(ConfigurationError, match=r'none\.urdf'):
        sf.Model.from_urdf('none.urdf')
    with pytest.raises(ConfigurationError, match='moves the joints slider'):
        sf.Model.from_urdf(model.urdf, {'elbow': 0.5})
    again = sf.Model.read(fitted.model.write(tmp_path / 'model'))
    assert again.urdf == model.urdf
    assert again.parameters().keys() == {'slider'}
    np.testing.assert_array_equal(again.friction([0.1, -0.2]), fitted.predict([0.1, -0.2]))
    assert repr(again) == '<Model emps; slider: coulomb_viscous>'


def test_a_fit_has_the_truth_in_its_intervals(fitted):
    intervals = fitted.conf_int()['slider']
    for name, truth in (('coulomb', COULOMB), ('viscous', VISCOUS), ('bias', 0.0)):
        low, high = intervals[name]
        assert low < truth < high
        assert low < fitted.parameters['slider'][name].value < high
    assert fitted.unavailable == {}


def test_a_fit_of_a_log_and_of_its_bag_are_the_same_numbers(log, model, fitted, tmp_path):
    content = model.content
    bag = write_joint_log(log, tmp_path / 'bag', content.urdf, content.to_yaml())
    # As every command does: sums of two threads end in other digits.
    of_bag = sf.Fit(in_one_thread(analyse_bag)(bag))
    np.testing.assert_equal(of_bag.conf_int(), fitted.conf_int())
    assert of_bag.to_dict()['joints'] == fitted.to_dict()['joints']


def test_a_fit_predicts_the_friction_that_was_there(log, fitted):
    v = np.array([-0.1, -0.03, 0.03, 0.1])
    truth = COULOMB * np.sign(v) + VISCOUS * v
    np.testing.assert_allclose(fitted.predict(v), truth, rtol=0.02)
    np.testing.assert_array_equal(fitted.predict(v[:, None])[:, 0], fitted.predict(v))
    along = fitted.predict(log)
    assert along.shape == log.q.shape
    np.testing.assert_array_equal(along, fitted.predict(log.v))
    # Without a measured velocity it is that of the position.
    without = fitted.predict(replace(log, v=np.full_like(log.v, np.nan)))
    steady = np.isfinite(without) & (np.abs(log.v) > 0.02)
    assert np.median(np.abs(without - along)[steady]) < 0.1
    with pytest.raises(ConfigurationError, match='last axis must be that of the joints slider'):
        fitted.predict(np.zeros((3, 2)))


def test_a_fit_is_told_in_words_and_as_the_json_of_the_tool(fitted, tmp_path):
    text = fitted.summary()
    assert text.startswith('slider: ')
    assert 'Coulomb friction' in text
    assert 'std error' in text
    assert valid(fitted.to_dict(), 'fit')
    assert repr(fitted).startswith('<Fit; slider: coulomb ')
    assert is_short(fitted)
    assert (fitted.write(tmp_path / 'fit') / 'report.html').is_file()


def test_several_logs_are_fitted_alone_and_together(log, model):
    logs = {'morning': log, 'noon': record(model, 4)}
    both = sf.fit(logs, model, method='weak', observers=['sosml'])
    assert list(both.analysis.bags) == ['morning', 'noon']
    low, high = both.conf_int()['slider']['coulomb']
    assert low < COULOMB < high
    assert valid(both.to_dict(), 'fit')
    assert 'morning' in both.summary()
    assert is_short(both)
    np.testing.assert_allclose(both.predict([0.05]), COULOMB + 0.05 * VISCOUS, rtol=0.02)
    with pytest.raises(ConfigurationError, match='log 1 and log 2 are copies of one recording'):
        sf.fit([log, log], model)
    with pytest.raises(DataError, match='give at least one'):
        sf.fit([], model)


@pytest.mark.parametrize('function', [sf.fit, sf.diagnose, sf.observe, sf.simulate])
def test_what_is_no_recording_and_no_model_is_refused_in_a_sentence(log, model, function):
    with pytest.raises(sf.SosmlFrictionError, match=r"^'bag' is no recording: give what sf"):
        function('bag', model)
    with pytest.raises(sf.SosmlFrictionError, match=r'^array\(.*\) is no recording: give what sf'):
        function(np.zeros((3, 2)), model)
    with pytest.raises(sf.SosmlFrictionError, match=r"^model is 'folder': give an sf"):
        function(log, 'folder')


def test_the_path_of_a_model_is_no_model():
    with pytest.raises(ConfigurationError, match=r'sf\.Model\.read'):
        sf.Model('config/exoskeleton')


def test_a_path_that_is_not_there_is_told():
    with pytest.raises(DataError, match='no/bag does not exist: give the path'):
        sf.load('no/bag')


def test_what_cannot_be_fitted_is_refused_in_a_sentence(log, model):
    silent = replace(log, tau=np.full_like(log.tau, np.nan))
    with pytest.raises(DataError, match='carries no effort for slider'):
        sf.fit(silent, model)
    with pytest.raises(DataError, match=r'^log 2: .*carries no effort'):
        sf.fit([log, silent], model, method='segments', observers=['quasi_static'])
    with pytest.raises(ConfigurationError, match='say how several recordings are put together'):
        sf.fit(log, model, roles={'log': 'T1'})
    with pytest.raises(ConfigurationError, match="law is 'cubic'"):
        sf.fit(log, model, law='cubic')
    with pytest.raises(ConfigurationError, match='body'):
        sf.fit(log, model, body_tolerance=-0.1)


def test_observers_say_why_what_they_estimate_may_be_no_friction(log, model):
    found = sf.observe(replace(log, tau=-log.tau), model)
    (why,) = found.told
    assert 'turn the sign of its effort' in why
    assert found.summary().startswith(why)
    assert found.to_dict()['told'] == [why]


def test_observers_say_what_the_friction_is(log, model):
    found = sf.observe(log, model, observers=['sosml'])
    assert list(found.friction) == ['sosml']
    tau_f = found.friction['sosml'][:, 0]
    steady = np.isfinite(tau_f) & (log.v[:, 0] > 0.039) & (log.v[:, 0] < 0.041)
    assert np.median(tau_f[steady]) == pytest.approx(COULOMB + 0.04 * VISCOUS, rel=0.05)
    assert 'forwards' in found.summary()
    assert found.told == ()
    document = found.to_dict()
    assert json.loads(json.dumps(document, allow_nan=False))['joints'] == ['slider']
    assert len(document['friction']['sosml']) == len(log)
    assert is_short(found)
    assert list(sf.observe(log, model, observers='sosml').friction) == ['sosml']
    joined = sf.observe(log, model, observers='sosml, first_order').friction
    assert set(joined) == {'sosml', 'first_order'}
    with pytest.raises(ConfigurationError, match="observer 'best' is unknown"):
        sf.observe(log, model, observers=['best'])


def test_observers_see_the_torque_that_a_model_makes_of_the_effort(log, model):
    from sosml_friction.model.model_folder import EffectTerm
    from sosml_friction.model.parameter import Parameter

    double = EffectTerm('effort_scale', 'slider', {'error': Parameter(1.0, '')})
    known = sf.Model(replace(model.content, effects=(double,)))
    twice = replace(log, tau=2.0 * log.tau)
    own, corrected = (sf.observe(x, m) for x, m in ((log, model), (twice, known)))
    np.testing.assert_array_equal(corrected.log.tau, log.tau)
    np.testing.assert_array_equal(corrected.friction['sosml'], own.friction['sosml'])


def test_a_simulation_with_the_fitted_model_follows_the_recording(log, fitted):
    found = sf.simulate(log, fitted.model, horizon_s=0.3)
    assert found.found.errors['slider']['position'].relative < 5.0
    assert found.measured['position'].shape == found.simulated['position'].shape
    assert len(found.time) == len(found.simulated['velocity'])
    assert valid(found.to_dict(), 'simulation')
    assert 'windows of 0.3 s' in found.summary()
    assert is_short(found)
    with pytest.raises(ConfigurationError, match='horizon'):
        sf.simulate(log, fitted.model, horizon_s=0.0)


def test_a_diagnosis_names_what_the_fitted_law_lacks(model, fitted):
    """Friction that is larger forwards: no symmetric law has it."""
    log, other = record(model, 5, asymmetry=60.0), record(model, 6, asymmetry=60.0)
    found = sf.diagnose(log, fitted.model, holdout=other)
    assert found.verdict == 'named'
    (cause,) = found.causes
    assert (cause.effect, cause.joint) == ('asymmetric_friction', 'slider')
    low, high = found.conf_int()['slider']['asymmetric_friction.viscous_asymmetry']
    assert low < cause.parameters['viscous_asymmetry'].value < high
    assert valid(found.to_dict(), 'diagnosis')
    assert [bag['bag'] for bag in found.to_dict()['provenance']['bags']] == ['log']
    assert found.summary().startswith('Named: slider: asymmetric friction')
    assert is_short(found)
    before, after = sf.simulate(other, fitted.model), found.predict(other)
    errors = [x.found.errors['slider']['position'].rms for x in (before, after)]
    assert errors[1] < 0.6 * errors[0]
    assert [term.effect for term in found.model.content.effects] == ['asymmetric_friction']
    with pytest.raises(ConfigurationError, match='the gain has to be measured on another one'):
        sf.diagnose(log, fitted.model, holdout=log)


def test_a_model_that_is_right_stays_as_it_is(model, fitted):
    found = sf.diagnose(record(model, 7), fitted.model)
    assert found.verdict == 'nothing_above_floor'
    assert found.causes == ()
    assert found.conf_int() == {}
    assert repr(found) == '<Diagnosis; nothing_above_floor>'
