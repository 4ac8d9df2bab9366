# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What an interval tells of a value."""

import math

import pytest

from sosml_friction.model.parameter import NOT_IDENTIFIABLE, Parameter


@pytest.mark.parametrize(
    ('interval', 'wider', 'may_be'),
    [
        (None, 1.0, False),
        ((1.0, 4.0), 1.0, False),
        ((1.0, 4.0), 1.9, False),
        ((1.0, 4.0), 2.0, True),
        ((-math.inf, 4.0), 1.0, True),
        ((1.0, math.inf), 1.0, False),
    ],
)
def test_an_interval_grows_about_its_estimate_to_either_side(interval, wider, may_be):
    """The lower half of [1, 4] about 2 is 1: twice as wide it reaches 0."""
    assert Parameter(2.0, 'Nm', 0.5, interval).may_be(0.0, wider) == may_be


def test_the_range_of_what_is_not_identifiable_is_not_made_wider():
    known = Parameter(2.0, 'Nm', 0.5, (1.0, 4.0), (NOT_IDENTIFIABLE,))
    assert not known.may_be(0.0, 2.0)
    assert known.may_be(1.0, 2.0)
    assert Parameter.not_told('Nm', interval=(-1.0, 4.0)).may_be(0.0, 2.0)
