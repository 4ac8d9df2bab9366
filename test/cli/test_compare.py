# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Two models side by side: what differs beyond its intervals is said to, and nothing else."""

import json
from dataclasses import replace
from pathlib import Path

import jsonschema
import pytest

from sosml_friction.model.model_folder import read_model
from sosml_friction.model.parameter import NOT_IDENTIFIABLE, Parameter
from sosml_friction.report.comparison.comparison import AGREE, DIFFER, NO_INTERVAL, Pair
from sosml_friction.share import share_directory

ROOT = Path(__file__).resolve().parents[2]


def pair(first, second):
    return Pair('shoulder', 'coulomb', first, second)


def known(value, error=float('nan')):
    return Parameter(value, 'Nm', error)


@pytest.mark.parametrize(
    ('first', 'second', 'verdict'),
    [
        # 1.96 sqrt(0.03^2 + 0.04^2) is 0.098.
        (known(1.0, 0.03), known(1.097, 0.04), AGREE),
        (known(1.0, 0.03), known(1.099, 0.04), DIFFER),
        # A number without an interval is taken for exact.
        (known(1.0, 0.03), known(1.05), AGREE),
        (known(1.0, 0.03), known(1.07), DIFFER),
        (known(1.0), known(2.0), NO_INTERVAL),
    ],
)
def test_a_difference_is_held_against_both_intervals(first, second, verdict):
    assert pair(first, second).verdict == verdict
    assert pair(second, first).verdict == verdict


@pytest.mark.parametrize(('low', 'high', 'verdict'), [(0.5, 2.0, AGREE), (1.2, 2.0, DIFFER)])
def test_a_range_that_does_not_have_the_other_interval_differs(low, high, verdict):
    open_one = Parameter(float('nan'), 'Nm', interval=(low, high), flags=(NOT_IDENTIFIABLE,))
    assert pair(open_one, known(1.0, 0.05)).verdict == verdict
    assert pair(known(1.0, 0.05), open_one).verdict == verdict


@pytest.fixture
def folders(tmp_path):
    """Return two model folders that differ in one parameter of one joint."""
    model = read_model(share_directory() / 'config' / 'emulated_exoskeleton')
    shoulder = model.joints['shoulder']
    own = shoulder.friction.parameters

    def written(name, coulomb):
        changed = {**own, 'coulomb': replace(own['coulomb'], value=coulomb, std_error=0.01)}
        friction = replace(shoulder.friction, parameters=changed)
        joints = {**model.joints, 'shoulder': replace(shoulder, friction=friction)}
        replace(model, joints=joints).write(tmp_path / name)
        return tmp_path / name

    return written('monday', 0.8), written('friday', 0.9)


def test_the_parameter_that_differs_is_named(sosml, folders):
    code, out, err = sosml('compare', *map(str, folders))
    assert (code, err) == (0, '')
    assert 'They differ beyond their 95 % intervals in coulomb of shoulder;' in out
    assert '0.800 ± 0.020' in out
    code, out, _ = sosml('compare', str(folders[0]), str(folders[0]))
    assert 'They agree' in out


def test_json_has_both_and_follows_its_schema(sosml, folders):
    code, out, _ = sosml('compare', *map(str, folders), '--json')
    document = json.loads(out)
    schema = json.loads((ROOT / 'docs' / 'schema' / 'compare.schema.json').read_text())
    jsonschema.validate(document, schema)
    (found,) = [x for x in document['parameters'] if x['verdict'] == 'differ']
    assert (found['joint'], found['name']) == ('shoulder', 'coulomb')
    assert found['difference'] == pytest.approx(0.1)
    assert found['half_width'] == pytest.approx(1.96 * 0.01 * 2**0.5, rel=1e-3)
    assert code == 0


def test_models_of_other_robots_are_refused(sosml, folders):
    code, out, err = sosml('compare', str(folders[0]), str(share_directory() / 'config' / 'emps'))
    assert (code, out) == (2, '')
    assert 'compare models of the same robot' in err
