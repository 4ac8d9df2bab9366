# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
What a fit and a diagnosis cost by the length of the recording: time, memory, exponent.

A pendulum of one joint moves back and forth at eight speeds, at 1 kHz, with C .40, B .12, S .25,
v_s .05, 10 urad of noise in position and 20 mNm in effort. Each run is a process of its own, from
samples in memory to the result, imports and compiled code from the cache included, with one thread
of BLAS; ``threads`` is the same with two. Seconds are of the wall, and beside it of the processor,
which neighbours do not slow. Ratios, of these, are to the shortest recording. The exponent is the
slope of log time over log length from the second length on. Nothing here is a test.

``python benchmarks/long_recordings.py [MINUTES ...]``; by default 3, 6 and 12 minutes.
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

from sosml_friction.report.common.table import print_table, terminal_table

if TYPE_CHECKING:
    from sosml_friction.bags.joint_log import JointLog

#: Speeds [rad/s] of the ladder, step [s], and the time of a speed one way [s].
SPEEDS, STEP, LONGEST = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0), 1e-3, 8.0
VISCOUS, KNEE, KNEE_SPEED = 0.12, 0.25, 0.05
INERTIA, WEIGHT, ARM = 0.15, 1.2, 0.122324
URDF = f"""<robot name="pendulum"><link name="base"/><link name="arm"><inertial>
<origin xyz="{ARM} 0 0"/><mass value="{WEIGHT / 9.81 / ARM}"/>
<inertia ixx="0.0001" iyy="{INERTIA - WEIGHT / 9.81 * ARM}" izz="0.13" ixy="0" ixz="0" iyz="0"/>
</inertial></link><joint name="joint" type="continuous"><parent link="base"/><child link="arm"/>
<axis xyz="0 1 0"/><limit effort="20" velocity="10"/></joint></robot>"""


def recording(minutes: float, step: float, coulomb: float, seed: int) -> JointLog:
    """Return the pendulum on the ladder, each speed both ways and rounded off over 0.2 s."""
    from sosml_friction.bags.joint_log import JointLog

    rng = np.random.default_rng(seed)
    ramp = 0.5 - 0.5 * np.cos(np.pi * np.arange(round(0.2 / step)) * step / 0.2)
    parts: list[np.ndarray] = []
    for speed in SPEEDS:
        one = np.ones(round(min(LONGEST, max(1.0, 1.2 / speed)) / step))
        one[: len(ramp)], one[-len(ramp) :] = ramp, ramp[::-1]
        parts += [speed * one, -speed * one]
    v = np.resize(np.concatenate(parts), round(60.0 * minutes / step))
    q = np.append(0.0, np.cumsum(0.5 * (v[1:] + v[:-1]))) * step
    friction = np.sign(v) * (coulomb + KNEE * np.exp(-np.abs(v) / KNEE_SPEED)) + VISCOUS * v
    # Gravity acts where x points down: the arm is level at q = 0.
    tau = INERTIA * np.gradient(v, step) - WEIGHT * np.cos(q) + friction
    q = q + 1e-5 * rng.standard_normal(len(q))
    tau = tau + 0.02 * rng.standard_normal(len(q))
    stamps = np.arange(len(q), dtype=np.int64) * round(1e9 * step)
    return JointLog(('joint',), stamps, q[:, None], np.full((len(q), 1), np.nan), tau[:, None])


def work(command: str, minutes: float) -> None:
    """Do one run and print its time, memory and answer."""
    import sosml_friction as sf

    log = recording(minutes, STEP, 0.40, 0)
    begun, busy = time.perf_counter(), time.process_time()
    model = sf.Model.from_urdf(URDF, {'joint': 0.0})
    if command == 'fit':
        answer = ', '.join(
            f'{name} {p.value:.4g}' for name, p in sf.fit(log, model).parameters['joint'].items()
        )
    else:
        answer = sf.diagnose(log, model).summary().split('\n')[0]
    print(
        json.dumps(
            {
                'seconds': time.perf_counter() - begun,
                'processor': time.process_time() - busy,
                'megabytes': resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
                'answer': answer,
            }
        )
    )


def run(command: str, minutes: float, threads: int) -> dict[str, float]:
    """Return what a process of its own found."""
    done = subprocess.run(
        [sys.executable, __file__, command, str(minutes)],
        env={**os.environ, 'OPENBLAS_NUM_THREADS': str(threads)},
        stdout=subprocess.PIPE,
        check=True,
    )
    found: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    print(f'{command} {minutes:g} min, {threads} threads: {found["answer"]}', file=sys.stderr)
    return found


def main(lengths: list[float]) -> None:
    """Print the table."""
    rows = []
    for command in ('fit', 'diagnose'):
        # What is compiled is in the cache afterwards.
        run(command, lengths[0], 1)
        found = [run(command, minutes, 1) for minutes in lengths]
        times = [each['processor'] for each in found]
        exponent = '-'
        if len(lengths) > 2:
            exponent = f'{np.polyfit(np.log(lengths[1:]), np.log(times[1:]), 1)[0]:.2f}'
        for minutes, taken, each in zip(lengths, times, found, strict=True):
            ratio, memory = f'{taken / times[0]:.2f}', f'{each["megabytes"]:.0f}'
            wall, cpu = f'{each["seconds"]:.1f}', f'{taken:.1f}'
            rows.append([command, f'{minutes:g}', wall, cpu, ratio, memory, exponent])
        two = run(command, lengths[0], 2)
        wall, cpu = f'{two["seconds"]:.1f}', f'{two["processor"]:.1f}'
        rows.append([f'{command}, threads', f'{lengths[0]:g}', wall, cpu, '', '', ''])
    names = ('command', 'minutes', 'seconds', 'of the processor', 'ratio', 'MB', 'exponent')
    heads = dict.fromkeys(names, 'w')
    print_table(terminal_table(heads, rows))


if __name__ == '__main__':
    if sys.argv[1:2] in (['fit'], ['diagnose']):
        work(sys.argv[1], float(sys.argv[2]))
    else:
        main([float(each) for each in sys.argv[1:]] or [3.0, 6.0, 12.0])
