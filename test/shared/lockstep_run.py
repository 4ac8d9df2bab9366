# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A trajectory from the start of the driver to its end, in emulated time."""

from __future__ import annotations

from lockstep import Lockstep

from sosml_friction.actuators.driver.configuration import DriverConfiguration
from sosml_friction.actuators.driver.report import DriverState
from sosml_friction.actuators.emulator.emulator import ExoskeletonEmulator
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ActuatorError
from sosml_friction.model.robot import Robot
from sosml_friction.motion.trajectory import Trajectory


def run_lockstep(
    trajectory: Trajectory,
    emulator: ExoskeletonEmulator,
    configuration: DriverConfiguration | None = None,
    robot: Robot | None = None,
    *,
    settle: float = 0.1,
) -> JointLog:
    """
    Execute ``trajectory`` with the real driver core, codecs and emulator; return what it measured.

    The driver is configured, runs ``settle`` [s] released, is enabled, follows the trajectory,
    holds for ``settle`` and shuts down. The log has every sample from the enabling to the end of
    the hold: exactly what the driver node would publish, stamped in emulated time.

    :param configuration: the driver's, that of ``config/exoskeleton.yaml`` if None.
    :param robot: the nominal model, that of ``config/exoskeleton`` if None.
    :raises ActuatorError: if the driver refuses or faults.
    :raises TrajectoryError: if the trajectory is refused.
    """
    with Lockstep(emulator, configuration, robot) as lockstep:
        driver = lockstep.driver
        driver.configure()
        lockstep.run(settle)
        driver.enable()
        first = len(lockstep.samples)
        driver.follow(trajectory)
        lockstep.run_while(lambda: driver.trajectory_running, trajectory.duration + 1.0)
        lockstep.run(settle)
        report = driver.report()
        if report.state is not DriverState.ENABLED:
            raise ActuatorError(report.reason)
    return lockstep.log(first)
