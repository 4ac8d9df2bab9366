# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is said of the data before anything is fitted to them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from known_robots import slider_model, slider_recording

from sosml_friction.diagnosis.data_checks import check_joints
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
