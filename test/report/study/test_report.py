# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The study's document, tables, figures and files."""

import dataclasses
import io
import json
import math
import re
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text
from rich.console import Console

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.report.common.drawing import to_png
from sosml_friction.report.common.figure import figures, figures_of
from sosml_friction.report.common.output import check_output_folder
from sosml_friction.report.study import results as study_results
from sosml_friction.report.study.results import (
    render_study,
    study_document,
    study_kind,
    write_study,
)
from sosml_friction.report.study.tables import rmse_text, settle_text, short, study_tables
from sosml_friction.report.study.view import findings, shown_observers
from sosml_friction.study.metrics import Score
from sosml_friction.study.outcome import ranked

FIGURES = {figure.identifier: figure for figure in figures('study')}
SCHEMA = Path(__file__).resolve().parents[3] / 'docs' / 'schema' / 'study.schema.json'


@pytest.fixture(scope='module')
def document(tiny_study):
    return study_document(tiny_study)


@pytest.fixture(scope='module')
def nominal_only(tiny_study):
    """Return the part of the study that is the slow motion without noise."""
    case = ('slow', 'nominal')
    return dataclasses.replace(
        tiny_study,
        settings=dataclasses.replace(
            tiny_study.settings, motions=('slow',), conditions=('nominal',)
        ),
        rows=[
            row
            for row in tiny_study.rows
            if (row.motion, row.condition) == case and row.tuning == 'case'
        ],
        observations={case: tiny_study.observations[case]},
        floors={case: tiny_study.floors[case]},
        sweeps={},
    )


def check(document):
    jsonschema.validate(
        document, json.loads(SCHEMA.read_text()), cls=jsonschema.Draft202012Validator
    )


def text_of(renderable):
    console = Console(width=100, record=True, file=io.StringIO())
    console.print(renderable)
    return console.export_text()


def test_the_document_follows_its_schema(document, nominal_only):
    check(document)
    check(study_document(nominal_only))
    broken = json.loads(json.dumps(document))
    broken['rows'][0]['rmse']['mean'] = -1.0
    with pytest.raises(jsonschema.ValidationError):
        check(broken)


def test_the_document_has_a_row_for_each_case_observer_joint_and_tuning(document, tiny_study):
    keys = ('motion', 'condition', 'observer', 'joint', 'tuning')
    rows = {tuple(row[key] for key in keys): row for row in document['rows']}
    assert len(rows) == len(document['rows']) == 6 * 3 * 2 * 2
    row = rows['slow', 'noise', 'sosml', 'elbow', 'case']
    score = tiny_study.row(('slow', 'noise'), 'sosml').scores[1]
    assert row['rmse']['mean'] == pytest.approx(np.mean(score.rmse))
    assert row['rmse']['std'] == pytest.approx(np.std(score.rmse, ddof=1))
    assert row['rmse']['n'] == 3
    assert row['noise_std'] == score.noise_std
    assert row['gains']['linear'] == tiny_study.row(('slow', 'noise'), 'sosml').gains['linear'][1]
    row = rows['reversal', 'mismatch', 'kalman', 'shoulder', 'shared']
    score = tiny_study.row(('reversal', 'mismatch'), 'kalman', 'shared').scores[0]
    # The rms over M x 1.1 and x 0.9: there is no seed to be spread over.
    assert row['rmse'] == {
        'mean': pytest.approx(math.hypot(*score.rmse) / math.sqrt(2.0)),
        'std': None,
        'n': 1,
    }
    assert row['noise_std'] is None
    assert document['settings']['tuning_seeds'] == [101]
    assert document['settings']['scoring_seeds'] == [1, 2, 3]


def test_fitted_laws_are_near_the_truth_where_signals_are_exact(document):
    """The slow motion alone: C, S to 0.05, v_s to 0.005 for SOSML, which has hardly a lag."""
    (fit,) = [
        fit['parameters']
        for fit in document['fits']
        if (fit['motion'], fit['observer']) == ('slow', 'sosml')
    ]
    assert fit['coulomb'] == pytest.approx(0.8, abs=0.05)
    assert fit['stribeck'] == pytest.approx(0.5, abs=0.05)
    assert fit['stribeck_velocity'] == pytest.approx(0.03, abs=0.005)
    biased = [fit for fit in document['fits'] if fit['condition'] == 'mismatch']
    for fit in biased:
        # The gravity offset of 0.10 Nm goes into the bias and nowhere else.
        assert fit['parameters']['bias'] == pytest.approx(-0.1, abs=0.01)


@pytest.mark.parametrize('name', FIGURES)
def test_a_figure_is_a_picture_with_units_and_no_text_outside(tiny_study, name):
    figure = FIGURES[name].draw(tiny_study)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    words = [
        text for text in figure.findobj(Text) if text.get_text().strip() and text.get_visible()
    ]
    labels = ' '.join(text.get_text() for text in words)
    for unit in {'figure3_noise': ('[mNm]', '[s]'), 'pareto': ('[mNm]', '[ms]')}.get(
        name, ('[Nm]', '[rad/s]')
    ):
        assert unit in labels
    for axes in figure.axes:
        assert axes.lines or axes.patches
        for text in (axes.title, axes.xaxis.label, axes.yaxis.label):
            if text.get_text().strip():
                box = text.get_window_extent(renderer)
                assert figure.bbox.x0 <= box.x0 <= box.x1 <= figure.bbox.x1 + 1.0
                assert figure.bbox.y0 <= box.y0 <= box.y1 <= figure.bbox.y1 + 1.0
    legends = [*figure.legends, *(a.get_legend() for a in figure.axes if a.get_legend())]
    assert legends
    for legend in legends:
        box = legend.get_window_extent(renderer)
        assert box.x0 >= 0.0
        assert box.x1 <= figure.bbox.x1
        assert box.y1 <= figure.bbox.y1 + 1.0
    pixels = np.asarray(canvas.buffer_rgba())[..., :3]
    # White paper, and more on it than a frame.
    assert 0.01 < np.mean((pixels < 200).any(axis=-1)) < 0.6


def test_figure_3_states_the_error_of_each_observer(tiny_study):
    figure = FIGURES['figure3_noise'].draw(tiny_study)
    said = [t.get_text() for axes in figure.axes[::2] for t in axes.get_legend().get_texts()]
    for case, words in ((('slow', 'noise'), said[:3]), (('reversal', 'noise'), said[3:])):
        errors = [
            1e3 * np.mean(tiny_study.row(case, n).scores[0].rmse) for n in ranked(tiny_study, case)
        ]
        for word, error in zip(reversed(words), errors, strict=True):
            assert f'RMSE {error:.3g} mNm' in word


def test_figures_of_cases_that_were_not_run_are_left_out(tiny_study, nominal_only):
    assert [figure.identifier for figure in figures_of('study', tiny_study)] == list(FIGURES)
    (one,) = figures_of('study', nominal_only)
    assert one.identifier == 'figure2_slow_nominal'
    assert to_png(FIGURES['figure2_slow_nominal'].draw(nominal_only)).startswith(b'\x89PNG')


def test_figures_show_the_papers_two_and_the_best_other(tiny_study):
    assert set(shown_observers(tiny_study, ('reversal', 'noise'))) == {
        'first_order_capped',
        'sosml',
        'kalman',
    }


def test_the_tables_name_every_observer_and_the_floor(tiny_study):
    text = text_of(study_tables(tiny_study))
    for words in ('FO capped', 'SOSML', 'Kalman', 'offset floor', 'shoulder', 'elbow', 'one gain'):
        assert words in text
    row = tiny_study.row(('slow', 'noise'), 'sosml').scores[0]
    assert rmse_text('noise', row) in text
    assert 'nan' not in text.lower()
    assert max(len(line.rstrip()) for line in text.splitlines()) <= 100


def test_numbers_that_are_not_known_are_a_dash():
    unknown = Score(np.array([np.nan]), math.nan, math.nan, math.nan)
    assert rmse_text('noise', unknown) == settle_text(unknown) == short(math.nan) == '-'
    diverged = Score(np.array([1e9]), 1e9, 0.01, 0.0)
    assert rmse_text('nominal', diverged) == '-'
    assert rmse_text('noise', Score(np.array([0.03, 0.04]), 0.0, 0.0, 0.0)) == '35.0 (7.1)'
    assert settle_text(diverged) == '10'


def test_findings_say_who_is_best_and_what_sliding_is_worth(tiny_study, nominal_only):
    sentences = findings(tiny_study)
    assert len(sentences) == 3
    best = ranked(tiny_study, ('reversal', 'noise'))[0]
    assert {'kalman': 'Kalman', 'sosml': 'SOSML'}[best] in sentences[1]
    assert 'times the RMSE of FO capped' in sentences[1]
    assert 'one gain set' in sentences[2]
    assert findings(nominal_only) == []


def test_the_report_holds_every_case_and_its_pictures(tiny_study):
    html = render_study(tiny_study, {'pareto': FIGURES['pareto'].draw(tiny_study)})
    # Each case, the method and the observers are folded.
    assert html.count('<details>') == 6 + 2
    assert html.count('<figure') == html.count('<svg') == 1
    assert 'disturbance_rate' in html
    assert not re.search(r'>[^<]*\bnan\b', html.partition('<script>')[0])


def test_files_appear_together_and_an_earlier_study_is_replaced(
    tiny_study, nominal_only, document, tmp_path
):
    folder = tmp_path / 'deep' / 'study'
    named = []
    assert write_study(folder, tiny_study, document, named.append) == folder
    assert named == list(FIGURES)
    pictures = {f'{name}.png' for name in FIGURES}
    assert {path.name for path in folder.iterdir()} == pictures | {'study.json', 'study.html'}
    for name in pictures:
        assert (folder / name).read_bytes().startswith(b'\x89PNG')
    check(json.loads((folder / 'study.json').read_text()))
    (folder / 'notes.txt').write_text('mine')
    # Figures that the new study does not have would be of the old one.
    write_study(folder, nominal_only, study_document(nominal_only))
    assert {path.name for path in folder.iterdir()} == {
        'study.json', 'study.html', 'figure2_slow_nominal.png', 'notes.txt',
    }  # fmt: skip
    assert [path.name for path in folder.parent.iterdir()] == ['study']


def test_something_else_is_not_overwritten(tmp_path):
    (tmp_path / 'thesis.tex').write_text('mine')
    with pytest.raises(ConfigurationError, match='earlier study, so it is not overwritten'):
        check_output_folder(tmp_path, study_kind())
    (tmp_path / 'study.json').write_text('{"format": "something/else"}')
    with pytest.raises(ConfigurationError, match='not overwritten'):
        check_output_folder(tmp_path, study_kind())
    assert check_output_folder(tmp_path / 'new', study_kind()) == tmp_path / 'new'


def test_an_interruption_leaves_what_was_there(nominal_only, tmp_path, monkeypatch):
    folder = tmp_path / 'study'
    write_study(folder, nominal_only, study_document(nominal_only))
    before = {path.name: path.read_bytes() for path in folder.iterdir()}

    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(study_results, 'render_study', interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_study(folder, nominal_only, {})
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    assert list(tmp_path.iterdir()) == [folder]
