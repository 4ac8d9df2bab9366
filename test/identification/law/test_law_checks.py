# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Checks of a fitted law: sentences with the right numbers, and only where they are true."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.identification.law.law_checks import (
    bend_check,
    dissipation_check,
    knee_check,
    odd_even_check,
)
from sosml_friction.identification.number_text import rounded


def best(**values):
    return {name: (value, None) for name, value in values.items()}


def test_a_bias_above_coulomb_friction_drives_the_joint():
    """The paper's numbers: from 7.2 exp(-w / 2.5e-3) = 0.17 on, at w = 9.4 mrad/s."""
    check = dissipation_check(
        best(coulomb=0.26, viscous=2.5e-3, stribeck=7.2, stribeck_velocity=2.5e-3, bias=0.43),
        'Nm',
        1e-3,
        0.7,
    )
    assert not check.passed
    assert check.sentence.startswith(
        'The bias 0.43 Nm is larger than Coulomb friction 0.26 Nm, so that the law drives the '
        'joint backwards from 0.009'
    )
    assert check.sentence.endswith('offset of gravity or of the current, not friction.')


def test_the_knee_of_the_check_is_that_of_the_law():
    """At 2 v_s, exp(-4) of S is left of a Gaussian knee, where exp(-2) is of an exponential."""
    known = best(coulomb=0.2, viscous=0.0, stribeck=1.0, stribeck_velocity=0.01, bias=0.3)
    assert dissipation_check(known, 'Nm', 0.01, 0.02).passed
    assert not dissipation_check(known, 'Nm', 0.01, 0.02, 2.0).passed


@pytest.mark.parametrize('bias', [0.1, -0.1, 0.0])
def test_a_bias_below_friction_passes_with_its_share(bias):
    check = dissipation_check(best(coulomb=0.5, viscous=0.1, bias=bias), 'Nm', 0.01, 1.0)
    assert check.passed
    assert (
        f'{rounded(100.0 * abs(bias) / 0.501)} % of the least friction, 0.501 Nm' in check.sentence
    )


def test_negative_friction_speeds_are_named_where_viscous_friction_saves_the_rest():
    check = dissipation_check(best(coulomb=0.1, viscous=1.0, bias=-0.3), 'N', 0.01, 1.0)
    assert not check.passed
    assert 'forwards from 0.01 to 0.19' in check.sentence or 'to 0.2 m/s' in check.sentence


def test_the_even_part_is_an_offset_if_it_stays_and_an_asymmetry_if_it_changes():
    speeds, odd = np.array([0.01, 0.7]), np.array([1.0, 1.2])
    same = odd_even_check(speeds, odd, np.array([0.1, 0.1]), 1e-9, 'Nm')
    assert same.passed
    assert 'constant offset of 0.1 Nm' in same.sentence
    noise = odd_even_check(speeds, odd, np.array([0.1, 0.2]), 0.3, 'Nm')
    assert noise.passed
    other = odd_even_check(speeds, odd, np.array([0.1, 0.2]), 1e-6, 'Nm')
    assert not other.passed
    assert 'differs by direction' in other.sentence
    assert '0.2 at 0.7' in other.sentence


def test_an_asymmetry_that_is_in_the_law_is_no_fault_and_no_reason_to_fit_it():
    speeds, odd = np.array([0.01, 0.7]), np.array([1.0, 1.2])
    check = odd_even_check(speeds, odd, np.array([0.1, 0.2]), 1e-6, 'Nm', True)
    assert check.passed
    assert 'differs by direction' in check.sentence
    assert 'fit the asymmetric form' not in check.sentence


def test_a_bend_is_told_where_it_is_largest_and_not_where_it_is_nothing():
    speeds, law = np.array([0.1, 0.2, 0.4]), np.array([1.0, 1.1, 1.3])
    check = bend_check(speeds, law, law + np.array([0.01, -0.05, 0.02]), 0.5, 'bias', 'Nm')
    assert not check.passed
    assert 'with |v|^0.5 beside it, it is 0.05 Nm less at 0.2 rad/s' in check.sentence
    assert '--terms bias,nonlinear_viscous' in check.sentence
    assert bend_check(speeds, law, law + np.array([0.01, -0.02, 0.02]), 0.5, 'bias', 'Nm') is None


def test_another_knee_is_told_with_its_values():
    law = {'coulomb': 0.8, 'viscous': 0.35, 'stribeck': 0.5, 'stribeck_velocity': 0.03}
    check = knee_check(law, 'Nm')
    assert check.passed
    assert check.sentence.endswith('C 0.8 Nm, B 0.35 Nm s/rad, S 0.5 Nm, v_s 0.03 rad/s.')


def test_drag_holds_a_bias_at_speed():
    """C is .6 and the bias .8: the drag .4 w^2 is more than what is missing from .707 rad/s on."""
    known = best(coulomb=0.6, viscous=0.0, bias=0.8, nonlinear_viscous=0.4, power=2.0)
    assert dissipation_check(known, 'Nm', 0.72, 3.0).passed
    assert not dissipation_check(known, 'Nm', 0.68, 3.0).passed
