# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What no working actuator measures: each limit from both sides, in both directions."""

import math

import pytest

from sosml_friction.actuators.measurement import Measurement
from sosml_friction.actuators.plausibility import Plausibility

#: 1.5 * 4 + 0.5 = 6.5 A; 0.3 |speed| + 0.6; 2 * 3 * 0.01 + 0.04 = 0.1; -40 degC.
LIMITS = Plausibility(current=4.0, velocity=3.0, step_slack=0.04)


def doubt(v=0.0, step=0.0, *, current=0.0, speed=0.0, temperature=20.0):
    measured = Measurement(current=current, speed=speed, temperature=temperature)
    return LIMITS.doubt(measured, v, step, 0.01)


@pytest.mark.parametrize('sign', [1.0, -1.0])
def test_a_current_is_doubted_above_its_factor_and_slack(sign):
    assert doubt(current=sign * 6.5) == ''
    assert doubt(current=sign * 6.51) == (
        f'reports {sign * 6.51:.2f} A where its limit is 4 A: its current sensor or its own limit '
        'is wrong'
    )


@pytest.mark.parametrize('sign', [1.0, -1.0])
@pytest.mark.parametrize('side', [1.0, -1.0])
def test_a_speed_is_doubted_further_from_the_slope_than_factor_and_slack(sign, side):
    """At 2 per second: 0.3 * 2 + 0.6 = 1.2 away is allowed."""
    assert doubt(sign * 2.0 + side * 1.199, speed=sign * 2.0) == ''
    v = sign * 2.0 + side * 1.201
    assert doubt(v, speed=sign * 2.0) == (
        f'reports {sign * 2.0:.2f} per second, its position says {v:.2f}: one of its sensors is '
        'wrong'
    )


def test_at_rest_a_slope_is_allowed_up_to_the_slack_itself():
    assert doubt(0.6) == ''
    assert doubt(math.nextafter(0.6, 1.0)) != ''


@pytest.mark.parametrize('sign', [1.0, -1.0])
def test_a_step_is_doubted_above_twice_the_limit_and_slack(sign):
    assert doubt(step=sign * 0.1) == ''
    assert doubt(step=sign * 0.1001) == (
        f'jumps by {sign * 0.1001:.4f} within 10.0 ms, where its limit is 3 per second: its '
        'position sensor is wrong'
    )


def test_the_time_of_a_step_is_told_in_milliseconds():
    assert 'jumps by 9.0000 within 1000.0 ms' in LIMITS.doubt(Measurement(), math.nan, 9.0, 1.0)


def test_a_temperature_is_doubted_below_the_coldest():
    assert doubt(temperature=-40.0) == ''
    assert doubt(temperature=-40.5) == (
        'reports -40 degC, below -40: its temperature sensor is wrong'
    )


def test_what_is_not_measured_is_not_judged():
    nothing = math.nan
    assert doubt(nothing, nothing, current=nothing, speed=nothing, temperature=nothing) == ''
