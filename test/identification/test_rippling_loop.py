# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The emulated exoskeleton whose elbow ripples, and as shipped: intervals of a joint fit of bags.

``SOSML_FRICTION_SEEDS=20 pytest -s`` prints the table of docs/identification.md (an hour on two
cores); ``make validate`` runs it. Seeds 1 to 10 were used for development, these begin at 101.
"""

from __future__ import annotations

import os
from concurrent.futures import ProcessPoolExecutor
from functools import partial

import numpy as np
import pytest
from lockstep import emulated_exoskeleton, nominal_robot
from lockstep_run import run_lockstep
from scipy.stats import binom

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.identification.law.law_fit import LawFit
from sosml_friction.identification.law.law_rows import LawRows
from sosml_friction.identification.law.law_stack import joined, row_noise, stack_rows
from sosml_friction.identification.weak_form import WeakForm
from sosml_friction.motion.trajectories import build_trajectory

SEEDS = int(os.environ.get('SOSML_FRICTION_SEEDS', '1'))
FULL = 'SOSML_FRICTION_SEEDS' in os.environ
HANGING = {'shoulder': -0.5 * np.pi, 'elbow': 0.0}
CENTRE = {'shoulder': -0.5 * np.pi, 'elbow': 1.2}
TRUTH = (
    {'coulomb': 0.80, 'viscous': 0.35, 'stribeck': 0.50, 'stribeck_velocity': 0.03},
    {'coulomb': 0.40, 'viscous': 0.20, 'stribeck': 0.25, 'stribeck_velocity': 0.03},
)
BAGS = {'T1 + T2 + T3': ('T1', 'T2', 'T3'), 'rich': ('rich',)} if FULL else {'T3': ('T3',)}
PLANTS = {'rippling': True, 'shipped': False} if FULL else {'rippling': True}
#: Whether velocities are smoothed by the torque, or slopes of the position as before.
WAYS = ('position', 'smoothed')

Fits = dict[tuple[str, str, int], LawFit]


def stacked(parts: list[LawRows]) -> LawFit:
    """Return the fit of bags together, as the command makes it: each by what its rows know."""
    noise = [row_noise(rows) for rows in parts]
    parts = [joined(rows, each) for rows, each in zip(parts, noise, strict=True)]
    effective = [row_noise(rows).effective for rows in parts]
    weights = [float(np.median(effective)) / each for each in effective]
    return stack_rows(parts, weights).rows.fit('Nm')


def recorded(name: str, seed: int, rippling: bool) -> JointLog:
    trajectory = build_trajectory(name, HANGING, CENTRE, {})
    log = run_lockstep(trajectory, emulated_exoskeleton(seed, rippling=rippling))
    return log.select(nominal_robot().names)


def identify(seed: int, rippling: bool) -> Fits:
    """Return the fits by bags, way and joint."""
    robot = nominal_robot()
    names = {name for bags in BAGS.values() for name in bags}
    rough = {n: WeakForm(recorded(n, seed, rippling), robot, 'end') for n in names}
    smooth = {n: form.with_laws([form.fit(i) for i in range(2)]) for n, form in rough.items()}
    return {
        (title, way, i): stacked([forms[name].rows(i) for name in bags])
        for title, bags in BAGS.items()
        for way, forms in zip(WAYS, (rough, smooth), strict=True)
        for i in range(2)
    }


@pytest.fixture(scope='module')
def results() -> dict[str, list[Fits]]:
    """Return the fits of each plant by seed, and print tables."""
    seeds = range(101, 101 + SEEDS)
    found = {}
    with ProcessPoolExecutor(min(2, SEEDS)) as pool:
        for plant, rippling in PLANTS.items():
            found[plant] = list(pool.map(partial(identify, rippling=rippling), seeds))
    for plant, fits in found.items():
        for title in BAGS:
            for way in WAYS:
                print_table(f'{plant}, {title}, {way}', [f for f in fits], title, way)
    return found


def print_table(head: str, fits: list[Fits], title: str, way: str) -> None:
    print(f'\n{head}, {len(fits)} seeds')
    print('joint parameter          mean error      sd  mean SE  rms error/SE  in 95 %')
    for i, truth in enumerate(TRUTH):
        for name, value in truth.items():
            found = [one[title, way, i].parameters[name] for one in fits]
            error = np.array([p.value for p in found]) - value
            se = np.array([p.std_error for p in found])
            print(
                f'{i}     {name:18} {error.mean():+.5f} {error.std():8.5f} {se.mean():8.5f} '
                f'{np.sqrt(np.mean((error / se) ** 2)):9.2f} {hits(found, value):9} of {len(fits)}'
            )


def hits(found, value):
    return sum(p.interval[0] <= value <= p.interval[1] for p in found)


@pytest.mark.parametrize('title', BAGS)
@pytest.mark.parametrize('plant', PLANTS)
def test_intervals_hold_the_truth(results, plant, title):
    """Of 95 % intervals, fewer than the bound would be seen once in 1000 campaigns."""
    fits = results[plant]
    held = sum(
        hits([one[title, 'smoothed', i].parameters[name]], value)
        for one in fits
        for i, truth in enumerate(TRUTH)
        for name, value in truth.items()
    )
    assert held >= binom.ppf(1e-3, 8 * len(fits), 0.95)


def test_the_elbow_s_ripple_no_longer_hides_its_knee(results):
    """S by smoothed velocities is nearer to the truth than by slopes of the position."""
    for title in BAGS:
        error = {way: [] for way in WAYS}
        for way in WAYS:
            for fits in results['rippling']:
                error[way].append(abs(fits[title, way, 1].drawn['stribeck'] - 0.25))
        assert np.mean(error['smoothed']) < 0.5 * np.mean(error['position'])
