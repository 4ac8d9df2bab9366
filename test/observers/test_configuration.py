# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The configuration that goes into a bag."""

from __future__ import annotations

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.observers.configuration import ObserverConfiguration, parse_configuration
from sosml_friction.observers.registry import OBSERVERS

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
        ({'gains': {'magic': {}}}, "observer 'magic' is unknown: use quasi_static, .*, smoother"),
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
