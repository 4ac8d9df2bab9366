# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The recording over time: which windows are used, and why the others are not."""

import dataclasses

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from sosml_friction.report.figures.fit.overview import Overview, number_rejected
from sosml_friction.report.fit.joint_view import joint_views, shown_estimates
from sosml_friction.report.fit.segment_rows import SegmentRow, segment_rows


@pytest.fixture(scope='module')
def view(rejecting_analysis):
    return joint_views(rejecting_analysis)[0]


def row(number, start, reason='steady for only 0.1 s'):
    return SegmentRow(number, start, start + 0.2, 0.1, {}, {}, reason)


def legend_of(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


def test_windows_are_counted_and_every_reason_is_in_the_legend_with_its_numbers(view):
    rows = segment_rows(view)
    labels = legend_of(Overview().draw(view))
    assert f'steady window used ({sum(not r.reason for r in rows)})' in labels
    assert 'not used: speed ripples by 9 to 12 % (2, 3)' in labels
    assert 'not used: steady for < 0.1 s (5)' in labels


def test_the_shaded_stretches_are_the_windows(view):
    used, _ = Overview().draw(view).axes[0].collections[:2]
    spans = sorted(path.get_extents().intervalx.tolist() for path in used.get_paths())
    expected = sorted([r.start_s, r.end_s] for r in segment_rows(view) if not r.reason)
    assert np.allclose(spans, expected)


@pytest.mark.parametrize('count', [1, 12, 400])
def test_marks_are_numbers_of_rows_and_never_over_one_another(count):
    rows = [row(k + 1, 0.1 + 0.27 * (k % 350)) for k in range(count)]
    figure = Figure(figsize=(10.0, 3.0), dpi=100)
    axes = figure.subplots()
    axes.set_xlim(0.0, 100.0)
    width = 72.0 * 10.0 * axes.get_position().width
    placed = number_rejected(axes, [*rows, row(999, 50.0, reason='')], width)
    assert set(placed) <= {r.number for r in rows}
    assert placed
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    boxes = [text.get_window_extent(canvas.get_renderer()) for text in axes.texts]
    assert sorted(int(text.get_text()) for text in axes.texts) == placed
    for k, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[:k])


def test_a_joint_without_effort_is_drawn_as_unknown(one_joint_analysis):
    elbow = joint_views(one_joint_analysis)[1]
    figure = Overview().draw(elbow)
    assert [t.get_text() for t in figure.axes[2].texts] == ['unknown']
    assert [t.get_text() for t in figure.axes[3].texts] == ['unknown']
    assert not any('SOSML' in label for label in legend_of(figure))
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    labels = [axes.yaxis.label.get_window_extent(canvas.get_renderer()) for axes in figure.axes]
    for k, box in enumerate(labels):
        assert not any(box.overlaps(other) for other in labels[:k])


def test_of_many_observers_that_of_the_model_and_the_first_others_are_shown(view):
    tau_f = view.estimates['sosml']
    many = {f'extra_{k}': tau_f for k in range(8)}
    crowded = dataclasses.replace(view, estimates={**many, 'sosml': tau_f})
    shown = shown_estimates(crowded)
    assert view.preferred in shown
    assert len(shown) == 4
    assert shown_estimates(view) == list(view.estimates)
