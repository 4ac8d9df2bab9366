# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Drives in which random frames come in among the answers, for the reliability run."""

from __future__ import annotations

import heapq
from typing import Any

import can
import numpy as np

from sosml_friction.actuators.bus.clock import Clock
from sosml_friction.actuators.bus.frame import Frame
from sosml_friction.actuators.driver.configuration import DriverConfiguration, read_parameters
from sosml_friction.actuators.driver.driver import JointDriver
from sosml_friction.actuators.driver.joint_sample import JointSample
from sosml_friction.actuators.driver.report import DriverState
from sosml_friction.actuators.emulator.emulator import ExoskeletonEmulator, hanging_position
from sosml_friction.actuators.rmd_x import codec as rmd_x
from sosml_friction.actuators.servo.dbc import Mode, ServoDbc
from sosml_friction.exceptions import SosmlFrictionError
from sosml_friction.model.model_folder import read_model
from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.share import share_directory
from validation.silent import SilentError

#: Random frames in each case.
FRAMES = 500
_CONFIG = share_directory() / 'config'
#: A controller that is off the bus restarts by itself after so long (restart-ms 100) [ns].
_RESTART_NS = 100_000_000
_BUS_OFF, _RESTARTED = 0x040, 0x100
#: A command is rounded to so much [A].
_ROUNDED = 0.005
#: Kinds of frames and how often each is; another program's commands and errors of the controller
#: end the drive for a second or so, and are rare. Random frames come with one of eight questions.
_HOW = {
    'answer': 0.15, 'flipped': 0.2, 'twice': 0.2, 'foreign': 0.2, 'short': 0.14, 'remote': 0.1,
    'request': 0.005, 'error': 0.005,
}  # fmt: skip
_SHARE = 0.125


class _StandingClock(Clock):
    """A clock that moves only when told to."""

    def __init__(self) -> None:
        self.time_ns = 0

    def now_ns(self) -> int:
        """Return the time [ns]."""
        return self.time_ns

    def sleep_until_ns(self, t_ns: int) -> None:
        """Set the time unless it is later already."""
        self.time_ns = max(self.time_ns, t_ns)


class _NoisyBus(can.BusABC):
    """
    Carry the frames between driver and emulator, and as many random ones as ``left`` says.

    ``sent``: the frames of the driver since it was emptied last.
    """

    def __init__(self, emulator: ExoskeletonEmulator, clock: _StandingClock, rng: Any) -> None:
        self._emulator, self._clock, self._rng = emulator, clock, rng
        self._answers: list[tuple[int, int, can.Message]] = []
        self._count = 0
        self._before = can.Message(arbitration_id=0x241, data=bytes(8), is_extended_id=False)
        self.left = 0
        self.sent: list[Frame] = []
        self._can_protocol = can.CanProtocol.CAN_20
        super().__init__(channel='noisy')

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Give the emulator a frame; random ones may come before its answer."""
        frame = Frame.from_message(msg)
        assert frame is not None
        self.sent.append(frame)
        now_ns = self._clock.now_ns()
        self._emulator.advance(now_ns)
        for t_ns, reply in [*self._emulator.handle(frame, now_ns), *self._emulator.take_sent()]:
            self._push(t_ns, reply.to_message())
        if self.left and self._rng.random() < _SHARE:
            self.left -= 1
            message = self._random(frame)
            self._push(now_ns + int(self._rng.integers(0, 600_000)), message)
            if message.is_error_frame and message.arbitration_id & _BUS_OFF:
                again = can.Message(
                    arbitration_id=_RESTARTED, is_error_frame=True, is_extended_id=False
                )
                self._push(now_ns + _RESTART_NS, again)

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """Return what is due within ``timeout`` [s]."""
        end_ns = self._clock.now_ns() + round((timeout or 0.0) * 1e9)
        if not self._answers or self._answers[0][0] > end_ns:
            self._clock.sleep_until_ns(end_ns)
            return None
        t_ns, _, message = heapq.heappop(self._answers)
        self._clock.sleep_until_ns(t_ns)
        self._before = message
        return message

    def _push(self, t_ns: int, message: can.Message) -> None:
        self._count += 1
        heapq.heappush(self._answers, (t_ns, self._count, message))

    def _random(self, asked: Frame) -> can.Message:
        rng = self._rng
        how = rng.choice(list(_HOW), p=list(_HOW.values()))
        answering = 0x171 if asked.can_id < 0x180 and asked.can_id >= 0x170 else 0x241
        identifier, data = answering, rng.bytes(8)
        if how == 'answer':
            # As if to that question: what cannot be true must be found by its value.
            data = asked.data[:1] + rng.bytes(7)
        elif how == 'flipped':
            identifier, flipped = self._before.arbitration_id, bytearray(self._before.data)
            if flipped:
                flipped[rng.integers(len(flipped))] ^= 1 << int(rng.integers(8))
            data = bytes(flipped)
        elif how == 'twice':
            identifier, data = self._before.arbitration_id, bytes(self._before.data)
        elif how == 'request':
            identifier = asked.can_id
        elif how in ('foreign', 'error'):
            identifier = int(rng.integers(0x800))
        elif how == 'short':
            data = rng.bytes(int(rng.integers(8)))
        return can.Message(
            arbitration_id=identifier,
            data=b'' if how == 'remote' else data,
            dlc=8 if how == 'remote' else None,
            is_extended_id=False,
            is_remote_frame=how == 'remote',
            is_error_frame=how == 'error',
        )


class RandomFrames:
    """
    Drive the emulated exoskeleton to and fro among random frames.

    What is promised: no frame ends the program; no current beyond the limit is commanded, none
    where the driver is not enabled, and the servo is then off; a sample is finite. A fault with
    its reason is what many frames deserve, and is told.
    """

    def __init__(self) -> None:
        values = read_parameters(_CONFIG / 'exoskeleton.yaml', 'driver_node')
        self._configuration = DriverConfiguration.from_parameters(values)
        self._model = read_model(_CONFIG / 'emulated_exoskeleton')
        self._robot = read_model(_CONFIG / 'exoskeleton').make_robot()
        self._dbc = ServoDbc(_CONFIG / 'elbow_servo.dbc')

    def __call__(self, rng: np.random.Generator) -> list[str]:
        """
        Run a drive, and return the faults.

        :raises SilentError: if a promise was broken.
        """
        clock, configuration = _StandingClock(), self._configuration
        start = hanging_position(len(configuration.names))
        emulator = ExoskeletonEmulator(
            self._model, configuration.joints, start, seed=int(rng.integers(2**31))
        )
        bus = _NoisyBus(emulator, clock, rng)
        driver = JointDriver(configuration, self._robot, bus, clock)
        driver.configure()
        faults: list[str] = []
        quiet = 0
        bus.left = FRAMES
        try:
            # And a while after the last of them.
            while bus.left or quiet < 50:
                quiet += not bus.left
                self._look(driver, start, faults, rng)
                bus.sent.clear()
                before = driver.state
                sample = driver.step()
                self._judge(bus.sent, before, driver.state, sample)
                clock.sleep_until_ns(clock.now_ns() + configuration.period_ns // 2)
        finally:
            driver.shut_down()
            bus.shutdown()
        return faults

    def _look(
        self, driver: JointDriver, start: Any, faults: list[str], rng: np.random.Generator
    ) -> None:
        """Enable it again, and let it swing."""
        report = driver.report()
        if report.state is DriverState.FAULT and report.reason not in faults:
            faults.append(report.reason)
        try:
            if report.state is not DriverState.ENABLED:
                driver.enable()
            elif not report.trajectory_running:
                q = np.array([joint.q for joint in report.joints])
                goal = np.array(start) + rng.uniform(0.1, 0.4, len(start))
                driver.follow(
                    Trajectory(
                        driver.configuration.names,
                        np.array([0.0, 1.0]),
                        np.array([q, goal]),
                        np.zeros((2, len(start))),
                    )
                )
        except SosmlFrictionError:
            # Refused, with its reason: as it should while it does not know where it is.
            return

    def _judge(
        self,
        sent: list[Frame],
        before: DriverState,
        after: DriverState,
        sample: JointSample | None,
    ) -> None:
        limit = self._configuration.joints[0]
        most = getattr(limit, 'current_limit', 0.0) + _ROUNDED
        free = DriverState.ENABLED not in (before, after)
        for frame in sent:
            if frame.can_id == 0x141:
                _, request = rmd_x.decode_request(frame)
                current = request.current if isinstance(request, rmd_x.SetCurrent) else 0.0
                if not abs(current) <= (0.0 if free else most):
                    raise SilentError(f'{current} A were commanded while {before.value}')
            elif free and self._dbc.decode_command(frame).mode is not Mode.OFF:
                raise SilentError(f'the servo was on while {before.value}')
        if sample is not None and not np.isfinite(sample.q).all():
            raise SilentError(f'a sample has the positions {sample.q}')
