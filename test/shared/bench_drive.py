# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A type of actuator from outside the package: it takes current and numbers its replies."""

from __future__ import annotations

import math
import struct
from collections.abc import Hashable
from dataclasses import dataclass

from sosml_friction.actuators.actuator import Actuator
from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.driver.start_up import Check, Request, Step
from sosml_friction.actuators.emulator.emulated_actuator import EmulatedActuator
from sosml_friction.actuators.joint_configuration import HostLoop, JointConfiguration
from sosml_friction.actuators.parameter import parameter
from sosml_friction.exceptions import CanProtocolError

OFF, READ, CURRENT = range(3)
COMMAND = struct.Struct('<BBh4x')
STATE = struct.Struct('<BhiB')


@dataclass(frozen=True)
class BenchConfiguration(JointConfiguration):
    """Say which node it is and how it is driven."""

    driver = 'bench_drive'

    node: int = parameter('its number on the bus', 0, mount=True, above=0.0)
    bench_current: float = parameter('most current to command', 6.0, unit='A', above=0.0)
    bench_kp: float = parameter('proportional gain', 250.0, unit='Nm/rad', above=0.0)
    bench_kd: float = parameter('derivative gain', 12.0, unit='Nm s/rad', least=0.0)

    def check_drive(self):
        """Need nothing more: everything has a default."""

    def loop(self, limits):
        """Return the loop on the host."""
        limit = min(self.bench_current * self.torque_constant, limits.effort)
        return HostLoop(self.bench_kp, self.bench_kd, limit, 625.0)


@dataclass(frozen=True)
class BenchOptions:
    """Say how good the emulated drive is."""

    bench_watchdog: float = parameter('off after so long without a frame', 0.05, unit='s')


class EmulatedBench(EmulatedActuator):
    """Give the current that was commanded, and 16 bits of state."""

    options_type = BenchOptions

    def __init__(self, mount, options, seed):
        super().__init__(mount, options, seed, current_limit=7.0)
        self._node = mount.node
        self._watchdog_ns = round(options.bench_watchdog * 1e9)
        self._heard_ns = 0
        self._tripped = False

    @property
    def request_id(self):
        return 0x500 + self._node

    def restart(self, t_ns):
        self._commanded = 0.0
        self._heard_ns = t_ns
        self._tripped = False

    def trip(self, t_ns):
        self.watchdog_trips += self._commanded != 0.0
        self._commanded = 0.0
        self._tripped = True

    def handle(self, frame, t_ns, q, v):
        self.frames += 1
        self._heard_ns = t_ns
        try:
            mode, number, counts = COMMAND.unpack(frame.data)
        except struct.error:
            self.undecodable += 1
            return None
        bits = self._fault_bits() & 0x7F
        if mode != READ:
            self._commanded = self._clamped(counts * 1e-3) if mode == CURRENT and not bits else 0.0
        tripped, self._tripped = self._tripped, False
        angle = round(self._position(q) * 1e5)
        state = STATE.pack(number, round(self.current * 1e3), angle, bits | 0x80 * tripped)
        return Frame(0x580 + self._node, state)

    def control(self, t_ns, q, v):
        if self._fault_bits():
            self._commanded = 0.0
        if t_ns - self._heard_ns > self._watchdog_ns and not self._tripped:
            self.trip(t_ns)


class BenchActuator(Actuator):
    """Command current, read angle and current; a reply has the number of its request."""

    configuration_type = BenchConfiguration
    emulated_type = EmulatedBench

    def __init__(self, configuration, limits, rate, **rest):
        super().__init__(configuration, limits, rate, **rest)
        self._number = 0
        self._last = 0.0
        self._bits = 0
        self._limit = min(
            configuration.bench_current, limits.effort / configuration.torque_constant
        )
        self._step = 625.0 / configuration.torque_constant / rate

    reply_id = property(lambda self: 0x580 + self.configuration.node)
    request_ids = property(lambda self: frozenset({0x500 + self.configuration.node}))
    frames_per_cycle = property(lambda self: 2.0)

    def _request(self, mode, current=0.0):
        self._number = (self._number + 1) % 256
        data = COMMAND.pack(mode, self._number, round(current * 1e3))
        frame = Frame(0x500 + self.configuration.node, data)
        return [Request(frame, (self.reply_id, self._number))]

    def start_up(self, *, read_only, watchdog=True):
        def check():
            return Check(self.name, 'position', '', self.fault() or self.out_of_band())

        return [Step('position', self.probe, check)]

    def probe(self):
        return self._request(READ)

    def command(self, setpoint, now_ns):
        current = self.configuration.direction * setpoint.effort
        current /= self.configuration.torque_constant
        if not math.isfinite(current):
            raise CanProtocolError(f'joint {self.name}: the effort {current} is not finite')
        current = min(max(current, -self._limit), self._limit)
        self._last = min(max(current, self._last - self._step), self._last + self._step)
        return self._request(CURRENT, self._last)

    def observe(self, now_ns):
        return self._request(READ)

    def release(self, now_ns):
        self._last = 0.0
        return self._request(OFF)

    def shut_down(self):
        return self.release(0)

    def key(self, frame: Frame) -> Hashable:
        if len(frame.data) != STATE.size:
            raise CanProtocolError(f'frame {frame} is no state')
        return frame.can_id, frame.data[0]

    def accept(self, frame, stamp_ns):
        _, current, angle, bits = STATE.unpack(frame.data)
        own, measured = self.configuration, self.measurement
        measured.current = current * 1e-3
        measured.tau = own.direction * own.torque_constant * measured.current
        measured.q = own.direction * angle * 1e-5 + own.zero_offset
        measured.position_raw = angle
        measured.stamp_ns = stamp_ns
        self.timeouts += bool(bits & 0x80)
        self._bits = bits & 0x7F

    def flags(self):
        return f'{self._bits:#04x}' if self._bits else 'none'

    def error(self):
        return f'joint {self.name}: the drive reports {self.flags()}' if self._bits else ''
