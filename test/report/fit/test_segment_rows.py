# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The windows as a table and as a file: each one, with the reason it is not used."""

import csv
import dataclasses
import io
import re
from html import escape

import numpy as np
import pytest

from sosml_friction.report.figures.fit.s_shape import SShape
from sosml_friction.report.fit.joint_view import joint_views
from sosml_friction.report.fit.segment_rows import (
    NOT_STARTED,
    rejected_groups,
    segment_rows,
    segment_table,
    segments_csv,
)


@pytest.fixture(scope='module')
def views(rejecting_analysis):
    return joint_views(rejecting_analysis)


def read(views):
    return list(csv.DictReader(io.StringIO(segments_csv({'ladder, first': views}))))


def test_the_file_has_every_window_of_every_joint_with_its_numbers(views):
    rows = read(views)
    assert len(rows) == sum(len(view.segments) for view in views)
    for view in views:
        mine = [row for row in rows if row['joint'] == view.name]
        for k, (row, segment) in enumerate(zip(mine, view.segments, strict=True)):
            assert row['recording'] == 'ladder, first'
            assert int(row['window']) == k + 1
            assert float(row['start_s']) == pytest.approx(segment.start_s, abs=1e-4)
            assert float(row['velocity']) == pytest.approx(segment.velocity, rel=1e-6)
            assert row['reason'] == segment.rejected
            assert (row['used'] == 'yes') == (not segment.rejected)
            for observer, fit in view.fits.items():
                text = row[f'level_{observer}']
                if np.isfinite(fit.levels[k]):
                    assert float(text) == pytest.approx(fit.levels[k], rel=1e-6)
                else:
                    assert text == ''
            assert (row['velocity_unit'], row['effort_unit']) == ('rad/s', 'Nm')


def test_the_file_is_plain_numbers_and_words(views):
    text = segments_csv({'a': views})
    assert text.isascii()
    assert not re.search(r'\b(nan|inf|None)\b', text)
    assert text.endswith('\n')


def test_a_joint_that_was_not_fitted_has_no_rows(one_joint_analysis):
    rows = read(joint_views(one_joint_analysis))
    assert {row['joint'] for row in rows} == {'shoulder'}


def test_the_spread_is_the_standard_deviation_within_the_window(views):
    view = views[0]
    row = next(row for row in segment_rows(view) if not row.reason)
    segment = view.segments[row.number - 1]
    inside = view.estimates['sosml'][segment.first : segment.last + 1]
    assert row.spreads['sosml'] == pytest.approx(np.std(inside))


@pytest.mark.parametrize('count', [0, 200])
def test_the_table_has_every_reason_and_is_folded_when_it_is_long(views, count):
    view = views[0]
    extra = tuple(
        dataclasses.replace(view.segments[0], rejected=f'reason <{k}>') for k in range(count)
    )
    fits = {
        o: dataclasses.replace(
            f, segments=f.segments + extra, levels=np.append(f.levels, np.zeros(count))
        )
        for o, f in view.fits.items()
    }
    table = segment_table(dataclasses.replace(view, fits=fits))
    for segment in view.segments:
        assert escape(segment.rejected) in table
    for k in range(count):
        assert f'reason &lt;{k}&gt;' in table
    assert table.startswith('<details>') == (count > 0)


def test_a_window_before_the_observer_started_says_so(views):
    view = views[0]
    fits = {
        o: dataclasses.replace(f, levels=np.full(len(f.levels), np.nan))
        for o, f in view.fits.items()
    }
    rows = segment_rows(dataclasses.replace(view, fits=fits))
    assert {row.reason for row, s in zip(rows, view.segments, strict=True) if not s.rejected} == {
        NOT_STARTED
    }


def test_reasons_that_differ_in_numbers_only_are_one(views):
    rows = segment_rows(views[0])[:4]
    words = ('short for 0.2 s', 'bent by 7 %', 'short for 0.15 s', '')
    groups = rejected_groups(
        [dataclasses.replace(r, reason=w) for r, w in zip(rows, words, strict=True)]
    )
    assert {reason: [r.number for r in some] for reason, some in groups.items()} == {
        'short for 0.15 to 0.2 s': [1, 3],
        'bent by 7 %': [2],
    }


def test_forward_simulation_has_no_levels_and_no_column(views):
    view = views[0]
    simulated = dataclasses.replace(
        view.fits['sosml'],
        observer='output_error',
        method='output_error',
        levels=np.full(len(view.segments), np.nan),
    )
    unknown = np.full(len(view.time), np.nan)
    both = dataclasses.replace(
        view,
        fits={**view.fits, 'output_error': simulated},
        estimates={**view.estimates, 'output_error': unknown},
    )
    assert segments_csv({'a': [both]}) == segments_csv({'a': [view]})
    assert segment_table(both) == segment_table(view)
    assert len(SShape().draw(both).axes) == 6
