# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The emulated exoskeleton: a plant with friction behind emulated actuators."""

import heapq
import math
from collections.abc import Sequence

import numpy as np

from sosml_friction.actuators.actuator import Actuator
from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.emulator.emulated_actuator import CURRENT_LOOP, EmulatedActuator
from sosml_friction.actuators.emulator.fault import (
    REPLIES,
    REQUESTS,
    Fault,
    FaultPlace,
    parse_faults,
)
from sosml_friction.actuators.emulator.frame_faults import FRAME_NS, FrameFaults, TimedFrame
from sosml_friction.actuators.emulator.options import EmulatorOptions
from sosml_friction.actuators.joint_configuration import JointConfiguration
from sosml_friction.arrays import FloatArray
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.model_folder import RobotModelFile
from sosml_friction.simulation.plant import Plant

# Friction as steep as 1.3 Nm over 5 mrad/s on a light forearm needs steps below 0.3 ms.
STEP_NS = 250_000


class ExoskeletonEmulator:
    """
    Answer CAN frames as the hardware would, in emulated time that starts at 0.

    The plant is M q'' + C q' + g = tau - tau_f of the truth model, integrated in steps of 0.25 ms
    on a fixed grid, whatever the times of the frames: a command takes effect at the grid point
    after its arrival, a measurement is extrapolated from the one before. So the same frames at the
    same times give the same answers, bit for bit, for one seed.

    What ``bus_off``, ``tx_full`` and ``adapter_gone`` look like to the host is the bus object's
    matter; here no frame passes meanwhile.

    Not modelled: bus arbitration, error counters and load; joint end stops, sticking (a static
    smooth friction creeps), backlash, joint elasticity, the wearer, temperature-dependent
    friction; and what the emulated actuators say of themselves.

    :param mounts: the actuator of each joint: type, identifier, direction, zero offset and torque
        constant of the hardware that is really there.
    :param position: where the joints rest at the start (n,) [rad or m].
    :raises ConfigurationError: if joints or numbers do not fit.
    """

    def __init__(
        self,
        model: RobotModelFile,
        mounts: Sequence[JointConfiguration],
        position: Sequence[float],
        *,
        options: EmulatorOptions | None = None,
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
        kinds = [Actuator.kind(mount.driver).emulated_type for mount in mounts]
        self.actuators: tuple[EmulatedActuator, ...] = tuple(
            kind(mount, self.options.of(kind), own_seed)
            for kind, mount, own_seed in zip(kinds, mounts, seeds[:-1], strict=True)
        )
        self._by_id = {actuator.request_id: i for i, actuator in enumerate(self.actuators)}
        if len(self._by_id) != len(self.actuators):
            raise ConfigurationError(
                'two emulated actuators listen to one identifier: give each its own'
            )
        self._latency_rng = np.random.default_rng(seeds[-1])
        self._last_reply_ns = [0] * len(self.actuators)
        #: The emulated time that the plant has reached [ns].
        self.time_ns = 0
        self.foreign_frames = 0
        self._frame_faults = FrameFaults(np.random.SeedSequence((seed, 1)))
        #: Those that stand now.
        self.faults: tuple[Fault, ...] = ()
        self._wanted: tuple[Fault, ...] = ()
        # Requests that arrive late, and replies nobody waits for: time, order, joint, frame.
        self._late: list[tuple[int, int, int, Frame]] = []
        self._sent: list[TimedFrame] = []
        self._count = 0

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
        while self.time_ns + STEP_NS <= t_ns:
            while self._late and self._late[0][0] <= self.time_ns:
                late_ns, _, i, frame = heapq.heappop(self._late)
                self._sent += self._answer(i, frame, max(late_ns, self.time_ns))
            # Plain floats: arithmetic on NumPy's scalars costs several times as much.
            states = zip(actuators, plant.q.tolist(), plant.v.tolist(), strict=True)
            for i, (actuator, q, v) in enumerate(states):
                actuator.run(self.time_ns, q, v)
                actuator.advance(share)
                effort[i] = actuator.effort
                for frame in actuator.take_unsolicited():
                    self._sent += self._reply(actuator.name, self.time_ns, frame)
            plant.step(effort, h)
            self.time_ns += STEP_NS

    def handle(self, frame: Frame, t_ns: int) -> list[tuple[int, Frame]]:
        """Take a frame that arrived at ``t_ns``, which never falls; return its timed replies."""
        i = self._by_id.get(frame.can_id)
        if i is None:
            self.foreign_frames += 1
            return []
        self.advance(t_ns)
        if self.bus_fault() is not None:
            return []
        replies: list[TimedFrame] = []
        heard_at = self._frame_faults.through(self.names[i], REQUESTS, t_ns, frame, self.faults)
        for arrival_ns, heard in heard_at:
            if arrival_ns > t_ns:
                self._count += 1
                heapq.heappush(self._late, (arrival_ns, self._count, i, heard))
            else:
                replies += self._answer(i, heard, t_ns)
        return replies

    def _answer(self, i: int, frame: Frame, t_ns: int) -> list[TimedFrame]:
        ahead = (t_ns - self.time_ns) * 1e-9
        v = float(self.plant.v[i])
        reply = self.actuators[i].take(frame, t_ns, float(self.plant.q[i]) + ahead * v, v)
        if reply is None:
            return []
        options = self.options
        delay = options.latency + options.latency_jitter * abs(
            float(self._latency_rng.standard_normal())
        )
        t_reply = max(t_ns + round(delay * 1e9), self._last_reply_ns[i] + FRAME_NS)
        self._last_reply_ns[i] = t_reply
        t_reply += self.actuators[i].reply_delay_ns(frame)
        return self._reply(self.names[i], t_reply, reply)

    def _reply(self, joint: str, t_ns: int, frame: Frame) -> list[TimedFrame]:
        return self._frame_faults.through(joint, REPLIES, t_ns, frame, self.faults)

    def take_sent(self) -> list[tuple[int, Frame]]:
        """
        Return the frames that left without :meth:`handle` returning them, with their times.

        What an actuator says unasked, and answers to requests that arrived late. They are there
        once :meth:`advance` has passed their time.
        """
        if self.bus_fault() is not None:
            self._sent.clear()
        sent, self._sent = self._sent, []
        return sent

    # ---- faults

    def bus_fault(self) -> Fault | None:
        """Return the fault of the bus as a whole, or None."""
        return next((own for own in self.faults if own.kind.place is FaultPlace.BUS), None)

    def inject(self, faults: str) -> None:
        """
        Let faults begin, besides those that stand: ``drop joint=shoulder; delay seconds=0.01``.

        :raises ConfigurationError: if one of them does not exist; then none begins.
        """
        for fault in parse_faults(faults, self.names):
            self._set((*self.faults, *(() if fault.kind.event else (fault,))))
            if fault.kind.place is FaultPlace.ACTUATOR:
                for actuator in self.actuators:
                    if fault.joint in ('', actuator.name):
                        actuator.happen(fault, self.time_ns)

    def clear(self, name: str = '') -> None:
        """End the faults called ``name``, all if it is empty."""
        self._set(tuple(own for own in self.faults if name and own.name != name))

    def set_faults(self, faults: str) -> None:
        """
        Have these faults and no others: those that stand already go on, the others begin.

        :raises ConfigurationError: if one of them does not exist; then nothing changes.
        """
        wanted = parse_faults(faults, self.names)
        before, self._wanted = self._wanted, wanted
        self._set(tuple(own for own in self.faults if own in wanted))
        self.inject('; '.join(str(fault) for fault in wanted if fault not in before))

    def _set(self, faults: tuple[Fault, ...]) -> None:
        self.faults = faults
        self._frame_faults.forget()
        own = [fault for fault in faults if fault.kind.place is FaultPlace.ACTUATOR]
        for actuator, q in zip(self.actuators, self.plant.q.tolist(), strict=True):
            actuator.set_faults(
                tuple(fault for fault in own if fault.joint in ('', actuator.name)), q
            )


def hanging_position(count: int) -> tuple[float, ...]:
    """Return where an arm of ``count`` joints hangs straight: -pi/2 and zeros, at rest."""
    return (-0.5 * math.pi, *([0.0] * (count - 1)))
