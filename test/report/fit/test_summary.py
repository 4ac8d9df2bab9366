# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The first screen of a fit says what was recorded, how it went and what to do."""

from dataclasses import replace

from sosml_friction.model.parameter import NOT_IDENTIFIABLE, Parameter
from sosml_friction.report.fit.joint_view import joint_views
from sosml_friction.report.fit.summary import (
    fit_verdict,
    next_steps,
    plain_table,
    recording_facts,
)


def test_the_recording_is_named_with_robot_joints_and_length(analysis):
    told = recording_facts(analysis)
    assert told['Recording'] == 'ladder'
    assert 'shoulder, elbow' in told['Robot']
    assert told['Length'].endswith('at 500 Hz')


def test_the_badge_follows_what_was_found(analysis):
    views = joint_views(analysis)
    kinds = {fit_verdict(views)[0]}
    assert kinds <= {'good', 'found'}
    without = [replace(view, preferred=None) for view in views]
    assert fit_verdict(without)[0] == 'bad'
    assert fit_verdict([views[0], without[1]]) == ('open', 'Fitted for 1 of 2 joints')


def test_a_check_that_failed_is_on_the_badge(analysis):
    view = joint_views(analysis)[0]
    law = view.model.fit
    failed = replace(law.checks[0], passed=False)
    fit = replace(view.model, fit=replace(law, checks=(failed,)))
    view = replace(view, fits={**view.fits, view.preferred: fit})
    assert fit_verdict([view])[0] == 'open'


def test_a_parameter_is_a_value_with_its_half_interval_or_a_range():
    parameters = {
        'coulomb': Parameter(0.8024, 'Nm', 0.0026),
        'stribeck': Parameter(float('nan'), 'Nm', interval=(0.0, 1.2), flags=(NOT_IDENTIFIABLE,)),
    }
    text = plain_table(parameters, {}, Parameter(0.058, '1', 0.004))
    assert '0.8024 ± 0.0051' in text
    assert '0 to 1.2' in text
    assert '5.80 ± 0.78' in text


def test_what_is_left_open_comes_before_what_else_can_be_done(analysis):
    views = joint_views(analysis)
    steps = next_steps(views, 'ladder')
    assert 'sosml diagnose ladder' in steps[-2]
    law = views[0].model.fit
    unknown = replace(law.parameters['stribeck'], flags=(NOT_IDENTIFIABLE,), reason='too fast')
    fit = replace(
        views[0].model, fit=replace(law, parameters={**law.parameters, 'stribeck': unknown})
    )
    view = replace(views[0], fits={**views[0].fits, views[0].preferred: fit})
    assert 'too fast' in next_steps([view], 'ladder')[0]
    assert next_steps([replace(view, preferred=None)], 'ladder') == [
        'See what the recording holds: sosml info ladder.'
    ]
