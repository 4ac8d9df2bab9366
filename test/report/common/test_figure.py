# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A class that is a figure is in its report; every figure says what it has to."""

import re
from dataclasses import replace

import pytest
from matplotlib.figure import Figure as Drawing

from sosml_friction.diagnosis.residual.joint_residual import joint_residuals
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.ripple import PlateauRipple
from sosml_friction.identification.term_residual import along_axis
from sosml_friction.report.common import figure as module
from sosml_friction.report.common.figure import REPORTS, Figure, figures, figures_of
from sosml_friction.report.fit.consolidation_view import bags_joints
from sosml_friction.report.fit.html import render_report
from sosml_friction.report.fit.joint_view import JointView, joint_views
from sosml_friction.report.simulation.document import SimulatedJoint

#: Labels that are a count or say their unit themselves.
WITHOUT_BRACKETS = {'periods per turn', 'periods per metre', '... that this one explains'}
#: Two plateaus, of which the second ripples.
EVEN = PlateauRipple(1.0, 2.0, 0.1, 1e-4, 1e-4, 1e-6, 2e-4, 0.5, 20.0)
UNEVEN = PlateauRipple(3.0, 4.0, 0.05, 5e-3, 2e-4, 3e-5, 2e-4, 1e-9, 24.0, 'ripple', 1e-3)
EVERY = [(report, figure.identifier) for report in REPORTS for figure in figures(report)]


@pytest.fixture(autouse=True)
def forgotten(monkeypatch):
    """Let the figures that a test defines go with it."""
    monkeypatch.setattr(Figure, '_defined', list(Figure._defined))


@pytest.fixture
def views(analysis, truth, bags, diagnosis, tiny_study, simulated, fitted_terms):
    """Return by report something of each kind that its figures draw."""
    view = joint_views(analysis, truth)[0]
    return {
        'fit': [replace(view, ripple=(EVEN, UNEVEN))],
        'bags': [bags_joints(bags)['shoulder'], view],
        'diagnosis': [*joint_residuals(diagnosis), diagnosis],
        'study': [tiny_study],
        'simulation': [SimulatedJoint(simulated, 0)],
        'terms': along_axis(fitted_terms, fitted_terms.terms[0]),
    }


class Scatter(Figure[JointView]):
    """Is what a person who uses the package adds."""

    title = 'Effort against velocity'
    report = 'fit'
    order = 36
    caption = 'Effort of joint {view.name} against its velocity.'

    def draw(self, view):
        drawing = Drawing()
        drawing.subplots().plot(view.speed, view.tau)
        return drawing


def test_a_figure_from_elsewhere_is_in_the_report_in_its_place(analysis, monkeypatch):
    class Mine(Scatter):
        identifier = 'mine'

    drawn = []
    monkeypatch.setattr(module, 'to_svg', lambda *one: drawn.append(one) or '<svg></svg>')
    text = render_report(analysis)
    order = [figure.identifier for figure in figures('fit')]
    assert order == [
        'curve',
        's_shape',
        'overview',
        'parameters',
        'ripple',
        'mine',
        'residual',
        'profile',
    ]
    for view in joint_views(analysis):
        caption = f'Effort of joint {view.name} against its velocity.'
        assert text.index(f'Overview of joint {view.name}:') < text.index(caption)
        assert text.index(caption) < text.index(
            f'What the law leaves of friction of joint {view.name}.'
        )
    assert len(drawn) == sum(len(figures_of('fit', view)) for view in joint_views(analysis))


def test_a_figure_that_does_not_say_all_it_has_to_is_refused():
    class Unfinished(Figure[JointView]):
        identifier = 'unfinished'
        report = 'fit'

    with pytest.raises(ConfigurationError, match='Unfinished has no caption, draw, order, title'):
        figures('fit')
    assert Unfinished in Figure._defined


def test_a_figure_that_does_not_say_what_it_draws_is_refused():
    class Vague(Figure):
        identifier = title = caption = 'vague'
        report = 'study'
        order = 1

        def draw(self, view):
            return Drawing()

    with pytest.raises(ConfigurationError, match=r'Vague has no class to draw'):
        figures('fit')
    assert Vague in Figure._defined


def test_a_figure_of_a_report_that_is_not_there_is_refused():
    class Lost(Scatter):
        identifier = 'lost'
        report = 'fits'

    with pytest.raises(ConfigurationError, match='no report fits: there are fit, bags'):
        figures('study')
    assert Lost in Figure._defined


def test_two_figures_of_one_name_are_refused():
    class Again(Scatter):
        identifier = 'overview'

    with pytest.raises(ConfigurationError, match='two figures overview'):
        figures('fit')
    assert Again in Figure._defined


def test_a_report_that_is_not_there_is_refused_with_those_that_are():
    with pytest.raises(ConfigurationError, match='no report fitt: there are fit, bags, diagnosis'):
        figures('fitt')


def test_a_figure_is_for_what_it_draws(views):
    for report, some in views.items():
        found = [figure.identifier for view in some for figure in figures_of(report, view)]
        assert len(found) == len(set(found))
        assert set(found) <= {figure.identifier for figure in figures(report)}
        assert figures_of(report, object()) == []


@pytest.mark.parametrize(('report', 'identifier'), EVERY)
def test_every_figure_has_a_title_a_caption_and_axes_with_units(views, report, identifier):
    shown = [
        (view, figure)
        for view in views[report]
        for figure in figures_of(report, view)
        if figure.identifier == identifier
    ]
    assert shown, 'the figure draws nothing of the test data'
    view, figure = shown[0]
    caption = figure.caption_of(view)
    assert len(figure.title) > 5
    assert len(caption) > 20
    assert not re.search(r'[{}]|nan|None', caption)
    drawing = figure.draw(view)
    labels = [text for axes in drawing.axes for text in (axes.get_xlabel(), axes.get_ylabel())]
    labels += [axes.get_title() for axes in drawing.axes]
    assert any('[' in label for label in labels)
    for axes in drawing.axes:
        for label in (axes.get_xlabel(), axes.get_ylabel()):
            assert not label.strip() or '[' in label or label in WITHOUT_BRACKETS, label
