# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What intervals allow, and when two of them exclude each other."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sosml_friction.identification.parameter_interval import (
    LAW_PARAMETERS,
    allowed_range,
    covers,
    excluding,
    finite_interval,
    half_width,
    missed_truths,
)
from sosml_friction.model.parameter import NOT_IDENTIFIABLE, Parameter

VALUES = st.floats(-1e9, 1e9)


def law(**intervals):
    """Return a law whose parameters have these intervals, the others 0 to 1."""
    whole = {name: (0.0, 1.0) for name in LAW_PARAMETERS} | intervals
    return {name: Parameter(0.5, 'Nm', 0.1, interval) for name, interval in whole.items()}


@settings(deadline=None)
@given(st.sampled_from(['coulomb', 'viscous', 'stribeck', 'stribeck_velocity']), VALUES, VALUES)
def test_a_range_of_what_cannot_be_negative_begins_at_zero(name, low, high):
    allowed = allowed_range(name, Parameter(math.nan, 'Nm', interval=(low, high)))
    assert allowed is None or 0.0 <= allowed[0] < allowed[1]
    assert (allowed is None) == (max(high, 0.0) <= max(low, 0.0))


def test_a_bias_may_be_negative():
    assert allowed_range('bias', Parameter(math.nan, 'N', interval=(-2.0, 1.0))) == (-2.0, 1.0)


@given(VALUES, VALUES, VALUES, VALUES)
def test_two_laws_exclude_each_other_where_no_value_is_in_both_intervals(a, b, c, d):
    one, other = sorted((a, b)), sorted((c, d))
    apart = max(one[0], other[0]) > min(one[1], other[1])
    found = excluding(law(viscous=tuple(one)), law(viscous=tuple(other)))
    assert found == (['viscous'] if apart else [])
    assert found == excluding(law(viscous=tuple(other)), law(viscous=tuple(one)))


@pytest.mark.parametrize('interval', [None, (math.nan, 0.1), (-math.inf, 0.1)])
def test_an_open_interval_excludes_nothing_and_misses_no_truth(interval):
    open_ended = law(stribeck=interval)
    assert finite_interval(open_ended['stribeck']) is None
    assert excluding(open_ended, law(stribeck=(5.0, 6.0))) == []
    assert missed_truths(open_ended, {'stribeck': Parameter(9.0, 'Nm')}) == []


def test_what_is_not_identifiable_has_no_interval_to_miss_a_truth_with():
    flagged = Parameter(0.5, 'Nm', 0.1, (0.0, 1.0), (NOT_IDENTIFIABLE,))
    assert not covers(flagged, 0.5)
    assert missed_truths({'bias': flagged}, {'bias': Parameter(9.0, 'Nm')}) == []
    known = {'bias': Parameter(1.5, 'Nm'), 'coulomb': Parameter(1.0, 'Nm')}
    assert missed_truths(law(), known) == ['bias']


def test_half_of_the_interval_is_that_of_the_standard_error_where_there_is_none():
    assert half_width(Parameter(1.0, 'Nm', 0.1, (0.7, 1.5))) == pytest.approx(0.4)
    assert half_width(Parameter(1.0, 'Nm', 0.1)) == pytest.approx(0.196, abs=1e-3)
