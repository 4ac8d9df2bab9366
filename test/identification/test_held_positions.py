# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Positions that an encoder goes on reporting while its joint moves."""

from __future__ import annotations

import numpy as np
import pytest
from known_robots import recording

from sosml_friction.identification.clean_samples import CleanSamples
from sosml_friction.identification.data_finding import LEFT_OUT
from sosml_friction.identification.held_positions import held_positions

#: Samples at 50 Hz.
TIME = 0.02 * np.arange(3000)
COUNT = 2.0 * np.pi / 2**14


def motion(noise=0.4 * COUNT):
    """Return sines with rests between, as of an arm that is sent from place to place."""
    q = np.where(np.sin(0.6 * TIME) > 0.0, np.cos(0.6 * TIME), 1.0) + 0.01 * np.sin(7.0 * TIME)
    # No noise in the rests: a position that repeats by itself is none that is held.
    noisy = noise * (np.sin(0.6 * TIME) > 0.0) * np.random.default_rng(1).standard_normal(3000)
    return COUNT * np.rint((np.cumsum(np.abs(q - 1.0)) * 0.01 + noisy) / COUNT)


@pytest.mark.parametrize('begin', [700, 1800])
def test_a_position_that_is_held_while_the_joint_moves_is_left_out_and_told(begin):
    q = motion()
    held = slice(begin, begin + 150)
    assert np.ptp(q[held]) > 100.0 * COUNT
    q[held] = q[begin]
    found = held_positions(TIME, q)
    assert found.sum() == 149
    assert found[begin + 1 : begin + 150].all()
    clean = CleanSamples.of(recording(('j',), TIME, q[:, None], np.cos(3.0 * TIME)[:, None]))
    (said,) = (f for f in clean.findings if f.check == 'held')
    assert said.level == LEFT_OUT
    assert 'of 2.96 s' in said.sentence
    assert len(clean.log) == 3000 - 149


@pytest.mark.parametrize('q', [motion(), motion(0.0), np.zeros(3000), np.sign(np.sin(TIME))])
def test_a_joint_that_rests_moves_or_steps_holds_nothing(q):
    """The last has no speed over two steps: what it does is all that it can do."""
    assert not held_positions(TIME, q).any()


def test_a_coarse_encoder_holds_nothing():
    q = np.rint(50.0 * np.sin(0.3 * TIME)) / 50.0
    assert not held_positions(TIME, q).any()


def test_a_joint_that_sticks_and_slips_holds_nothing():
    """Slips of 5 to 30 mrad in two samples, each after it stuck for 0.4 s."""
    rng = np.random.default_rng(2)
    slips = np.zeros(3000)
    slips[20::20], slips[21::20] = rng.uniform(2e-3, 2e-2, (2, 149))[:, :149]
    q = COUNT * np.rint(np.cumsum(slips[:3000]) / COUNT)
    assert not held_positions(TIME, q).any()
