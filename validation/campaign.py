# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Run the blind campaign: draw hidden effects, diagnose each, write tables and pictures.

    make campaign ARGS='--trials 60'

One file per trial in OUT/trials: a run that was stopped goes on where it was, given the same seed
and trials, as long as neither the package nor the trials were changed. ``--repeat
OUT/trials/NAME.json --keep DIR`` runs one trial again from what its file says was hidden, and
keeps its bags, model and answer.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import os
import secrets
import shutil
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import lru_cache
from pathlib import Path
from typing import Any

from validation.bars import bars
from validation.gain import held_out
from validation.judge import judge
from validation.pictures import draw
from validation.plan import KINDS, make_plan
from validation.process import ask
from validation.sizes import true_values
from validation.tables import tables
from validation.trial import FAULTS, SINGLES, TRANSMISSION, Spec, build, make_trial

Row = dict[str, Any]
#: Effects that are removed from the library, one at a time. Backlash and elasticity are one class;
#: an encoder's eccentricity is below the noise at any size that occurs.
MUTANTS = (
    *(e for e in SINGLES if e not in TRANSMISSION),
    'transmission',
    'thermal_drift',
    *FAULTS,
)


#: Modules that a row depends on, besides the package; tables and pictures do not.
_DECIDES = ('plant', 'motion', 'effects', 'snr', 'trial', 'process', 'judge', 'gain', 'sizes')


@lru_cache(maxsize=1)
def code_hash() -> str:
    """Return a digest of the code that a row is the result of."""
    here = Path(__file__).resolve().parent
    files = [*sorted((here.parents[0] / 'sosml_friction').rglob('*.py'))]
    digest = hashlib.sha256()
    for path in (*files, *(here / f'{name}.py' for name in _DECIDES)):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def run_spec(spec: Spec, keep: Path | None = None) -> Row:
    """Return everything about one trial: what was hidden, what was answered, what it is worth."""
    started = time.process_time()
    trial = build(spec)
    row: Row = {
        'spec': spec.to_dict(),
        'kind': spec.kind,
        'truths': [vars(truth) for truth in trial.truths],
    }
    workshop = Path(tempfile.mkdtemp(prefix='trial_'))
    try:
        answer = ask(trial, workshop / 'trial')
        if keep is not None:
            shutil.copytree(workshop / 'trial', keep, dirs_exist_ok=True)
    except RuntimeError as error:
        # A diagnosis that fails is no answer; it is told apart in the tables.
        return {**_without_answer(spec, 'failed', str(error)), 'truths': row['truths']}
    finally:
        shutil.rmtree(workshop, ignore_errors=True)
    document = answer.document
    judged = judge(spec.kind, trial.truths, document)
    band = document['band_hz']
    row.update(
        verdict=document['verdict'],
        sentence=document['sentence'],
        causes=[
            {key: cause[key] for key in ('effect', 'joint', 'rivals', 'size_known')}
            for cause in document['causes']
        ],
        parameters=[cause['parameters'] for cause in document['causes']],
        true=true_values(trial) if spec.kind == 'single' else None,
        rejected=document.get('rejected'),
        ranking=(document.get('ranking') or [])[:4],
        structure=document.get('structure'),
        band_hz=band,
        cpu_s=answer.cpu_s,
        score=judged.score,
        outcome=judged.outcome,
        first=judged.first,
        found=judged.found,
        spurious=judged.spurious,
    )
    if band is not None and math.isfinite(band):
        row['snr'] = None if spec.kind in ('null', 'double') else trial.snr(band)
        if spec.holdout and judged.outcome == 'right':
            row['held_out'] = held_out(trial, document)
    row['generator_cpu_s'] = time.process_time() - started
    return row


def mutants(rows: Iterable[Row]) -> tuple[list[Spec], list[Row]]:
    """
    Return, for each effect, the trial to be diagnosed without it, and rows where there is none.

    It is the trial of the largest SNR that was answered right; without one there is no trial.
    """
    rows = list(rows)
    specs, none = [], []
    for effect in MUTANTS:
        names = TRANSMISSION if effect == 'transmission' else (effect,)
        right = [
            row
            for row in rows
            if row['kind'] in ('single', 'thermal', 'fault')
            and row['outcome'] == 'right'
            and row['truths'][0]['effect'] in names
        ]
        best = max(right, key=lambda row: row.get('snr') or 0.0, default=None)
        options = {} if best is None else best['spec']
        spec = Spec(
            **{
                'seed': 0, **options, 'name': f'mutant-{effect}', 'kind': 'mutant',
                'without': names, 'holdout': False,
            }
        )  # fmt: skip
        if best is not None:
            specs.append(spec)
        else:
            none.append(_without_answer(spec, 'never right'))
    return specs, none


def run_all(specs: list[Spec], out: Path, jobs: int, say: Callable[[str], None]) -> dict[str, Row]:
    """Return the row of every spec by name, from its file where it was run before."""
    folder = out / 'trials'
    folder.mkdir(parents=True, exist_ok=True)
    rows: dict[str, Row] = {}
    waiting = []
    for spec in specs:
        path = folder / f'{spec.name}.json'
        if path.is_file():
            row = json.loads(path.read_text())
            same = row['spec'] == json.loads(json.dumps(spec.to_dict()))
            if same and row.get('code') == code_hash() and row['outcome'] != 'failed':
                rows[spec.name] = row
                continue
        waiting.append(spec)
    if rows:
        say(f'{len(rows)} of {len(specs)} trials were run before')
    started, code = time.monotonic(), code_hash()
    with ProcessPoolExecutor(jobs) as pool:
        futures = {pool.submit(_run, spec): spec for spec in waiting}
        try:
            for done, future in enumerate(as_completed(futures), 1):
                spec, row = futures[future], {**future.result(), 'code': code}
                rows[spec.name] = row
                part = folder / f'.{spec.name}.part'
                part.write_text(json.dumps(row, indent=1))
                part.replace(folder / f'{spec.name}.json')
                left = (time.monotonic() - started) / done * (len(waiting) - done)
                say(f'{done}/{len(waiting)}, {left / 60.0:.0f} min left: {line(row)}')
        except BaseException:
            # Stopped by hand: the trials that run are finished, the others are not begun.
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return {spec.name: rows[spec.name] for spec in specs}


def _run(spec: Spec) -> Row:
    try:
        return run_spec(spec)
    except Exception:
        # One trial does not end a campaign of hours; the bar on failures does.
        return _without_answer(spec, 'failed', traceback.format_exc()[-800:])


def _without_answer(spec: Spec, outcome: str, error: str = '') -> Row:
    return {
        'spec': spec.to_dict(), 'kind': spec.kind, 'truths': [], 'causes': [], 'error': error,
        'score': 0, 'outcome': outcome, 'verdict': outcome,
    }  # fmt: skip


def line(row: Row) -> str:
    """Return a trial in a line."""
    hidden = ' + '.join(f'{t["effect"]} {t["joint"]} {t["size"]:.3g}' for t in row['truths'])
    answer = ', '.join(
        f'{c["effect"]} {c["joint"]}' + (f' or {"/".join(c["rivals"])}' if c['rivals'] else '')
        for c in row['causes']
    )
    snr = '' if row.get('snr') is None else f' (SNR {row["snr"]:.2f})'
    return (
        f'{row["spec"]["name"]}: {hidden or "nothing"}{snr} -> {row["verdict"]} '
        f'{answer or "-"}: {row["outcome"]} [{row.get("cpu_s", 0.0):.0f} s]'
    )


def run_campaign(
    seed: int,
    trials: int,
    out: Path,
    jobs: int = 2,
    kinds: tuple[str, ...] = (),
    say: Callable[[str], None] = print,
) -> list[Row]:
    """
    Run a campaign, write its tables and pictures into ``out``, and return its rows.

    :param kinds: only these; all for none.
    """
    out.mkdir(parents=True, exist_ok=True)
    # Compiles the plant before two processes do so at once.
    make_trial(seed, duration=12.0)
    plan = [spec for spec in make_plan(seed, trials) if not kinds or spec.kind in kinds]
    say(f'seed {seed}: {len(plan)} trials, then {len(MUTANTS)} without their effect')
    found = run_all(plan, out, jobs, say)
    if not kinds or 'mutant' in kinds:
        specs, none = mutants(found.values())
        found |= run_all(specs, out, jobs, say)
        found |= {row['spec']['name']: row for row in none}
    rows = list(found.values())
    write(rows, seed, trials, out)
    return rows


def write(rows: list[Row], seed: int, trials: int, out: Path) -> None:
    """Write campaign.json, campaign.md and the pictures."""
    document = {'seed': seed, 'trials': trials, 'rows': rows}
    (out / 'campaign.json').write_text(json.dumps(document, indent=1))
    (out / 'campaign.md').write_text(tables(rows, bars(rows), seed, trials))
    draw(rows, out)


def main() -> int:
    """Run a campaign from the command line; exit code 1 if a bar is missed."""
    parser = argparse.ArgumentParser(
        prog='python -m validation.campaign', description=__doc__.split('\n\n')[0]
    )
    parser.add_argument(
        '--trials',
        type=int,
        default=60,
        help='single effects with an SNR of 0.6 or more (%(default)s)',
    )
    parser.add_argument('--seed', type=int, default=None, help='a new one, printed, if not given')
    parser.add_argument(
        '--jobs', type=int, default=min(2, os.cpu_count() or 1), help='trials at a time'
    )
    parser.add_argument(
        '--kinds', default='', help=f'some of {", ".join((*KINDS, "mutant"))}, joined by commas'
    )
    parser.add_argument(
        '--out', type=Path, default=Path('blind_campaign'), help='folder (%(default)s)'
    )
    parser.add_argument('--repeat', type=Path, help='run one trial again, from its file')
    parser.add_argument('--keep', type=Path, help='folder for its bags, model and answer')
    arguments = parser.parse_args()
    seed = secrets.randbelow(10**6) if arguments.seed is None else arguments.seed
    if arguments.repeat is not None:
        spec = Spec(**json.loads(arguments.repeat.read_text())['spec'])
        row = run_spec(spec, arguments.keep)
        print(json.dumps(row, indent=1))
        print(line(row))
        return 0
    kinds = tuple(x for x in arguments.kinds.split(',') if x)
    rows = run_campaign(
        seed, arguments.trials, arguments.out, arguments.jobs, kinds,
        lambda text: print(text, flush=True),
    )  # fmt: skip
    print(tables(rows, bars(rows), seed, arguments.trials))
    print(f'written: {arguments.out}/campaign.md, campaign.json, pictures')
    return int(not all(bar.met for bar in bars(rows) if bar.n or not kinds))


if __name__ == '__main__':
    sys.exit(main())
