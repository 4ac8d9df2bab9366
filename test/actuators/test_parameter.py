# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A number from a parameter file is within the bounds that a node would hold it to."""

import math
from dataclasses import replace

import pytest

from sosml_friction.actuators.driver.configuration import DriverConfiguration, read_parameters
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.share import share_directory


@pytest.fixture(scope='module')
def configuration():
    values = read_parameters(share_directory() / 'config' / 'exoskeleton.yaml', 'driver_node')
    own = {k: v for k, v in values.items() if k not in ('can_interface', 'can_channel')}
    return DriverConfiguration.from_parameters(own)


@pytest.mark.parametrize(
    ('name', 'value', 'sentence'),
    [
        ('limit_margin', math.nan, 'limit_margin is nan: it must be a finite number'),
        ('limit_margin', -0.1, 'limit_margin is -0.1: it must be from 0 to 1'),
        ('start_tolerance', math.inf, 'start_tolerance is inf: it must be a finite number'),
        ('bitrate', 0, 'can_bitrate is 0: it must be from 10000 to 1e'),
        ('rate', 1e-9, 'rate is 1e-09: it must be from 10 to 1000'),
        ('stop_deceleration', 1e300, 'stop_deceleration is 1e.300: it must be from 0.01 to 1000'),
    ],
)
def test_a_number_that_no_node_takes_is_refused(configuration, name, value, sentence):
    with pytest.raises(ConfigurationError, match=sentence):
        replace(configuration, **{name: value})


def test_a_number_at_a_bound_is_taken(configuration):
    assert replace(configuration, rate=1000.0, limit_margin=0.0).rate == 1000.0
