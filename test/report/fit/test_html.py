# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The report stands alone, begins with the answer, and says what is doubtful."""

import dataclasses
import re
from html import escape

import pytest

from sosml_friction.identification.number_text import format_number
from sosml_friction.report.common import figure
from sosml_friction.report.common.table import Column, Markup, html_table
from sosml_friction.report.fit import html as report
from sosml_friction.report.fit.findings import joint_sentence, notes
from sosml_friction.report.fit.joint_view import joint_views


@pytest.fixture(scope='module')
def text(fit_page):
    return fit_page


@pytest.fixture
def quick(monkeypatch):
    """Leave out the drawing of the pictures, which has its own tests."""
    monkeypatch.setattr(figure, 'to_svg', lambda *drawn: '<svg></svg>')


def test_nothing_is_loaded_from_elsewhere(text):
    assert text.count('<svg') == 12
    # Only names within the page.
    assert set(re.findall(r'(?:src|href)\s*=\s*"(.)', text)) == {'#'}
    assert set(re.findall(r'url\((.)', text)) == {'#'}
    assert not re.search(r'@import|<script [^>]|<img|<link|<iframe', text)


def test_it_begins_with_a_sentence_that_has_the_numbers(text, analysis):
    beginning = text[text.index('<body>') : text.index('<h2>')]
    for joint, fits in analysis.fit.joints.items():
        coulomb = fits['sosml'].fit.parameters['coulomb']
        half = 0.5 * (coulomb.interval[1] - coulomb.interval[0])
        sentence = f'{format_number(coulomb.value, half)} ± {format_number(half, half)} Nm'
        assert re.search(rf'<strong>{joint}</strong>: {sentence} of Coulomb friction', beginning)


def test_it_has_the_truth_the_segments_and_the_provenance(text, analysis):
    assert '<td class="n">0.8</td>' in text
    used = [s for s in analysis.fit.joints['shoulder']['sosml'].segments if not s.rejected]
    assert f'<td class="n">{used[0].start_s:.2f}</td>' in text
    assert analysis.model.provenance['sha256'] in text
    assert 'positive for positive velocity' in text


def test_every_reason_of_a_window_not_used_is_in_it(text, rejecting_analysis):
    for fits in rejecting_analysis.fit.joints.values():
        reasons = {s.rejected for s in fits['sosml'].segments if s.rejected}
        assert len(reasons) >= 3
        for reason in reasons:
            assert f'<td class="l">{escape(reason)}</td>' in text


def test_every_picture_says_in_words_what_it_shows(text):
    told = re.findall(r'<svg [^>]*aria-label="([^"]*)"', text)
    assert len(told) == 12
    for joint in ('shoulder', 'elbow'):
        assert sum(f'joint {joint}' in one for one in told) == 6


def test_no_unknown_number_is_printed_as_such(text):
    visible = re.sub(
        r'<style>.*?</style>|<script>.*?</script>|<[^>]*>', ' ', text, flags=re.DOTALL
    )
    assert not re.search(r'\b(nan|inf|None)\b', visible)


@pytest.mark.usefixtures('quick')
def test_names_cannot_break_the_page(text, analysis):
    assert '&lt;7&gt;' in text
    assert '<7>' not in text
    named = dataclasses.replace(analysis.model, name='<script>alert(1)</script>')
    page = report.render_report(dataclasses.replace(analysis, model=named))
    assert '<script>alert' not in page


def test_methods_that_exclude_each_other_are_noted(analysis, truth):
    view = joint_views(analysis)[0]
    fit = view.fits['sosml']
    value = fit.fit.parameters['coulomb']
    far = dataclasses.replace(value, value=value.value + 9.0, interval=(8.9, 9.1))
    law = dataclasses.replace(fit.fit, parameters={**fit.fit.parameters, 'coulomb': far})
    other = dataclasses.replace(
        fit, method='samples' if fit.method == 'segments' else 'segments', fit=law
    )
    told = notes([dataclasses.replace(view, alternatives={'sosml': other})])
    assert any(note.startswith('shoulder (SOSML)') and 'coulomb' in note for note in told)
    same = dataclasses.replace(view, alternatives={'sosml': fit}, fits={'sosml': fit})
    assert notes([same]) == []


def test_a_truth_outside_the_interval_is_noted(analysis, truth):
    view = joint_views(analysis, truth)[1]
    wrong = dataclasses.replace(view.truth.parameters['viscous'], value=99.0)
    moved = dataclasses.replace(view.truth, parameters={**view.truth.parameters, 'viscous': wrong})
    told = notes([dataclasses.replace(view, truth=moved)])
    assert any('truth is outside' in note and 'viscous' in note for note in told)


@pytest.mark.usefixtures('quick')
def test_a_joint_without_fit_says_why(one_joint_analysis):
    page = report.render_report(one_joint_analysis)
    assert 'elbow</strong>: its friction is not available, because the recording has no' in page
    assert 'nan' not in joint_sentence(joint_views(one_joint_analysis)[1])


def test_a_table_has_a_class_for_each_column_and_no_markup_of_its_texts():
    text = html_table({'joint': '', 'error': 'n'}, [('<a>', '1')], 'A & B')
    assert text == (
        '<div class="wide"><table><caption>A &amp; B</caption>'
        '<thead><tr><th>joint</th><th class="n">error</th></tr></thead>'
        '<tbody><tr><td>&lt;a&gt;</td><td class="n">1</td></tr></tbody></table></div>'
    )
    with pytest.raises(ValueError, match='zip'):
        html_table({'joint': ''}, [('a', 'b')])


def test_neighbours_of_one_group_have_a_head_above_theirs():
    columns = [Column('from'), Column('value', 'n', 'C [Nm]'), Column('error', 'n', 'C [Nm]')]
    text = html_table(columns, [(Markup('<b>T1</b>'), '1', '2')], dim=[0])
    assert text == (
        '<div class="wide"><table><thead><tr><th rowspan="2">from</th>'
        '<th class="g l" colspan="2">C [Nm]</th></tr>'
        '<tr><th class="n">value</th><th class="n">error</th></tr></thead>'
        '<tbody><tr class="no"><td><b>T1</b></td><td class="n">1</td><td class="n">2</td></tr>'
        '</tbody></table></div>'
    )


def test_the_model_is_the_first_of_the_observers(text):
    heads = re.findall(r'<td class="w">((?:FO|SOSML)[^<]*)</td>', text)
    assert heads[:2] == ['SOSML, segments (the model)', 'FO, segments']


def test_what_is_said_of_observers_is_not_said_of_the_model(analysis, truth):
    view = joint_views(analysis, truth)[0]
    fo = view.fits['first_order']
    value = fo.fit.parameters['coulomb']
    far = dataclasses.replace(value, value=value.value + 9.0, interval=(8.9, 9.1))
    law = dataclasses.replace(fo.fit, parameters={**fo.fit.parameters, 'coulomb': far})
    moved = {**view.fits, 'first_order': dataclasses.replace(fo, fit=law)}
    view = dataclasses.replace(view, fits=moved, alternatives={})
    assert notes([view], beside=False) == []
    assert [note for note in notes([view], beside=True) if 'FO' in note]
