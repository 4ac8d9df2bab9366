# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The equation of each term, written a second time, and the amplitudes that are impossible."""

from __future__ import annotations

from math import cos, exp, sin
from types import SimpleNamespace

import numpy as np
import pytest

from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.fading_term import broad_fade, fade, fade_slopes
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.measurement_term import MeasurementTerm
from sosml_friction.model.terms.kinds.motion import Motion
from sosml_friction.model.terms.kinds.term import TERMS

#: Time, position, velocity, sign, load and rise of temperature: at rest, before a sign is
#: settled, driving a load and driven by it, either way.
SAMPLES = (
    (0.0, 0.3, 0.0, 0.0, 0.0, 0.0),
    (2.0, -0.7, 0.02, 0.4, 0.6, 1.0),
    (5.0, 1.1, 0.5, 1.0, 2.0, 3.0),
    (9.0, 1.9, 1.5, 1.0, -3.0, 4.0),
    (12.0, 0.4, 0.3, 1.0, -0.5, 5.0),
    (20.0, -2.1, -0.7, -1.0, -0.8, 6.0),
    (40.0, 0.2, -2.0, -1.0, 4.0, 9.0),
)
FADING = {'stribeck_velocity': 0.4, 'exponent': 1.5}


def fading(v):
    return exp(-((abs(v) / 0.4) ** 1.5))


#: Inner parameters, and the effort per unit of each amplitude of t, q, v, s, load and warmth.
EFFORTS = {
    'asymmetric_friction': (
        {'by_speed': 1.0},
        lambda t, q, v, s, load, warm: (abs(v), abs(s)),
    ),
    'bias': ({}, lambda t, q, v, s, load, warm: (1.0,)),
    'cogging': (
        {'frequency': 7.0},
        lambda t, q, v, s, load, warm: (cos(7.0 * q), sin(7.0 * q)),
    ),
    'coulomb': ({}, lambda t, q, v, s, load, warm: (s,)),
    'directional_load_friction': (
        {},
        lambda t, q, v, s, load, warm: (
            abs(load) * s if load * s > 0.0 else 0.0,
            abs(load) * s if load * s <= 0.0 else 0.0,
        ),
    ),
    'load_dependent_friction': ({}, lambda t, q, v, s, load, warm: (abs(load) * s,)),
    'load_dependent_stribeck': (
        FADING,
        lambda t, q, v, s, load, warm: (abs(load) * s * fading(v),),
    ),
    'position_dependent_friction': (
        {'frequency': 2.0},
        lambda t, q, v, s, load, warm: (s * cos(2.0 * q), s * sin(2.0 * q)),
    ),
    'quadratic_load_friction': ({}, lambda t, q, v, s, load, warm: (load * load * s,)),
    'spring': ({}, lambda t, q, v, s, load, warm: (q, 1.0)),
    'stribeck': (FADING, lambda t, q, v, s, load, warm: (s * fading(v),)),
    'stribeck_asymmetry': (FADING, lambda t, q, v, s, load, warm: (abs(s) * fading(v),)),
    'thermal_drift': (
        {'time_constant': 10.0},
        lambda t, q, v, s, load, warm: (
            (1.0 - exp(-t / 10.0)) * v,
            (1.0 - exp(-t / 10.0)) * s,
        ),
    ),
    'viscous': ({}, lambda t, q, v, s, load, warm: (v,)),
    'nonlinear_viscous': ({'power': 0.5}, lambda t, q, v, s, load, warm: (s * abs(v) ** 0.5,)),
    'viscous_asymmetry': ({}, lambda t, q, v, s, load, warm: (abs(v),)),
}
#: Terms whose effort depends on a state of their own.
WITH_A_STATE = {'hysteresis', 'maxwell_slip', 'presliding_hysteresis'}
#: What joint 1 reports beyond its torque, of the torques of joints 0 and 1.
EXCESSES = {
    'effort_bias': ({}, lambda other, own: (1.0,)),
    'effort_saturation': ({'reference': 2.0}, lambda other, own: ((own / 2.0) ** 3,)),
    'effort_scale': ({}, lambda other, own: (own,)),
    'joint_coupling': ({'source': 0.0}, lambda other, own: (other,)),
}


def test_every_term_of_one_line_is_in_these_tables():
    efforts = {name for name in TERMS if issubclass(TERMS[name], EffortTerm)}
    assert efforts == WITH_A_STATE | set(EFFORTS)
    assert {name for name in TERMS if issubclass(TERMS[name], MeasurementTerm)} == set(EXCESSES)


def motion_of_joint_1():
    """Return the samples as motion of the second of two joints, the first doing other things."""
    t, *own = np.array(SAMPLES).T
    q, v, s, load, warm = (np.column_stack([0.5 - 0.3 * x, x]) for x in own)
    return Motion(t, q, v, s, load, warm)


@pytest.mark.parametrize('name', sorted(EFFORTS))
def test_the_effort_is_the_equation(name):
    inner, equation = EFFORTS[name]
    parts = TERMS[name]().effort(motion_of_joint_1(), 1, inner, np.zeros((len(SAMPLES), 0)))
    expected = [equation(*sample) for sample in SAMPLES]
    np.testing.assert_allclose(np.column_stack(parts), expected, rtol=1e-14, atol=1e-15)


def test_a_difference_of_the_level_alone_has_no_slope():
    speed, level = TERMS['asymmetric_friction']().effort(
        motion_of_joint_1(), 1, {'by_speed': 0.0}, np.zeros((len(SAMPLES), 0))
    )
    assert not speed.any()
    np.testing.assert_array_equal(level, [abs(sample[3]) for sample in SAMPLES])


def test_where_temperature_is_measured_friction_follows_it_and_not_time():
    parts = TERMS['thermal_drift']().effort(
        motion_of_joint_1(), 1, {'time_constant': 0.0}, np.zeros((len(SAMPLES), 0))
    )
    expected = [(warm * v, warm * s) for _, _, v, s, _, warm in SAMPLES]
    np.testing.assert_allclose(np.column_stack(parts), expected, rtol=1e-14)


#: A joint from rest at 0.5 to 0.53, held, back to 0.49 and forth again.
PATH = np.array([0.5, 0.51, 0.53, 0.53, 0.49, 0.53, 0.53])


def test_dahls_state_is_an_exponential_of_the_displacement_beside_the_sign():
    term, inner = TERMS['presliding_hysteresis'](), {'displacement': 0.02}
    state = np.zeros((1, 1))
    found = [state]
    for step in np.diff(PATH):
        state = term.next_state(state, np.array([step]), inner)
        found.append(state)
    there = 1.0 - exp(-1.5)
    back = -1.0 + (there + 1.0) * exp(-2.0)
    again = 1.0 + (back - 1.0) * exp(-2.0)
    z = np.array([0.0, 1.0 - exp(-0.5), there, there, back, again, again])
    np.testing.assert_allclose(np.concatenate(found)[:, 0], z, rtol=1e-12)
    motion = motion_of_joint_1()
    (effort,) = term.effort(motion, 1, inner, np.concatenate(found))
    np.testing.assert_allclose(effort, z - motion.sign[:, 1], rtol=1e-12)
    # The same without the sign: what comes beside the friction of the nominal model.
    (effort,) = TERMS['hysteresis']().effort(motion, 1, inner, term.path_state(PATH, inner))
    np.testing.assert_allclose(effort, z, rtol=1e-12)


def test_maxwells_springs_stretch_until_their_blocks_slide_beside_the_sign():
    """Springs of 1/8, 1/4, 1/2 and all of 0.02."""
    term, inner = TERMS['maxwell_slip'](), {'displacement': 0.02}
    state = term.path_state(PATH, inner)
    expected = [
        [0.0, 0.0, 0.0, 0.0],
        [1.0, 1.0, 1.0, 0.5],
        [1.0, 1.0, 1.0, 1.0],
        [1.0, 1.0, 1.0, 1.0],
        [-1.0, -1.0, -1.0, -1.0],
        [1.0, 1.0, 1.0, 1.0],
        [1.0, 1.0, 1.0, 1.0],
    ]
    np.testing.assert_allclose(state, expected, rtol=1e-12)
    small = term.path_state(np.array([0.0, 0.004, 0.003, 0.004]), inner)
    np.testing.assert_allclose(small[1], [1.0, 0.8, 0.4, 0.2], rtol=1e-12)
    np.testing.assert_allclose(small[2], [0.6, 0.6, 0.3, 0.15], rtol=1e-12)
    # A loop within closes: the state is that from which it began.
    np.testing.assert_allclose(small[3], small[1], rtol=1e-12)
    parts = term.effort(motion_of_joint_1(), 1, inner, state)
    sign = motion_of_joint_1().sign[:, 1:]
    np.testing.assert_allclose(np.column_stack(parts), state - sign, rtol=1e-12)


@pytest.mark.parametrize('name', sorted(EXCESSES))
def test_what_is_reported_beyond_the_torque_is_the_equation(name):
    inner, equation = EXCESSES[name]
    torque = np.array([[0.5, -1.0], [2.0, 0.0], [-1.5, 3.0]])
    parts = TERMS[name]().excess(torque, 1, inner)
    expected = [equation(*row) for row in torque]
    np.testing.assert_allclose(np.column_stack(parts), expected, rtol=1e-14)


def fitted(name, amplitude, inner, **changed):
    """Return amplitudes fitted to a joint with C 0.8, B 0.5, up to 2 rad/s, 3 Nm rms of effort."""
    numbers = {
        **{'coulomb': 0.8, 'viscous': 0.5, 'stribeck': 0.0, 'bias': 0.0},
        **{'speed': 2.0, 'effort': 3.0, 'displacement': 0.01, 'sign_limit': 0.01, 'span': 2.0},
        **changed,
    }
    scales = SimpleNamespace(**{key: np.array([x]) for key, x in numbers.items()})
    scales.level = lambda joint: float(scales.coulomb[joint] + scales.stribeck[joint])
    signals = SimpleNamespace(
        scales=scales,
        q=np.linspace(-1.0, 1.0, 50)[:, None],
        band=SimpleNamespace(step=0.002),
        robot=SimpleNamespace(inertia=lambda q: np.array([[0.2]])),
    )
    amplitude = np.array(amplitude)
    return TERMS[name](), Fitted(signals, 0, inner, amplitude, np.full(len(amplitude), 1e-3))


#: What is possible beside what is not, near to each edge: name, amplitudes, inner, changes.
POSSIBLE = (
    ('asymmetric_friction', (0.89, 0.79), {'by_speed': 1.0}, {}),
    ('asymmetric_friction', (-0.89, -0.79), {'by_speed': 1.0}, {}),
    ('asymmetric_friction', (0.0, 7.0), {'by_speed': 1.0}, {'bias': np.nan}),
    ('cogging', (4.2, 0.0), {'frequency': 9.0}, {}),
    ('coulomb', (-0.79,), {}, {}),
    ('directional_load_friction', (0.01, 0.49), {}, {}),
    ('effort_delay', (0.0009,), {}, {}),
    ('effort_delay', (-0.049,), {}, {}),
    ('effort_saturation', (0.01,), {'reference': 2.0}, {}),
    ('effort_saturation', (0.99,), {'reference': 2.0}, {}),
    ('effort_scale', (0.49,), {}, {}),
    ('effort_scale', (-0.49,), {}, {}),
    ('hysteresis', (0.01,), {'displacement': 0.017}, {}),
    ('inertia', (-0.13,), {}, {}),
    ('joint_coupling', (-0.49,), {'source': 0.0}, {}),
    ('load_dependent_friction', (0.01,), {}, {}),
    ('load_dependent_friction', (0.49,), {}, {}),
    ('load_dependent_stribeck', (0.01,), FADING, {}),
    ('load_dependent_stribeck', (0.49,), FADING, {}),
    ('position_dependent_friction', (0.0, 1.19), {'frequency': 1.0}, {}),
    ('presliding_hysteresis', (1.0,), {'displacement': 0.05}, {}),
    ('spring', (0.5, 0.0), {}, {}),
    ('stribeck', (0.01,), FADING, {}),
    ('stribeck', (1.59,), FADING, {}),
    ('viscous', (-0.49,), {}, {}),
)
IMPOSSIBLE = (
    ('asymmetric_friction', (0.91, 0.0), {'by_speed': 1.0}, {}, 'no friction left'),
    ('asymmetric_friction', (-0.91, 0.0), {'by_speed': 1.0}, {}, 'no friction left'),
    ('asymmetric_friction', (0.0, -0.81), {'by_speed': 1.0}, {}, 'no friction left'),
    ('cogging', (3.1, 3.1), {'frequency': 9.0}, {}, 'more than all of the measured effort'),
    ('coulomb', (-0.81,), {}, {}, 'negative'),
    ('directional_load_friction', (0.0, 0.2), {}, {}, 'between nothing and half'),
    ('directional_load_friction', (0.2, -0.01), {}, {}, 'between nothing and half'),
    ('directional_load_friction', (0.2, 0.5), {}, {}, 'between nothing and half'),
    ('effort_delay', (-0.051,), {}, {}, 'over 50 ms'),
    ('effort_saturation', (0.0,), {'reference': 2.0}, {}, 'by less than half'),
    ('effort_saturation', (1.0,), {'reference': 2.0}, {}, 'by less than half'),
    ('effort_scale', (-0.51,), {}, {}, 'wrong by more than half'),
    ('effort_scale', (0.51,), {}, {}, 'wrong by more than half'),
    ('hysteresis', (0.0,), {'displacement': 0.5}, {}, 'give energy back'),
    ('hysteresis', (0.2,), {'displacement': 0.016}, {}, 'slip over less'),
    ('inertia', (-0.15,), {}, {}, 'hardly any inertia'),
    ('joint_coupling', (-0.51,), {'source': 0.0}, {}, 'pass over'),
    ('load_dependent_friction', (0.0,), {}, {}, 'between nothing and half'),
    ('load_dependent_friction', (0.5,), {}, {}, 'between nothing and half'),
    ('load_dependent_stribeck', (0.0,), FADING, {}, 'between nothing and half'),
    ('load_dependent_stribeck', (0.5,), FADING, {}, 'between nothing and half'),
    ('position_dependent_friction', (0.9, 0.9), {'frequency': 1.0}, {}, 'negative in some'),
    ('presliding_hysteresis', (0.0,), {'displacement': 0.05}, {}, 'would be negative'),
    ('presliding_hysteresis', (0.1,), {'displacement': 0.05}, {}, 'where all of it does'),
    ('presliding_hysteresis', (9.0,), {'displacement': 0.05}, {}, 'where all of it does'),
    ('presliding_hysteresis', (1.0,), {'displacement': 0.05}, {'coulomb': 0.0}, 'no Coulomb'),
    ('spring', (0.0, 0.0), {}, {}, 'positive stiffness'),
    ('spring', (1e-4, 0.5), {}, {}, 'no stiffness is seen'),
    ('stribeck', (0.0,), FADING, {}, 'fall towards standstill'),
    ('stribeck', (1.61,), FADING, {}, 'over three times'),
    ('viscous', (-0.51,), {}, {}, 'negative'),
)


@pytest.mark.parametrize(('name', 'amplitude', 'inner', 'changed'), POSSIBLE)
def test_what_a_joint_may_have_is_possible(name, amplitude, inner, changed):
    term, fit = fitted(name, amplitude, inner, **changed)
    assert term.implausible(fit) == ''


@pytest.mark.parametrize(('name', 'amplitude', 'inner', 'changed', 'because'), IMPOSSIBLE)
def test_what_no_joint_has_is_impossible_and_why(name, amplitude, inner, changed, because):
    term, fit = fitted(name, amplitude, inner, **changed)
    assert because in term.implausible(fit)


@pytest.mark.parametrize(
    ('stiffness', 'offset', 'left'),
    [
        (0.0041, 5.0, ''),
        (0.0039, 5.0, 'effort_bias'),
        # Within 1.5 spans (of 2) of the middle (1.5), by a stiffness that may be 0.003.
        (0.002, 0.0055, ''),
        (0.002, 0.0065, 'effort_bias'),
        (0.002, -0.0115, ''),
        (0.002, -0.0125, 'effort_bias'),
        (-0.002, 0.003, 'effort_bias'),
        (0.0, 0.0, 'effort_bias'),
    ],
)
def test_a_spring_without_a_stiffness_is_a_constant_but_where_it_may_relax_near(
    stiffness, offset, left
):
    signals = SimpleNamespace(q=np.linspace(0.5, 2.5, 50)[:, None])
    fit = Fitted(signals, 0, {}, np.array([stiffness, offset]), np.array([1e-3, 5e-3]))
    assert TERMS['spring']().reduces_to(fit) == left


@pytest.mark.parametrize(('stiffness', 'other'), [(0.0019, 'effort_bias'), (0.0020, '')])
def test_a_spring_whose_interval_holds_no_stiffness_may_be_a_constant_as_well(stiffness, other):
    fit = Fitted(SimpleNamespace(), 0, {}, np.array([stiffness, 0.1]), np.array([1e-3, 5e-3]))
    assert TERMS['spring']().nested(fit) == other
    assert TERMS['spring']().as_stated(np.zeros(2), ('k', 'offset')).nested(fit) == ''


def test_a_torque_constant_within_its_tolerance_is_tolerated_in_one_joint_and_in_all():
    term, fit = fitted('effort_scale', (0.03,), {})
    assert term.tolerated(fit, 0.031)
    assert not term.tolerated(fit, 0.029)
    assert term.counterpart.of_robot
    assert not term.of_robot


def test_a_joint_is_coupled_to_any_other_and_not_to_itself():
    term = TERMS['joint_coupling']()

    def of(n):
        return SimpleNamespace(robot=SimpleNamespace(n=n))

    assert [inner['source'] for inner in term.grid(of(3), 1)] == [0.0, 2.0]
    assert [term.applies(of(n), 0) for n in (1, 2)] == [False, True]
    refused = {k: term.not_undone(2, 1, {'source': k}, None) for k in (0.0, 1.0, 2.0, -1.0)}
    assert refused == {0.0: False, 1.0: True, 2.0: True, -1.0: True}


def test_friction_by_direction_is_tried_with_the_slope_and_without():
    grid = TERMS['asymmetric_friction']().grid(None, 0)
    assert [inner['by_speed'] for inner in grid] == [1.0, 0.0]


#: What terms say of themselves: all that do.
SAID = {
    'at_reversals': {'backlash', 'hysteresis', 'joint_elasticity', 'presliding_hysteresis'},
    'elsewhere_too': {'hysteresis', 'joint_elasticity'},
    'of_law': {
        *('bias', 'coulomb', 'nonlinear_viscous', 'stribeck', 'stribeck_asymmetry', 'viscous'),
        'viscous_asymmetry',
    },
    'of_robot': {'effort_delay', 'gravity_tilt', 'payload'},
    'one_power': {'coulomb', 'nonlinear_viscous', 'stribeck', 'viscous'},
    'parameter_error': {
        *('coulomb', 'effort_bias', 'effort_scale', 'gravity', 'gravity_tilt', 'inertia'),
        'viscous',
    },
    'repeats': {'cogging', 'position_dependent_friction'},
    'reversals_alone': {'presliding_hysteresis'},
    'worn': {'spring'},
}
#: Terms of a fit or a law that a diagnosis does not look for by themselves.
NOT_SEARCHED = {
    *('bias', 'directional_load_friction', 'load_dependent_stribeck', 'maxwell_slip'),
    *('nonlinear_viscous', 'quadratic_load_friction', 'stribeck_asymmetry', 'viscous_asymmetry'),
}


@pytest.mark.parametrize('what', sorted(SAID))
def test_what_terms_say_of_themselves(what):
    assert {name for name in TERMS if getattr(TERMS[name], what)} == SAID[what]


def test_a_diagnosis_looks_for_all_but_the_parts_of_another_term():
    assert {name for name in TERMS if not TERMS[name].searched} == NOT_SEARCHED


@pytest.mark.parametrize('exponent', [0.5, 1.0, 2.0])
def test_the_slopes_of_the_fade_are_those_of_differences(exponent):
    """A central difference of step h = 1e-5 is wrong by h^2 / 6 of the third derivative."""
    v, v_s, h = np.array([-0.2, -0.01, 0.0, 0.02, 0.05, 0.3]), 0.05, 1e-5
    by_velocity, by_exponent = fade_slopes(v, v_s, exponent)
    ahead, behind = (fade(v, v_s * (1.0 + way * h), exponent) for way in (1.0, -1.0))
    np.testing.assert_allclose(by_velocity * v_s, (ahead - behind) / (2.0 * h), atol=1e-8)
    ahead, behind = (fade(v, v_s, exponent + way * h) for way in (1.0, -1.0))
    np.testing.assert_allclose(by_exponent, (ahead - behind) / (2.0 * h), atol=1e-8)


def test_the_rival_of_friction_that_fades_is_its_broad_knee():
    """Half of it is left at v_s, a fifth at twice v_s, and it has no exponent."""
    v, inner = np.array([0.0, 0.05, -0.1]), {'stribeck_velocity': 0.05, 'exponent': 1.0}
    np.testing.assert_allclose(broad_fade(v, 0.05), [1.0, 0.5, 0.2])
    (rival,) = TERMS['stribeck']().rivals()
    one, none = np.ones((3, 1)), np.zeros((3, 0))
    motion = Motion.steady(v[:, None], one)
    np.testing.assert_allclose(rival.effort(motion, 0, inner, none)[0], [1.0, 0.5, 0.2])
    assert rival.refined == ('stribeck_velocity',)
    assert TERMS['coulomb']().rivals() == ()


def test_a_term_that_the_model_states_has_no_rival():
    stated = TERMS['stribeck']().as_stated(np.array([0.3]), ('stribeck joint',))
    assert stated.rivals() == ()
