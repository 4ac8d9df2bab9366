# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Run the driver for minutes over slcan/TCP and account for every cycle: ``make soak``.

The emulated exoskeleton in a process of its own, the driver's core with its cycle thread here, two
actuators, 500 Hz, swinging to and fro. At the end: is every cycle counted, has memory or the
number of threads grown, by how much cycles were late, as a histogram, and how long an answer took
in the first quarter and in the last. Exit code 1 if a count does not add up or something grew. How
late cycles are is the machine's affair and never judged.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import sys
import threading
import time
from collections import Counter
from dataclasses import asdict, dataclass, field, replace
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

from sosml_friction.actuators.bus.clock import Clock
from sosml_friction.actuators.bus.open_bus import open_bus
from sosml_friction.actuators.bus.slcan_server import SlcanServerBus
from sosml_friction.actuators.driver.configuration import DriverConfiguration, read_parameters
from sosml_friction.actuators.driver.cycle_thread import CycleThread
from sosml_friction.actuators.driver.driver import JointDriver
from sosml_friction.actuators.driver.joint_sample import JointSample
from sosml_friction.actuators.driver.report import DriverState
from sosml_friction.actuators.emulator.emulator import ExoskeletonEmulator, hanging_position
from sosml_friction.actuators.emulator.emulator_thread import EmulatorThread
from sosml_friction.actuators.emulator.options import EmulatorOptions
from sosml_friction.exceptions import SosmlFrictionError
from sosml_friction.model.model_folder import read_model
from sosml_friction.motion.trajectory import Trajectory
from sosml_friction.share import share_directory

CONFIG = share_directory() / 'config'
# Nobody wears the emulated arm: a machine that stops for half a second does not end the soak.
PATIENCE_S = 0.5
# Time before memory is measured first [s], and the most it may grow from then on [MB]: an
# allocator's arena is 1 MB, and a leak of one small object per cycle is 30 MB in ten minutes.
# The time is chosen, no measurement.
SETTLE_S = 30.0
MOST_GROWTH_MB = 4.0


class BeginClock(Clock):
    """Remember the first time that is told to the thread of the cycle: when it began."""

    def __init__(self) -> None:
        self.begin_ns: int | None = None

    def now_ns(self) -> int:
        """Return the time now [ns]."""
        now_ns = super().now_ns()
        if self.begin_ns is None and threading.current_thread().name == 'can cycle':
            self.begin_ns = now_ns
        return now_ns


@dataclass
class SoakResult:
    """Hold what was counted; times [s], memory [MB]."""

    seconds: float
    rate: float
    slots: int = 0
    cycles: int = 0
    skipped: int = 0
    incomplete: int = 0
    came_late: int = 0
    samples: int = 0
    backward_stamps: int = 0
    overruns: int = 0
    begun: str = ''
    late: str = ''
    most_late_ms: float = 0.0
    frames_sent: int = 0
    frames_heard: int = 0
    frames_received: int = 0
    stale: int = 0
    foreign: int = 0
    undecodable: int = 0
    missed: int = 0
    threads: list[int] = field(default_factory=list)
    latency_ms: list[float] = field(default_factory=list)
    memory_mb: list[float] = field(default_factory=list)
    emulator_mb: list[float] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)

    def problems(self) -> list[str]:
        """Return what does not add up, one sentence each."""
        result = []
        if abs(self.cycles + self.skipped - self.slots) > 1:
            result.append(
                f'{self.slots} cycles were due, but {self.cycles} ran and {self.skipped} were '
                'counted as skipped'
            )
        if self.samples != self.cycles - self.incomplete - self.came_late:
            result.append(
                f'{self.cycles} cycles with {self.incomplete} incomplete and {self.came_late} '
                f'late gave {self.samples} samples'
            )
        if self.backward_stamps:
            result.append(f'{self.backward_stamps} stamps did not increase')
        if self.frames_sent != self.frames_heard:
            result.append(
                f'{self.frames_sent} frames were sent, the actuators heard {self.frames_heard}'
            )
        if len(set(self.threads)) > 1:
            result.append(f'the number of threads went from {self.threads[0]} to {self.threads}')
        for who, memory in (('driver', self.memory_mb), ('emulator', self.emulator_mb)):
            if memory and growth_mb(memory) > MOST_GROWTH_MB:
                result.append(f'the memory of the {who} grew by {growth_mb(memory):.1f} MB')
        return result


def growth_mb(memory: list[float]) -> float:
    """Return the median of the last third minus that of the first third."""
    third = max(1, len(memory) // 3)
    return float(np.median(memory[-third:]) - np.median(memory[:third]))


def default_configuration() -> DriverConfiguration:
    """Return the driver's configuration in ``config/exoskeleton.yaml``."""
    values = read_parameters(CONFIG / 'exoskeleton.yaml', 'driver_node')
    return DriverConfiguration.from_parameters(values)


def emulate(connection: Connection) -> None:
    """Be the hardware, in a process of its own, until told to end; then say what it heard."""
    sys.setswitchinterval(5e-4)
    joints = default_configuration().joints
    emulator = ExoskeletonEmulator(
        read_model(CONFIG / 'emulated_exoskeleton'),
        joints,
        hanging_position(len(joints)),
        options=EmulatorOptions(comm_timeout=PATIENCE_S, servo_watchdog=PATIENCE_S),
    )
    bus = SlcanServerBus('127.0.0.1:0')
    thread = EmulatorThread(bus, emulator)
    thread.start()
    connection.send(bus.port)
    connection.recv()
    thread.stop()
    bus.shutdown()
    connection.send(sum(actuator.frames for actuator in emulator.actuators))


def resident_mb(pid: int) -> float:
    """Return the resident memory of a process [MB]."""
    with open(f'/proc/{pid}/statm', encoding='ascii') as stream:
        return int(stream.read().split()[1]) * os.sysconf('SC_PAGE_SIZE') / 2**20


def swing() -> Trajectory:
    """Return a motion of 4 s from hanging and back."""
    hanging = np.array([-np.pi / 2, 0.0])
    return Trajectory(
        ('shoulder', 'elbow'),
        np.array([1.0, 2.5, 4.0]),
        np.array([hanging, hanging + np.array([0.5, 0.8]), hanging]),
        np.zeros((3, 2)),
    )


def soak(seconds: float, rate: float = 500.0, *, progress: bool = False) -> SoakResult:
    """
    Run it.

    :raises SosmlFrictionError: if the driver cannot be started.
    """
    sys.setswitchinterval(5e-4)
    context = multiprocessing.get_context('spawn')
    here, there = context.Pipe()
    process = context.Process(target=emulate, args=(there,), daemon=True)
    process.start()
    assert process.pid is not None
    bus = None
    try:
        port = here.recv()
        bus = open_bus('slcan', f'socket://127.0.0.1:{port}', 1_000_000)
        clock = BeginClock()
        configuration = default_configuration()
        configuration = replace(
            configuration,
            rate=rate,
            missed_limit=max(1, round(PATIENCE_S * rate)),
            reply_timeout=0.02,
        )
        robot = read_model(CONFIG / 'exoskeleton').make_robot()
        driver = JointDriver(configuration, robot, bus, clock)
        print(f'bus load: {driver.bus_load()}', file=sys.stderr)
        driver.configure()
        result = _run(driver, clock, seconds, process.pid, progress)
        result.frames_sent = driver.report().bus.sent
        here.send(None)
        result.frames_heard = here.recv()
        return result
    finally:
        if bus is not None:
            bus.shutdown()
        process.terminate()
        process.join()


def _run(
    driver: JointDriver, clock: BeginClock, seconds: float, emulator: int, progress: bool
) -> SoakResult:
    result = SoakResult(seconds, driver.configuration.rate)
    last = 0

    def count(sample: JointSample) -> None:
        nonlocal last
        result.samples += 1
        result.backward_stamps += sample.stamp_ns <= last
        last = sample.stamp_ns

    thread = CycleThread(driver, clock, count)
    begin_ns = clock.now_ns()
    thread.start()
    trajectory = swing()
    end_ns = begin_ns + round(seconds * 1e9)
    next_ns = begin_ns
    while (now_ns := clock.now_ns()) < end_ns:
        if now_ns >= next_ns:
            next_ns += 1_000_000_000
            _look(driver, trajectory, result)
            if now_ns - begin_ns > min(SETTLE_S, seconds / 3) * 1e9:
                result.threads.append(threading.active_count())
                result.memory_mb.append(resident_mb(os.getpid()))
                result.emulator_mb.append(resident_mb(emulator))
            if progress and result.memory_mb:
                print(
                    f'\r{(now_ns - begin_ns) * 1e-9:6.0f} s, {thread.overruns} overruns, '
                    f'{result.memory_mb[-1]:.1f} MB',
                    end='',
                    file=sys.stderr,
                )
        time.sleep(0.05)
    thread.stop()
    if thread.error is not None:
        raise thread.error
    if progress:
        print(file=sys.stderr)
    report = driver.report()
    ran_ns = thread.last_cycle_ns - (clock.begin_ns or begin_ns)
    result.slots = round(ran_ns / driver.configuration.period_ns)
    result.cycles, result.incomplete = report.cycles, report.incomplete_cycles
    result.came_late = report.late_cycles
    result.skipped, result.overruns = thread.skipped, thread.overruns
    begun = thread.begun
    result.begun = f'{begun.text()}; most {begun.greatest_ns * 1e-6:.2f} ms'
    result.late, result.most_late_ms = thread.late.text(), thread.late.greatest_ns * 1e-6
    bus = report.bus
    result.frames_received = bus.received
    result.stale, result.foreign = bus.stale, bus.foreign
    result.undecodable, result.missed = bus.undecodable, bus.missed
    return result


def _look(driver: JointDriver, trajectory: Trajectory, result: SoakResult) -> None:
    """Keep the arm swinging, and note why if it does not."""
    report = driver.report()
    result.latency_ms.append(1e3 * report.joints[0].usual_latency)
    try:
        if report.state is DriverState.FAULT:
            result.faults.append(report.reason)
        if report.state is not DriverState.ENABLED:
            driver.enable()
        elif not report.trajectory_running:
            driver.follow(trajectory)
    except SosmlFrictionError as error:
        # It was just started, or has just fallen: the next second will do.
        if report.state is DriverState.FAULT:
            result.faults.append(str(error))


def main() -> int:
    """Run the soak as a program."""
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--seconds', type=float, default=600.0)
    parser.add_argument('--rate', type=float, default=500.0)
    parser.add_argument('--json', action='store_true')
    options = parser.parse_args()
    result = soak(options.seconds, options.rate, progress=sys.stderr.isatty())
    problems = result.problems()
    if options.json:
        print(json.dumps({**asdict(result), 'problems': problems}))
    else:
        for line in lines(result):
            print(line)
    for problem in problems:
        print(f'soak: {problem}', file=sys.stderr)
    return 1 if problems else 0


def lines(result: SoakResult) -> list[str]:
    """Return the result in words."""
    rows: dict[str, Any] = {
        'cycles due, run, skipped': f'{result.slots}, {result.cycles}, {result.skipped}',
        'cycles incomplete, late': f'{result.incomplete}, {result.came_late}',
        'samples': result.samples,
        'replies missed, stale': f'{result.missed}, {result.stale}',
        'frames foreign, undecodable': f'{result.foreign}, {result.undecodable}',
        'frames sent, heard by the actuators': f'{result.frames_sent}, {result.frames_heard}',
        'overruns': f'{result.overruns} ({100 * result.overruns / max(1, result.cycles):.2f} %)',
        'begun late by': result.begun,
        'late by': f'{result.late}; most {result.most_late_ms:.1f} ms',
        'usual latency': _latency(result.latency_ms),
        'threads': ', '.join(map(str, sorted(set(result.threads)))),
        'memory of the driver': _memory(result.memory_mb),
        'memory of the emulator': _memory(result.emulator_mb),
        'faults and refusals': _faults(result.faults),
    }
    width = max(map(len, rows))
    return [
        f'{result.seconds:g} s at {result.rate:g} Hz over slcan/TCP, two actuators',
        *(f'{name:{width}}  {value}' for name, value in rows.items()),
    ]


def _faults(faults: list[str]) -> str:
    """Return how many there were and the most frequent ones, without their numbers."""
    kinds = Counter(text.split(' (')[0] for text in faults)
    most = '; '.join(f'{count} x {text}' for text, count in kinds.most_common(3))
    return f'{len(faults)}: {most}' if faults else 'none'


def _latency(values: list[float]) -> str:
    """Return the medians of the first and of the last quarter."""
    part = max(1, len(values) // 4)
    first, last = (float(np.median(some)) for some in (values[:part], values[-part:]))
    return f'{first:.2f} ms in the first quarter, {last:.2f} ms in the last'


def _memory(values: list[float]) -> str:
    if not values:
        return 'not measured'
    return f'{values[0]:.1f} to {values[-1]:.1f} MB, grown by {growth_mb(values):+.2f} MB'


if __name__ == '__main__':
    sys.exit(main())
