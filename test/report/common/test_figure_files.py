# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Figures as files hold what the figures show."""

import csv
import re
from io import StringIO

import numpy as np
import pytest

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.report.common import drawing, figure_files
from sosml_friction.report.common.figure import figures_of
from sosml_friction.report.common.figure_files import FORMS, check_forms, figure_csv, write_figures
from sosml_friction.report.common.svg import to_svg
from sosml_friction.report.figures.fit.curve import Curve
from sosml_friction.report.fit.joint_view import joint_views

X = np.array([0.1, 0.2, 0.4])
BEGINS = {'png': b'\x89PNG', 'pdf': b'%PDF', 'svg': b'<?xml', 'csv': b'panel,'}


@pytest.fixture
def figure():
    """Return two curves of one colour each, one with error bars, and their legend."""
    made = drawing.new_figure(6.0, 4.0)
    axes = made.subplots()
    axes.plot(X, 2.0 * X, color='#0072B2')
    axes.errorbar(X, X**2, 0.01 * np.arange(1.0, 4.0), fmt='s', color='#D55E00')
    drawing.label_axes(axes, 'speed [rad/s]', 'friction [Nm]')
    law = drawing.key(color='#0072B2', label='the law')
    made.legend(
        handles=[law, drawing.key(color='#D55E00', marker='s', linestyle='', label='seen')]
    )
    return made


def test_a_csv_has_every_point_with_its_error_and_the_name_in_the_legend(figure):
    rows = list(csv.DictReader(StringIO(figure_csv(figure))))
    assert {row['x_label'] for row in rows} == {'speed [rad/s]'}
    law = [(float(r['x']), float(r['y'])) for r in rows if r['series'] == 'the law']
    np.testing.assert_allclose(law, np.column_stack([X, 2.0 * X]))
    seen = [r for r in rows if r['series'] == 'seen']
    np.testing.assert_allclose([float(r['y']) for r in seen], X**2)
    half = [0.5 * (float(r['high']) - float(r['low'])) for r in seen]
    np.testing.assert_allclose(half, [0.01, 0.02, 0.03])


def test_each_form_is_written_and_begins_as_its_kind_does(analysis, tmp_path, monkeypatch):
    view = joint_views(analysis)[0]
    write_figures(tmp_path, 'fit', {'left arm/1': view}, ['csv'])
    names = {path.name for path in (tmp_path / 'figures').iterdir()}
    assert names == {f'left_arm_1_{one.identifier}.csv' for one in figures_of('fit', view)}
    monkeypatch.setattr(figure_files, 'figures_of', lambda report, view: [Curve()])
    write_figures(tmp_path, 'fit', {'': view}, FORMS)
    assert set(FORMS) == set(BEGINS)
    for form, begin in BEGINS.items():
        assert (tmp_path / 'figures' / f'curve.{form}').read_bytes().startswith(begin)


def test_nothing_is_made_where_nothing_is_asked_for(analysis, tmp_path):
    write_figures(tmp_path, 'fit', {'': joint_views(analysis)[0]}, [])
    assert list(tmp_path.iterdir()) == []


def test_a_form_that_is_not_known_is_refused_with_those_that_are():
    with pytest.raises(ConfigurationError, match='jpg is no form of a figure: give some of png'):
        check_forms(['png', 'jpg'])


def test_a_figure_of_a_page_has_greys_of_the_page_and_its_limits(figure):
    text = to_svg(figure, 'speed & friction')
    assert 'aria-label="speed &amp; friction"' in text
    assert '#000000' not in text
    assert 'speed [rad/s]' in text
    assert to_svg(figure, themed=False).count('var(--') == 0


def test_a_page_of_many_joints_shows_fewer_points_of_each():
    assert drawing.points(900) == 900
    with drawing.page_of(2):
        assert (drawing.points(900), drawing.is_crowded()) == (900, False)
    with drawing.page_of(6):
        assert (drawing.points(900), drawing.is_crowded()) == (300, True)
    assert not drawing.is_crowded()


def test_a_cloud_of_points_is_one_path_of_as_many_dots():
    made = drawing.new_figure(6.0, 4.0)
    points = np.random.default_rng(0).normal(size=(2, 500))
    made.subplots().plot(*points, linestyle='', marker='.', markersize=3.0)
    text = to_svg(made)
    assert text.count('<use') < 50
    assert text.count('h0') == 500


def test_the_numbers_of_an_axis_keep_their_digits():
    made = drawing.new_figure(6.0, 4.0)
    axes = made.subplots()
    axes.plot([0.0, 1.0], [-4e-3, 4e-3])
    axes.set_yticks([-2.5e-3, 0.00125])
    axes.set_title('0.00125 Nm')
    text = to_svg(made)
    assert {'0.00125', '0.00125 Nm'} <= set(re.findall(r'<text[^>]*>([^<]*)<', text))
    assert not re.search(r'[xyd]="[^"]*\.\d{3}', text)


@pytest.mark.parametrize('size', [0.2, 3e-4, 2.5e-5])
def test_small_numbers_leave_room_for_the_label_of_their_axis(size):
    made = drawing.new_figure(10.0, 6.4)
    for axes in made.subplots(1, 2, sharey=True):
        axes.plot([0.0, 1.0], [-size, size])
        drawing.label_axes(axes, 'time [s]', 'mean unexplained effort [Nm]')
    drawing.legend_below(made, drawing.before_and_after())
    made.draw_without_rendering()
    assert made.axes[0].yaxis.label.get_window_extent().x0 >= 0.0
