# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Measure how much a right name reduces the residual on another recording.

The true model leaves the noise alone: of effort, and of position through the true inertia, in the
effort sensor's scale. It is measured on the same motion, with the same random numbers and nothing
hidden. The error of an answer's model beyond the noise is sqrt(error^2 - noise^2), before and
after.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from sosml_friction.regression.band import Band
from validation.motion import JOINTS, reference
from validation.plant import PERIOD, Plant, inertia, simulate
from validation.snr import residual, rms
from validation.trial import HOLDOUT, Trial


def true_residual(trial: Trial, band_hz: float) -> np.ndarray:
    """Return what the true model leaves of the recording left out, (rows, 2)."""
    nothing = Plant(soft=trial.exact.two_mass)
    runs = [
        simulate(nothing, *reference(*HOLDOUT), np.random.default_rng([trial.spec.seed, 4]), noise)
        for noise in (trial.noise, replace(trial.noise, exact=True))
    ]
    noisy, exact = (residual(run, band_hz) for run in runs)
    band = Band(band_hz, PERIOD)
    effort = band.apply(runs[0].tau - runs[1].tau)
    # The rest of the noise is that of position through the nominal inertia.
    position = effort - (noisy - exact)
    elbow = band.apply(runs[1].q)[:, 1]
    acceleration = np.linalg.solve(_inertia(nothing, elbow), position[:, :, None])
    true = (_inertia(trial.exact, elbow) @ acceleration)[:, :, 0] * trial.exact.scale
    return np.asarray(exact + effort - true)


def _inertia(plant: Plant, elbow: np.ndarray) -> np.ndarray:
    """Return the inertia (rows, 2, 2) at positions of the elbow, rotors included."""
    m11, m12, m22 = (x + 0.0 * elbow for x in inertia(plant.body(), elbow))
    rotor = plant.joint['armature']
    rows = [[m11 + rotor[0], m12], [m12, m22 + rotor[1]]]
    return np.moveaxis(np.array(rows), -1, 0)


def held_out(trial: Trial, document: dict[str, Any]) -> dict[str, Any]:
    """
    Return the numbers of the gain in the joint of the hidden effect.

    ``before``, ``after``, ``true``: effort errors [Nm]; ``cut``: the excess before over that
    after, infinite where the latter is not above the noise; ``gain`` and ``true_gain``: before
    over after, before over true; ``forward``: error of the simulated position, after over before,
    in the joint and in all ``joints``; ``forward_error``, ``joint_errors``: their standard errors.
    """
    true = rms(true_residual(trial, document['band_hz']))
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
