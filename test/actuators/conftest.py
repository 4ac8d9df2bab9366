# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""An emulated exoskeleton with the real driver on it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest
from lockstep import (
    Lockstep,
    default_configuration,
    emulated_exoskeleton,
)

from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.driver.configuration import DriverConfiguration
from sosml_friction.actuators.emulator.options import EmulatorOptions
from sosml_friction.motion.trajectory import Trajectory


class Recorded(Lockstep):
    """A lockstep that notes every frame the emulator saw and every reply it gave."""

    def __init__(self, emulator, configuration, **kwargs):
        super().__init__(emulator, configuration, **kwargs)
        self.seen: list[tuple[int, Frame]] = []
        self.filter: Callable[[Frame, list], list] = lambda frame, replies: replies
        handle = emulator.handle

        def noted(frame, t_ns):
            self.seen.append((t_ns, frame))
            return self.filter(frame, handle(frame, t_ns))

        emulator.handle = noted

    def currents(self, since: int = 0) -> np.ndarray:
        """Return every current commanded to the shoulder [A], from seen frame ``since`` on."""
        return np.array(
            [
                int.from_bytes(frame.data[4:6], 'little', signed=True) / 100
                for _, frame in self.seen[since:]
                if frame.can_id == 0x141 and frame.data[0] == 0xA1
            ]
        )

    def servo_modes(self, since: int = 0) -> set[int]:
        """Return the modes commanded to the elbow, from seen frame ``since`` on."""
        return {frame.data[0] for _, frame in self.seen[since:] if frame.can_id == 0x170}


@pytest.fixture
def make_lockstep() -> Iterator[Callable[..., Recorded]]:
    made: list[Recorded] = []

    def make(
        *,
        seed: int = 0,
        options: EmulatorOptions | None = None,
        joint: dict[str, dict] | None = None,
        **changes,
    ) -> Recorded:
        configuration = default_configuration()
        joints = tuple(replace(j, **(joint or {}).get(j.name, {})) for j in configuration.joints)
        configuration = replace(configuration, joints=joints, **changes)
        emulator = emulated_exoskeleton(seed, options=options, configuration=configuration)
        made.append(Recorded(emulator, configuration))
        return made[-1]

    yield make
    for lockstep in made:
        lockstep.bus.shutdown()


@pytest.fixture
def lockstep(make_lockstep) -> Recorded:
    """Return a driver that is configured and has run 0.1 s released."""
    result = make_lockstep()
    result.driver.configure()
    result.run(0.1)
    return result


@pytest.fixture
def configuration() -> DriverConfiguration:
    return default_configuration()


@pytest.fixture
def there_and_back() -> Trajectory:
    """Return a motion of 2 s: from hanging by 0.5 and 0.8 rad, and back."""
    hanging = np.array([-np.pi / 2, 0.0])
    return Trajectory(
        ('shoulder', 'elbow'),
        np.array([0.0, 1.0, 2.0]),
        np.array([hanging, hanging + np.array([0.5, 0.8]), hanging]),
        np.zeros((3, 2)),
    )
