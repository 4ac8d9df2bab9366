# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A model leaves the package: what a target holds is read back, what it cannot is said."""

from __future__ import annotations

import csv
import io
from typing import ClassVar

import pytest

from sosml_friction.cli.main import main
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.export.common.target import TARGETS, ExportTarget, entries
from sosml_friction.model.model_folder import parse_model, read_model
from sosml_friction.model.robot import Robot
from sosml_friction.model.terms.kinds.term import TERMS
from sosml_friction.share import share_directory

FOLDER = share_directory() / 'config/emulated_exoskeleton'


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
    assert "'word' is unknown: use one of csv, latex, urdf" in capsys.readouterr().err


def test_a_model_without_urdf_is_refused(model):
    bare = parse_model(model.to_yaml(), 'text')
    with pytest.raises(ConfigurationError, match='has no URDF'):
        TARGETS['urdf']().text(bare)
