# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Numbers show what their uncertainty supports, and what is not identifiable is no number."""

import math
from pathlib import Path

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import sosml_friction
from sosml_friction.identification.number_text import (
    error_text,
    format_interval,
    format_number,
    interval_text,
    number_text,
    plus_minus,
    value_text,
)
from sosml_friction.model.parameter import AT_BOUND, NOT_IDENTIFIABLE, Parameter
from sosml_friction.report.common.labels import SYMBOLS

VALUES = st.floats(-1e9, 1e9)
UNCERTAINTIES = st.floats(1e-12, 1e9)
ANY = st.floats(allow_nan=True, allow_infinity=True)


def is_number(text):
    try:
        float(text)
    except ValueError:
        return False
    return True


@settings(deadline=None)
@given(VALUES, UNCERTAINTIES)
def test_rounding_is_a_twentieth_of_the_uncertainty_at_most(value, uncertainty):
    assume(abs(value) < 1e12 * uncertainty)
    shown = float(format_number(value, uncertainty))
    assert abs(shown - value) <= 0.0501 * uncertainty + 1e-15 * abs(value)


@settings(deadline=None)
@given(VALUES, UNCERTAINTIES)
def test_no_digit_is_below_a_hundredth_of_the_uncertainty(value, uncertainty):
    text = format_number(value, uncertainty)
    digits, _, exponent = text.partition('e')
    last_place = int(exponent or 0) - len(digits.partition('.')[2])
    assert 10.0**last_place > 0.0099 * uncertainty or last_place == 0


@pytest.mark.parametrize(
    ('value', 'half', 'text'),
    [
        (0.4275, 0.19, '0.43 ± 0.19 Nm'),
        (30.9, 0.29, '30.90 ± 0.29 Nm'),
        (-0.05093, 0.043, '-0.051 ± 0.043 Nm'),
        (0.0004, 0.043, '0.000 ± 0.043 Nm'),
        (10.23, 0.0998, '10.230 ± 0.100 Nm'),
        (1412.7, 35.0, '1413 ± 35 Nm'),
        (0.4275, math.nan, '0.4275 Nm'),
        (0.4275, 0.0, '0.4275 Nm'),
    ],
)
def test_a_value_has_the_digits_that_its_error_bears(value, half, text):
    assert plus_minus(value, half, 'Nm') == text


def test_no_sentence_writes_an_error_in_digits_of_its_own():
    root = Path(sosml_friction.__file__).parent
    own = [p.name for p in root.rglob('*.py') if '± {' in p.read_text(encoding='utf-8')]
    assert own == ['number_text.py']


@pytest.mark.parametrize(
    ('interval', 'text'),
    [
        ((0.060, 0.084), '0.072 ± 0.012'),
        # The middle is off by less than two digits of half of it tell.
        ((0.061, 0.085), '0.072 ± 0.012'),
        ((0.0553, 0.0786), '0.0720 (0.0553 to 0.0786)'),
    ],
)
def test_an_interval_that_is_not_about_its_value_is_told_by_its_ends(interval, text):
    assert number_text('coulomb', Parameter(0.072, 'Nm', 0.006, interval)) == text


@settings(deadline=None)
@given(ANY, ANY)
def test_always_ascii_and_never_nan_infinite_or_negative_zero(value, uncertainty):
    text = format_number(value, uncertainty)
    assert text.isascii()
    assert text == '-' or math.isfinite(float(text))
    assert not (text.startswith('-') and text != '-' and float(text) == 0.0)


@pytest.mark.parametrize(
    ('value', 'uncertainty', 'text'),
    [
        (20.7557, 0.3937, '20.76'),
        (199.935, 5.3, '199.9'),
        (0.3, 0.0996, '0.300'),
        (21283.2, 1450.0, '21300'),
        (0.00002, 0.0012, '0.0000'),
        (-0.00002, 0.0012, '0.0000'),
        (2.4e-7, 1.3e-8, '2.40e-07'),
        (1234567.0, 1000.0, '1.2346e+06'),
        (0.123456, math.nan, '0.1235'),
        (0.0, math.nan, '0'),
        (math.nan, 1.0, '-'),
    ],
)
def test_examples(value, uncertainty, text):
    assert format_number(value, uncertainty) == text


@settings(deadline=None)
@given(st.sampled_from(list(SYMBOLS)), ANY, ANY, st.none() | st.tuples(ANY, ANY), st.booleans())
def test_what_is_not_identifiable_is_never_a_number(name, value, error, interval, bound):
    flags = (NOT_IDENTIFIABLE, AT_BOUND) if bound else (NOT_IDENTIFIABLE,)
    parameter = Parameter(value, 'Nm', error, interval, flags)
    text = value_text(name, parameter)
    assert text == 'not identifiable' or ' to ' in text or text[:6] in ('above ', 'below ')
    assert not is_number(text)
    assert error_text(parameter) == '-'
    assert interval_text(parameter) == '-'


@pytest.mark.parametrize(
    ('name', 'interval', 'text'),
    [
        ('stribeck', (0.0, 1.234), '0 to 1.23'),
        ('stribeck', (-0.5, 1.234), '0 to 1.23'),
        ('stribeck', (0.1234, math.inf), 'above 0.123'),
        ('stribeck', (0.1234, math.nan), 'above 0.123'),
        ('stribeck', (0.0, math.inf), 'not identifiable'),
        ('stribeck', (math.nan, math.nan), 'not identifiable'),
        ('stribeck', None, 'not identifiable'),
        ('bias', (-math.inf, 2.5), 'below 2.50'),
        ('bias', (-math.inf, math.inf), 'not identifiable'),
    ],
)
def test_a_range_that_is_open_names_the_end_that_it_has(name, interval, text):
    parameter = Parameter(math.nan, 'Nm', interval=interval, flags=(NOT_IDENTIFIABLE,))
    assert value_text(name, parameter) == text


def test_a_value_at_its_bound_says_so():
    parameter = Parameter(0.0, 'Nm', flags=(AT_BOUND,))
    assert value_text('viscous', parameter) == '0 (at bound)'
    assert error_text(parameter) == interval_text(parameter) == '-'


def test_both_ends_of_an_interval_have_the_digits_of_the_standard_error():
    assert format_interval(19.9637, 21.5477, 0.3937) == '19.96 to 21.55'
    parameter = Parameter(20.7557, 'N', 0.3937, (19.9637, 21.5477))
    assert interval_text(parameter) == '19.96 to 21.55'
