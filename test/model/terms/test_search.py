# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Where each term is looked for: its inner parameters, in which range, and in what data."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from sosml_friction.model.parameter import Z_95
from sosml_friction.model.terms.cogging import lines
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.term import TERMS

TURN = 2.0 * np.pi
#: What searches a Stribeck velocity, and an exponent from 0.5 to 2.5.
FADING = ('stribeck', 'load_dependent_stribeck', 'stribeck_asymmetry')


def recording(
    unit='rad', span=2.0, speed=3.0, cutoff=12.0, whole=300.0, warm=None, whole_torque=()
):
    """Return a recording of one joint: its range, top speed, length and warmth."""
    scales = SimpleNamespace(
        span=np.array([span]), speed=np.array([speed]), sign_limit=np.array([1e-3])
    )
    return SimpleNamespace(
        scales=scales,
        length_unit=lambda joint: unit,
        effort_unit=lambda joint: 'Nm' if unit == 'rad' else 'N',
        robot=SimpleNamespace(inertia_units=('kg m2',)),
        band=SimpleNamespace(cutoff=cutoff),
        time=np.linspace(0.0, whole, 4),
        temperature=None if warm is None else np.array(warm)[:, None],
        whole_torque=np.array(whole_torque, dtype=float)[:, None],
    )


def values(name, key, **own):
    """Return the values of an inner parameter that are tried."""
    return np.array([inner[key] for inner in TERMS[name]().grid(recording(**own), 0)])


@pytest.mark.parametrize(
    ('own', 'first'),
    [
        # Three periods in a range of 2 rad; four per turn where that is more; three along a slide.
        ({'span': 2.0}, 3.0 * TURN / 2.0),
        ({'span': 6.0}, 4.0),
        ({'unit': 'm', 'span': 6.0}, 3.0 * TURN / 6.0),
    ],
)
def test_cogging_repeats_three_times_in_the_range_or_four_times_in_a_turn(own, first):
    assert values('cogging', 'frequency', **own)[0] == pytest.approx(first)


def test_a_line_of_cogging_is_within_a_fifth_of_a_period_of_one_that_is_tried():
    """Over the range, 2.5 / 2 rad: a fifth of a turn, of which sin(x) / x leaves 76 % and more."""
    found = values('cogging', 'frequency', span=2.0)
    assert np.diff(found) == pytest.approx(np.full(len(found) - 1, 2.5 / 2.0))
    assert np.sinc(0.5 * 2.5 / TURN) > 0.75


def test_cogging_passes_the_band_where_the_joint_is_slow():
    """At 0.04 of 3 rad/s, a line of w has 0.04 * 3 * w / 2 pi Hz, which is within 12."""
    found = values('cogging', 'frequency', span=20.0, unit='m')
    last = 12.0 * TURN / (0.04 * 3.0)
    assert last - 2.5 / 0.6 <= values('cogging', 'frequency', span=0.6)[-1] < last
    # Of a long range no more than 400 are tried.
    assert found[-1] < 400 * 2.5 / 20.0
    assert len(found) == pytest.approx(400 - 3.0 * TURN / 2.5, abs=1.0)


def test_of_many_turns_what_repeats_in_each_is_tried_up_to_400():
    found = values('cogging', 'frequency', span=20.0)
    dense = found[found < 400 * 2.5 / 20.0]
    whole = found[len(dense) :]
    assert np.diff(dense) == pytest.approx(np.full(len(dense) - 1, 2.5 / 20.0))
    assert whole.tolist() == list(range(50, 400))
    bounds = TERMS['cogging']().inner_bounds(recording(span=20.0), 0)['frequency']
    assert bounds == pytest.approx((3.0 * TURN / 20.0, 400.0))
    # Less than a turn, or a slide, has its own.
    for own in ({'span': 6.0}, {'span': 20.0, 'unit': 'm'}):
        bounds = TERMS['cogging']().inner_bounds(recording(**own), 0)['frequency']
        assert bounds == pytest.approx((3.0 * TURN / own['span'], 400 * 2.5 / own['span']))


def test_lines_in_equal_steps_are_their_sines():
    q = np.linspace(-1.0, 2.0, 7)
    found = lines.py_func(q, 3.0, 0.7, 5)
    angle = np.outer(q, 3.0 + 0.7 * np.arange(5))
    np.testing.assert_allclose(found, np.stack([np.cos(angle), np.sin(angle)], 2), atol=1e-14)
    signals = SimpleNamespace(q=q[:, None])
    own = TERMS['cogging']().own_columns
    even = [{'frequency': 3.0 + 0.7 * k} for k in range(5)]
    np.testing.assert_allclose(own(signals, 0, even), found, atol=1e-14)
    # Steps that differ by more than rounding are none.
    for k in range(2, 5):
        uneven = [dict(inner) for inner in even]
        uneven[k]['frequency'] += 1e-9
        assert own(signals, 0, uneven) is None
    assert own(signals, 0, even[:1]).shape == (7, 1, 2)


def test_cogging_is_no_more_than_all_of_the_measured_effort():
    """Of sines of 3 and 4 Nm the mean square is 12.5."""
    for effort, why in ((3.53, 'more than all'), (3.54, '')):
        signals = SimpleNamespace(scales=SimpleNamespace(effort=np.array([effort])))
        fit = Fitted(signals, 0, {}, np.array([3.0, 4.0]), np.zeros(2))
        assert why in TERMS['cogging']().implausible(fit)
        assert bool(why) == bool(TERMS['cogging']().implausible(fit))


def test_friction_by_posture_has_one_or_two_periods_in_a_turn_and_half_periods_on_a_slide():
    name = 'position_dependent_friction'
    assert values(name, 'frequency').tolist() == [1.0, 2.0]
    assert values(name, 'frequency', unit='m', span=0.5) == pytest.approx(
        TURN / (2.0 * 0.5) * np.arange(1, 7)
    )


def test_friction_that_builds_up_does_so_over_more_than_the_sign():
    found = values('presliding_hysteresis', 'displacement')
    assert (np.diff(found) > 0.0).all()
    low, high = TERMS['presliding_hysteresis']().inner_bounds(recording(), 0)['displacement']
    assert (low, high) == (1e-3, pytest.approx(0.04))
    # A factor of 1.7 at most from one to the next, as build-ups that differ by less look alike.
    assert low < found[0] <= 1.3 * low
    assert high / 2.0 <= found[-1] < high
    assert (found[1:] / found[:-1]).max() < 1.7


def test_a_hysteresis_begins_at_a_share_of_the_range_and_turns_around_within_it():
    found = values('hysteresis', 'displacement', span=2.0)
    assert found[[0, -1]] == pytest.approx([0.016, 1.0])
    assert np.diff(np.log(found)) == pytest.approx(np.full(19, np.log(62.5) / 19.0))
    term = TERMS['hysteresis']()
    bounds = [term.inner_bounds(recording(span=x), 0)['displacement'] for x in (2.0, 0.05)]
    # Not below what the data resolve.
    assert bounds == [pytest.approx((0.016, 1.0)), pytest.approx((1e-3, 0.025))]
    # A joint that moves by less than two displacements of its sign is not asked.
    assert [term.applies(recording(span=x), 0) for x in (1.9e-3, 2.1e-3)] == [False, True]


def test_slip_of_several_blocks_is_tried_by_factors_of_two():
    found = values('maxwell_slip', 'displacement')
    low, high = TERMS['maxwell_slip']().inner_bounds(recording(), 0)['displacement']
    assert found == pytest.approx(1e-3 * 2.0 ** np.arange(1, 6))
    assert (low, high) == (1e-3, pytest.approx(0.08))


@pytest.mark.parametrize(
    ('displacement', 'error', 'nothing'),
    [(0.9e-3, 0.0, True), (1.1e-3, 0.0, False), (1.1e-3, 0.11e-3 / Z_95, True)],
)
def test_build_up_over_what_the_sign_has_is_nothing(displacement, error, nothing):
    scales = SimpleNamespace(displacement=np.array([1e-3]))
    inner = {'displacement': displacement}
    fit = Fitted(
        SimpleNamespace(scales=scales), 0, inner, np.ones(1), np.ones(1), {'displacement': error}
    )
    assert TERMS['presliding_hysteresis']().tolerated(fit, 0.0) == nothing
    assert (
        error
        or TERMS['presliding_hysteresis']().tolerated(
            Fitted(fit.signals, 0, inner, fit.amplitude, fit.error), 0.0
        )
        == nothing
    )


@pytest.mark.parametrize(
    ('level', 'displacement', 'coulomb', 'why'),
    [
        (0.0, 4e-3, 1.0, 'negative'),
        (0.41, 4e-3, 1.0, ''),
        (0.39, 4e-3, 1.0, 'where all of it does'),
        (1.99, 4e-3, 1.0, ''),
        (2.01, 4e-3, 1.0, '2.01 of Coulomb friction would build up'),
        # F (x_s - x_0) is what shows: 1 / (1 - x_0 / x_s) of C near the sign's own x_0.
        (4.9, 1.25e-3, 1.0, ''),
        (5.1, 1.25e-3, 1.0, 'where all of it does'),
        (50.0, 1e-3, 1.0, ''),
        (1.0, 4e-3, 0.0, 'no Coulomb friction'),
        (50.0, 4e-3, np.nan, ''),
    ],
)
def test_what_builds_up_is_the_coulomb_friction_of_the_model(level, displacement, coulomb, why):
    scales = SimpleNamespace(displacement=np.array([1e-3]), coulomb=np.array([coulomb]))
    fit = Fitted(
        SimpleNamespace(scales=scales), 0, {'displacement': displacement}, np.array([level]), None
    )
    said = TERMS['presliding_hysteresis']().implausible(fit)
    assert why in said
    assert bool(why) == bool(said)


@pytest.mark.parametrize('name', FADING)
def test_a_stribeck_velocity_is_between_a_two_hundredth_and_four_tenths_of_the_top_speed(name):
    term = TERMS[name]()
    found = values(name, 'stribeck_velocity', speed=3.0)
    assert found[[0, -1]] == pytest.approx([0.03, 0.75])
    assert len(found) == 7
    assert found[1:] / found[:-1] == pytest.approx(np.full(6, 25.0 ** (1.0 / 6.0)))
    assert values(name, 'exponent').tolist() == [1.0] * 7
    bounds = term.inner_bounds(recording(speed=3.0), 0)
    assert bounds['stribeck_velocity'] == pytest.approx((0.015, 1.2))
    assert bounds['exponent'] == (0.5, 2.5)


def test_friction_that_warms_up_takes_a_minute_and_is_sought_where_it_shows():
    term = TERMS['thermal_drift']()
    assert [term.applies(recording(whole=s), 0) for s in (199.5, 200.5)] == [False, True]
    assert values('thermal_drift', 'time_constant', whole=300.0) == pytest.approx([120, 240, 480])
    # No gear warms up within a minute.
    assert values('thermal_drift', 'time_constant', whole=100.0).tolist() == [60, 80, 160]
    low, high = term.inner_bounds(recording(whole=300.0), 0)['time_constant']
    assert (low, high) == (60.0, 1200.0)
    assert term.units(recording(), 0)['coulomb_drift'] == 'Nm'


@pytest.mark.parametrize(
    ('warm', 'measured'),
    [
        ((20.0, 21.0, 22.0, 22.1), True),
        ((22.1, 22.0, 21.0, 20.0), True),
        ((20.0, 21.0, 22.0, 22.0), False),
        ((20.0, np.nan, 25.0, 30.0), False),
    ],
)
def test_a_temperature_that_changes_by_more_than_two_degrees_stands_for_time(warm, measured):
    term, signals = TERMS['thermal_drift'](), recording(whole=100.0, warm=warm)
    assert term.applies(signals, 0) == measured
    units = term.units(signals, 0)
    ending = '/degC' if measured else ''
    assert [units[key] for key in term.amplitudes] == [f'Nm s/rad{ending}', f'Nm{ending}']
    assert units['time_constant'] == 's'
    tried = [inner['time_constant'] for inner in term.grid(signals, 0)]
    assert (tried == [0.0]) == measured
    assert (term.inner_bounds(signals, 0) == {}) == measured


def test_saturation_is_of_the_largest_torque_but_for_a_hundredth_of_the_time():
    torque = np.append(np.full(990, -2.0), np.full(9, 50.0))
    assert values('effort_saturation', 'reference', whole_torque=torque) == pytest.approx([2.0])
    assert values('effort_saturation', 'reference', whole_torque=np.zeros(9)).tolist() == [1e-9]
