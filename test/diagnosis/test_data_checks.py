# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is said of the data before anything is fitted to them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known_robots import slider_model, slider_recording

from sosml_friction.diagnosis.data_checks import check_joints, check_log
from sosml_friction.diagnosis.diagnosis import diagnose


def limited(share):
    """Return the slider whose effort is limited in about this share of the samples."""
    log = slider_recording()
    limit = np.quantile(np.abs(log.tau), 1.0 - share)
    return replace(log, tau=np.clip(log.tau, -limit, limit))


def effort_checks(log):
    checks = check_joints(log, slider_model().make_robot())
    return [check for check in checks if check.kind == 'effort']


def test_an_effort_that_is_limited_for_some_of_the_time_is_told():
    """Runs of less than five samples are none, and noise cuts others: not all of it is seen."""
    assert not effort_checks(slider_recording())
    (check,) = effort_checks(limited(0.07))
    assert check.severity == 'warning'
    assert 0.5 * 0.07 < check.values['limited_share'] < 1.01 * 0.07
    assert 'stays at its extreme in' in check.sentence


def test_a_time_in_ms_that_was_taken_for_s_is_no_data():
    """An inertia a million times as large explained it well."""
    log = slider_recording()
    slow = replace(log, t_ns=1000 * log.t_ns, v=np.full_like(log.v, np.nan))
    found = diagnose([slow], slider_model())
    assert found.verdict == 'bad_data'
    assert 'check the unit of time, as ms that were taken for s' in found.sentence


@pytest.mark.parametrize(('column', 'quantity'), [('q', 'position'), ('tau', 'effort')])
@pytest.mark.parametrize('share', [0.0, 0.004, 0.02, 0.4])
def test_values_that_are_lost_are_told_as_samples_are(column, quantity, share):
    """Of the first share of the samples; what is never known is told otherwise."""
    log = slider_recording()
    values = getattr(log, column).copy()
    values[: round(share * len(log))] = np.nan
    told = [c for c in check_log(replace(log, **{column: values})) if 'lost_share' in c.values]
    told = [check for check in told if check.joint != '*']
    if share < 0.005:
        assert not told
        return
    (check,) = told
    assert (check.kind, check.severity, check.joint) == (quantity, 'warning', log.names[0])
    assert check.values['lost_share'] == pytest.approx(share, rel=0.01)
    assert (
        f'of the samples have no {quantity} of {log.names[0]} and are taken as lost;'
        in check.sentence
    )


def test_every_second_effort_that_is_lost_leaves_the_answer_what_it_was():
    log = slider_recording()
    tau = log.tau.copy()
    tau[1::2] = np.nan
    whole, half = (diagnose([x], slider_model()) for x in (log, replace(log, tau=tau)))
    assert half.verdict == whole.verdict == 'nothing_above_floor'
    assert any(check.values.get('lost_share') == 0.5 for check in half.checks)


def test_an_effort_without_its_sign_is_no_data():
    log = slider_recording()
    found = diagnose([replace(log, tau=np.abs(log.tau))], slider_model())
    assert found.verdict == 'bad_data'
    assert 'never changes its sign' in found.sentence


def test_an_effort_that_is_limited_for_most_of_the_motion_is_no_data():
    """More than a fifth is what a fit refuses as well."""
    found = diagnose([limited(0.4)], slider_model())
    assert found.verdict == 'bad_data'
    assert 'stays at its extreme of' in found.sentence
