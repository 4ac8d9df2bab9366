# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Run the real driver against the emulator in emulated time."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from emulated_clock import EmulatedClock
from lockstep_bus import LockstepBus

from sosml_friction.actuators.driver.configuration import DriverConfiguration, read_parameters
from sosml_friction.actuators.driver.driver import JointDriver
from sosml_friction.actuators.driver.joint_sample import JointSample
from sosml_friction.actuators.emulator.emulator import ExoskeletonEmulator, hanging_position
from sosml_friction.actuators.emulator.options import EmulatorOptions
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.exceptions import ActuatorError
from sosml_friction.model.model_folder import read_model
from sosml_friction.model.robot import Robot
from sosml_friction.share import share_directory

#: A servo whose slow filter and single readings let the elbow ripple at slow plateaus.
RIPPLING = {
    'servo_velocity_filter': 5e-3,
    'servo_readings': 1,
    'servo_kp': 240.0,
    'servo_kd': 6.0,
}


def default_configuration() -> DriverConfiguration:
    """Return the driver's configuration in ``config/exoskeleton.yaml``."""
    file = share_directory() / 'config' / 'exoskeleton.yaml'
    return DriverConfiguration.from_parameters(read_parameters(file, 'driver_node'))


def emulated_exoskeleton(
    seed: int = 0,
    *,
    options: EmulatorOptions | None = None,
    configuration: DriverConfiguration | None = None,
    rippling: bool = False,
) -> ExoskeletonEmulator:
    """
    Return the emulated exoskeleton of the package's config/, hanging at rest.

    :param rippling: with the gains that rippled at 24 Hz: 2 mrad/s at the shoulder, 8 at the
        elbow.
    """
    if rippling:
        options = (options or EmulatorOptions()).changed(**RIPPLING)
    configuration = configuration or default_configuration()
    return ExoskeletonEmulator(
        read_model(share_directory() / 'config' / 'emulated_exoskeleton'),
        configuration.joints,
        hanging_position(len(configuration.names)),
        options=options,
        seed=seed,
    )


def nominal_robot() -> Robot:
    """Return the robot of ``config/exoskeleton``, which the driver is told."""
    return read_model(share_directory() / 'config' / 'exoskeleton').make_robot()


class Lockstep:
    """
    Hold a driver and an emulator on one emulated clock and step them together.

    ``samples`` are those of all completed cycles: what the driver node would publish.
    """

    def __init__(
        self,
        emulator: ExoskeletonEmulator,
        configuration: DriverConfiguration | None = None,
        robot: Robot | None = None,
    ) -> None:
        self.emulator = emulator
        self.clock = EmulatedClock(emulator.time_ns)
        self.bus = LockstepBus(emulator, self.clock)
        self.driver = JointDriver(
            configuration or default_configuration(),
            robot or nominal_robot(),
            self.bus,
            self.clock,
        )
        self.samples: list[JointSample] = []
        self._next_ns = 0

    def __enter__(self) -> Lockstep:
        return self

    def __exit__(self, *_: object) -> None:
        """Shut the driver and the bus down."""
        self.driver.shut_down()
        self.bus.shutdown()

    def step(self) -> JointSample | None:
        """Run one cycle at its time on the grid of the driver's period."""
        period_ns = self.driver.configuration.period_ns
        self._align()
        self.clock.sleep_until_ns(self._next_ns)
        self._next_ns += period_ns
        sample = self.driver.step()
        # A driver that sends nothing, for want of a bus, does not stop the plant.
        self.emulator.advance(self.clock.now_ns())
        if sample is not None:
            self.samples.append(sample)
        return sample

    def _align(self) -> None:
        period_ns = self.driver.configuration.period_ns
        late_ns = self.clock.now_ns() - self._next_ns
        if late_ns > 0:
            self._next_ns += late_ns // period_ns * period_ns

    def run(self, seconds: float) -> None:
        """Run the cycles of ``seconds`` of emulated time, from now on."""
        self._align()
        end_ns = self._next_ns + round(seconds * 1e9)
        while self._next_ns < end_ns:
            self.step()

    def run_while(self, condition: Callable[[], bool], at_most: float) -> None:
        """
        Run cycles while ``condition()`` holds.

        :raises ActuatorError: if it still holds after ``at_most`` seconds of emulated time.
        """
        end_ns = self.clock.now_ns() + round(at_most * 1e9)
        while condition():
            if self.clock.now_ns() >= end_ns:
                raise ActuatorError(f'the emulation is not done after {at_most:g} s')
            self.step()

    def log(self, first: int = 0) -> JointLog:
        """Return the samples from number ``first`` on as a log; stamps are emulated time."""
        return samples_to_log(self.driver.configuration.names, self.samples[first:])


def samples_to_log(names: tuple[str, ...], samples: list[JointSample]) -> JointLog:
    """
    Return samples of the driver as a log.

    :raises DataError: if there are none.
    """
    n = len(names)
    return JointLog(
        names=names,
        t_ns=np.array([sample.stamp_ns for sample in samples], dtype=np.int64),
        q=np.array([sample.q for sample in samples]).reshape(-1, n),
        v=np.array([sample.v for sample in samples]).reshape(-1, n),
        tau=np.array([sample.tau for sample in samples]).reshape(-1, n),
    )
