# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Which of the paper's trajectories a recording is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.several.bag_roles import find_roles, parse_roles
from sosml_friction.motion.trajectories import TRAJECTORIES, build_trajectory


def recorded(name, scale=1.0, **values):
    """Return a trajectory of one joint at 250 Hz, read by an encoder of 16 bit."""
    path = build_trajectory(name, {'j': 0.1}, {'j': 0.1}, values)
    t = np.arange(0.0, path.duration, 0.004)
    step = 2.0 * np.pi / 2**16
    q = np.round(path.spline()(t) / step) * scale * step
    unknown = np.full_like(q, np.nan)
    return JointLog(('j',), np.rint(t * 1e9).astype(np.int64), q, unknown, unknown)


@pytest.fixture(scope='module')
def logs():
    return {name: recorded(name) for name in TRAJECTORIES}


def test_ladders_and_reversals_are_told_by_their_motion(logs):
    roles = {label: role.role for label, role in find_roles(logs).items()}
    assert roles == {
        'speed_ladder': 'T1',
        'symmetric_reversals': 'T2',
        'slow_ladder': 'T3',
        'slow_s_shape': 'T2',
        'reversal': 'T2',
        'multisine': '',
        'rich': '',
    }
    assert all(role.source == 'motion' for role in find_roles(logs).values())


def test_a_ladder_is_slow_beside_a_faster_one_whatever_its_units():
    """A slider of millimetres is judged as a joint of radians is: by ratios."""
    logs = {name: recorded(name, 1e-3) for name in ('speed_ladder', 'slow_ladder')}
    assert [role.role for role in find_roles(logs).values()] == ['T1', 'T3']
    alone = find_roles({'only': recorded('slow_ladder')})
    assert alone['only'].role == 'T1'


def test_what_was_recorded_comes_before_motion_and_what_is_stated_before_both(logs):
    tagged = replace(logs['multisine'], tags={'trajectory': 'slow_ladder'})
    labelled = replace(logs['multisine'], tags={'trajectory_label': 'T2', 'trajectory': 'mine'})
    other = replace(logs['speed_ladder'], tags={'trajectory': 'multisine'})
    given = {'a': tagged, 'b': labelled, 'c': other}
    roles = find_roles(given)
    assert [roles[key].role for key in 'abc'] == ['T3', 'T2', '']
    assert all(role.source == 'recorded' for role in roles.values())
    stated = find_roles(given, parse_roles(['a=T1', 'b=other'], list(given)))
    assert (stated['a'].role, stated['a'].source) == ('T1', 'stated')
    assert (stated['b'].role, stated['b'].source) == ('', 'stated')
    assert stated['c'] == roles['c']


@pytest.mark.parametrize('text', ['T1', 'a=T4', 'b=T1', 'a=', '=T1'])
def test_a_role_that_cannot_be_is_one_sentence(text):
    with pytest.raises(ConfigurationError, match='BAG=ROLE: the bags are a, a role is T1, T2'):
        parse_roles([text], ['a'])


def test_a_joint_that_stands_has_no_role():
    still = np.zeros((100, 1))
    log = JointLog(('j',), np.arange(100) * 4_000_000, still, still, still)
    assert find_roles({'still': log})['still'].role == ''


def test_the_speed_in_a_reason_has_its_unit(logs):
    only = {'a': logs['speed_ladder']}
    assert find_roles(only)['a'].reason.split(',')[0].endswith(' rad/s')
    units = dict.fromkeys(only['a'].names, 'N')
    assert find_roles(only, None, units)['a'].reason.split(',')[0].endswith(' m/s')
