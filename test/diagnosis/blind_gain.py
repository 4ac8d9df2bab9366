# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
What a right name is worth on another recording, against what the true model leaves there.

The true model leaves the noise: of effort, and of position through the inertia. It is measured on
the same motion with the same draws of noise and nothing hidden. What an answer's model gets wrong
beyond that is sqrt(error^2 - noise^2), before and after.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from blind_motion import JOINTS, reference
from blind_plant import Plant, simulate
from blind_snr import residual, rms
from blind_trial import HOLDOUT, Trial


def held_out(trial: Trial, document: dict[str, Any]) -> dict[str, Any]:
    """
    Return the numbers of the gain in the joint of the hidden effect.

    ``before``, ``after``, ``true``: effort errors [Nm]; ``cut``: the excess before over that
    after, infinite where the latter is not above the noise; ``gain`` and ``true_gain``: before
    over after, before over true; ``forward``: error of the simulated position, after over before,
    in the joint and in all ``joints``; ``forward_error``, ``joint_errors``: their standard errors.
    """
    rng = np.random.default_rng([trial.spec.seed, 4])
    plant = Plant(soft=trial.exact.two_mass)
    run = simulate(plant, *reference(*HOLDOUT), rng, trial.noise)
    true = rms(residual(run, document['band_hz']))
    entries = [document['gain'][name] for name in JOINTS]
    before = np.array([entry['inverse']['before'] for entry in entries])
    after = np.array([entry['inverse']['after'] for entry in entries])
    excess = [np.sqrt(np.maximum(x**2 - true**2, 0.0)) for x in (before, after)]
    i = int(np.argmax(excess[0] / true)) if trial.joint == '*' else JOINTS.index(trial.joint)
    # A simulation that ran away has no ratio.
    ratios = [x if x is not None else np.inf for x in (e['forward']['ratio'] for e in entries)]
    errors = [e['forward']['ratio_std_error'] or 0.0 for e in entries]
    return {
        'joint': JOINTS[i],
        'before': float(before[i]),
        'after': float(after[i]),
        'true': float(true[i]),
        'cut': float(excess[0][i] / excess[1][i]) if excess[1][i] > 0.0 else None,
        'gain': float(before[i] / after[i]),
        'true_gain': float(before[i] / true[i]),
        'forward': ratios[i],
        'forward_error': errors[i],
        'joints': ratios,
        'joint_errors': errors,
    }
