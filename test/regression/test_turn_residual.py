# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A joint sticks where most of its turns leave much, and nothing that acts there explains it."""

from __future__ import annotations

import pytest

from sosml_friction.regression.turn_residual import TurnResidual


@pytest.mark.parametrize(
    ('whole', 'usual', 'least', 'sticks'),
    [
        (4.0, 3.0, 4.0, True),
        # As little as motion leaves, in a recording of few turns.
        (2.5, 2.2, 2.5, False),
        # A push at one turn.
        (4.0, 1.5, 4.0, False),
        # An elastic gear.
        (4.0, 3.5, 3.5, False),
        # What acts there explains a part, and far too much is left.
        (22.6, 19.0, 18.4, True),
    ],
)
def test_a_joint_that_sticks_is_told_from_pushes_and_from_what_acts_at_reversals(
    whole, usual, least, sticks
):
    left = TurnResidual(whole, usual, least)
    assert left.sticks is sticks
    assert left.explained == pytest.approx((whole - least) / (whole - 1.0))
