# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""``--mjcf``: MuJoCo as the plant, and as the model that is fitted or put to the test."""

from __future__ import annotations

import json
import re
from pathlib import Path

import mujoco
import numpy as np
import pytest
from jsonschema import Draft202012Validator

import sosml_friction as sf
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.bags.recorded_robot import read_recorded_robot
from sosml_friction.cli.main import main
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.mujoco import apply_friction
from sosml_friction.mujoco.reading import read_mjcf
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


def test_a_fit_takes_bodies_from_mjcf_and_finds_rotors_that_it_leaves_out(
    folder, monkeypatch, capsys
):
    monkeypatch.chdir(folder)
    own = Path('robot.xml').read_text()
    Path('bare.xml').write_text(re.sub(' armature="[^"]*"', '', own))
    # A robot_description beside the recording whose bodies are not those of the MJCF.
    Path('light.xml').write_text(own.replace('mass="2.2"', 'mass="0.5"'))
    log = simulate(Arm(), reference('multisine', 8.0), np.random.default_rng(5))
    write_joint_log(log, Path('described'), sf.Model.from_mjcf('light.xml').urdf)
    bare = read_mjcf('bare.xml', free_rotors=True)
    assert read_recorded_robot('described', bare).nominal.urdf == bare.urdf
    terms = ['coulomb', 'viscous']
    command = ['fit', 'described', '--mjcf', 'bare.xml', '--terms', ','.join(terms)]
    assert main([*command, '--out', 'fit', '--json']) == 0
    capsys.readouterr()
    of_log = sf.fit(log, mjcf='bare.xml', terms=terms).model.content
    for i, name in enumerate(JOINTS):
        armature = of_log.joints[name].armature
        assert abs(armature.value - Arm().armature[i]) < 3.0 * armature.std_error
        found = of_log.joints[name].friction.parameters
        assert found['coulomb'].value == pytest.approx(Arm().coulomb[i], rel=0.1)
        assert sf.Model.read('fit').parameters()[name]['coulomb'].value == pytest.approx(
            found['coulomb'].value, rel=1e-6
        )


def test_one_model_is_asked_for(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    log = sf.load('bag')
    for call in (sf.fit, sf.diagnose):
        with pytest.raises(ConfigurationError, match='give model or mjcf'):
            call(log)
    for command in ('fit', 'simulate', 'tune'):
        assert main([command, 'bag', '--mjcf', 'robot.xml', '--urdf', 'x']) == 2
        assert '--mjcf is the model: leave out --model, --urdf' in capsys.readouterr().err
