# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The result of a fit as files: complete or absent, and never in place of something else."""

import dataclasses
import json
import math
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.ripple import PlateauRipple
from sosml_friction.identification.several.bag_roles import BagRole
from sosml_friction.model.model_folder import read_model
from sosml_friction.model.parameter import Parameter
from sosml_friction.plain_document import to_plain
from sosml_friction.report.common.output import check_output_folder, to_json
from sosml_friction.report.fit import results

SCHEMA = Path(__file__).resolve().parents[3] / 'docs' / 'schema' / 'fit.schema.json'


@pytest.fixture
def quick_report(monkeypatch):
    """Replace the drawing of the report, which has its own tests."""

    monkeypatch.setattr(results, 'render_report', lambda *_: '<html></html>')


def check(document):
    jsonschema.validate(
        document,
        json.loads(SCHEMA.read_text()),
        cls=jsonschema.Draft202012Validator,
    )


def test_the_document_follows_its_schema(analysis, one_joint_analysis, truth):
    check(results.fit_document(analysis, truth))
    document = results.fit_document(one_joint_analysis)
    check(document)
    assert set(document['joints']) == {'shoulder'}
    assert set(document['unavailable']) == {'elbow'}


def test_the_document_says_why_a_joint_that_was_fitted_has_no_friction_in_the_model(analysis):
    why = 'its 95 % interval is 0 to 0.05 Nm s/rad, which does not leave out 0'
    fits = {}
    for observer, one in analysis.fit.joints['elbow'].items():
        unsure = {'viscous': Parameter.not_told('Nm s/rad', why)}
        law = dataclasses.replace(one.fit, parameters={**one.fit.parameters, **unsure})
        fits[observer] = dataclasses.replace(one, fit=law)
    elbow = dataclasses.replace(analysis.model.joints['elbow'], friction=None)
    unsure_one = dataclasses.replace(
        analysis,
        fit=dataclasses.replace(analysis.fit, joints={**analysis.fit.joints, 'elbow': fits}),
        model=dataclasses.replace(
            analysis.model, joints={**analysis.model.joints, 'elbow': elbow}
        ),
    )
    document = results.fit_document(unsure_one)
    check(document)
    assert document['unavailable']['elbow'] == f'viscous is not identifiable: {why}'
    assert 'elbow' not in document['model']
    assert 'elbow' in document['joints']


def test_the_schema_refuses_what_is_not_a_fit(analysis):
    document = results.fit_document(analysis)
    document['joints']['shoulder']['sosml']['parameters']['coulomb']['value'] = 'much'
    with pytest.raises(jsonschema.ValidationError):
        check(document)


def test_the_document_has_the_ripple_of_each_plateau_and_null_where_it_is_hidden(analysis):
    seen = PlateauRipple(0.5, 1.5, 0.03, 0.01, 1e-3, 7e-5, 3e-3, 1e-9, 24.0, 'limit cycle', 2e-3)
    hidden = PlateauRipple(2.0, 3.0, 0.01, *([math.nan] * 4), 1.0, math.nan)
    plateaus = {'shoulder': (seen, hidden), 'elbow': ()}
    document = results.fit_document(dataclasses.replace(analysis, ripple=plateaus))
    check(document)
    first, second = document['ripple']['shoulder']
    assert (first['ripple'], first['kind'], first['bias']) == (0.01, 'limit cycle', 2e-3)
    assert second['ripple'] is None


def test_the_document_has_the_numbers_of_the_fit_and_the_truth(analysis, truth):
    document = results.fit_document(analysis, truth)
    for joint, fits in analysis.fit.joints.items():
        for observer, fit in fits.items():
            entry = document['joints'][joint][observer]['parameters']['viscous']
            assert entry['value'] == fit.fit.parameters['viscous'].value
            assert entry['std_error'] == fit.fit.parameters['viscous'].std_error
    assert document['truth']['elbow']['coulomb'] == {'value': 0.4, 'unit': 'Nm'}
    assert document['model'] == {'shoulder': 'sosml', 'elbow': 'sosml'}


@settings(deadline=None)
@given(
    st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
        lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    )
)
def test_json_never_holds_nan(value):
    text = to_json({'value': value})
    assert json.loads(text, parse_constant=pytest.fail)['value'] is not NotImplemented


def test_numpy_becomes_plain():
    plain = to_plain({'a': np.array([1.0, math.nan]), 'b': np.int64(3), 'c': (np.float64(2),)})
    assert plain == {'a': [1.0, None], 'b': 3, 'c': [2.0]}


def test_a_result_becomes_what_it_says_and_another_dataclass_its_fields():
    parameter = Parameter(1.0, 'Nm', flags=('at_bound',))
    plain = to_plain({'parameter': parameter, 'role': BagRole('T1', 'stated', 'as told')})
    assert plain['parameter'] == {
        'value': 1.0, 'std_error': None, 'unit': 'Nm', 'flags': ['at_bound'],
    }  # fmt: skip
    assert plain['role'] == {'role': 'T1', 'source': 'stated', 'reason': 'as told'}


def test_all_files_are_written_and_the_model_can_be_loaded(analysis, truth, tmp_path):
    folder = results.write_results(tmp_path / 'new' / 'fit', analysis, truth)
    assert sorted(p.name for p in folder.iterdir()) == sorted(results.KIND.files)
    model = read_model(folder)
    law = model.joints['shoulder'].friction.make_law()
    assert (
        law.parameters['coulomb']
        == analysis.fit.joints['shoulder']['sosml'].fit.parameters['coulomb'].value
    )
    check(json.loads((folder / 'fit.json').read_text()))
    assert [p.name for p in (tmp_path / 'new').iterdir()] == ['fit']


@pytest.mark.usefixtures('quick_report')
def test_an_earlier_fit_is_replaced_and_other_files_are_kept(analysis, tmp_path):
    folder = results.write_results(tmp_path / 'fit', analysis)
    (folder / 'report.html').write_text('older')
    (folder / 'notes.txt').write_text('mine')
    results.write_results(folder, analysis)
    assert (folder / 'report.html').read_text() != 'older'
    assert (folder / 'notes.txt').read_text() == 'mine'


@pytest.mark.usefixtures('quick_report')
@pytest.mark.parametrize('content', ['model.yaml', 'fit.json', 'thesis.txt'])
def test_a_folder_of_something_else_is_refused_and_kept(analysis, tmp_path, content):
    (tmp_path / content).write_text('{}')
    with pytest.raises(ConfigurationError, match='not the result of an earlier fit'):
        results.write_results(tmp_path, analysis)
    assert [p.name for p in tmp_path.iterdir()] == [content]
    assert (tmp_path / content).read_text() == '{}'


def test_a_file_in_the_place_of_the_folder_is_refused(tmp_path):
    (tmp_path / 'fit').write_text('')
    with pytest.raises(ConfigurationError, match='not the result'):
        check_output_folder(tmp_path / 'fit', results.KIND)


def test_an_interruption_leaves_nothing(analysis, tmp_path):
    def interrupt(step):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        results.write_results(tmp_path / 'fit', analysis, progress=interrupt)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures('quick_report')
def test_a_place_that_cannot_be_written_is_one_sentence(analysis, tmp_path):
    (tmp_path / 'file').write_text('')
    with pytest.raises(ConfigurationError, match=r'cannot be (read|written).*another place'):
        results.write_results(tmp_path / 'file' / 'fit', analysis)


@pytest.mark.usefixtures('quick_report')
def test_an_interruption_leaves_the_earlier_fit(analysis, tmp_path, monkeypatch):
    folder = results.write_results(tmp_path / 'fit', analysis)
    before = {p.name: p.read_bytes() for p in folder.iterdir()}

    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(results, 'fit_document', interrupt)
    with pytest.raises(KeyboardInterrupt):
        results.write_results(folder, analysis)
    assert {p.name: p.read_bytes() for p in folder.iterdir()} == before
    assert [p.name for p in tmp_path.iterdir()] == ['fit']
