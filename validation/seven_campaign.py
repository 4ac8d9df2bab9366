# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Hide effects in an arm of seven joints and ask a diagnosis that knows its bodies, and no friction.

    python -m validation.seven_campaign --seed 1 --out OUT

One file per trial in OUT: a run that was stopped goes on. Each trial is one effect, none, or one
that the catalogue does not have, in one of two motions (:mod:`validation.seven_plant`).
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

import sosml_friction as sf
from validation.judge import judge
from validation.kept_trials import kept_trials, outcomes, parser_of
from validation.seven_plant import (
    CATALOGUE,
    MOTIONS,
    NAMES,
    OF_ROBOT,
    OUTSIDE,
    ROTOR,
    Arm,
    recording,
)
from validation.trial import Truth


def trial(seed: int, length_s: float, kind: str, effect: str, k: int) -> dict[str, Any]:
    """Return what was hidden in a recording, what was answered, and what that is worth."""
    rng = np.random.default_rng([seed, k, *f'{kind} {effect}'.encode()])
    motion = list(MOTIONS)[k % len(MOTIONS)]
    log, joint, size = recording(rng, motion, length_s, effect)
    model = sf.Model.from_urdf(Arm.nominal().urdf(), dict(zip(NAMES, ROTOR.tolist(), strict=True)))
    document = sf.diagnose(log, model).to_dict()
    place = '*' if effect in OF_ROBOT else NAMES[joint]
    judged = judge(kind, [Truth(effect, place, size)] if effect else [], document)
    return {
        'kind': kind,
        'effect': effect,
        'k': k,
        'motion': motion,
        'joint': place,
        'size': size,
        'outcome': judged.outcome,
        'spurious': judged.spurious,
        'verdict': document['verdict'],
        'causes': [[c['effect'], c['joint'], c['rivals']] for c in document['causes']],
        'sentence': document['sentence'],
    }


def main() -> int:
    """Run the trials that are not there yet, and print the table."""
    parser = parser_of('seven_campaign', __doc__)
    parser.add_argument('--length', type=float, default=60.0, help='of a recording [s]')
    given = parser.parse_args()
    plan = [('single', effect, k) for effect in CATALOGUE for k in range(given.singles)]
    plan += [('null', '', k) for k in range(given.nulls)]
    plan += [('outside', effect, k) for effect in OUTSIDE for k in range(given.outside)]
    rows = kept_trials(plan, partial(trial, given.seed, given.length), given.out)
    print('\n'.join(outcomes(rows)))
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
