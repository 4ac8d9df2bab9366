# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Recordings of a busy recorder: stamps that are late, and a hole."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from known_robots import slider_model, slider_recording

from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.regression.settings import DiagnosisSettings


@pytest.mark.parametrize('seed', [1, 2])
@pytest.mark.parametrize(('ripple', 'causes'), [(0.0, []), (6.0, [('cogging', 'slider')])])
def test_samples_that_are_stamped_late_show_what_exact_stamps_show(ripple, causes, seed):
    """Of 0.3 ms in the mean, beside exact positions: that was an unknown structure."""
    log = slider_recording(seed=seed)
    log = replace(log, tau=log.tau + ripple * np.sin(150.0 * log.q))
    late = np.random.default_rng(seed).exponential(0.08 * log.step, len(log))
    log = replace(log, t_ns=log.t_ns + np.rint(1e9 * late).astype(np.int64))
    found = diagnose([log], slider_model(), settings=DiagnosisSettings())
    assert found.verdict == ('named' if causes else 'nothing_above_floor'), found.sentence
    assert [(cause.effect, cause.joint) for cause in found.causes] == causes


def test_a_hum_goes_on_over_a_hole():
    """Of 5 Hz, with one phase on both sides."""
    log = slider_recording(duration=56.0, seed=3)
    log = replace(log, tau=log.tau + 2.0 * np.sin(10.0 * np.pi * log.time)[:, None])
    log = log.rows(np.flatnonzero(np.abs(log.time - 30.0) > 0.1))
    found = diagnose([log], slider_model(), settings=DiagnosisSettings())
    assert found.verdict == 'unknown_structure'
    assert re.search(r'slider has a tone of (4\.9\d|5|5\.0\d) Hz', found.sentence), found.sentence
