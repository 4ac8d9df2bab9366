# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Run the whole chain in real time on a machine that is busy with other work.

    python -m validation.busy [--load 6] [--runs 3] [--standstills driver_node]

Beside N processes that count, copy memory, write to the disk and start programs, and, if asked to,
with one node stopped and continued at random, the chain of the demonstration runs for a minute,
each time. Judged is what a busy machine must not touch: the robot reaches the end of its
trajectory, every sample has its estimates, those are what a replay of the recording gives, to the
last bit, and they begin afresh nowhere but where a gap is recorded. Told beside it is what it does
touch. A run that breaks one of these promises keeps its recording; the exit code is then 1.
"""

from __future__ import annotations

import argparse
import contextlib
import multiprocessing
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from sosml_friction.bags.bag import Bag
from sosml_friction.exceptions import SosmlFrictionError
from sosml_friction.identification.bag_analysis import analyse_bag
from sosml_friction.identification.friction_fit import FitSettings
from sosml_friction.identification.log_analysis import BagAnalysis
from sosml_friction.nodes.demo import run_chain
from sosml_friction.nodes.fit_job import summary

#: Length of a plateau of T1 [s], a minute in all.
PLATEAU_S = 1.6
#: A gap in joint_states, as the chain's observers are told [s].
GAP_S = 0.05
#: A standstill comes each so often in the mean, chosen for some thirty in a run, and lasts at most
#: so long [s]: less than the half second after which the emulated motors switch themselves off.
EVERY_S, LONGEST_S = 2.0, 0.3
#: Before the name of an observer in its topic.
_ESTIMATES = '/friction_estimate/'
#: What the copying process moves, more than any cache holds, and the disk gets at once [bytes].
BLOCK = 1 << 27


def count() -> None:
    """Keep a core busy."""
    x = 0
    while True:
        x = (x * 1103515245 + 12345) % 2**31


def copy() -> None:
    """Keep the memory busy."""
    block = np.ones(BLOCK // 8)
    while True:
        block = block + 1.0


def write() -> None:
    """Keep the disk busy."""
    with tempfile.TemporaryFile() as stream:
        while True:
            stream.seek(0)
            stream.write(bytes(BLOCK))
            stream.flush()
            os.fsync(stream.fileno())


def start() -> None:
    """Keep starting programs."""
    while True:
        subprocess.run([sys.executable, '-c', 'import json, email, unittest'], check=False)


WORK: tuple[Callable[[], None], ...] = (count, copy, write, start)


@contextlib.contextmanager
def busy(load: int) -> Iterator[None]:
    """Have so many processes work beside what runs in the block."""
    # New programs: a fork of this one would share its threads' locks.
    context = multiprocessing.get_context('spawn')
    workers = [context.Process(target=WORK[i % len(WORK)], daemon=True) for i in range(load)]
    for worker in workers:
        worker.start()
    try:
        yield
    finally:
        for worker in workers:
            worker.terminate()
            worker.join()


@contextlib.contextmanager
def standstills(node: str, seed: int) -> Iterator[None]:
    """Stop this process's own ``node`` at random and let it go on; none where it is ''."""
    rng, ended = random.Random(seed), threading.Event()

    def run() -> None:
        while not ended.wait(rng.expovariate(1.0 / EVERY_S)):
            command = ['pgrep', '-P', str(os.getpid()), '-f', f'sosml_friction.nodes.{node}']
            found = subprocess.run(command, capture_output=True, text=True, check=False)
            for sent in (signal.SIGSTOP, signal.SIGCONT):
                for process in map(int, found.stdout.split()):
                    with contextlib.suppress(ProcessLookupError):
                        os.kill(process, sent)
                if sent is signal.SIGSTOP:
                    ended.wait(rng.uniform(0.0, LONGEST_S))

    thread = threading.Thread(target=run)
    if node:
        thread.start()
    try:
        yield
    finally:
        ended.set()
        if node:
            thread.join()


def replayed(run: Path) -> BagAnalysis:
    """
    Return the analysis of a run with the observers that ran, and the bodies that they had.

    Else bodies are refitted where the data contradict them, and estimates are of those.
    """
    return analyse_bag(run / 'bag', settings=FitSettings(body_tolerance=0.0))


def judge(run: Path) -> tuple[str, list[str]]:
    """Return what is told of a run, and the promises that it broke."""
    bag = Bag.open(run / 'bag')
    log = bag.joint_log()
    live = {
        topic.removeprefix(_ESTIMATES): bag.joint_log(topic)
        for topic in bag.topics
        if topic.startswith(_ESTIMATES)
    }
    steps = np.diff(log.t_ns) * 1e-9
    analysis = replayed(run)
    blind = ~np.isfinite(log.v).all(axis=1)
    starts = np.r_[True, steps > GAP_S] | blind | np.roll(blind, 1)
    broken = []
    for name, estimate in live.items():
        if not np.array_equal(estimate.t_ns, log.t_ns):
            broken.append(f'samples without an estimate of {name}')
            continue
        again = analysis.estimates[name]
        alike = (estimate.tau == again) | (np.isnan(estimate.tau) & np.isnan(again))
        if not alike.all():
            broken.append(
                f'{name} is not what a replay gives, in {int(np.sum(~alike))} numbers by up to '
                f'{np.nanmax(np.abs(estimate.tau - again)):.2g}'
            )
        elif not np.array_equal(np.isnan(estimate.tau).any(axis=1), starts):
            broken.append(f'{name} begins afresh where no gap is')
    told = (
        f'{len(log)} samples in {np.sum(steps):.1f} s, longest step {steps.max() * 1e3:.0f} ms, '
        f'{int(np.sum(steps > GAP_S))} gaps; {summary(analysis)}'
    )
    return told, broken


def main() -> int:
    """Run the chain and print a line each time."""
    parser = argparse.ArgumentParser(prog='python -m validation.busy', description=__doc__)
    parser.add_argument('--load', type=int, default=6, help='processes beside it, default 6')
    parser.add_argument('--runs', type=int, default=3, help='default 3')
    parser.add_argument('--standstills', default='', metavar='NODE', help='stop it at random')
    options = parser.parse_args()
    failed = 0
    for seed in range(options.runs):
        folder = Path(tempfile.mkdtemp(prefix='busy_'))
        try:
            with busy(options.load), standstills(options.standstills, seed):
                run = run_chain(folder, seed, plateau=PLATEAU_S)
                load = os.getloadavg()[0]
            told, broken = judge(run)
            if analyse_bag(run / 'bag').body is not None:
                told += '; a fit refits bodies, which are those of the model'
        except SosmlFrictionError as error:
            told, broken, load = 'no end', [str(error)], os.getloadavg()[0]
        failed += bool(broken)
        if broken:
            told += f'; see {folder}'
        else:
            shutil.rmtree(folder)
        print(f'run {seed}, load {load:.1f}: {", ".join(broken) or "ok"}; {told}', flush=True)
    return 1 if failed else 0


if __name__ == '__main__':
    sys.exit(main())
