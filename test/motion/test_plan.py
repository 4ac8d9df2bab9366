# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A planned trajectory: its demands are the extremes of its samples, beside the robot's limits."""

import numpy as np
import pytest

from sosml_friction.motion.plan import Demand, plan_trajectory


def test_demands_are_the_extremes_of_the_samples_with_the_limits_of_the_robot():
    planned = plan_trajectory('reversal', stated=['acceleration_limit=4,9'])
    loads = planned.loads
    for i, limit in enumerate(planned.robot.limits):
        demands = planned.demands(i)
        for name, values in (('speed', loads.v), ('acceleration', loads.a), ('effort', loads.tau)):
            k = int(np.flatnonzero(loads.t == demands[name].at_s)[0])
            assert demands[name].peak == abs(values[k, i]) == np.abs(values[:, i]).max()
        assert demands['speed'].limit == limit.velocity
        assert demands['acceleration'].limit == (4.0, 9.0)[i]
        assert demands['effort'].limit == limit.effort
        # Of the effort 15 % are friction's.
        assert demands['effort'].allowance == pytest.approx(0.15 * limit.effort)
        assert demands['speed'].allowance == 0.0


def test_a_share_counts_what_friction_needs_and_is_not_told_without_a_limit():
    assert Demand(3.0, 1.0, 8.0, 1.0).share == 0.5
    assert Demand(3.0, 1.0, None).share is None
    assert plan_trajectory('reversal').demands(0)['acceleration'].share is None


def test_a_trajectory_beyond_a_limit_says_which():
    beyond = plan_trajectory('speed_ladder', stated=['centre=0,1']).beyond
    assert {(use.joint, use.quantity) for use in beyond} == {('shoulder', 'rigid-body effort')}
    assert plan_trajectory('speed_ladder').beyond == []
