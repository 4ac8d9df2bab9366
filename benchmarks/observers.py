# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
What an observer costs: side by side in one run, as ratios to the first-order observer.

Run with ``make benchmark``. Times are medians over repetitions on whatever else the machine does;
only the ratios of one run say something. Nothing here is a test.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

import numpy as np

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.model.model_folder import read_model
from sosml_friction.observers.conditions import Conditions
from sosml_friction.observers.friction_estimator import FrictionEstimator
from sosml_friction.observers.momentum_samples import MomentumSamples
from sosml_friction.observers.recipe import gains_for_conditions
from sosml_friction.observers.registry import OBSERVERS, make_observer
from sosml_friction.report.common.table import print_table, terminal_table
from sosml_friction.share import share_directory

COUNT, REPEATS, CALLS = 20_000, 15, 2_000


def median_time(work: Callable[[], object], repeats: int = REPEATS) -> float:
    """Return the median time of ``work`` [s], after one call that may compile."""
    work()
    times = []
    for _ in range(repeats):
        begun = time.perf_counter()
        work()
        times.append(time.perf_counter() - begun)
    return statistics.median(times)


def main() -> None:
    """Print the table."""
    robot = read_model(share_directory() / 'config' / 'exoskeleton').make_robot()
    rng = np.random.default_rng(0)
    t = np.arange(COUNT + 1) * 1e-3
    q = np.stack([0.35 * np.sin(np.pi * t), 0.2 * np.sin(2.0 * t)], axis=1)
    q += 5e-5 * rng.normal(size=q.shape)
    v = np.diff(q, axis=0, prepend=q[:1]) / 1e-3
    tau = rng.normal(size=q.shape)
    log = JointLog(robot.names, np.round(t * 1e9).astype(np.int64), q, v, tau)
    conditions = Conditions.of(
        robot, q[0], [5e-5] * 2, [0.07] * 2, [2.0, 1.0], [1.0, 1.0], [1.1, 0.4]
    )
    gains = gains_for_conditions(conditions)
    first = FrictionEstimator(robot, [make_observer('first_order', gains['first_order'])])
    (stretch,) = first.stretches(log)
    samples = stretch.samples
    one = MomentumSamples(
        *(getattr(samples, name)[:1] for name in ('h', 'p', 'integral', 'forcing', 'inertia'))
    )
    loops, calls = {}, {}
    for name in OBSERVERS:
        observer = make_observer(name, gains[name])
        observer.start(stretch.p_start)
        loops[name] = median_time(lambda o=observer: o.run(samples)) / len(samples)
        calls[name] = median_time(lambda o=observer: [o.run(one) for _ in range(CALLS)], 5) / CALLS
    heads = ('us/step in a loop', 'ratio', 'us/call from Python', 'its ratio')
    costs = [
        (
            name,
            f'{1e6 * loops[name]:.3f}',
            f'{loops[name] / loops["first_order"]:.1f}',
            f'{1e6 * calls[name]:.2f}',
            f'{calls[name] / calls["first_order"]:.1f}',
        )
        for name in OBSERVERS
    ]
    print('Recursion alone, 2 joints')
    print_table(terminal_table({'observer': '', **dict.fromkeys(heads, 'n')}, costs))


if __name__ == '__main__':
    main()
