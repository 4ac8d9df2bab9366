# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""``sosml study``: files, tables, and settings that cannot be."""

import json

import pytest
from slider_bags import checked

SMALL_STUDY = (
    'study',
    '--quick',
    '--evaluations=4',
    '--motions=slow',
    '--conditions=nominal,noise',
    '--observers=first_order_capped, sosml',
    '--processes=1',
)


def test_study_prints_one_json_object_and_writes_it(sosml, tmp_path):
    code, out, err = sosml(*SMALL_STUDY, '--bits=19', '--json')
    assert (code, err) == (0, '')
    document = checked(out, 'study')
    assert document['output'] == 'study_output'
    assert document['settings']['evaluations'] == 4
    # --quick where nothing else is said.
    assert document['settings']['scoring_seeds'] == [1, 2]
    assert document['settings']['plant_step_s'] == 200e-6
    assert document['settings']['bits'] == 19
    assert document['settings']['observers'] == ['first_order_capped', 'sosml']
    assert {row['rmse']['n'] for row in document['rows']} == {1, 2}
    del document['output']
    folder = tmp_path / 'study_output'
    assert json.loads((folder / 'study.json').read_text()) == document
    names = {path.name for path in folder.iterdir()}
    pictures = {'figure2_slow_nominal.png', 'figure3_noise.png'}
    assert names == {'study.json', 'study.html', *pictures}


def test_study_prints_tables_and_where_the_report_is(sosml, tmp_path):
    code, out, err = sosml(*SMALL_STUDY, '--conditions=nominal', '--out=here')
    assert (code, err) == (0, '')
    assert 'RMSE [mNm] of the shoulder' in out
    assert 'FO capped' in out
    assert out.rstrip().endswith('study.html, study.json and the figures are in here')
    assert (tmp_path / 'here' / 'study.html').is_file()


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        (['--observers', 'sosml,magic'], "observer 'magic' is not in the study: use "),
        (['--motions', 'fast'], "motion 'fast' is not in the study: use slow, reversal"),
        (['--conditions', ''], "condition '' is not in the study"),
        (['--seeds', '0'], 'the number of seeds is 0: use 1 to 100'),
        (['--tuning-seeds', '101'], 'the number of tuning seeds is 101'),
        (['--evaluations', '3'], 'the number of evaluations is 3'),
        (['--evaluations', 'many'], '--evaluations'),
        (['--bits', '40'], 'the number of bits is 40: use 8 to 24'),
        (['--processes', '0'], 'the number of processes is 0'),
    ],
)
def test_a_study_that_cannot_be_is_refused(refused, arguments, words):
    assert words in refused('study', *arguments)


def test_study_does_not_overwrite_something_else(refused, tmp_path):
    (tmp_path / 'thesis').mkdir()
    (tmp_path / 'thesis' / 'study.json').write_text('{"mine": 1}')
    assert 'earlier study' in refused('study', '--out', 'thesis')


@pytest.mark.parametrize('stage', ['run_study', 'write_study'])
def test_ctrl_c_in_a_study_ends_with_130_and_nothing_written(sosml, tmp_path, monkeypatch, stage):
    from sosml_friction.report.study import results as study_results
    from sosml_friction.study import run as study_run

    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(study_run if stage == 'run_study' else study_results, stage, interrupt)
    code, out, err = sosml(*SMALL_STUDY, '--conditions=nominal')
    assert (code, out, err.strip()) == (130, '', 'sosml: interrupted')
    assert list(tmp_path.iterdir()) == []
