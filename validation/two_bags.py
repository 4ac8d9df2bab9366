# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Two recordings of one pendulum whose Coulomb friction differs, C .40 and .44, with one knee.

The pendulum of benchmarks/long_recordings.py at 250 Hz, 1.6 minutes each. Told is in how many
seeds the 95 % intervals hold the truth: S of both together, and C of each by itself.
``python -m validation.two_bags --seeds 20`` (half an hour on one core).
"""

from __future__ import annotations

import argparse

import numpy as np

import sosml_friction as sf
from benchmarks.long_recordings import KNEE, URDF, recording

STEP, MINUTES, LEVELS = 4e-3, 1.6, {'a': 0.40, 'b': 0.44}


def main() -> None:
    """Print each seed, then how many held."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seeds', type=int, default=20)
    model = sf.Model.from_urdf(URDF, {'joint': 0.0})
    held, seeds = dict.fromkeys(('S of both', *LEVELS), 0), parser.parse_args().seeds
    knees = []
    for seed in range(1, seeds + 1):
        logs = {
            bag: recording(MINUTES, STEP, C, 2 * seed + k)
            for k, (bag, C) in enumerate(LEVELS.items())
        }
        fit = sf.fit(logs, model, effort_hold='mean')
        found = {'S of both': (fit.parameters['joint']['stribeck'], KNEE)}
        for bag, C in LEVELS.items():
            own = fit.analysis.bags[bag].fit.joints['joint']['weak_form'].fit
            found[bag] = (own.parameters['coulomb'], C)
        for name, (p, truth) in found.items():
            low, high = p.interval or (np.nan, np.nan)
            held[name] += low <= truth <= high
            print(f'seed {seed} {name}: {p.value:.4f}, {low:.4f} to {high:.4f}', flush=True)
        knees.append(found['S of both'][0].value)
    for name, count in held.items():
        print(f'{name}: the truth within the interval in {count} of {seeds}')
    if seeds > 1:
        print(
            f'S of both: mean {np.mean(knees):.5f}, standard deviation {np.std(knees, ddof=1):.5f}'
        )


if __name__ == '__main__':
    main()
