# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Efforts of exactly 0 amid others that are far from it."""

from __future__ import annotations

import numpy as np
import pytest
from known_robots import recording

from sosml_friction.identification.clean_samples import CleanSamples
from sosml_friction.identification.data_finding import LEFT_OUT
from sosml_friction.identification.zero_efforts import zero_efforts

TIME = 0.01 * np.arange(2000)


def effort(count=0.0, noise=0.02):
    """Return friction and inertia of 1 Nm and more, with noise, in counts."""
    tau = np.sign(np.cos(TIME)) + np.sin(TIME)
    tau += noise * np.random.default_rng(3).standard_normal(len(TIME))
    return count * np.rint(tau / count) if count else tau


def test_readings_that_were_lost_are_left_out_and_told():
    tau, at = effort(), [300, 700, 900]
    for k in at:
        assert abs(tau[k]) > 0.3
        tau[k] = 0.0
    assert zero_efforts(tau).sum() == 3
    clean = CleanSamples.of(recording(('j',), TIME, np.sin(TIME)[:, None], tau[:, None]))
    (said,) = (f for f in clean.findings if f.check == 'zero_effort')
    assert said.level == LEFT_OUT
    assert 'in 3 single samples' in said.sentence
    assert np.nanmin(np.abs(clean.log.tau[[300, 700, 900], 0])) > 0.3


@pytest.mark.parametrize('count', [0.05, 0.2])
def test_efforts_that_pass_through_0_are_as_they_are(count):
    """Beside a reading that was lost as well."""
    tau = effort(count)
    assert np.count_nonzero(tau == 0.0) > 5
    assert not zero_efforts(tau).any()
    tau[300] = 0.0
    assert np.flatnonzero(zero_efforts(tau)).tolist() == [300]


def test_a_drive_that_is_off_is_no_lost_reading():
    tau = effort()
    tau[700:702] = 0.0
    assert not zero_efforts(tau).any()
