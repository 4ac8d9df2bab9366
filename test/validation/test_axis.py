# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The linear axis that judges the diagnosis: its physics, and one trial of its campaign."""

from __future__ import annotations

import numpy as np
import pytest

from validation.axis_campaign import judge_guess, trial, truly_off, without
from validation.axis_plant import (
    CATALOGUE,
    OUTSIDE,
    PERIOD,
    Axis,
    hide,
    moves,
    signal_to_noise,
    simulate,
)

LONG_S = 12.0


@pytest.fixture(scope='module')
def reference():
    """Return the first moves of a motion, at the rate of control."""
    return moves(1, LONG_S)


def test_the_axis_obeys_its_equation_of_motion(reference):
    """Away from rest: M a = force - C sign(v) - B v, integrated over time to a momentum."""
    axis = Axis()
    _, x, v, force = simulate(axis, reference)
    assert np.abs(x - reference[::4][: len(x)]).max() < 1e-3
    net = force - axis.coulomb * np.sign(v) - axis.viscous * v
    fast = np.convolve(np.abs(v) < 5e-3, np.ones(51), 'same') == 0
    window = 25
    momentum = (axis.motor + axis.carriage) * (v[window:] - v[:-window])
    impulse = np.concatenate([[0.0], np.cumsum(0.5 * (net[1:] + net[:-1]))]) * PERIOD
    error = (momentum - (impulse[window:] - impulse[:-window]))[fast[window:] & fast[:-window]]
    assert len(error) > 500
    assert np.abs(error).max() < 0.01 * np.abs(momentum).max()


@pytest.mark.parametrize('effect', [*CATALOGUE, *OUTSIDE])
def test_every_effect_is_seen_in_the_effort(reference, effect):
    size = {**CATALOGUE, **OUTSIDE}[effect]
    axis = hide(Axis(), effect, size, np.random.default_rng(0), LONG_S)
    assert signal_to_noise(axis, Axis(), reference) > 0.5


def test_a_guessed_friction_is_right_by_names_and_sizes():
    def cause(effect, value):
        size = {'change': {'value': value, 'std_error': 1.0}}
        return {'effect': effect, 'joint': 'axis', 'rivals': [], 'parameters': size}

    both = [cause('coulomb', 5.0), cause('viscous', -9.0)]
    off = {'coulomb': 6.0, 'viscous': -8.0}

    def judged(causes, effect=''):
        return judge_guess({'verdict': 'named', 'causes': causes}, off, effect)

    assert judged(both) == 'right'
    assert judged([both[0], cause('viscous', 0.0)]) == 'size'
    assert judged(both[:1]) == 'part'
    assert judged(both, 'stribeck') == 'part'
    assert judged([*both, cause('stribeck', 1.0)]) == 'wrong name'
    assert judged([*both, cause('stribeck', 1.0)], 'stribeck') == 'right'
    assert judge_guess({'verdict': 'unknown_structure', 'causes': []}, off, '') == (
        'unknown_structure'
    )


def test_a_nominal_parameter_that_is_truly_off_is_right_with_its_size_alone():
    def document(value):
        size = {'change': {'value': value, 'std_error': 0.1}}
        cause = {'effect': 'coulomb', 'joint': 'axis', 'rivals': [], 'parameters': size}
        return {'verdict': 'named', 'causes': [cause]}

    assert truly_off(document(1.0), {'coulomb': 1.1}, '') == ['coulomb']
    assert truly_off(document(2.0), {'coulomb': 1.1}, '') == []
    assert truly_off(document(0.8), {'coulomb': 0.8}, '') == []
    assert without(document(1.0), ['coulomb'])['verdict'] == 'nothing_above_floor'
    assert without(document(1.0), [])['verdict'] == 'named'


def test_a_trial_of_the_campaign_names_what_is_hidden():
    row = trial(7, 'single', 'cogging', 0)
    assert row['outcome'] == 'right'
    assert row['snr'] > 0.5
