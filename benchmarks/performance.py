# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
What a step, a recording and a bag cost, beside the way by calls: the table of docs/performance.md.

Run with ``make benchmark``. The way by calls asks Pinocchio for the terms of every sample, makes
its interval with NumPy, and decodes a bag message by message with mcap and rclpy. Both take turns
in one run, and each time, of the processor, is the median of its turns, beside the best of them,
which a busy machine spares more; the ratios of one run say more than its times. Nothing here is a
test.
"""

from __future__ import annotations

import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from mcap.reader import make_reader

from sosml_friction.arrays import FloatArray
from sosml_friction.bags.bag import JOINT_STATE, Bag
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.bags.serialization import deserialize
from sosml_friction.model.model_folder import read_model
from sosml_friction.model.robot import Robot
from sosml_friction.observers.friction_estimator import FrictionEstimator
from sosml_friction.observers.momentum_samples import MomentumSamples
from sosml_friction.observers.observer import Observer
from sosml_friction.observers.registry import make_observer
from sosml_friction.observers.watched_estimator import WatchedEstimator
from sosml_friction.report.common.table import print_table, terminal_table
from sosml_friction.share import share_directory

#: Samples of a recording, of which so many go through a batch and through updates; turns of each
#: side.
COUNT, BATCH, STEPS, TURNS = 50_000, 4_000, 200, 60


def skew_arm(n: int) -> Robot:
    """Return an arm of joints whose axes are neither parallel nor at right angles."""
    rng = np.random.default_rng(0)
    text = '<robot name="arm"><link name="l0"/>'
    for k in range(n):
        axis, turn, way, centre = (' '.join(map(str, x)) for x in rng.normal(size=(4, 3)))
        text += (
            f'<link name="l{k + 1}"><inertial><origin xyz="{centre}"/><mass value="2"/>'
            '<inertia ixx="0.03" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.025"/></inertial>'
            f'</link><joint name="j{k}" type="revolute"><parent link="l{k}"/>'
            f'<child link="l{k + 1}"/><origin xyz="{way}" rpy="{turn}"/><axis xyz="{axis}"/>'
            '<limit lower="-9" upper="9" effort="900" velocity="9"/></joint>'
        )
    return Robot(text + '</robot>', [f'j{k}' for k in range(n)], [0.1] * n)


def recording(robot: Robot) -> JointLog:
    """Return a motion at 1 kHz with the noise of an encoder."""
    rng = np.random.default_rng(0)
    t = np.arange(COUNT) * 1e-3
    phase = 3.0 * t[:, np.newaxis] + rng.uniform(0.0, 6.0, robot.n)
    q = 0.3 * np.sin(phase) + 1e-5 * rng.normal(size=phase.shape)
    v = 0.9 * np.cos(phase) + 1e-3 * rng.normal(size=phase.shape)
    t_ns = np.round(t * 1e9).astype(np.int64) + 10**18
    return JointLog(robot.names, t_ns, q, v, rng.normal(size=q.shape))


def observers(n: int) -> list[Observer]:
    """Return FO and SOSML."""
    sosml = {'sliding': 5.0, 'sliding_root': 3.6, 'linear': 2500.0, 'linear_damping': 50.0}
    return [
        make_observer('first_order', {'cutoff': [50.0] * n}),
        make_observer('sosml', {name: [gain] * n for name, gain in sosml.items()}),
    ]


def terms_by_calls(robot: Robot, q: FloatArray, v: FloatArray) -> tuple[FloatArray, ...]:
    """Return p, C^T q' - g and M, by three calls of Pinocchio."""
    M = robot.inertia(q)
    return M @ v, robot.coriolis(q, v).T @ v - robot.gravity(q), M


def updates_by_calls(robot: Robot, log: JointLog, count: int) -> list[dict[str, FloatArray]]:
    """Return the estimates of ``count`` samples, with an interval in NumPy for each."""
    both = {observer.identifier: observer for observer in observers(robot.n)}
    p, drift, M = terms_by_calls(robot, log.q[0], log.v[0])
    for observer in both.values():
        observer.start(p)
    found = []
    for k in range(1, count):
        before, drift_before = M, drift
        p, drift, M = terms_by_calls(robot, log.q[k], log.v[k])
        integral = 0.5 * ((before + M) @ (log.q[k] - log.q[k - 1]))
        forcing = log.tau[k - 1] + 0.5 * (drift_before + drift)
        h = (log.t_ns[k] - log.t_ns[k - 1]) * 1e-9
        samples = MomentumSamples(*(np.array([x]) for x in (h, p, integral, forcing, M)))
        found.append({name: -observer.run(samples)[0] for name, observer in both.items()})
    return found


def updates(estimator: FrictionEstimator | WatchedEstimator, log: JointLog) -> None:
    """Take the first samples of a recording one after the other."""
    estimator.reset()
    stamps = log.t_ns[:STEPS].tolist()
    for t_ns, q, v, tau in zip(stamps, log.q, log.v, log.tau, strict=False):
        estimator.update(t_ns, q, v, tau)


def read_by_calls(folder: Path) -> FloatArray:
    """Return stamps, positions, velocities and efforts of joint_states, message by message."""
    rows = []
    (file,) = folder.glob('*.mcap')
    with file.open('rb') as stream:
        for _, _, message in make_reader(stream).iter_messages(topics=['/joint_states']):
            state = deserialize(message.data, JOINT_STATE)
            stamp = state.header.stamp
            rows.append(
                [stamp.sec + 1e-9 * stamp.nanosec, *state.position, *state.velocity, *state.effort]
            )
    return np.array(rows)


def in_turn(
    *sides: Callable[[], object],
    turns: int = TURNS,
    clock: Callable[[], float] = time.process_time,
) -> list[FloatArray]:
    """Return the median and the least time of each side [s], after one turn that may compile."""
    times: list[list[float]] = [[] for _ in sides]
    for turn in range(turns + 1):
        for side, own in zip(sides, times, strict=True):
            begun = clock()
            side()
            if turn:
                own.append(clock() - begun)
    return [np.array([statistics.median(own), min(own)]) for own in times]


def rows_of(robot: Robot, folder: Path) -> list[tuple[str, FloatArray, FloatArray]]:
    """Return what is timed with one robot: what, the way by calls and this package's [s], (2,)."""
    log, n = recording(robot), robot.n
    q, v = log.q[0], log.v[0]
    estimator = FrictionEstimator(robot, observers(n))
    watched = WatchedEstimator(FrictionEstimator(robot, observers(n)), 'sosml')
    close = WatchedEstimator(FrictionEstimator(robot, observers(n)), 'sosml')
    # Every sample is looked at as closely as one that may be wrong.
    vars(close._plausibility)['_is_plain'] = lambda *_: False
    write_joint_log(log, folder)
    short = log.rows(np.arange(BATCH))
    calls, terms, steps, batch, watch, looks = in_turn(
        lambda: updates_by_calls(robot, log, STEPS),
        lambda: [terms_by_calls(robot, q, v) for _ in range(STEPS)],
        lambda: updates(estimator, log),
        lambda: estimator.batch(short),
        lambda: updates(watched, log),
        lambda: updates(close, log),
    )
    message, read = in_turn(
        lambda: read_by_calls(folder), lambda: Bag.open(folder).joint_log(), turns=3
    )
    compiled, _ = in_turn(lambda: [robot.momentum_terms(q, v) for _ in range(STEPS)], lambda: None)
    return [
        ('terms of one sample', terms / STEPS, compiled / STEPS),
        ('update, FO + SOSML + dynamics', calls / STEPS, steps / STEPS),
        ('batch, a sample', calls / STEPS, batch / BATCH),
        ('checked update, with its error', looks / STEPS, watch / STEPS),
        ('bag to JointLog, a message', message / COUNT, read / COUNT),
    ]


#: The tool as a program; and one that makes an estimator, with what is compiled already.
TOOL = 'import sys; from sosml_friction.cli.main import main; sys.exit(main(sys.argv[1:]))'
ESTIMATOR = (
    'from sosml_friction.model.model_folder import read_model;'
    'from sosml_friction.observers.friction_estimator import FrictionEstimator;'
    'from sosml_friction.observers.registry import make_observer;'
    'from sosml_friction.share import share_directory;'
    'robot = read_model(share_directory() / "config/exoskeleton").make_robot();'
    'FrictionEstimator(robot, [make_observer("first_order", {"cutoff": [50.0] * robot.n})])'
)


def of_programs() -> float:
    """Return the processor time of all programs that were run and have ended [s]."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def start_up(code: str, *arguments: str) -> float:
    """Return the median processor time of a program [s], its modules compiled to bytes before."""
    command = [sys.executable, '-c', code, *arguments]
    environment = {k: v for k, v in os.environ.items() if k != 'PYTHONDONTWRITEBYTECODE'}

    def run() -> None:
        subprocess.run(command, env=environment, capture_output=True, check=True)

    (taken,) = in_turn(run, turns=5, clock=of_programs)
    return float(taken[0])


def main() -> None:
    """Print the table."""
    heads = [
        'what',
        'joints',
        'by calls [us]',
        'here [us]',
        'ratio',
        'best',
        'best here',
        'ratio ',
    ]
    table = []
    with tempfile.TemporaryDirectory() as folder:
        exoskeleton = read_model(share_directory() / 'config' / 'exoskeleton').make_robot()
        for robot in (exoskeleton, skew_arm(7)):
            for what, calls, here in rows_of(robot, Path(folder) / f'bag{robot.n}'):
                cells = [(*pair, pair[0] / pair[1]) for pair in zip(calls, here, strict=True)]
                numbers = [
                    f'{1e6 * x:.2f}' if unit else f'{x:.1f}'
                    for row in cells
                    for x, unit in zip(row, (True, True, False), strict=True)
                ]
                table.append((what, f'{robot.n}', *numbers))
        starts = [
            (what, f'{start_up(*program):.2f}')
            for what, program in (
                ('sosml --help', (TOOL, '--help')),
                ('sosml info BAG', (TOOL, 'info', str(Path(folder) / 'bag2'))),
                ('an estimator, compiled before', (ESTIMATOR,)),
            )
        ]
    print_table(terminal_table({head: 'n' if head != 'what' else '' for head in heads}, table))
    print_table(terminal_table({'start of a program': '', 's': 'n'}, starts))


if __name__ == '__main__':
    main()
