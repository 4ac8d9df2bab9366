# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""``sosml fit --terms``: a model folder, a report and JSON of any list of terms."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import sosml_friction as sf
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.cli.main import main
from sosml_friction.model.model_folder import read_model
from validation import plant as bp
from validation.motion import reference
from validation.trial import JOINTS, nominal_model

SCHEMA = Path(__file__).resolve().parents[2] / 'docs/schema/term_fit.schema.json'
TERMS = 'coulomb,viscous,load_dependent_friction@elbow'


@pytest.fixture(scope='module')
def log():
    """Return 70 s of the blind plant, whose elbow has friction by load."""
    plant = bp.Plant()
    plant.joint['load'][:] = [0.0, 0.08]
    run = bp.simulate(plant, *reference('rich', 70.0), np.random.default_rng(8), bp.Noise())
    return JointLog(JOINTS, np.rint(run.t * 1e9).astype(np.int64), run.q, run.v, run.tau)


@pytest.fixture(scope='module')
def folder(log, tmp_path_factory):
    where = tmp_path_factory.mktemp('terms')
    model = nominal_model()
    write_joint_log(log, where / 'bag', model.urdf)
    model.write(where / 'nominal')
    return where


@pytest.fixture(scope='module')
def fitted(folder):
    """Return the folder of a fit."""
    out = folder / 'fitted'
    model = str(folder / 'nominal')
    assert main(['fit', str(folder / 'bag'), '--model', model, '--terms', TERMS,
                 '--out', str(out)]) == 0  # fmt: skip
    return out


def test_the_document_follows_its_schema_and_the_model_has_the_terms(fitted):
    document = json.loads((fitted / 'fit.json').read_text())
    jsonschema.validate(document, json.loads(SCHEMA.read_text()))
    found = {(t['term'], t['joint']): t['parameters'] for t in document['terms']}
    k = found['load_dependent_friction', 'elbow']['load_coefficient']
    assert k['interval'][0] < 0.08 < k['interval'][1]
    (effect,) = read_model(fitted).effects
    assert effect.parameters['load_coefficient'].value == k['value']


def test_the_page_names_each_parameter_and_draws_each_term(fitted):
    page = (fitted / 'report.html').read_text()
    assert page.count('<svg') == 5
    for word in ('coulomb', 'viscous', 'load coefficient', 'shoulder', 'elbow'):
        assert word in page


def test_the_same_from_python(log, fitted):
    result = sf.fit(log, sf.Model(nominal_model()), terms=TERMS.split(','))
    document = json.loads((fitted / 'fit.json').read_text())
    assert result.to_dict()['terms'] == document['terms']
    assert 'load' in result.summary()
    assert set(result.conf_int()) == {
        'coulomb@shoulder', 'viscous@shoulder', 'coulomb@elbow', 'viscous@elbow',
        'load_dependent_friction@elbow',
    }  # fmt: skip


@pytest.mark.parametrize(
    ('given', 'words'),
    [
        (['--terms', 'lugre'], "term 'lugre' is unknown: use"),
        (['--law', 'm9'], "law is 'm9': use one of auto, coulomb_viscous, stribeck, m1"),
        (['--terms', 'coulomb@knee'], 'unknown joint'),
    ],
)
def test_what_nobody_knows_is_refused_in_one_sentence(folder, capsys, given, words):
    arguments = ['fit', str(folder / 'bag'), '--model', str(folder / 'nominal'), *given]
    assert main([*arguments, '--out', str(folder / 'none')]) == 2
    err = capsys.readouterr().err
    assert words in err
    assert len(err.splitlines()) == 1
    assert not (folder / 'none').exists()


def test_the_data_are_checked_as_for_any_fit(log, folder, tmp_path, capsys):
    """A joint that rests is named, and the other goes on; from Python too."""
    still = np.random.default_rng(4).normal(0.0, 1e-5, len(log))
    q, v, tau = log.q.copy(), log.v.copy(), log.tau.copy()
    q[:, 1], v[:, 1], tau[:, 1] = 0.2 + still, 0.0, 0.3
    part = JointLog(JOINTS, log.t_ns, q, v, tau)
    model = folder / 'nominal'
    write_joint_log(part, tmp_path / 'bag', read_model(model).urdf)
    told = {}
    for more in ([], ['--terms', 'coulomb,viscous']):
        out = str(tmp_path / f'out{len(more)}')
        assert (
            main(['fit', str(tmp_path / 'bag'), '--model', str(model), *more, '--out', out]) == 1
        )
        told[len(more)] = capsys.readouterr().err
    (rests,) = (line for line in told[0].splitlines() if 'rest' in line)
    assert rests in told[2].splitlines()
    result = sf.fit(part, sf.Model.read(model), terms=['coulomb', 'viscous'])
    assert set(result.conf_int()) == {'coulomb@shoulder', 'viscous@shoulder'}
    assert 'as resting' in result.to_dict()['left_out']['coulomb@elbow']


def test_a_rotor_that_is_not_known_is_fitted_with_the_terms(log):
    model = nominal_model()
    joints = {
        name: replace(joint, armature=replace(joint.armature, value=np.nan))
        for name, joint in model.joints.items()
    }
    unknown = sf.Model(replace(model, joints=joints))
    result = sf.fit(log, unknown, terms=TERMS.split(','))
    jsonschema.validate(result.to_dict(), json.loads(SCHEMA.read_text()))
    for name, joint in model.joints.items():
        low, high = result.model.content.joints[name].armature.interval
        assert low < joint.armature.value < high
        assert f'The armature of {name} was not stated' in result.summary()
