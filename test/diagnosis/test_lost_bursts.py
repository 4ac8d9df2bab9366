# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A recorder that loses bursts, each shorter than half a period of the band, hides nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known_robots import slider_model, slider_recording

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.regression.settings import DiagnosisSettings

#: Band [Hz] whose half period the longest burst, of 30 ms, is within.
SETTINGS = DiagnosisSettings(band=15.0)


def with_bursts(log: JointLog) -> JointLog:
    """Return a log that has lost 6 to 30 ms about twice in a second."""
    rng = np.random.default_rng(8)
    kept = np.ones(len(log), dtype=bool)
    first = 0
    while first < len(log):
        length = round(rng.uniform(6e-3, 30e-3) / log.step)
        kept[first : first + length] = False
        first += length + round(rng.uniform(0.2, 0.8) / log.step)
    return log.rows(np.flatnonzero(kept))


@pytest.mark.parametrize('size', [0.0, 3.0])
def test_a_recording_without_bursts_of_samples_is_one(size):
    log = slider_recording(seed=3)
    whole = replace(log, tau=log.tau + size * np.sin(150.0 * log.q))
    found = diagnose([with_bursts(whole)], slider_model(), settings=SETTINGS)
    assert len(found.laboratory.signals) == 1
    named = [cause.effect for cause in found.causes if cause.joint == 'slider']
    assert named == (['cogging'] if size else []), found.sentence
    if size:
        sine = found.causes[0].parameters['sine']
        assert abs(sine.value - size) < 3.0 * sine.std_error
