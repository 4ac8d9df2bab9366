# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""One class from outside the package is an observer everywhere: on line, in the study, in tune."""

from __future__ import annotations

import json
from io import StringIO

import numpy as np
import pytest
import yaml
from outside_observer import define_observer
from rich.console import Console

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.nodes.observer_node import parameters
from sosml_friction.observers.configuration import ObserverConfiguration
from sosml_friction.observers.friction_estimator import FrictionEstimator
from sosml_friction.observers.observer import Observer
from sosml_friction.observers.recipe import recipe_gains
from sosml_friction.observers.registry import OBSERVERS, make_observer
from sosml_friction.report.common.labels import in_order, observer_label
from sosml_friction.report.study.results import render_study, study_document
from sosml_friction.report.study.tables import study_tables
from sosml_friction.share import share_directory
from sosml_friction.study.run import StudySettings, run_study


@pytest.fixture(autouse=True)
def leaky(monkeypatch):
    """Define the observer for one test alone."""
    monkeypatch.setattr(Observer.registry, 'known', dict(Observer.registry))
    return define_observer()


def test_it_is_found_after_those_of_the_package_and_has_a_label(leaky):
    assert list(OBSERVERS)[-1] == 'leaky'
    assert OBSERVERS['leaky'] is leaky
    assert observer_label('leaky_slow') == 'Leaky, slow'
    assert in_order(['weak_form', 'leaky', 'sosml']) == ['sosml', 'leaky', 'weak_form']


def test_it_is_gone_with_its_class(monkeypatch):
    monkeypatch.undo()
    assert 'leaky' not in OBSERVERS
    with pytest.raises(ConfigurationError, match="observer 'leaky' is unknown: use quasi_static"):
        make_observer('leaky', {})


def test_it_runs_on_line_with_gains_by_recipe_and_finds_the_friction(two_joints, reversal_run):
    """Within 5 % of the plateaus after a quarter of a second; batch and steps to the last bit."""
    log, truth = reversal_run
    gains = recipe_gains(two_joints, 60.0)['leaky']
    configuration = ObserverConfiguration(two_joints.names, {'leaky': gains})
    live = configuration.make_estimator(two_joints)
    rows = [
        live.update(int(t), q, v, tau)['leaky']
        for t, q, v, tau in zip(log.t_ns, log.q, log.v, log.tau, strict=True)
    ]
    batch = FrictionEstimator(two_joints, [make_observer('leaky', gains)]).batch(log)['leaky']
    np.testing.assert_array_equal(np.array(rows), batch)
    late = (log.time % 1.0 > 0.25) & (log.time % 1.0 < 0.45) & (log.time > 1.0)
    assert np.abs(batch - truth)[late, 0].max() < 0.05 * np.abs(truth[:, 0]).max()


def test_the_node_has_its_gains_as_parameters():
    (spec,) = [spec for spec in parameters() if spec.name.startswith('leaky.')]
    assert (spec.name, spec.unit) == ('leaky.time_constant', 's')


def test_it_takes_part_in_the_study_with_both_variants():
    settings = StudySettings(
        motions=('slow',),
        conditions=('noise',),
        observers=('first_order', 'leaky', 'leaky_slow'),
        seeds=2,
        tuning_seeds=1,
        evaluations=12,
        plant_step=500e-6,
    )
    assert StudySettings().observers[-2:] == ('leaky', 'leaky_slow')
    study = run_study(settings, 1)
    rmse = {row.observer: row.scores[0].rmse.mean() for row in study.rows}
    # Backward Euler is a first-order observer, to h / T: tuned alike it errs alike.
    assert rmse['leaky'] == pytest.approx(rmse['first_order'], rel=0.1)
    gains = study.row(('slow', 'noise'), 'leaky_slow').gains
    assert min(gains['time_constant']) >= 0.1
    console = Console(width=150, record=True, file=StringIO())
    console.print(study_tables(study))
    assert 'Leaky, slow: a tenth of a second at least.' in console.export_text()
    assert 'time_constant 0.1 to 1 s' in render_study(study, {})
    assert {row['observer'] for row in study_document(study)['rows']} == set(settings.observers)


@pytest.fixture
def slider_bag(tmp_path):
    """Return a bag of the EMPS axis that moves to and fro under friction of 20 N."""
    model = share_directory() / 'config' / 'emps' / 'model.yaml'
    t = np.arange(0.0, 12.0, 0.004)
    w = 2.0 * np.pi / 3.0
    q = 0.1 * np.sin(w * t)[:, None]
    v, a = 0.1 * w * np.cos(w * t)[:, None], -(w**2) * q
    noise = np.random.default_rng(2).normal(0.0, 0.3, q.shape)
    q = 2e-6 * np.round(q / 2e-6 + noise)
    tau = 95.1089 * a + 20.0 * np.sign(v)
    log = JointLog(('slider',), np.rint(t * 1e9).astype(np.int64), q, v, tau)
    urdf = (share_directory() / 'urdf' / 'emps.urdf').read_text(encoding='utf-8')
    return write_joint_log(log, tmp_path / 'slider', urdf, model.read_text(encoding='utf-8'))


def test_tune_proposes_gains_for_it_and_says_what_they_will_do(sosml, slider_bag, tmp_path):
    options = ('--velocity-noise', '1e-3', '--out', 'gains.yaml')
    code, out, err = sosml('tune', slider_bag, *options, '--json')
    assert (code, err) == (0, '')
    proposed = json.loads(out)['joints']['slider']['observers']
    assert list(proposed) == list(OBSERVERS)
    found = proposed['leaky']
    cutoff = proposed['first_order']['gains']['cutoff']
    assert found['gains']['time_constant'] == pytest.approx(1.0 / cutoff)
    assert found['on_line'] is True
    assert found['noise'] == pytest.approx(proposed['first_order']['noise'], rel=0.2)
    written = yaml.safe_load((tmp_path / 'gains.yaml').read_text())
    assert 'leaky' in written['/**/observer_node']['ros__parameters']


def test_the_tool_takes_its_name_and_lists_it(sosml, refused, slider_bag):
    code, out, _ = sosml(
        'tune', slider_bag, '--velocity-noise', '1e-3', '--observers', 'leaky', '--json'
    )
    assert code == 0
    assert list(json.loads(out)['joints']['slider']['observers']) == ['leaky']
    for command in ('tune', 'fit'):
        sentence = refused(command, slider_bag, '--observers', 'magic')
        assert "observer 'magic' is unknown: use quasi_static" in sentence
        assert 'smoother, leaky' in sentence
    sentence = refused('study', '--observers', 'magic')
    assert "'magic' is not in the study" in sentence
    assert 'smoother, leaky, leaky_slow' in sentence


@pytest.mark.parametrize(
    'missing', ['identifier', 'label', 'study', 'place', 'gain_units', 'causal']
)
def test_a_class_that_does_not_say_everything_is_refused(leaky, missing):
    said = {name: value for name, value in vars(leaky).items() if name != missing}
    with pytest.raises(TypeError, match=f'the observer Odd does not say its {missing}'):
        type('Odd', (Observer,), {**said, '__qualname__': 'Odd'})


@pytest.mark.parametrize('missing', ['recipe', 'start', 'run', 'lag_filter'])
def test_an_observer_without_a_method_cannot_be_made(leaky, missing):
    said = {name: value for name, value in vars(leaky).items() if name != missing}
    odd = type('Odd', (Observer,), {**said, '__qualname__': 'Odd', 'identifier': 'odd'})
    with pytest.raises(TypeError, match=missing):
        odd({'time_constant': [1.0]})


def test_two_observers_of_one_name_are_refused(leaky):
    said = dict(vars(leaky), __qualname__='Odd')
    with pytest.raises(ConfigurationError, match="two observers of the name 'leaky'"):
        type('Odd', (Observer,), said)
