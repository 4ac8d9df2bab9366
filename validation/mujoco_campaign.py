# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Hide effects in MuJoCo and ask ``sosml diagnose --mjcf``, which sees a nominal MJCF and the bags.

    python -m validation.mujoco_campaign --out OUT                 # ten effects, three seeds each
    python -m validation.mujoco_campaign --out OUT --nulls 30 --outside 3 --seeds 0

One file per trial in OUT: a run that was stopped goes on. The friction of the nominal MJCF is a
guess, off by a factor exp(0.3 N(0, 1)), or 0, MuJoCo's default, in every third trial.
"""

from __future__ import annotations

import argparse
import tempfile
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from sosml_friction.bags.joint_log_bag import write_joint_log
from sosml_friction.diagnosis.bag_diagnosis import diagnose_bags
from sosml_friction.exceptions import SosmlFrictionError
from sosml_friction.export.diagnosed import trust_of_a_simulation, with_simulator
from sosml_friction.mujoco.reading import read_mjcf
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.report.diagnosis.document import diagnosis_document
from validation.judge import judge
from validation.kept_trials import kept_trials, outcomes
from validation.motion import reference
from validation.mujoco_plant import (
    OUTSIDE,
    TEN,
    Arm,
    hide,
    make_arm,
    scale_for,
    signal_to_noise,
    simulate,
    truth,
)

#: Seed of all trials beside their number and effect, unless another is given.
SEED = 20261124


def trial(seed: int, kind: str, effect: str, k: int, motion: str = 'rich') -> dict[str, Any]:
    """Return what was hidden, what was answered, and what that is worth."""
    code = list(effect.encode())
    rng = np.random.default_rng([seed, k, *code])
    noise = 2.0 if kind == 'null' and k % 2 else 1.0
    plain, joint = make_arm(rng), k % 2
    arm, snr, beside = plain, None, None
    if effect:
        wanted = float(np.exp(rng.uniform(np.log(0.7), np.log(3.0))))
        scale = scale_for(effect, joint, wanted, k, noise)
        arm = hide(plain, effect, joint, scale, np.random.default_rng(k))
        snr = float(signal_to_noise(arm, plain, 'rich', noise).max())
        beside = float(signal_to_noise(arm, plain, 'rich', noise, beside_friction=True).max())
    level, slope = Arm().coulomb, Arm().viscous
    if k % 3 == 2:
        guess = (0.0 * level, 0.0 * slope)
    else:
        guess = (level * np.exp(0.3 * rng.standard_normal(2)),
                 slope * np.exp(0.3 * rng.standard_normal(2)))  # fmt: skip
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / 'robot.xml').write_text(Arm().xml(guess))
        write_joint_log(simulate(arm, reference(motion), rng, noise), folder / 'bag', None)
        other = reference('other', 60.0)
        write_joint_log(simulate(arm, other, rng, noise), folder / 'holdout', None)
        row: dict[str, Any] = {
            'kind': kind, 'effect': effect, 'k': k, 'joint': joint, 'snr': snr,
            'snr_beside': beside, 'size': arm.size,
            'guess': 'zero' if k % 3 == 2 else 'off',
        }  # fmt: skip
        try:
            document = ask(folder)
        except SosmlFrictionError as error:
            return {**row, 'outcome': 'failed', 'said': str(error)}
    judged = judge(kind, [truth(arm)] if effect else [], document)
    return {
        **row,
        'outcome': judged.outcome,
        'spurious': judged.spurious,
        'verdict': document['verdict'],
        'causes': [[c['effect'], c['joint'], c['rivals']] for c in document['causes']],
        'sentence': document['sentence'],
        'simulator': document.get('simulator'),
        'off': {name: float(np.abs(getattr(plain, name) / getattr(Arm(), name) - 1.0).max())
                for name in ('mass', 'centre', 'gyration', 'armature')},
    }  # fmt: skip


def ask(folder: Path) -> dict[str, Any]:
    """Return the answer of ``sosml diagnose --mjcf``, which sees the files in a folder alone."""
    mjcf, bag, holdout = (folder / name for name in ('robot.xml', 'bag', 'holdout'))
    settings = DiagnosisSettings(trust=trust_of_a_simulation({}))
    found = diagnose_bags([bag], read_mjcf(mjcf), holdout=holdout, settings=settings)
    found = with_simulator(found, mjcf)
    return diagnosis_document(found.diagnosis, found.provenance)


def table(rows: list[dict[str, Any]]) -> str:
    """Return counts of outcomes by kind and effect, and the gains in MuJoCo."""
    lines = outcomes(rows)
    silent = [row for row in rows if row['kind'] == 'outside' and row['outcome'] == 'nothing']
    for row in silent:
        lines.append(
            f'Silent: {row["effect"]}, SNR {row["snr"]:.2f}, of which {row["snr_beside"]:.2f} are '
            'beside what friction refits.'
        )
    for what in ('inverse', 'forward'):
        ends = [('_before_percent', '_after_percent'), ('_before', '_after')][what == 'forward']
        pairs = [
            [one[what + end] for end in ends]
            for row in rows
            if row.get('simulator') and row['outcome'] in ('right', 'set')
            for one in row['simulator']['joints'].values()
        ]
        if pairs:
            before, after = np.array(pairs).T
            cut = before / after
            lines.append(
                f'\nIn MuJoCo, {what}, right answers: before {np.median(before):.3g}, after '
                f'{np.median(after):.3g}, cut {np.median(cut):.2g} times in the median; worse in '
                f'{int(np.sum(cut < 1.0))} of {len(cut)} joints.'
            )
    return '\n'.join(lines)


def main() -> int:
    """Run the trials that are not there yet, and print the table."""
    parser = argparse.ArgumentParser(prog='python -m validation.mujoco_campaign',
                                     description=__doc__)  # fmt: skip
    parser.add_argument('--out', type=Path, default=Path('mujoco_campaign'))
    parser.add_argument('--seeds', type=int, default=3, help='trials of each of the ten effects')
    parser.add_argument('--seed', type=int, default=SEED, help='of all that is drawn')
    parser.add_argument('--first', type=int, default=0, help='number of the first trial')
    parser.add_argument('--nulls', type=int, default=0, help='trials without an effect')
    parser.add_argument('--outside', type=int, default=0, help='trials of each effect outside')
    parser.add_argument('--effects', default=','.join(TEN))
    given = parser.parse_args()
    first = given.first
    plan = [('single', e, first + k) for k in range(given.seeds) for e in given.effects.split(',')]
    plan += [('null', '', first + k) for k in range(given.nulls)]
    plan += [('outside', e, first + k) for k in range(given.outside) for e in OUTSIDE]
    rows = kept_trials(plan, partial(trial, given.seed), given.out)
    print(table(rows))
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
