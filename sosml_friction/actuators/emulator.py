# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The emulated exoskeleton: a plant with friction behind emulated actuators."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sosml_friction.actuators.configuration import RMD_X, ActuatorMount
from sosml_friction.actuators.emulated_actuator import CURRENT_LOOP, EmulatedActuator
from sosml_friction.actuators.emulated_rmd_x import EmulatedRmdX
from sosml_friction.actuators.emulated_servo import EmulatedServo
from sosml_friction.actuators.frame import Frame
from sosml_friction.actuators.servo_dbc import ServoDbc
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.simulation.plant import Plant

FloatArray = NDArray[np.float64]

# Friction as steep as 1.3 Nm over 5 mrad/s on a light forearm needs steps below 0.3 ms.
STEP_NS = 250_000
# A frame of 8 bytes at 1 Mbit/s: two replies of one actuator are at least this far apart.
FRAME_NS = 130_000


@dataclass(frozen=True)
class EmulatorOptions:
    """
    Say how good the emulated hardware is; noises are standard deviations of white noise.

    ``rmd_current_noise`` and ``servo_current_noise`` [A], ``rmd_encoder_noise`` [rad] before the
    0.01 degree rounding, ``servo_encoder_noise`` [rad], ``latency`` from request to reply [s] plus
    half-normal ``latency_jitter`` [s], ``comm_timeout`` of the motors and ``servo_watchdog`` [s],
    0 for none in the motor; ``rmd_current_limit`` and ``servo_current_limit`` [A] are the
    hardware's own; ``servo_kp`` [A/rad] and ``servo_kd`` [A s/rad] of the servo's position loop.
    """

    rmd_current_noise: float = 0.03
    rmd_encoder_noise: float = 2e-5
    rmd_current_limit: float = 7.2
    servo_current_noise: float = 0.005
    servo_encoder_noise: float = 5e-5
    servo_current_limit: float = 5.0
    servo_current_available: bool = True
    servo_kp: float = 240.0
    servo_kd: float = 6.0
    servo_watchdog: float = 0.05
    comm_timeout: float = 0.05
    latency: float = 3e-4
    latency_jitter: float = 5e-5


class ExoskeletonEmulator:
    """
    Answer CAN frames as the hardware would, in emulated time that starts at 0.

    The plant is M q'' + C q' + g = tau - tau_f of the truth model, integrated in steps of 0.25 ms
    on a fixed grid, whatever the times of the frames: a command takes effect at the grid point
    after its arrival, a measurement is extrapolated from the one before. So the same frames at the
    same times give the same answers, bit for bit, for one seed.

    Not modelled: bus arbitration, errors and load; joint end stops, sticking (a static smooth
    friction creeps), backlash, joint elasticity, the wearer, temperature-dependent friction; and
    what :class:`EmulatedRmdX` and :class:`EmulatedServo` say of themselves.

    :param model: the truth: rigid body, armature and friction of each joint.
    :param mounts: the actuator of each joint: type, identifier, direction, zero offset and, where
        ``torque_constants`` does not say otherwise, torque constant.
    :param position: where the joints rest at the start (n,) [rad or m].
    :param torque_constants: of the hardware that is really there, by joint [Nm/A or N/A].
    :raises ConfigurationError: if joints or numbers do not fit.
    """

    def __init__(
        self,
        model: RobotModelFile,
        mounts: Sequence[ActuatorMount],
        position: Sequence[float],
        *,
        options: EmulatorOptions | None = None,
        torque_constants: Mapping[str, float] | None = None,
        seed: int = 0,
    ) -> None:
        names = tuple(mount.name for mount in mounts)
        if model.joint_names != names or len(position) != len(model.joint_names):
            raise ConfigurationError(
                f'the emulated model has the joints {", ".join(model.joint_names)}, the actuators '
                f'{", ".join(names)} and the start position {len(position)} values: '
                'make them the same'
            )
        self.names = model.joint_names
        self.options = options or EmulatorOptions()
        self.plant = Plant(
            model.make_robot(),
            model.friction_laws(),
            np.array(position, dtype=float),
            np.zeros(len(position)),
        )
        seeds = np.random.SeedSequence(seed).spawn(len(self.names) + 1)
        self.actuators = tuple(
            self._make(mount, dict(torque_constants or {}), own_seed)
            for mount, own_seed in zip(mounts, seeds[:-1], strict=True)
        )
        self._by_id = {actuator.request_id: i for i, actuator in enumerate(self.actuators)}
        self._latency_rng = np.random.default_rng(seeds[-1])
        self._last_reply_ns = [0] * len(self.actuators)
        self._grid_ns = 0
        self.foreign_frames = 0

    def _make(
        self,
        joint: ActuatorMount,
        torque_constants: Mapping[str, float],
        seed: np.random.SeedSequence,
    ) -> EmulatedActuator:
        options = self.options
        constant = torque_constants.get(joint.name, joint.torque_constant)
        if joint.driver == RMD_X:
            return EmulatedRmdX(
                joint.name,
                can_id=joint.can_id,
                torque_constant=constant,
                direction=joint.direction,
                zero_offset=joint.zero_offset,
                current_limit=options.rmd_current_limit,
                current_noise=options.rmd_current_noise,
                encoder_noise=options.rmd_encoder_noise,
                comm_timeout_ns=round(options.comm_timeout * 1e9),
                seed=seed,
            )
        return EmulatedServo(
            joint.name,
            dbc=ServoDbc(joint.dbc),
            torque_constant=constant,
            direction=joint.direction,
            zero_offset=joint.zero_offset,
            current_limit=options.servo_current_limit,
            kp=options.servo_kp,
            kd=options.servo_kd,
            current_noise=options.servo_current_noise,
            current_available=options.servo_current_available,
            encoder_noise=options.servo_encoder_noise,
            watchdog_ns=round(options.servo_watchdog * 1e9),
            seed=seed,
        )

    @property
    def time_ns(self) -> int:
        """Return the emulated time the plant has reached [ns]."""
        return self._grid_ns

    @property
    def q(self) -> FloatArray:
        """Return the true position (n,) [rad or m]."""
        return self.plant.q.copy()

    @property
    def v(self) -> FloatArray:
        """Return the true velocity (n,) [rad/s or m/s]."""
        return self.plant.v.copy()

    @property
    def effort(self) -> FloatArray:
        """Return the true effort of the actuators (n,) [Nm or N]."""
        return np.array([actuator.effort for actuator in self.actuators])

    def actuator(self, name: str) -> EmulatedActuator:
        """Return the emulated actuator of joint ``name``."""
        return self.actuators[self.names.index(name)]

    def advance(self, t_ns: int) -> None:
        """Integrate up to the last point of the grid that is not after ``t_ns`` [ns]."""
        plant, actuators = self.plant, self.actuators
        h = STEP_NS * 1e-9
        share = -math.expm1(-h / CURRENT_LOOP)
        effort = np.empty(len(actuators))
        while self._grid_ns + STEP_NS <= t_ns:
            # Plain floats: arithmetic on NumPy's scalars costs several times as much.
            states = zip(actuators, plant.q.tolist(), plant.v.tolist(), strict=True)
            for i, (actuator, q, v) in enumerate(states):
                actuator.control(self._grid_ns, q, v)
                actuator.advance(share)
                effort[i] = actuator.effort
            plant.step(effort, h)
            self._grid_ns += STEP_NS

    def handle(self, frame: Frame, t_ns: int) -> list[tuple[int, Frame]]:
        """
        Take a frame that arrived at ``t_ns`` and return its replies with the times they leave.

        Times must not decrease from call to call.
        """
        i = self._by_id.get(frame.can_id)
        if i is None:
            self.foreign_frames += 1
            return []
        self.advance(t_ns)
        ahead = (t_ns - self._grid_ns) * 1e-9
        v = float(self.plant.v[i])
        reply = self.actuators[i].handle(frame, t_ns, float(self.plant.q[i]) + ahead * v, v)
        if reply is None:
            return []
        options = self.options
        delay = options.latency + options.latency_jitter * abs(
            float(self._latency_rng.standard_normal())
        )
        t_reply = max(t_ns + round(delay * 1e9), self._last_reply_ns[i] + FRAME_NS)
        self._last_reply_ns[i] = t_reply
        return [(t_reply, reply)]


def hanging_position(count: int) -> tuple[float, ...]:
    """Return where an arm of ``count`` joints hangs straight: -pi/2 and zeros, at rest."""
    return (-0.5 * math.pi, *([0.0] * (count - 1)))
