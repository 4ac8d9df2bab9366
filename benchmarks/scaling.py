# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
What a fit and a diagnosis cost by the number of joints and of effects looked for.

Arms of skew axes move along sums of five sines, each joint with C .8, B .3, S .5, v_s .05, 10
urad of noise in position and 50 mNm in effort: 60 s at 250 Hz by number of joints, 46 s of two
joints at 1 kHz, as long as the demo's recording, and 60 s of two joints by number of effects. Each
run is a process of its own with one thread of BLAS, from samples in memory to the result, without
imports and compilation: a run of 10 s goes before. Times are of the processor. The exponent is the
slope of log time over log joints. Nothing here is a test.

``python benchmarks/scaling.py``: ten minutes on one core.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
from typing import TYPE_CHECKING

import numpy as np
from performance import skew_arm

from sosml_friction.report.common.table import print_table, terminal_table

if TYPE_CHECKING:
    from sosml_friction.bags.joint_log import JointLog

JOINTS, EFFECTS = (1, 2, 4, 7), (4, 8, 99)
#: Duration [s], rate [Hz].
BY_JOINTS, AS_DEMO = (60.0, 250.0), (46.0, 1000.0)


def recording(n: int, seconds: float, rate: float) -> JointLog:
    """Return the motion of n joints."""
    from sosml_friction.bags.joint_log import JointLog

    robot, rng = skew_arm(n), np.random.default_rng(0)
    t = np.arange(round(seconds * rate)) / rate
    q, v, a = np.zeros((3, len(t), n))
    for i in range(n):
        for k in range(5):
            w, size = 2.0 * np.pi * (0.05 + 0.11 * k + 0.013 * i), 0.5 / (1 + k)
            angle = w * t + rng.uniform(0.0, 2.0 * np.pi)
            q[:, i] += size * np.sin(angle)
            v[:, i] += size * w * np.cos(angle)
            a[:, i] -= size * w**2 * np.sin(angle)
    tau = np.array([robot.inverse_dynamics(*x) for x in zip(q, v, a, strict=True)])
    tau += np.tanh(v / 1e-3) * (0.8 + 0.5 * np.exp(-np.abs(v) / 0.05)) + 0.3 * v
    tau += 0.05 * rng.standard_normal(q.shape)
    q += 1e-5 * rng.standard_normal(q.shape)
    stamps = np.round(1e9 * t).astype(np.int64)
    return JointLog(robot.names, stamps, q, np.full_like(q, np.nan), tau)


def work(command: str, n: int, seconds: float, rate: float, effects: int) -> None:
    """Do one run and print its processor time and memory."""
    import sosml_friction as sf
    from sosml_friction.diagnosis.library import make_library

    model = sf.Model.from_urdf(skew_arm(n).document, {f'j{k}': 0.1 for k in range(n)})
    own = {} if command == 'fit' else {'without': sorted(make_library())[:-effects]}
    for length in (10.0, seconds):
        log = recording(n, length, rate)
        begun = time.process_time()
        getattr(sf, command)(log, model, **own)
    taken, most = time.process_time() - begun, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(json.dumps([taken, most / 1024.0]))


def run(command: str, n: int, seconds: float, rate: float, effects: int = 99) -> list[float]:
    """Return the processor time [s] and memory [MB] of a process of its own."""
    done = subprocess.run(
        [sys.executable, __file__, command, *map(str, (n, seconds, rate, effects))],
        env={**os.environ, 'OPENBLAS_NUM_THREADS': '1'},
        stdout=subprocess.PIPE,
        check=True,
    )
    found: list[float] = json.loads(done.stdout.splitlines()[-1])
    print(f'{command}, {n} joints, {seconds:g} s: {found[0]:.1f} s', file=sys.stderr)
    return found


def main() -> None:
    """Print the table."""
    rows = []

    def add(what: str, command: str, found: list[float], exponent: str = '') -> None:
        rows.append([command, what, f'{found[0]:.1f}', f'{found[1]:.0f}', exponent])

    for command in ('fit', 'diagnose'):
        found = [run(command, n, *BY_JOINTS) for n in JOINTS]
        slope = np.polyfit(np.log(JOINTS), np.log([x[0] for x in found]), 1)[0]
        for n, one in zip(JOINTS, found, strict=True):
            last = f'{slope:.2f}' if n == JOINTS[-1] else ''
            add(f'{n} joints, 60 s at 250 Hz', command, one, last)
        add('2 joints, 46 s at 1 kHz', command, run(command, 2, *AS_DEMO))
    for effects in EFFECTS:
        what = 'all' if effects == EFFECTS[-1] else f'{effects} of the'
        add(f'2 joints, 60 s, {what} effects', 'diagnose', run('diagnose', 2, *BY_JOINTS, effects))
    heads = {'command': 'w', 'what': 'w', 's': 'n', 'MB': 'n', 'exponent': 'n'}
    print_table(terminal_table(heads, rows))


if __name__ == '__main__':
    if len(sys.argv) > 1:
        command, n, seconds, rate, effects = sys.argv[1:]
        work(command, int(n), float(seconds), float(rate), int(effects))
    else:
        main()
