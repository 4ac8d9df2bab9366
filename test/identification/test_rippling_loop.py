# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
The emulated exoskeleton whose elbow ripples, and as shipped: intervals of a joint fit of bags.

``SOSML_FRICTION_SEEDS=20 pytest -s`` prints the table of docs/identification.md (an hour on two
cores); ``make validate`` runs it. Seeds 1 to 10 were used for development, these begin at 101.
"""

from __future__ import annotations

import os
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from full_runs import FULL, only_full
from lockstep import emulated_exoskeleton, nominal_robot
from lockstep_run import run_lockstep
from over_seeds import over_seeds
from scipy.stats import binom

import sosml_friction as sf
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.identification.friction_fit import FitSettings
from sosml_friction.identification.law.law_fit import LawFit
from sosml_friction.identification.law.law_form import LawForm
from sosml_friction.identification.law.law_rows import LawRows
from sosml_friction.identification.law.law_stack import joined, row_noise, stack_rows
from sosml_friction.identification.segments import unsure_sign
from sosml_friction.identification.weak_form import WeakForm
from sosml_friction.motion.trajectories import build_trajectory
from sosml_friction.share import share_directory

SEEDS = int(os.environ.get('SOSML_FRICTION_SEEDS', '1'))
HANGING = {'shoulder': -0.5 * np.pi, 'elbow': 0.0}
CENTRE = {'shoulder': -0.5 * np.pi, 'elbow': 1.2}
TRUTH = (
    {'coulomb': 0.80, 'viscous': 0.35, 'stribeck': 0.50, 'stribeck_velocity': 0.03},
    {'coulomb': 0.40, 'viscous': 0.20, 'stribeck': 0.25, 'stribeck_velocity': 0.03},
)
BAGS = {'T1 + T2 + T3': ('T1', 'T2', 'T3'), 'rich': ('rich',)} if FULL else {'T3': ('T3',)}
PLANTS = {'rippling': True, 'shipped': False} if FULL else {'rippling': True}
#: Encoders that read the first of the bags again, on the rippling plant.
BITS = (12, 14, 16, 19, 21) if FULL else ()
#: The law looked up at slopes of the position as before, at velocities smoothed by the torque,
#: and as the user's fit does it, which measures besides when the effort acts.
WAYS = ('position', 'smoothed', 'fit')

Fits = dict[tuple[str, str, int], LawFit | SimpleNamespace]
Run = tuple[Fits, np.ndarray, dict[tuple[int, int], LawFit]]


def stacked(parts: list[LawRows]) -> LawFit:
    """Return the fit of bags together, as the command makes it: each by what its rows know."""
    noise = [row_noise(rows) for rows in parts]
    parts = [joined(rows, each) for rows, each in zip(parts, noise, strict=True)]
    effective = [row_noise(rows).effective for rows in parts]
    weights = [float(np.median(effective)) / each for each in effective]
    return stack_rows(parts, weights).rows.fit('Nm')


def recorded(name: str, seed: int, rippling: bool) -> tuple[JointLog, np.ndarray, np.ndarray]:
    """Return what the driver measured; the plant's positions and velocities at its stamps."""
    emulator = emulated_exoskeleton(seed, rippling=rippling)
    states, step = [], emulator.plant.step

    def watched(effort, h):
        step(effort, h)
        states.append((emulator.time_ns * 1e-9 + h, *emulator.plant.q, *emulator.plant.v))

    emulator.plant.step = watched
    trajectory = build_trajectory(name, HANGING, CENTRE, {})
    log = run_lockstep(trajectory, emulator).select(nominal_robot().names)
    at, *true = np.array(states).T
    true = np.column_stack([np.interp(log.t_ns * 1e-9, at, each) for each in true])
    return log, true[:, :2], true[:, 2:]


def fitted(log: JointLog, alpha: float | None = None) -> tuple[WeakForm, WeakForm]:
    """Return the weak form by slopes of the position, and with smoothed velocities."""
    rough = WeakForm(log, nominal_robot(), 'end', FitSettings(form=LawForm(alpha=alpha)))
    return rough, rough.with_laws([rough.law(i) for i in range(2)])


def read_by(bits: int, logs: list[tuple[JointLog, np.ndarray]]) -> list[LawFit]:
    """
    Return the fit of each joint as if an encoder of so many bits had read its position.

    With the plant's exponent: what S is beside one that is not known has nothing to do with it.
    """
    step = 2.0 * np.pi / 2**bits
    forms = [fitted(replace(log, q=step * np.round(q / step)), 1.0)[1] for log, q in logs]
    return [stacked([form.rows(i) for form in forms]) for i in range(2)]


def velocity_errors(rough: WeakForm, smooth: WeakForm, true: np.ndarray, i: int) -> np.ndarray:
    """
    Return root mean squares of joint ``i`` in motion [rad/s]: error of either, and what is stated.

    The fourth is how unsure the smoothed one is, over the noise of the slope.
    """
    v = rough._log.v[:, i]
    unsure = unsure_sign(np.nan_to_num(v), rough.settings.segments.zero_band, rough._half)
    moving = (np.abs(v) > 5e-3) & np.isfinite(smooth._variance[:, i]) & ~unsure
    variance = smooth._variance[moving, i]
    squares = [
        (rough._log.v[moving, i] - true[moving, i]) ** 2,
        (smooth._log.v[moving, i] - true[moving, i]) ** 2,
        variance,
    ]
    noises = np.sqrt(np.median(variance)) / rough._v_noise[i]
    return np.array([*(np.sqrt(np.mean(x)) for x in squares), noises])


def identify(seed: int, rippling: bool) -> Run:
    """Return fits by bags, way and joint, velocity errors on T3 (joint, 4), and fits by bits."""
    names = sorted({name for bags in BAGS.values() for name in bags})
    rough, smooth, logs = {}, {}, {}
    for name in names:
        log, q, true = recorded(name, seed, rippling)
        logs[name] = log, q
        rough[name], smooth[name] = fitted(log)
        if name == 'T3':
            errors = [velocity_errors(rough[name], smooth[name], true, i) for i in range(2)]
    fits = {
        (title, way, i): stacked([forms[name].rows(i) for name in bags])
        for title, bags in BAGS.items()
        for way, forms in zip(WAYS, (rough, smooth), strict=False)
        for i in range(2)
    }
    model = sf.Model.read(share_directory() / 'config' / 'exoskeleton')
    for title, bags in BAGS.items():
        found = sf.fit([logs[name][0] for name in bags], model).parameters
        for i, joint in enumerate(model.joints):
            fits[title, 'fit', i] = SimpleNamespace(parameters=found[joint])
    first = [logs[name] for name in next(iter(BAGS.values()))]
    by_bits = {
        (bits, i): fit
        for bits in (BITS if rippling else ())
        for i, fit in enumerate(read_by(bits, first))
    }
    return fits, np.array(errors), by_bits


@pytest.fixture(scope='module')
def runs() -> dict[str, list[Run]]:
    """Return what each plant has by seed, and print tables."""
    seeds = range(101, 101 + SEEDS)
    found = {
        plant: over_seeds(__file__, 'identify', seeds, rippling)
        for plant, rippling in PLANTS.items()
    }
    for plant, some in found.items():
        fits = [one for one, _, _ in some]
        for title in BAGS:
            for way in WAYS:
                print_table(f'{plant}, {title}, {way}', fits, title, way)
            print(f'left over what smoothing changed, S: {share_left(fits, title):.2f} rms')
        for i, (slope, smoothed, stated, unsure) in enumerate(np.mean([e for _, e, _ in some], 0)):
            print(
                f'{plant}, T3, velocity of joint {i} [mrad/s]: slope wrong by {1e3 * slope:.2f}, '
                f'smoothed by {1e3 * smoothed:.2f}, stated {1e3 * stated:.2f}; '
                f'{unsure:.1f} times the noise of the slope'
            )
    if FULL:
        print_bits([by_bits for _, _, by_bits in found['rippling']])
    return found


@pytest.fixture(scope='module')
def results(runs) -> dict[str, list[Fits]]:
    """Return the fits of each plant by seed."""
    return {plant: [fits for fits, _, _ in some] for plant, some in runs.items()}


def share_left(fits: list[Fits], title: str) -> float:
    """
    Return the error of S after smoothing over what smoothing changed, root mean square.

    Of the fits that it changed: where v is no surer than the slope, the slope stays.
    """
    shares = []
    for one in fits:
        for i, truth in enumerate(TRUTH):
            before, after = (one[title, way, i].drawn['stribeck'] for way in WAYS[:2])
            if after != before:
                shares.append((after - truth['stribeck']) / (after - before))
    return float(np.sqrt(np.mean(np.square(shares))))


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


def print_bits(runs: list[dict[tuple[int, int], LawFit]]) -> None:
    print('\nrippling, the same motion read by an encoder of so many bits')
    print('bits joint  mean error of S  mean half interval  in 95 % (all parameters)')
    for bits in BITS:
        for i, truth in enumerate(TRUTH):
            S = [one[bits, i].drawn['stribeck'] - truth['stribeck'] for one in runs]
            held = sum(hits([one[bits, i].parameters[n]], x) for one in runs
                       for n, x in truth.items())  # fmt: skip
            wide = np.mean([half_width(one[bits, i].parameters['stribeck']) for one in runs])
            print(f'{bits:4} {i:5} {np.mean(S):+16.5f} {wide:19.5f} {held:8} of {4 * len(runs)}')


def half_width(parameter):
    low, high = parameter.interval
    return 0.5 * (high - low)


def hits(found, value):
    return sum(p.interval[0] <= value <= p.interval[1] for p in found)


@pytest.mark.parametrize('title', BAGS)
@pytest.mark.parametrize('plant', PLANTS)
def test_intervals_hold_the_truth(results, plant, title):
    """Of 95 % intervals, fewer than the bound would be seen once in 1000 campaigns."""
    fits = results[plant]
    held = sum(
        hits([one[title, 'fit', i].parameters[name]], value)
        for one in fits
        for i, truth in enumerate(TRUTH)
        for name, value in truth.items()
    )
    assert held >= binom.ppf(1e-3, 8 * len(fits), 0.95)


def test_the_elbow_s_ripple_no_longer_hides_its_knee(results):
    """S by smoothed velocities is nearer to the truth than by slopes of the position."""
    for title in BAGS:
        error = {way: [] for way in WAYS[:2]}
        for way in error:
            for fits in results['rippling']:
                error[way].append(abs(fits[title, way, 1].drawn['stribeck'] - 0.25))
        assert np.mean(error['smoothed']) < 0.5 * np.mean(error['position'])


def test_smoothed_velocities_are_nearer_to_the_plant_s(runs):
    """By half and more where the joint ripples; what is stated is not less than the error."""
    errors = np.mean([errors for _, errors, _ in runs['rippling']], axis=0)
    slope, smoothed, stated, _ = errors.T
    assert (smoothed < 0.5 * slope).all()
    assert (stated > 0.5 * smoothed).all()


@only_full
def test_a_better_encoder_makes_the_fit_better(runs):
    """S of both joints from the finest encoder: nearer, and of a narrower interval that holds."""
    runs = [by_bits for _, _, by_bits in runs['rippling']]
    coarse, fine = BITS[0], BITS[-1]
    for i, truth in enumerate(TRUTH):
        by = {bits: [one[bits, i].parameters['stribeck'] for one in runs] for bits in BITS}
        wide = {bits: np.mean([half_width(p) for p in found]) for bits, found in by.items()}
        assert wide[fine] <= wide[coarse]
        assert hits(by[fine], truth['stribeck']) >= binom.ppf(1e-3, len(runs), 0.95)
