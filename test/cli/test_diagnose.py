# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""``sosml diagnose``: files, schema, exit codes, on a short recording of one slider."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from known_robots import slider_model, slider_recording

from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.cli.main import main
from sosml_friction.diagnosis.library import searched_terms
from sosml_friction.model.model_folder import read_model
from sosml_friction.model.terms.kinds.term import DATA_CAUSES, TERMS

SCHEMA = Path(__file__).resolve().parents[2] / 'docs/schema/diagnosis.schema.json'


def slider_log(asymmetry=0.0, offset=0.0, duration=28.0, seed=0):
    """Return a slider with an asymmetry [N s/m] and an offset [N] hidden in its friction."""
    return slider_recording(lambda v: asymmetry * np.abs(v) + offset, duration, seed)


@pytest.fixture(scope='module')
def nominal(tmp_path_factory):
    folder = tmp_path_factory.mktemp('nominal')
    slider_model().write(folder)
    return folder


def run(tmp_path, nominal, log, *more, capsys):
    bag = write_joint_log(log, tmp_path / 'bag')
    out = tmp_path / 'out'
    code = main(['diagnose', str(bag), '--model', str(nominal), '--out', str(out), *more])
    captured = capsys.readouterr()
    return code, out, captured.out, captured.err


def test_a_hidden_asymmetry_is_named_and_the_document_obeys_its_schema(tmp_path, nominal, capsys):
    other = write_joint_log(slider_log(asymmetry=60.0, duration=16.0, seed=1), tmp_path / 'other')
    code, out, stdout, _ = run(
        tmp_path,
        nominal,
        slider_log(asymmetry=60.0),
        '--holdout',
        str(other),
        '--json',
        capsys=capsys,
    )
    assert code == 0
    document = json.loads(stdout)
    assert 'On another recording' in document['sentence']
    validator = Draft202012Validator(json.loads(SCHEMA.read_text()))
    assert not list(validator.iter_errors(document))
    written = json.loads((out / 'diagnosis.json').read_text())
    assert {**written, 'output': str(out)} == document
    assert document['verdict'] == 'named'
    (cause,) = document['causes']
    assert (cause['effect'], cause['joint']) == ('asymmetric_friction', 'slider')
    value = cause['parameters']['viscous_asymmetry']
    assert value['value'] == pytest.approx(60.0, abs=4.0 * value['std_error'])
    gain = document['gain']['slider']
    assert gain['inverse']['after'] < 0.5 * gain['inverse']['before']
    assert gain['forward']['after'] < gain['forward']['before']
    assert read_model(out).effects[0].effect == 'asymmetric_friction'
    assert 'asymmetric friction' in (out / 'report.html').read_text()


def test_a_model_within_its_tolerance_is_left_alone(tmp_path, nominal, capsys):
    """Nominal Coulomb friction is 1.5 % and viscous friction 2 % off: no cause."""
    code, out, stdout, _ = run(tmp_path, nominal, slider_log(), capsys=capsys)
    assert code == 0
    assert stdout.startswith('The refitted model explains the data')
    document = json.loads((out / 'diagnosis.json').read_text())
    assert document['verdict'] == 'nothing_above_floor'
    assert document['causes'] == []
    assert not (out / 'model.yaml').exists()


def test_a_constant_may_be_a_bias_or_an_asymmetry_and_the_experiment_is_named(
    tmp_path, nominal, capsys
):
    code, out, stdout, _ = run(tmp_path, nominal, slider_log(offset=6.0), capsys=capsys)
    assert code == 0
    document = json.loads((out / 'diagnosis.json').read_text())
    assert document['verdict'] == 'ambiguous'
    (cause,) = document['causes']
    assert {cause['effect'], *cause['rivals']} >= {'effort_bias', 'asymmetric_friction'}
    assert 'free of load and at rest' in document['recommended_experiment']['condition']
    assert 'Next: ' in stdout


def test_an_effect_can_be_left_out_and_then_is_not_named(tmp_path, nominal, capsys):
    code, out, _, _ = run(
        tmp_path,
        nominal,
        slider_log(asymmetry=60.0, duration=16.0),
        '--without',
        'asymmetric_friction',
        capsys=capsys,
    )
    assert code == 0
    document = json.loads((out / 'diagnosis.json').read_text())
    assert all(cause['effect'] != 'asymmetric_friction' for cause in document['causes'])


def test_bad_data_end_with_code_1_and_a_sentence(tmp_path, nominal, capsys):
    log = slider_log(duration=1.5)
    code, out, _, stderr = run(tmp_path, nominal, log, capsys=capsys)
    assert code == 1
    assert 'usable samples over 1.5 s' in stderr
    assert json.loads((out / 'diagnosis.json').read_text())['verdict'] == 'bad_data'


def test_bad_input_ends_with_code_2_and_writes_nothing(tmp_path, nominal, capsys):
    code, out, _, stderr = run(
        tmp_path, nominal, slider_log(duration=3.0), '--without', 'stiction', capsys=capsys
    )
    assert code == 2
    assert 'stiction' in stderr
    assert not out.exists()


def test_a_recording_left_out_that_is_too_short_is_refused_before_anything_is_done(
    tmp_path, nominal, capsys
):
    other = write_joint_log(slider_log(duration=1.5), tmp_path / 'other')
    code, out, _, stderr = run(
        tmp_path, nominal, slider_log(duration=12.0), '--holdout', str(other), capsys=capsys
    )
    assert code == 2
    assert 'holdout' in stderr
    assert not out.exists()


def test_the_schema_knows_every_effect():
    definitions = json.loads(SCHEMA.read_text())['$defs']
    known = set(definitions['effect']['enum'])
    assert {*searched_terms(), *DATA_CAUSES} == known
    # A bias of friction is a constant of the law, and no term that may be off as stated.
    stated = set(definitions['term']['anyOf'][1]['enum'])
    assert {*TERMS.classes} - known - {'bias'} == stated
