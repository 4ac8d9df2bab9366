# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""``sosml tune``: gains from a recording, as JSON and as a parameter file."""

import pytest
import yaml
from slider_bags import COULOMB, VISCOUS, checked, record, slider_log

from sosml_friction.observers.registry import OBSERVERS, make_observer


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
    assert 'is something else, so it is not overwritten' in error
    assert (tmp_path / 'notes.yaml').read_text() == 'mine: 1\n'


def test_tune_refuses_a_bag_without_effort(refused, tmp_path_factory):
    bag = record(tmp_path_factory.mktemp('bags') / 'silent', slider_log(effort=False))
    assert 'effort' in refused('tune', bag)
