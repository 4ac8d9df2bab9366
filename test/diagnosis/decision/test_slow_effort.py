# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What lasts and has no name is hidden in the effort, and is not taken for noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from known_robots import slider_model, slider_recording
from scipy.signal import lfilter

from sosml_friction.diagnosis.decision.leftover import SLOW
from sosml_friction.diagnosis.diagnosis import diagnose


def wandering(t, v, rng):
    """Return a torque that wanders at random, 3 N about its mean."""
    walk = np.cumsum(rng.standard_normal(len(t)))
    return 3.0 * (walk - walk.mean()) / walk.std()


def giving_way(t, v, rng):
    """Return Coulomb friction of 20 N that falls by 60 % for 0.4 s of each 3.1 s."""
    phase = t / 3.1 % 1.0
    return -12.0 * np.sin(np.pi * phase / 0.13) * (phase < 0.13) * np.sign(v)


def nothing(t, v, rng):
    """Return no effort."""
    return np.zeros_like(t)


def smoothed_noise(t, v, rng):
    """Return noise of 3 N as a drive smooths it, by a low-pass of first order at 20 Hz."""
    share = 1.0 - np.exp(-2.0 * np.pi * 20.0 * (t[1] - t[0]))
    noise = lfilter([share], [1.0, share - 1.0], rng.standard_normal(len(t)))
    return 3.0 * noise / noise.std()


@pytest.mark.parametrize('hidden', [wandering, giving_way])
def test_an_effort_that_lasts_and_has_no_name_is_no_noise(hidden):
    """The structure is unknown, and the sentence says that something lasts."""
    found = told(hidden)
    assert found.verdict == 'unknown_structure'
    assert [x.axis for x in found.selection.remainder.significant] == [SLOW]
    assert 'too slow for noise' in found.sentence


@pytest.mark.parametrize('hidden', [nothing, smoothed_noise])
def test_noise_is_not_slow(hidden):
    """A tenth of its power is in the slowest tenth of the band, of smoothed noise not half."""
    found = told(hidden)
    assert found.verdict == 'nothing_above_floor'
    assert not any(x.axis == SLOW for x in found.selection.remainder.found)


def told(hidden):
    """Return the diagnosis of the slider with an effort besides."""
    log = slider_recording(duration=60.0)
    t, v = log.time, np.gradient(log.q[:, 0], log.time)
    more = hidden(t, v, np.random.default_rng(7))
    return diagnose([replace(log, tau=log.tau + more[:, None])], slider_model(20.0, 200.0))
