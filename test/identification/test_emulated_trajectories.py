# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Every trajectory on the emulated exoskeleton: driver core, codecs and arm, in emulated time.

The suite runs short ones about a posture near the hanging arm. ``make validate`` runs them as
``sosml trajectory`` shows them (7 minutes of motion) and prints what each tells of friction.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from full_runs import FULL, only_full
from lockstep import (
    emulated_exoskeleton,
    nominal_robot,
)
from lockstep_run import run_lockstep
from shipped_observers import shipped_estimator

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.identification.data_checks import check_data
from sosml_friction.identification.data_finding import NOTE
from sosml_friction.identification.friction_fit import FitSettings, FrictionFit, fit_friction
from sosml_friction.model.model_folder import read_model
from sosml_friction.model.parameter import NOT_IDENTIFIABLE
from sosml_friction.motion.building_blocks import check_limits
from sosml_friction.motion.trajectories import TRAJECTORIES, build_trajectory
from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.share import share_directory

HANGING = {'shoulder': -0.5 * np.pi, 'elbow': 0.0}
CENTRE = {'shoulder': -0.5 * np.pi, 'elbow': 1.2 if FULL else 0.35}
#: Options that leave little of each but its shape.
SHORT: dict[str, dict[str, Any]] = {
    'speed_ladder': {'speeds': (0.5,), 'plateau': 0.4, 'ramp': 0.2},
    'symmetric_reversals': {'speeds': (0.08,), 'cycles': 1},
    'slow_ladder': {'speeds': (0.08,), 'plateau': 0.5, 'way': 0.02},
    'slow_s_shape': {'cycles': 1, 'plateau': 1.0, 'turn': 1.0},
    'reversal': {'amplitude': 0.2, 'frequency': 1.0, 'cycles': 3.0, 'ramp': 1.0},
    'multisine': {'amplitude': 0.2, 'period': 4.0, 'periods': 1, 'ramp': 1.0},
    'rich': {
        'offset': (0.1,),
        'speeds': (0.3,),
        'plateau': 0.4,
        'amplitude': 0.1,
        'frequency': 1.0,
        'cycles': 1.0,
        'multisine_amplitude': 0.1,
        'period': 2.0,
    },
}
#: Those that take longest: the suite has shorter ones of the same kind.
LONG = ('rich', 'slow_s_shape', 'symmetric_reversals', 'multisine')
#: Largest distance from the trajectory [rad] and, of the servo, which lags, more with speed [s].
NEAR, SERVO_LAG = 0.010, 0.060
#: Shares of the truth that Coulomb and viscous friction may be off by where they are not flagged.
#: Ladders up to 0.4 rad/s or more: as T1 over 40 seeds. Fits of every sample in motion: the bend
#: near standstill, which a lagging observer smears, costs viscous friction up to 13 %.
TOLERANCES = {
    'speed_ladder': (0.05, 0.10),
    'rich': (0.05, 0.10),
    'reversal': (0.05, 0.20),
    'multisine': (0.05, 0.20),
}
#: Those up to 0.08 rad/s, 2.7 v_s, are not for these two: their fit should say so.
OTHERS = (0.10, 0.30)


@lru_cache
def ran(name: str) -> tuple[Trajectory, JointLog]:
    """Return a trajectory and what the driver measured while it was executed."""
    trajectory = build_trajectory(name, HANGING, CENTRE, {} if FULL else SHORT[name])
    return trajectory, run_lockstep(trajectory, emulated_exoskeleton(1))


@pytest.mark.parametrize(
    'name',
    [pytest.param(x, marks=[only_full] if x in LONG else []) for x in TRAJECTORIES],
)
def test_it_is_within_limits_followed_and_measured_without_fault(name):
    """The driver ends it enabled, or run_lockstep would raise; effort stays below its limit."""
    robot = nominal_robot()
    trajectory, log = ran(name)
    check_limits(trajectory, robot, 0.85)
    log = log.select(robot.names)
    wanted = trajectory.spline()(np.clip(log.time, 0.0, trajectory.duration))
    order = [trajectory.names.index(joint) for joint in robot.names]
    error = np.abs(log.q - wanted[:, order]).max(axis=0)
    top = np.abs(trajectory.v).max(axis=0)[order]
    assert error[0] <= NEAR
    assert error[1] <= NEAR + SERVO_LAG * top[1]
    checked, checks = check_data(log, robot)
    assert [f.sentence for f in checks.findings if f.level != NOTE] == []
    assert len(checked) == len(log)
    for joint, limit in zip(robot.names, robot.limits, strict=True):
        assert checks.joints[joint].friction_level > 0.0
        assert checks.joints[joint].top_speed < limit.velocity
    assert (np.nanmax(np.abs(log.tau), axis=0) < [limit.effort for limit in robot.limits]).all()


def fit_of(log: JointLog) -> FrictionFit:
    """Return the fit by SOSML with the gains of config/exoskeleton.yaml."""
    robot = nominal_robot()
    estimator = shipped_estimator(robot, ['sosml'])
    return fit_friction(
        log, estimator.batch(log), robot, estimator.observers, FitSettings(), require=False
    )


@pytest.mark.skipif(not FULL, reason='of whole trajectories, in make validate')
@pytest.mark.parametrize('name', TRAJECTORIES)
def test_coulomb_and_viscous_are_within_tolerance_or_flagged(name):
    truth = read_model(share_directory() / 'config' / 'emulated_exoskeleton')
    trajectory, log = ran(name)
    fit = fit_of(log)
    print(f'\n{name}, {trajectory.duration:.0f} s')
    for joint in ('shoulder', 'elbow'):
        known = truth.joints[joint].friction.parameters
        if joint not in fit.joints:
            print(f'  {joint}: {fit.unavailable[joint]}')
            continue
        found = fit.joints[joint]['sosml']
        cells = []
        for key, p in found.fit.parameters.items():
            flagged = NOT_IDENTIFIABLE in p.flags
            text = f'in {p.interval}' if flagged else f'{p.value:.4f} +- {p.std_error:.4f}'
            cells.append(f'{key} {text} ({known[key].value:g})')
        print(f'  {joint}, {found.method}: ' + ', '.join(cells))
    for joint in fit.joints:
        parameters = fit.joints[joint]['sosml'].fit.parameters
        shares = TOLERANCES.get(name, OTHERS)
        for key, share in zip(('coulomb', 'viscous'), shares, strict=True):
            value = truth.joints[joint].friction.parameters[key].value
            p = parameters[key]
            assert NOT_IDENTIFIABLE in p.flags or abs(p.value - value) <= share * value, (
                f'{name}, {joint}: {key} {p.value:.4g} +- {p.std_error:.2g}, truth {value:g}'
            )
