# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Damage bags, files, frames and recordings at random, and count what goes wrong without a word.

    python -m validation.reliability --cases 10000 --files 1000 --seed 1

Prints the table of docs/reliability.md. A case is one damaged bag, or one malformed file, that is
read as the commands read it; or a drive among 500 random frames; or a recording that is killed. It
may be read whole, be read with a sentence on what is missing (or end in a fault with its reason),
or be refused in a sentence. Three things are failures: what is there is not what was recorded, or
another promise is broken, and nobody says so (silent), anything but an error of this package
(traceback), and no answer within ``LIMIT_S`` (hang). Cases run in a process of their own, whose
memory is measured.
"""

from __future__ import annotations

import argparse
import multiprocessing
import resource
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from sosml_friction.exceptions import SosmlFrictionError
from validation.damaged_bags import BAG_DAMAGES, DamagedBags
from validation.kill_points import KillPoints
from validation.malformed_files import FILES, MalformedFiles
from validation.random_frames import RandomFrames
from validation.silent import SilentError

#: Seconds after which a case counts as one that never ends; a usual one takes 10 ms.
LIMIT_S = 20.0
FAILURES = ('silent', 'traceback', 'hang')
#: What is neither bag nor file; 200 drives have 100 000 frames.
DRIVES = ('frames, 500 each', 'kill points')
Case = Callable[[np.random.Generator], object]


@dataclass
class Tally:
    """Count what came of the cases of one kind; ``examples`` of failures are (case, what)."""

    cases: int = 0
    outcomes: Counter[str] = field(default_factory=Counter)
    memory_mb: float = 0.0
    examples: list[tuple[int, str]] = field(default_factory=list)

    def add(self, case: int, outcome: str, detail: str, memory_mb: float) -> None:
        """Count one case."""
        self.cases += 1
        self.outcomes[outcome] += 1
        self.memory_mb = max(self.memory_mb, memory_mb)
        if outcome in FAILURES and len(self.examples) < 5:
            self.examples.append((case, detail))

    @property
    def failures(self) -> int:
        """Return the number of failures."""
        return sum(self.outcomes[name] for name in FAILURES)


def cases_of(kind: str, folder: Path) -> Case:
    """Return what runs a case of one kind."""
    if kind == DRIVES[0]:
        return RandomFrames()
    if kind in DRIVES:
        return KillPoints(folder)
    return (DamagedBags if kind in BAG_DAMAGES else MalformedFiles)(kind, folder)


def outcome_of(run: Case, rng: np.random.Generator) -> tuple[str, str]:
    """Return what came of one case, and what is to be said of a failure."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter('ignore')
            said = run(rng)
    except SilentError as error:
        return 'silent', str(error)
    except SosmlFrictionError as error:
        text = str(error)
        return ('refused', '') if text.strip() else ('traceback', 'an error without a sentence')
    except BaseException:
        return 'traceback', traceback.format_exc(limit=-3)
    return ('told', '') if said else ('whole', '')


def _work(kind: str, first: int, last: int, seed: int, folder: str, pipe: Connection) -> None:
    """Run the cases of a kind, and send what came of each."""
    place = Path(folder)
    cases = cases_of(kind, place)
    base = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for case in range(first, last):
        outcome, detail = outcome_of(cases, np.random.default_rng((seed, case)))
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        pipe.send((case, outcome, detail, max(peak, base) / 1024.0))
    pipe.send(None)


def run_kind(kind: str, cases: int, seed: int, limit_s: float = LIMIT_S) -> Tally:
    """Run cases of one kind in a process; one that hangs is ended, and the rest goes on."""
    tally, first = Tally(), 0
    context = multiprocessing.get_context('spawn')
    with tempfile.TemporaryDirectory() as folder:
        while first < cases:
            here, there = context.Pipe(duplex=False)
            worker = context.Process(
                target=_work, args=(kind, first, cases, seed, folder, there), daemon=True
            )
            worker.start()
            there.close()
            # The first answer comes after the imports.
            first = _collect(tally, here, first, cases, limit_s)
            worker.kill()
            worker.join()
    return tally


def _collect(tally: Tally, pipe: Connection, first: int, cases: int, limit_s: float) -> int:
    """Take answers until there are no more; return the case to go on with."""
    patience = limit_s + 60.0
    while first < cases:
        try:
            answer = pipe.recv() if pipe.poll(patience) else None
            if answer is None:
                tally.add(first, 'hang', f'no answer in {limit_s:g} s', 0.0)
                return first + 1
        except EOFError:
            tally.add(first, 'traceback', 'the process died', 0.0)
            return first + 1
        tally.add(*answer)
        first, patience = first + 1, limit_s
    return first


def table(tallies: dict[str, Tally]) -> str:
    """Return the table of docs/reliability.md."""
    head = '| cases | tried | read whole | told | refused | silent | tracebacks | hangs | memory |'
    rows = [head, '|---|---|---|---|---|---|---|---|---|']
    for kind, tally in tallies.items():
        counts = [str(tally.outcomes[key]) for key in ('whole', 'told', 'refused', *FAILURES)]
        rows.append(
            f'| {kind} | {tally.cases} | {" | ".join(counts)} | {tally.memory_mb:.0f} MB |'
        )
    return '\n'.join(rows)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the cases and print the table; return 1 if there is a failure."""
    parser = argparse.ArgumentParser(
        prog='python -m validation.reliability', description=__doc__.split('\n\n')[0]
    )
    parser.add_argument('--cases', type=int, default=10_000, help='damaged bags (10000)')
    parser.add_argument('--files', type=int, default=1_000, help='malformed files (1000)')
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--drives', type=int, default=200, help='drives, and recordings (200)')
    parser.add_argument('--kinds', default='', help='some of them, with semicolons')
    options = parser.parse_args(arguments)
    chosen = options.kinds.split(';') if options.kinds else [*BAG_DAMAGES, *FILES, *DRIVES]
    tallies = {}
    for kind in chosen:
        groups = ((BAG_DAMAGES, options.cases), (FILES, options.files))
        count = options.drives
        for group, wanted in groups:
            if kind in group:
                count = -(-wanted // sum(other in group for other in chosen))
        began = time.monotonic()
        tallies[kind] = run_kind(kind, count, options.seed)
        print(f'{kind}: {time.monotonic() - began:.0f} s', file=sys.stderr)
        for case, what in tallies[kind].examples:
            print(f'  case {case}: {what.strip()}', file=sys.stderr)
    print(table(tallies))
    return int(any(tally.failures for tally in tallies.values()))


if __name__ == '__main__':
    sys.exit(main())
