# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The configuration that goes into a bag, and the gains made by recipe."""

from __future__ import annotations

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError, DataError
from sosml_friction.observers.configuration import (
    OBSERVERS,
    ObserverConfiguration,
    make_observer,
    parse_configuration,
)
from sosml_friction.observers.recipe import configuration_for, gains_from_noise

numbers = st.floats(0.0, allow_infinity=False)


@st.composite
def configurations(draw):
    joints = draw(st.lists(st.text('abc_1', min_size=1), min_size=1, max_size=4, unique=True))
    gains = {
        name: {
            gain: draw(st.lists(numbers, min_size=len(joints), max_size=len(joints)))
            for gain in OBSERVERS[name].gain_units
        }
        for name in draw(st.sets(st.sampled_from(sorted(OBSERVERS)), min_size=1))
    }
    holds = draw(st.sampled_from(['start', 'mean', 'end']))
    return ObserverConfiguration(
        tuple(joints),
        gains,
        draw(st.sampled_from([(), (holds,) * len(joints)])),
        draw(st.sampled_from(['message', 'position_difference'])),
        draw(st.floats(1e-9, 1e9)),
    )


@given(configurations())
def test_yaml_gives_every_float_back_to_the_last_bit(configuration):
    assert parse_configuration(configuration.to_yaml(), 'bag') == configuration


def good():
    return {
        'format': 'sosml_friction/observers/1',
        'joints': ['shoulder', 'elbow'],
        'effort_hold': [],
        'velocity_source': 'message',
        'maximum_gap_s': 0.05,
        'gains': {'first_order': {'cutoff': [40.0, 40.0]}},
    }


@pytest.mark.parametrize(
    ('change', 'words'),
    [
        ({'format': 'other'}, 'has no entry format: sosml_friction/observers/1'),
        ({'gains': [1, 2]}, 'is not an observer configuration'),
        ({'gains': {'first_order': 3.0}}, 'is not an observer configuration'),
        ({'joints': 3}, 'is not an observer configuration'),
        ({'maximum_gap_s': 'long'}, 'is not an observer configuration'),
    ],
)
def test_a_configuration_that_cannot_be_read_names_its_source(change, words):
    with pytest.raises(ConfigurationError, match=words) as caught:
        parse_configuration(yaml.safe_dump({**good(), **change}), 'topic of bag')
    assert str(caught.value).startswith('topic of bag')
    assert '\n' not in str(caught.value)


@pytest.mark.parametrize('key', sorted(set(good()) - {'format'}))
def test_an_entry_that_is_missing_is_named(key):
    document = good()
    del document[key]
    with pytest.raises(ConfigurationError, match=f'topic lacks {key}'):
        parse_configuration(yaml.safe_dump(document), 'topic')


@pytest.mark.parametrize('text', ['', '[1,', 'plain', 'a: [\n - b'])
def test_text_that_is_no_configuration_is_refused_in_one_sentence(text):
    with pytest.raises(ConfigurationError, match=r'^topic ') as caught:
        parse_configuration(text, 'topic')
    assert '\n' not in str(caught.value)


@pytest.mark.parametrize(
    ('change', 'words'),
    [
        ({'joints': ('elbow', 'shoulder')}, 'configured for elbow, shoulder where the model has'),
        ({'gains': {'kalman': {}}}, "observer 'kalman' is unknown: use first_order, sosml"),
        ({'gains': {'first_order': {'cutoff': [40.0]}}}, 'has gains for 1 joints'),
        ({'gains': {}}, 'at least one'),
        ({'effort_hold': ('start',)}, 'one for each of shoulder, elbow'),
        ({'velocity_source': 'guess'}, 'velocity_source'),
    ],
)
def test_a_configuration_that_does_not_fit_the_robot_is_refused(two_joints, change, words):
    configuration = ObserverConfiguration(
        **{
            'joints': ('shoulder', 'elbow'),
            'gains': {'first_order': {'cutoff': [40.0, 40.0]}},
            **change,
        }
    )
    with pytest.raises(ConfigurationError, match=words) as caught:
        configuration.make_estimator(two_joints)
    assert '\n' not in str(caught.value)


def test_a_configuration_makes_the_estimator_it_describes(two_joints):
    configuration = ObserverConfiguration(
        ('shoulder', 'elbow'),
        {'first_order': {'cutoff': [40.0, 30.0]}},
        ('end', 'start'),
        'position_difference',
        0.2,
    )
    estimator = configuration.make_estimator(two_joints)
    assert list(estimator.observers) == ['first_order']
    assert estimator.observers['first_order'].gains['cutoff'].tolist() == [40.0, 30.0]
    assert (estimator.velocity_source, estimator.maximum_gap_s) == ('position_difference', 0.2)


def test_the_recipe_is_its_formula():
    """c0 = w; S2 = w^2, T2 = w (zeta 0.5); S1 = 0.1 S2 s_p; T1 = 1.6 sqrt(S1)."""
    gains = gains_from_noise(40.0, [0.01, 0.0])
    assert gains['first_order'] == {'cutoff': [40.0, 40.0]}
    assert gains['sosml']['linear'] == [1600.0, 1600.0]
    assert gains['sosml']['linear_damping'] == [40.0, 40.0]
    assert gains['sosml']['sliding'] == pytest.approx([1.6, 0.0])
    assert gains['sosml']['sliding_root'] == pytest.approx([1.6 * 1.6**0.5, 0.0])
    for name, values in gains.items():
        assert make_observer(name, values).n == 2


@pytest.mark.parametrize(
    ('bandwidth', 'noise'),
    [(x, [0.1]) for x in (0.0, -1.0, np.nan, np.inf)]
    + [(40.0, [x]) for x in (-1.0, np.nan, np.inf)],
)
def test_a_recipe_from_numbers_out_of_range_is_refused(bandwidth, noise):
    with pytest.raises(ConfigurationError, match='must be positive'):
        gains_from_noise(bandwidth, noise)


def sine_log(noise_v=0.0, noise_q=0.0, with_velocity=True, n=20_000, seed=0):
    rng = np.random.default_rng(seed)
    t = np.arange(n) * 1e-3
    q = 0.1 * np.sin(2 * np.pi * 0.5 * t) + noise_q * rng.normal(size=n)
    v = 0.1 * np.pi * np.cos(2 * np.pi * 0.5 * t) + noise_v * rng.normal(size=n)
    if not with_velocity:
        v = np.full(n, np.nan)
    t_ns = np.arange(n, dtype=np.int64) * 1_000_000
    return JointLog(('slider',), t_ns, q[:, None], v[:, None], np.zeros((n, 1)))


@pytest.mark.parametrize('sigma', [1e-4, 1e-3, 1e-2])
def test_the_measured_momentum_noise_is_the_injected_white_one(slider, sigma):
    """p = 95.1 kg v: within 20 %; 5000 second differences know their median to about 2 %."""
    configuration = configuration_for(sine_log(noise_v=sigma), slider, bandwidth=40.0)
    s1 = configuration.gains['sosml']['sliding'][0]
    assert s1 / (0.1 * 1600.0) == pytest.approx(95.1089 * sigma, rel=0.2)
    assert configuration.velocity_source == 'message'


def test_two_coupled_joints_have_the_noise_of_their_rows_of_the_inertia(two_joints):
    """Velocity noise of joint 1 alone enters both momenta, by M11 and M21."""
    rng = np.random.default_rng(1)
    n, q0 = 20_000, np.array([-0.9, 1.1])
    v = np.column_stack([0.01 * rng.normal(size=n), np.zeros(n)])
    q = np.broadcast_to(q0, (n, 2)).copy()
    t_ns = np.arange(n, dtype=np.int64) * 1_000_000
    log = JointLog(('shoulder', 'elbow'), t_ns, q, v, np.zeros((n, 2)))
    s1 = np.array(configuration_for(log, two_joints).gains['sosml']['sliding'])
    expected = 0.1 * 1600.0 * 0.01 * two_joints.inertia(q0)[:, 0]
    np.testing.assert_allclose(s1, expected, rtol=0.2)


def test_a_recording_without_velocity_gets_differences_and_their_noise(slider):
    """
    Differences of white position noise s have sqrt(2) s / h, neighbours opposed.

    The second difference is then the third of position, std sqrt(20) s / h: over sqrt(6) that is
    1.83 s / h, 29 % above sqrt(2), on the safe side. 20 % on that number.
    """
    sigma = 1e-6
    log = sine_log(noise_q=sigma, with_velocity=False)
    configuration = configuration_for(log, slider)
    assert configuration.velocity_source == 'position_difference'
    s1 = configuration.gains['sosml']['sliding'][0]
    expected = 95.1089 * np.sqrt(20.0 / 6.0) * sigma / 1e-3
    assert s1 / (0.1 * 1600.0) == pytest.approx(expected, rel=0.2)


def test_repeated_stamps_and_holes_do_not_disturb_the_measured_noise(slider):
    log = sine_log(noise_v=1e-3)
    log.t_ns[5000:] -= 1_000_000
    log.q[9000:9500] = np.nan
    s1 = configuration_for(log, slider).gains['sosml']['sliding'][0]
    assert s1 / 160.0 == pytest.approx(95.1089e-3, rel=0.2)


@pytest.mark.parametrize(('count', 'hole'), [(9, None), (200, 2)])
def test_a_recording_in_which_noise_cannot_be_measured_is_refused(slider, count, hole):
    log = sine_log(n=count)
    if hole:
        log.q[::hole] = np.nan
    with pytest.raises(DataError, match='ten or more, one after the other'):
        configuration_for(log, slider)


def test_slow_recordings_have_their_gap_measured_in_their_own_steps(slider):
    """A gap is 25 periods, at least 0.05 s."""
    log = sine_log(noise_v=1e-3)
    assert configuration_for(log, slider).maximum_gap_s == 0.05
    slow = JointLog(log.names, log.t_ns * 10, log.q, log.v, log.tau)
    assert configuration_for(slow, slider).maximum_gap_s == pytest.approx(0.25)
