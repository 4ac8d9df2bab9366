# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Friction laws: sign, dissipation, limits, names and refusals."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.laws import (
    FRICTION_LAWS,
    law_definition,
    law_of,
    make_friction_law,
    unit_of,
)
from sosml_friction.model.smooth_sign import smooth_sign

positive = st.floats(1e-4, 1e2)
anything = {
    'coulomb': positive,
    'viscous': positive,
    'stribeck': positive,
    'stribeck_velocity': st.floats(1e-3, 1.0),
    'bias': st.floats(-10.0, 10.0),
}
SYMMETRIC = [name for name in FRICTION_LAWS if not name.endswith('_asymmetric')]


@st.composite
def laws(draw):
    name = draw(st.sampled_from(sorted(SYMMETRIC)))
    values = {key: draw(anything[key]) for key in FRICTION_LAWS[name].parameter_names}
    return make_friction_law(name, values, draw(st.sampled_from([0.0, 1e-3, 0.1])))


@given(laws(), st.floats(-10.0, 10.0))
def test_what_does_not_change_with_direction_is_the_bias_and_the_rest_dissipates(law, v):
    bias = law.parameters['bias']
    odd = 0.5 * (law.torque(v) - law.torque(-v))
    even = 0.5 * (law.torque(v) + law.torque(-v))
    assert v * odd >= 0.0
    assert even == pytest.approx(bias, abs=1e-12 * (1.0 + abs(odd)))


@given(laws())
def test_at_rest_only_the_bias_is_left(law):
    assert law.torque(0.0) == law.parameters['bias']


@given(laws())
def test_at_high_speed_stribeck_has_vanished_and_the_line_is_left(law):
    p, v = law.parameters, 200.0
    line = p['coulomb'] + p['viscous'] * v + p['bias']
    assert law.torque(v) == pytest.approx(line, rel=1e-12)


@pytest.mark.parametrize('name', [n for n in FRICTION_LAWS if n not in SYMMETRIC])
def test_an_asymmetric_law_is_its_symmetric_one_with_other_numbers_each_way(name):
    """Forwards B + D_B and S + D_S, backwards B - D_B and S - D_S."""
    p = {'coulomb': 0.8, 'viscous': 0.35, 'bias': 0.1}
    even = {'viscous_asymmetry': 0.05}
    if name.startswith('stribeck'):
        p |= {'stribeck': 0.5, 'stribeck_velocity': 0.03}
        even |= {'stribeck_asymmetry': -0.1}
    law = make_friction_law(name, {**p, **even}, 0.005)
    v = np.array([0.004, 0.03, 0.5])
    for way in (1.0, -1.0):
        own = {**p, 'viscous': p['viscous'] + way * even['viscous_asymmetry']}
        if 'stribeck' in p:
            own['stribeck'] += way * even['stribeck_asymmetry']
        one = make_friction_law(name.removesuffix('_asymmetric'), own, 0.005)
        np.testing.assert_allclose(law.torque(way * v), one.torque(way * v), rtol=1e-12)
    assert law.torque(0.0) == 0.1


def test_breakaway_is_coulomb_plus_stribeck():
    values = {
        'coulomb': 0.8,
        'viscous': 0.35,
        'stribeck': 0.5,
        'stribeck_velocity': 0.03,
        'bias': 0.1,
    }
    law = make_friction_law('stribeck', values, 0.0)
    assert law.torque(1e-12) == pytest.approx(0.8 + 0.5 + 0.1, abs=1e-9)
    assert law.torque(0.03) == pytest.approx(0.8 + 0.5 / np.e + 0.35 * 0.03 + 0.1, rel=1e-15)


@pytest.mark.parametrize('way', ['', '_asymmetric'])
@pytest.mark.parametrize(('name', 'exponent'), [('stribeck', 1.0), ('stribeck_gaussian', 2.0)])
def test_the_extra_friction_fades_as_the_name_of_the_law_says(name, exponent, way):
    """At twice the Stribeck velocity, where exp(-2) is not exp(-2^2)."""
    values = dict.fromkeys(FRICTION_LAWS[name + way].parameter_names, 0.0)
    law = make_friction_law(
        name + way, {**values, 'stribeck': 0.5, 'stribeck_velocity': 0.03}, 0.0
    )
    assert law.torque(0.06) == pytest.approx(0.5 * np.exp(-(2.0**exponent)), rel=1e-12)


@pytest.mark.parametrize('name', FRICTION_LAWS)
def test_terms_are_the_law_whose_fixed_numbers_they_have(name):
    law = FRICTION_LAWS[name]
    assert law_of(law.terms[::-1], law.fixed) is law
    if law.fixed:
        free = law_of(law.terms, {'exponent': 1.5})
        assert (free.identifier, free.fixed) == ('+'.join(law.terms), {})
        assert 'exponent' in free.parameter_names


def test_terms_that_are_no_law_are_joined_and_one_is_told_from_the_law_of_its_name():
    assert law_of(['viscous', 'bias', 'viscous'], {}).identifier == 'viscous+bias'
    alone = law_of(['stribeck'], {})
    assert (alone.identifier, alone.terms) == ('stribeck+', ('stribeck',))
    for law in (law_of(['viscous', 'bias'], {}), alone):
        assert law_definition(law.identifier) == law


@pytest.mark.parametrize('name', ['', '+', 'coulomb+no_such_term', 'gravity'])
def test_what_is_no_law_is_refused_with_the_laws_and_the_terms(name):
    with pytest.raises(
        ConfigurationError, match=r'use one of coulomb_viscous, .* joined by \+, of'
    ):
        law_definition(name)


def test_a_law_knows_the_units_of_amplitudes_and_inner_parameters():
    law = FRICTION_LAWS['stribeck']
    assert law.unit('viscous', 'N') == 'N s/m'
    assert law.unit('stribeck_velocity', 'Nm') == 'rad/s'


def test_a_law_answers_in_the_shape_it_is_asked():
    law = make_friction_law('coulomb_viscous', {'coulomb': 1, 'viscous': 2, 'bias': 0}, 0.0)
    v = np.array([[-1.0, 0.0], [0.5, 2.0]])
    np.testing.assert_array_equal(law.torque(v), [[-3.0, 0.0], [2.0, 5.0]])
    assert law.torque(1.0).shape == ()


def test_the_smooth_sign_is_the_sign_for_width_zero_and_99_5_percent_of_it_at_three_widths():
    np.testing.assert_array_equal(smooth_sign([-2.0, 0.0, 1e-300], 0.0), [-1.0, 0.0, 1.0])
    assert smooth_sign(0.015, 0.005) == pytest.approx(0.995, abs=1e-3)
    assert smooth_sign(1e-8, 0.005) == pytest.approx(1e-8 / 0.005, rel=1e-9)


@pytest.mark.parametrize(
    ('name', 'unit', 'expected'),
    [
        ('coulomb', 'Nm', 'Nm'),
        ('bias', 'N', 'N'),
        ('viscous', 'Nm', 'Nm s/rad'),
        ('viscous', 'N', 'N s/m'),
        ('stribeck_velocity', 'Nm', 'rad/s'),
        ('stribeck_velocity', 'N', 'm/s'),
    ],
)
def test_units_follow_the_kind_of_joint(name, unit, expected):
    assert unit_of(name, unit) == expected


GOOD = {'coulomb': 1.0, 'viscous': 1.0, 'bias': 0.0}
KNEE = {'stribeck': 1.0, 'stribeck_velocity': 0.1}


@pytest.mark.parametrize(
    ('name', 'values', 'width', 'words'),
    [
        ('lugre', GOOD, 0.0, 'unknown: use one of coulomb_viscous, stribeck'),
        ('coulomb_viscous', {'coulomb': 1.0}, 0.0, "missing ['viscous', 'bias']"),
        ('coulomb_viscous', {**GOOD, **KNEE}, 0.0, "unknown ['stribeck', 'stribeck_velocity']"),
        ('coulomb_viscous', GOOD, -1.0, 'smoothing_velocity'),
        ('coulomb_viscous', GOOD, float('nan'), 'smoothing_velocity'),
        ('coulomb_viscous', GOOD, float('inf'), 'smoothing_velocity'),
        ('coulomb_viscous', {**GOOD, 'viscous': float('nan')}, 0.0, 'viscous'),
        ('stribeck', {**GOOD, **KNEE, 'stribeck_velocity': 0.0}, 0.0, 'must be positive'),
        ('stribeck', {**GOOD, **KNEE, 'stribeck_velocity': -0.1}, 0.0, 'must be positive'),
    ],
)
def test_a_law_that_makes_no_sense_is_refused_in_one_sentence(name, values, width, words):
    with pytest.raises(ConfigurationError) as caught:
        make_friction_law(name, values, width)
    assert words in str(caught.value)
    assert '\n' not in str(caught.value)
