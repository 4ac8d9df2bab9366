# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A number with its standard error over stretches of the data."""

import pytest

from sosml_friction.diagnosis.extended_model.uncertain import Uncertain


@pytest.mark.parametrize(
    ('value', 'error', 'above', 'beyond'),
    [
        # Of a false delay, and of a spring that is there.
        (0.21, 0.19, False, False),
        (0.85, 0.23, True, True),
        (2.32, 1.0, False, False),
        (2.34, 1.0, True, True),
        (-2.34, 1.0, False, True),
        (0.0, 0.0, False, False),
    ],
)
def test_chance_is_one_in_a_hundred_to_one_side(value, error, above, beyond):
    number = Uncertain(value, error)
    assert number.above(0.0) == above
    assert number.beyond(0.0) == beyond
