# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Beyond the limits the effort outward fades, and what cannot stop is braked."""

from __future__ import annotations

import numpy as np
import pytest

from sosml_friction.actuators.driver.soft_stop import SoftStop
from sosml_friction.model.robot import JointLimits

LIMITS = [JointLimits(-1.0, 1.0, 3.0, 8.0), JointLimits(-0.5, 2.0, 3.0, 4.0)]
STOP = SoftStop(LIMITS, np.array([8.0, 4.0]), np.array([12.0, 0.0]), 5.0, 0.1)
ZERO = np.zeros(2)


def test_inside_the_limits_nothing_changes():
    tau = np.array([100.0, -100.0])
    assert STOP.limit(tau, np.array([0.99, 1.99]), ZERO) is tau
    # 1 rad/s stops in 0.1 rad.
    assert STOP.limit(tau, np.array([0.89, -0.39]), np.array([1.0, -1.0])) is tau


@pytest.mark.parametrize('share', [0.0, 0.25, 0.5, 1.0])
def test_beyond_a_limit_the_effort_outward_fades_to_none_at_the_margin(share):
    q = np.array([1.0 + 0.1 * share, -0.5 - 0.1 * share])
    tau = STOP.limit(np.array([100.0, -100.0]), q, ZERO)
    # At the limit itself the joint is not beyond it.
    most = np.array([8.0, -4.0]) * (1.0 - share) if share else [100.0, -100.0]
    np.testing.assert_allclose(tau, most, atol=1e-12)
    inward = np.array([-3.0, 3.0])
    np.testing.assert_array_equal(STOP.limit(inward, q, ZERO), inward)


def test_a_joint_that_cannot_stop_in_time_is_braked_before_the_limit():
    """2 rad/s stops in 0.4 rad: from 0.65 at 1.05, half way into the margin."""
    tau = STOP.limit(np.array([8.0, 0.0]), np.array([0.65, 0.0]), np.array([2.0, 0.0]))
    assert tau[0] == pytest.approx(8.0 * 0.5 - 0.5 * 12.0 * 2.0)
    # On its way back in it is left alone.
    tau = STOP.limit(np.array([-8.0, 0.0]), np.array([1.05, 0.0]), np.array([-0.1, 0.0]))
    assert tau[0] == -8.0


def test_what_is_not_finite_stays_so():
    """The actuator refuses it: it must not be turned into a number here."""
    assert np.isnan(STOP.limit(np.array([np.nan, 0.0]), np.array([1.05, 0.0]), ZERO)[0])


def test_without_a_margin_the_effort_ends_at_the_limit():
    stop = SoftStop(LIMITS, np.array([8.0, 4.0]), np.zeros(2), 5.0, 0.0)
    assert stop.limit(np.array([8.0, 0.0]), np.array([1.001, 0.0]), ZERO)[0] == 0.0
    # Another joint at its limit itself is not beyond it.
    tau = stop.limit(np.array([8.0, 4.0]), np.array([1.001, 2.0]), ZERO)
    np.testing.assert_array_equal(tau, [0.0, 4.0])


@pytest.mark.parametrize('way', [1.0, -1.0])
@pytest.mark.parametrize('v', [0.5, -0.5])
def test_a_joint_inside_its_limits_is_left_alone_while_another_is_beyond(way, v):
    stop = SoftStop(LIMITS, np.array([8.0, 4.0]), np.array([12.0, 12.0]), 5.0, 0.1)
    tau = stop.limit(
        np.array([-3.0 * way, 100.0 * way]), np.array([1.05 * way, 0.5]), np.array([0.0, v])
    )
    np.testing.assert_array_equal(tau, [-3.0 * way, 100.0 * way])


@pytest.mark.parametrize('way', [1.0, -1.0])
def test_far_beyond_the_margin_no_effort_outward_is_left_and_the_damping_is_whole(way):
    q = np.array([1.2 * way, 0.0])
    for tau, left in ((8.0, 0.0), (-3.0, -3.0)):
        assert STOP.limit(np.array([tau * way, 0.0]), q, ZERO)[0] == left * way
    moving = STOP.limit(np.array([-3.0 * way, 0.0]), q, np.array([0.5 * way, 0.0]))
    assert moving[0] == pytest.approx((-3.0 - 12.0 * 0.5) * way)
    # On its way back in it is not damped.
    assert STOP.limit(np.array([-3.0 * way, 0.0]), q, np.array([-0.5 * way, 0.0]))[0] == -3.0 * way
