# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Whole turns that bring an angle back into its joint's band."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sosml_friction.actuators.rmd_x.start_up import lost_turns
from sosml_friction.model.robot import JointLimits

LIMITS = JointLimits(-1.7, 0.7, 3.0, 8.0)
TURN = 2.0 * math.pi


@given(st.integers(-50, 50), st.floats(-1.6, 0.6))
def test_a_number_of_turns_in_a_band_narrower_than_one_is_found(k, q):
    assert lost_turns(q - k * TURN, LIMITS, 0.05, TURN) == [k]


def test_an_angle_no_number_of_turns_explains_gives_none():
    assert lost_turns(2.0, LIMITS, 0.05, TURN) == []


def test_a_band_wider_than_a_turn_gives_several_the_smallest_first():
    """Motor turns of a 1:8 gear are 0.785 rad: three of them fit into 2.4 rad."""
    found = lost_turns(1.0, LIMITS, 0.0, TURN / 8)
    assert found == [-1, -2, -3]
    assert all(LIMITS.lower <= 1.0 + k * TURN / 8 <= LIMITS.upper for k in found)


@pytest.mark.parametrize('q', [math.nan, math.inf, 1e9])
def test_no_angle_at_all_gives_none(q):
    assert lost_turns(q, LIMITS, 0.05, TURN) == []
