# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""``sosml diagnose --mjcf``: MuJoCo as the plant, and as the model that is put to the test."""

from __future__ import annotations

import json
from pathlib import Path

import mujoco
import numpy as np
import pytest
from jsonschema import Draft202012Validator

from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.cli.main import main
from sosml_friction.mujoco import apply_friction
from sosml_friction.report.diagnosis import document as document_of
from validation.motion import reference
from validation.mujoco_plant import JOINTS, Arm, hide, simulate

SCHEMA = Path(__file__).resolve().parents[2] / 'docs/schema/diagnosis.schema.json'


@pytest.fixture(scope='module')
def folder(tmp_path_factory):
    """Return a folder with a bag in which ripple is hidden, and an MJCF without any friction."""
    folder = tmp_path_factory.mktemp('mjcf')
    nothing = np.zeros(2)
    (folder / 'robot.xml').write_text(Arm().xml((nothing, nothing)))
    arm = hide(Arm(), 'cogging', 0, 1.5, np.random.default_rng(3))
    log = simulate(arm, reference('multisine', 20.0), np.random.default_rng(4))
    write_joint_log(log, folder / 'bag', None)
    return folder


def test_a_hidden_ripple_is_named_and_the_gain_is_mujocos_own(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    # The report is that of any diagnosis, and takes as long as all the rest.
    monkeypatch.setattr(document_of, 'render_diagnosis', lambda *_: '<p></p>')
    assert main(['diagnose', 'bag', '--mjcf', 'robot.xml', '--out', 'why', '--json']) == 0
    document = json.loads(capsys.readouterr().out)
    validator = Draft202012Validator(json.loads(SCHEMA.read_text()))
    assert not list(validator.iter_errors(document))
    assert document['verdict'] == 'named'
    (cause,) = document['causes']
    assert (cause['effect'], cause['joint']) == ('cogging', 'shoulder')
    assert document['provenance']['trust'] == {'friction': 'inf'}
    simulator = document['simulator']
    assert simulator['fitted_to']
    for own in simulator['joints'].values():
        assert own['inverse_after_percent'] < 0.5 * own['inverse_before_percent']
        assert own['forward_after'] < own['forward_before']
    assert 'In MuJoCo, on bag, to which the model was fitted' in document['sentence']
    m = mujoco.MjModel.from_xml_path('why/robot.xml')
    friction = apply_friction(m, mujoco.MjData(m))
    assert friction.content.joint_names == JOINTS
    # Its nominal had none: what was refitted is in it.
    np.testing.assert_allclose(m.dof_frictionloss, Arm().coulomb, rtol=0.1)
    np.testing.assert_allclose(m.dof_damping, Arm().viscous, rtol=0.2)
    assert len(m.actuator_trnid) == 1


def test_an_mjcf_is_the_model(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    assert main(['diagnose', 'bag', '--mjcf', 'robot.xml', '--model', 'x', '--out', 'no']) == 2
    assert '--mjcf is the model: leave out --model' in capsys.readouterr().err
    assert main(['diagnose', 'bag', '--mjcf', 'absent.xml', '--out', 'no']) == 2
    assert 'MJCF absent.xml cannot be read' in capsys.readouterr().err
    assert not Path('no').exists()
