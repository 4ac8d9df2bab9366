# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A model leaves the package: what a target holds is read back, what it cannot is said."""

from __future__ import annotations

import csv
import io
import json
import math
import sys
import types
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import jsonschema
import numpy as np
import pytest

from sosml_friction.cli.main import main
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.export.common.motion import KnownMotion
from sosml_friction.export.common.target import TARGETS, ExportTarget, entries
from sosml_friction.model.model_folder import parse_model, read_model
from sosml_friction.model.parameter import Parameter
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.term import TERMS
from sosml_friction.share import share_directory

FOLDER = share_directory() / 'config/emulated_exoskeleton'
SCHEMA = Path(__file__).resolve().parents[2] / 'docs/schema/export.schema.json'


@pytest.fixture
def model():
    return read_model(FOLDER)


@pytest.mark.parametrize('name', sorted(TARGETS))
def test_every_target_says_what_it_is_and_writes_text(model, name):
    target = TARGETS[name]()
    assert target.identifier == name
    assert target.file
    assert target.text(model)
    assert target.holds_all == (target.lost(model) == [])


def test_terms_name_targets_that_exist():
    for kind in TERMS.classes.values():
        assert set(kind.held_by) <= set(TARGETS)


def test_urdf_has_friction_and_damping_and_says_what_is_lost(model):
    import pinocchio

    text = TARGETS['urdf']().text(model)
    read = pinocchio.buildModelFromXML(text)
    order = [read.getJointId(name) - 1 for name in model.joint_names]
    assert [read.damping[i] for i in order] == [0.35, 0.20]
    assert [read.friction[i] for i in order] == [0.80, 0.40]
    assert Robot(text, model.joint_names, [0.0, 0.0]).limits
    lost = TARGETS['urdf']().lost(model)
    assert lost == ['stribeck of shoulder', 'stribeck of elbow', 'armature of shoulder',
                    'armature of elbow']  # fmt: skip
    assert all(part in text for part in lost)


def test_the_table_has_every_number_to_the_last_digit(model):
    rows = list(csv.DictReader(io.StringIO(TARGETS['csv']().text(model))))
    found = {(r['joint'], r['term'], r['parameter']): float(r['value']) for r in rows}
    for entry in entries(model):
        assert found[entry.joint, entry.term, entry.name] == entry.parameter.value
    assert found['shoulder', 'body', 'armature'] == 0.0054


def test_a_target_from_outside_is_found(model):
    class Names(ExportTarget):
        identifier: ClassVar[str] = 'names'
        file: ClassVar[str] = 'names.txt'
        holds_all: ClassVar[bool] = True

        def text(self, model):
            return ' '.join(model.joint_names)

    try:
        assert TARGETS['names']().text(model) == 'shoulder elbow'
    finally:
        TARGETS.remove('names')


def test_the_command_writes_and_says_what_is_lost(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(['export', str(FOLDER), '--to', 'urdf']) == 0
    assert 'stribeck of shoulder' in capsys.readouterr().out
    assert (tmp_path / 'robot.urdf').exists()
    assert main(['export', str(FOLDER), '--to', 'urdf']) == 2
    assert 'exists' in capsys.readouterr().err
    assert main(['export', str(FOLDER), '--to', 'word']) == 2
    assert (
        "'word' is unknown: use one of csv, isaaclab, json, latex, mjcf" in capsys.readouterr().err
    )


def test_a_model_without_urdf_is_refused(model):
    bare = parse_model(model.to_yaml(), 'text')
    with pytest.raises(ConfigurationError, match='has no URDF'):
        TARGETS['urdf']().text(bare)


def test_ros2_control_has_every_number_of_a_joint(model):
    root = ElementTree.fromstring(TARGETS['ros2-control']().text(model))
    joints = {x.get('name'): x for x in root.find('ros2_control').findall('joint')}
    values = {p.get('name'): float(p.text) for p in joints['shoulder'].findall('param')}
    assert values['armature'] == 0.0054
    assert values['stribeck.stribeck_velocity'] == 0.03
    assert joints['elbow'].find('command_interface').get('name') == 'effort'
    # Its dynamics are those of the URDF target, which Pinocchio reads.
    assert root.find("joint[@name='shoulder']/dynamics").get('friction') == '0.8'


def test_sdf_has_the_joints_dynamics(model):
    root = ElementTree.fromstring(TARGETS['sdf']().text(model))
    dynamics = root.find("model/joint[@name='elbow']/axis/dynamics")
    assert {x.tag: float(x.text) for x in dynamics} == {'damping': 0.2, 'friction': 0.4}


def test_isaac_lab_gets_physx_friction_and_keeps_its_gains(model, monkeypatch):
    module = types.ModuleType('isaaclab.actuators')
    module.ImplicitActuatorCfg = dict
    monkeypatch.setitem(sys.modules, 'isaaclab', types.ModuleType('isaaclab'))
    monkeypatch.setitem(sys.modules, 'isaaclab.actuators', module)
    names = {}
    exec(compile(TARGETS['isaaclab']().text(model), 'actuators.py', 'exec'), names)
    shoulder = names['ACTUATORS']['shoulder']
    assert shoulder == {
        'joint_names_expr': ['shoulder'], 'stiffness': None, 'damping': None, 'friction': 1.3,
        'dynamic_friction': 0.8, 'viscous_friction': 0.35, 'armature': 0.0054,
    }  # fmt: skip


def test_usd_gives_a_stage_physx_friction_and_leaves_the_rest(model, tmp_path):
    usd, physics, sdf, tf = (
        pytest.importorskip(f'pxr.{name}') for name in ('Usd', 'UsdPhysics', 'Sdf', 'Tf')
    )
    shoulder, elbow = model.joints.values()
    unknown = replace(elbow, armature=replace(elbow.armature, value=math.nan))
    names = ('shoulder', '2nd joint-ä')
    renamed = replace(model, joints=dict(zip(names, (shoulder, unknown), strict=True)))
    (tmp_path / 'joints.usda').write_text(TARGETS['usd']().text(renamed), encoding='utf-8')
    own = usd.Stage.CreateNew(str(tmp_path / 'robot.usda'))
    place = f'/{tf.MakeValidIdentifier(model.name)}/joints'
    for name in names:
        joint = physics.RevoluteJoint.Define(own, f'{place}/{tf.MakeValidIdentifier(name)}')
        # What the stage had before.
        joint.GetPrim().CreateAttribute(
            'physxJointAxis:angular:armature', sdf.ValueTypeNames.Float
        ).Set(0.1)
    own.Save()
    stage = usd.Stage.CreateNew(str(tmp_path / 'both.usda'))
    stage.GetRootLayer().subLayerPaths[:] = ['joints.usda', 'robot.usda']
    for name in names:
        joint = stage.GetPrimAtPath(f'{place}/{tf.MakeValidIdentifier(name)}')
        assert joint.GetTypeName() == 'PhysicsRevoluteJoint'
        schemas = joint.GetMetadata('apiSchemas').GetAppliedItems()
        assert schemas == ['PhysxJointAxisAPI:angular']
        values = {
            x.GetName().removeprefix('physxJointAxis:angular:'): x.Get()
            for x in joint.GetAttributes()
            if x.GetName().startswith('physxJointAxis')
        }
        if name == 'shoulder':
            assert values == pytest.approx({
                'armature': 0.0054, 'dynamicFrictionEffort': 0.8, 'staticFrictionEffort': 1.3,
                'viscousFrictionCoefficient': math.radians(0.35),
            })  # fmt: skip
    # An armature that the model does not know is that of the stage.
    assert values['armature'] == pytest.approx(0.1)
    alike = replace(model, joints=dict(zip(('a b', 'a-b'), (shoulder, elbow), strict=True)))
    with pytest.raises(ConfigurationError, match='joints a b and a-b are both a_b in USD'):
        TARGETS['usd']().text(alike)


def test_json_is_a_model_again(model):
    document = json.loads(TARGETS['json']().text(model))
    assert document.pop('urdf') == model.urdf
    assert parse_model(json.dumps(document), 'text') == replace(model, urdf=None)


def test_what_is_lost_costs_what_the_constants_leave(model):
    # At two speeds either way two constants meet the law; at many they cannot.
    few, many = np.array([-0.5, -0.1, 0.1, 0.5]), np.linspace(-1.0, 1.0, 100)
    for speeds, least, most in ((few, 0.0, 1e-3), (many, 0.02, 0.1)):
        target = TARGETS['urdf'](KnownMotion('these', speeds={'shoulder': speeds}))
        held = target.held(model)['shoulder']
        assert least <= held.error / held.friction <= most
    C, B = held.constants.values()
    law = 0.8 + 0.5 * np.exp(-np.abs(many) / 0.03) + 0.35 * np.abs(many)
    wrong = law - C - B * np.abs(many)
    assert held.error == pytest.approx(np.sqrt(np.mean(wrong**2)))
    (said, silent) = (line for line in target.losses(model))
    assert 'shoulder: without stribeck the effort is wrong by' in said
    assert 'on these, with constants refitted there' in said
    assert silent.startswith('elbow: what stribeck would cost is not known')
    assert said in target.text(model)


def test_constants_that_one_speed_cannot_tell_apart_stay(model):
    joint = model.joints['shoulder']
    own = {**joint.friction.parameters, 'bias': Parameter(-2e-4, 'Nm')}
    own['stribeck'] = Parameter(0.0, 'Nm')
    joint = replace(joint, friction=replace(joint.friction, parameters=own))
    model = replace(model, joints={**model.joints, 'shoulder': joint})
    # C + 0.12 and B - 0.4, or the other way, would stand for the bias without an error.
    speeds = np.array([0.300, -0.301])
    held = TARGETS['urdf'](KnownMotion('these', speeds={'shoulder': speeds})).held(model)
    constants = held['shoulder'].constants
    assert constants == pytest.approx({'coulomb': 0.8, 'viscous': 0.35}, rel=0.01)
    assert held['shoulder'].error == pytest.approx(2e-4, rel=0.01)


def test_intervals_are_in_the_file(model):
    known = Parameter(0.8, 'Nm', 0.01)
    joint = model.joints['shoulder']
    parameters = {**joint.friction.parameters, 'coulomb': known}
    joint = replace(joint, friction=replace(joint.friction, parameters=parameters))
    model = replace(model, joints={**model.joints, 'shoulder': joint})
    for name in ('urdf', 'sdf', 'mjcf', 'isaaclab', 'ros2-control', 'usd'):
        assert 'shoulder coulomb coulomb: 0.8 [0.7804, 0.8196] Nm' in TARGETS[name]().text(model)


def test_the_json_of_the_command_obeys_its_schema(tmp_path, capsys):
    out = tmp_path / 'new' / 'robot.urdf'
    assert main(['export', str(FOLDER), '--to', 'urdf', '--out', str(out), '--json']) == 0
    document = json.loads(capsys.readouterr().out)
    jsonschema.validate(document, json.loads(SCHEMA.read_text()))
    assert document['lost'][0] == 'stribeck of shoulder'
    # No motion is known: the limits of the URDF say how fast it may be.
    assert "on all velocities up to the URDF's limits" in document['losses'][0]
