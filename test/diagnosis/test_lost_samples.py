# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Recordings that lost samples in bursts: what is left of them is enough."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from known_robots import slider_model, slider_recording

from sosml_friction.bags.even_stretches import even_stretches
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.regression.settings import DiagnosisSettings


def with_losses(log: JointLog, rng: np.random.Generator) -> JointLog:
    """Return a log without 8 % of its samples, in bursts of two in the mean, stamped late."""
    lost = np.zeros(len(log), dtype=bool)
    for first in np.flatnonzero(rng.random(len(log)) < 0.04):
        lost[first : first + rng.geometric(0.5)] = True
    late = rng.exponential(0.08 * log.step, len(log))
    t_ns = log.t_ns + np.rint(1e9 * late).astype(np.int64)
    return replace(log, t_ns=t_ns).rows(np.flatnonzero(~lost))


@pytest.mark.parametrize('seed', [1, 2])
@pytest.mark.parametrize(('ripple', 'causes'), [(0.0, []), (6.0, [('cogging', 'slider')])])
def test_stretches_of_seconds_show_what_the_whole_shows(ripple, causes, seed):
    """No stretch has the five seconds that each had to have."""
    log = slider_recording(duration=56.0, seed=seed)
    log = replace(log, tau=log.tau + ripple * np.sin(150.0 * log.q))
    log = with_losses(log, np.random.default_rng(seed))
    lengths = [len(each) * each.step for each in even_stretches(log)]
    assert sum(x for x in lengths if x < 5.0) > 0.5 * sum(lengths)
    found = diagnose([log], slider_model(), settings=DiagnosisSettings())
    assert found.verdict == 'named'
    told = [(cause.effect, cause.joint) for cause in found.causes]
    assert told == [*causes, ('dropped_samples', '*')], found.sentence


def test_a_hum_goes_on_over_holes():
    """Of 5 Hz, with one phase in all stretches."""
    log = slider_recording(duration=56.0, seed=3)
    log = replace(log, tau=log.tau + 2.0 * np.sin(10.0 * np.pi * log.time)[:, None])
    log = with_losses(log, np.random.default_rng(3))
    found = diagnose([log], slider_model(), settings=DiagnosisSettings())
    assert found.verdict == 'unknown_structure'
    assert re.search(r'slider has a tone of (4\.9\d|5|5\.0\d) Hz', found.sentence), found.sentence
