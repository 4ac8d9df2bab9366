# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A number with its standard error over stretches of the data."""

import pytest

from sosml_friction.diagnosis.extended_model.uncertain import Uncertain


@pytest.mark.parametrize(
    ('value', 'error', 'beyond'),
    [
        # Of a false delay, and of a spring that is there.
        (0.21, 0.19, False),
        (0.85, 0.23, True),
        (2.32, 1.0, False),
        (2.34, 1.0, True),
        (-2.34, 1.0, True),
        (0.0, 0.0, False),
    ],
)
def test_chance_is_one_in_a_hundred_to_one_side(value, error, beyond):
    assert Uncertain(value, error).beyond(0.0) == beyond
