# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Two recordings of one pendulum whose Coulomb friction differs, C .40 and .44, with one knee.

S .25, v_s .05, B .12; positions with 10 urad and efforts with 20 mNm of white noise at 250 Hz, 1.6
minutes each. Told is in how many seeds the 95 % intervals hold the truth: S of both together, and
C of each by itself. ``python -m validation.two_bags --seeds 20`` (half an hour on one core).
"""

from __future__ import annotations

import argparse

import numpy as np

import sosml_friction as sf
from sosml_friction.bags.joint_log import JointLog

STEP, SPEEDS = 4e-3, (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0)
LEVELS, VISCOUS, KNEE, KNEE_SPEED = {'a': 0.40, 'b': 0.44}, 0.12, 0.25, 0.05
INERTIA, WEIGHT, ARM = 0.15, 1.2, 0.122324
URDF = f"""<robot name="pendulum"><link name="base"/><link name="arm"><inertial>
<origin xyz="{ARM} 0 0"/><mass value="{WEIGHT / 9.81 / ARM}"/>
<inertia ixx="0.0001" iyy="{INERTIA - WEIGHT / 9.81 * ARM}" izz="0.13" ixy="0" ixz="0" iyz="0"/>
</inertial></link><joint name="joint" type="continuous"><parent link="base"/><child link="arm"/>
<axis xyz="0 1 0"/><limit effort="20" velocity="10"/></joint></robot>"""


def recording(seed: int, coulomb: float) -> JointLog:
    """Return the pendulum on a ladder of speeds, each both ways; level at q = 0."""
    rng = np.random.default_rng(seed)
    ramp = 0.5 - 0.5 * np.cos(np.pi * np.arange(round(0.2 / STEP)) * STEP / 0.2)
    parts: list[np.ndarray] = []
    for speed in SPEEDS:
        one = np.ones(round(min(8.0, max(1.0, 1.2 / speed)) / STEP))
        one[: len(ramp)], one[-len(ramp) :] = ramp, ramp[::-1]
        parts += [speed * one, -speed * one]
    v = np.resize(np.concatenate(parts), round(96.0 / STEP))
    q = np.append(0.0, np.cumsum(0.5 * (v[1:] + v[:-1]))) * STEP
    friction = np.sign(v) * (coulomb + KNEE * np.exp(-np.abs(v) / KNEE_SPEED)) + VISCOUS * v
    tau = INERTIA * np.gradient(v, STEP) - WEIGHT * np.cos(q) + friction
    q = q + 1e-5 * rng.standard_normal(len(q))
    tau = tau + 0.02 * rng.standard_normal(len(q))
    stamps = np.arange(len(q), dtype=np.int64) * round(1e9 * STEP)
    return JointLog(('joint',), stamps, q[:, None], np.full((len(q), 1), np.nan), tau[:, None])


def main() -> None:
    """Print each seed, then how many held."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seeds', type=int, default=20)
    model = sf.Model.from_urdf(URDF, {'joint': 0.0})
    held, seeds = dict.fromkeys(('S of both', *LEVELS), 0), parser.parse_args().seeds
    knees = []
    for seed in range(1, seeds + 1):
        logs = {bag: recording(2 * seed + k, C) for k, (bag, C) in enumerate(LEVELS.items())}
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
