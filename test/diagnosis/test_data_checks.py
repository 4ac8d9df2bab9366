# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is said of the data before anything is fitted to them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known_robots import slider_model, slider_recording

from sosml_friction.diagnosis.data_checks import check_joints
from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.identification.new_values import WORDS


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


@pytest.mark.parametrize('column', ['q', 'tau'])
def test_every_second_value_that_is_lost_leaves_the_answer_what_it_was(column):
    log = slider_recording()
    values = getattr(log, column).copy()
    values[1::2] = np.nan
    whole, half = (diagnose([x], slider_model()) for x in (log, replace(log, **{column: values})))
    assert half.verdict == whole.verdict == 'nothing_above_floor'
    word = WORDS[column]
    assert any(f'the {word} of {log.names[0]} is not in each' in c.sentence for c in half.checks)


def test_samples_that_came_late_are_put_in_order():
    """Of each hundredth sample: a stretch without one was too short for anything."""
    log = slider_recording()
    order = np.arange(len(log))
    order[::100], order[1::100] = order[1::100].copy(), order[::100].copy()
    found = [diagnose([x], slider_model()) for x in (log, log.rows(order))]
    assert found[0].verdict == found[1].verdict == 'nothing_above_floor'
    np.testing.assert_array_equal(found[0].selection.after.x, found[1].selection.after.x)


def test_an_effort_that_one_joint_lacks_for_a_while_is_told():
    log = slider_recording()
    tau = log.tau.copy()
    tau[: len(log) // 5] = np.nan
    (check,) = effort_checks(replace(log, tau=tau))
    assert check.severity == 'warning'
    assert 'no effort in 20 % of the samples' in check.sentence


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
