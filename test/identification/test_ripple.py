# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Ripple of the speed on plateaus: told from the encoder's noise, with its size and frequency."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from fitted_law import fit_law
from full_runs import FULL
from lockstep import emulated_exoskeleton
from lockstep_run import run_lockstep
from scipy.stats import binom

from sosml_friction.identification.data_finding import NOTE, WARNING
from sosml_friction.identification.ripple import joint_ripple, measure_ripple, shift_by_ripple
from sosml_friction.identification.weak_form import shown_by_slope
from sosml_friction.model.laws import make_friction_law
from sosml_friction.motion.trajectory_kinds.slow_ladder import slow_ladder

#: Encoders: step of time [s], quantum and other noise [rad], share of samples lost, plateau [s].
ENCODERS = {
    'rmd': (0.002, 1.745e-4, 2e-5, 0.0, 1.5),
    'servo': (0.002, 2e-4, 5e-5, 0.0, 1.5),
    'quantised only': (0.002, 1.745e-4, 0.0, 0.0, 1.5),
    'fine': (0.002, 3e-6, 1.5e-6, 0.0, 1.5),
    'white': (0.001, 0.0, 1e-5, 0.0, 1.5),
    'slow': (0.01, 1e-4, 5e-5, 0.0, 3.0),
    'lossy': (0.008, 0.0, 5e-5, 0.1, 3.0),
}
#: The emulated loop takes 25 s; that it ripples is in the suite's test_rippling_loop.py too.
SPEEDS = (0.01, 0.015, 0.02, 0.03, 0.05, 0.08)
SEEDS = 10
LAW = {'coulomb': 0.4, 'viscous': 0.2, 'stribeck': 0.25, 'stribeck_velocity': 0.03, 'bias': 0.0}


def read(q, step, quantum, noise, lost, seed):
    """Return stamps and what an encoder says of a path."""
    rng = np.random.default_rng(seed)
    q = q + quantum * rng.uniform() + noise * rng.normal(size=len(q))
    if quantum > 0.0:
        q = quantum * np.round(q / quantum)
    kept = rng.uniform(size=len(q)) >= lost
    return np.arange(len(q))[kept] * step, q[kept]


def ladder(encoder, seed, ripple=0.0, frequency=24.0, speeds=SPEEDS):
    """Return what an encoder says of plateaus up and down, with a sine of ``ripple`` rms."""
    step, quantum, noise, lost, plateau = ENCODERS[encoder]
    ramp = np.linspace(0.0, 1.0, round(0.3 / step))
    pulse = np.concatenate([ramp, np.ones(round(plateau / step)), ramp[::-1]])
    v = np.concatenate([way * speed * pulse for speed in speeds for way in (1.0, -1.0)])
    w = 2.0 * np.pi * frequency
    wave = np.sqrt(2.0) * ripple / w * np.sin(w * step * np.arange(len(v)))
    return read(np.cumsum(v) * step + wave, step, quantum, noise, lost, seed)


def rms(x):
    return float(np.sqrt(np.mean(np.square(x))))


def test_noise_rounding_and_lost_samples_are_no_ripple():
    """Of a joint in 1 % of cases: no more than chance has in one of a hundred such tests."""
    alarms = [
        encoder
        for encoder in ENCODERS
        for seed in range(SEEDS)
        if any(own.kind for own in measure_ripple(*ladder(encoder, seed)))
    ]
    print(f'\n{len(alarms)} of {SEEDS * len(ENCODERS)} joints: {alarms}')
    assert len(alarms) <= binom.isf(0.01, SEEDS * len(ENCODERS), 0.01)


def test_lines_of_rounding_that_fold_into_the_band_are_no_ripple_where_a_speed_settles():
    """Of 1565 counts a second, at 1 kHz, the second line is seen at 130 Hz, the first at 435."""
    t = np.arange(0.0, 1.5, 0.001)
    rest = np.zeros(300)
    settling = 0.3 * (1.0 + 0.03 * np.exp(-t / 0.2))
    v = np.concatenate([rest, settling, rest, -settling, rest])
    for seed in range(SEEDS):
        found = measure_ripple(*read(0.001 * np.cumsum(v), 0.001, 0.3 / 1565, 0.0, 0.0, seed))
        assert len(found) == 2
        assert {own.kind for own in found} == {''}


@pytest.mark.parametrize('encoder', ['servo', 'fine', 'white', 'slow', 'lossy'])
@pytest.mark.parametrize(('size', 'frequency'), [(0.006, 24.0), (0.003, 8.0)])
def test_a_sine_is_found_with_its_size_and_frequency(encoder, size, frequency):
    found = measure_ripple(*ladder(encoder, 1, size, frequency))
    seen = [own for own in found if own.kind]
    assert len(seen) >= 0.9 * len(found) > 0
    assert rms([own.ripple for own in found]) == pytest.approx(size, rel=0.1)
    assert np.median([own.frequency for own in seen]) == pytest.approx(frequency, abs=2.0)
    position = size / (2.0 * np.pi * frequency)
    assert np.median([own.position for own in seen]) == pytest.approx(position, rel=0.15)
    fast = [own.kind for own in seen if abs(own.velocity) > 0.04]
    assert set(fast) == {'limit cycle'}
    slow = [own for own in seen if abs(own.velocity) < 0.9 * np.sqrt(2.0) * own.ripple]
    assert {own.kind for own in slow} <= {'stick-slip'}


def test_ripple_through_steps_as_large_as_itself_is_found_within_a_third():
    found = measure_ripple(*ladder('rmd', 1, 0.002, 24.0))
    assert rms([own.ripple for own in found if np.isfinite(own.ripple)]) == pytest.approx(
        0.002, rel=0.33
    )


@pytest.mark.parametrize('frequency', [2.0, 4.0, 8.0])
def test_stick_slip_is_told_with_frequency_and_size(frequency):
    """0.03 rad/s on the mean; it moves in 30 % of each period and stands in the rest."""
    t = np.arange(0.0, 6.0, 0.002)
    moves = np.where((frequency * t) % 1.0 < 0.3, 0.03 / 0.3, 0.0)
    rest = np.zeros(250)
    v = np.concatenate([part for way in (1.0, -1.0) for part in (rest, way * moves)] + [rest])
    found = measure_ripple(*read(0.002 * np.cumsum(v), 0.002, 1.745e-4, 2e-5, 0.0, 3))
    assert len(found) >= 2
    assert {own.kind for own in found} == {'stick-slip'}
    # The fundamental and its harmonics: 0.7 / 0.3 of the mean speed, squared.
    assert rms([own.ripple for own in found]) == pytest.approx(0.03 * np.sqrt(0.7 / 0.3), rel=0.2)
    for own in found:
        # No better than half of the bandwidth of the spectrum.
        width = 2.5 / (own.end_s - own.start_s)
        assert own.frequency == pytest.approx(frequency, abs=width)


def law_fit(noise=1e-3, seed=0):
    """Return the fit of the law to pairs at the speeds of the ladder and above."""
    v = np.repeat([way * w for w in (*SPEEDS, 0.15, 0.3, 0.6) for way in (1.0, -1.0)], 4)
    y = make_friction_law('stribeck', LAW, 0.0).torque(v)
    y = y + noise * np.random.default_rng(seed).normal(size=len(v))
    return fit_law(v, y, np.arange(len(v)), 'Nm')


def test_the_bias_of_a_law_is_its_mean_over_the_ripple_minus_the_law_at_the_mean():
    found, finding = joint_ripple('elbow', 'Nm', *ladder('fine', 1, 0.005), law_fit())
    law = make_friction_law('stribeck', LAW, 0.0)
    phase = np.sin(2.0 * np.pi * np.arange(400) / 400)
    for own in found:
        if abs(own.velocity) > 0.012:
            swing = law.torque(abs(own.velocity) + np.sqrt(2.0) * 0.005 * phase)
            expected = np.mean(swing) - law.torque(abs(own.velocity))
            assert abs(own.bias) == pytest.approx(expected, rel=0.3, abs=2e-4)
    assert finding is not None
    assert finding.level == WARNING
    assert finding.joint == 'elbow'
    for words in ('12 of 12 plateaus', '24', 'rad/s', 'stribeck by about'):
        assert words in finding.sentence


def test_plateaus_on_which_no_ripple_is_seen_do_not_move_the_law():
    """S and v_s of one rippling speed alone were two numbers from one: S moved by anything."""
    found, _ = joint_ripple('elbow', 'Nm', *ladder('fine', 1, 0.005), law_fit())
    law = make_friction_law('stribeck', LAW, 0.0)
    quiet = [own if abs(own.velocity) > 0.07 else replace(own, kind='') for own in found]
    assert any(own.kind for own in quiet)
    every, fast = shift_by_ripple(found, law), shift_by_ripple(quiet, law)
    assert abs(fast['stribeck']) < 0.2 * abs(every['stribeck'])
    assert abs(fast['stribeck_velocity']) < 0.01 * LAW['stribeck_velocity']


def test_ripple_that_the_slope_of_the_position_shows_does_not_move_the_law():
    """A slow one, of 2 Hz, is in the velocities of the weak form, and one of 24 Hz is not."""
    found, _ = joint_ripple('elbow', 'Nm', *ladder('fine', 1, 0.005), law_fit())
    law = make_friction_law('stribeck', LAW, 0.0)
    shift = shift_by_ripple(found, law)['stribeck']
    for frequency, low, high in ((2.0, 0.0, 0.01), (24.0, 0.98, 1.0)):
        same = [replace(own, frequency=frequency) for own in found]
        left = shift_by_ripple(same, law, partial(shown_by_slope, 0.002))['stribeck']
        assert low <= left / shift <= high


def test_ripple_too_small_to_move_the_law_is_a_note():
    wide = law_fit(noise=0.05)
    _, finding = joint_ripple('slide', 'N', *ladder('fine', 1, 0.001, speeds=(0.05, 0.08)), wide)
    assert finding is not None
    assert finding.level == NOTE
    assert 'm/s rms' in finding.sentence


def test_without_plateaus_there_is_nothing_to_tell():
    t = np.arange(0.0, 5.0, 0.002)
    assert joint_ripple('elbow', 'Nm', t, np.sin(2.0 * np.pi * t), None) == ((), None)
    assert measure_ripple(t, np.zeros(len(t))) == ()
    assert measure_ripple(t[:1], t[:1]) == ()


@pytest.fixture(scope='module')
def plateaus():
    """Return (found, true rms) of the plateaus, by joint, of a slow ladder; rippling or not."""

    def run(rippling):
        centre = {'shoulder': -0.5 * np.pi, 'elbow': 1.2}
        emulator = emulated_exoskeleton(1, rippling=rippling)
        times, speeds, step = [], [], emulator.plant.step

        def noted(effort, h):
            step(effort, h)
            times.append(emulator.time_ns)
            speeds.append(emulator.v)

        emulator.plant.step = noted
        start = {'shoulder': -0.5 * np.pi, 'elbow': 0.0}
        log = run_lockstep(slow_ladder(start, centre, (0.015, 0.02, 0.03, 0.05)), emulator)
        t, v = (np.array(times) - log.t_ns[0]) * 1e-9, np.array(speeds)
        result = []
        for i in range(2):
            found = [own for own in measure_ripple(log.time, log.q[:, i])]
            found = [own for own in found if 0.012 < abs(own.velocity) < 0.06]
            true = []
            for own in found:
                inside = (t >= own.start_s) & (t <= own.end_s)
                trend = np.polyfit(t[inside], v[inside, i], 2)
                true.append(np.std(v[inside, i] - np.polyval(trend, t[inside])))
            result.append((found, rms(true)))
        return result

    return {rippling: run(rippling) for rippling in (False, True)}


@pytest.mark.skipif(not FULL, reason='25 s: make validate')
@pytest.mark.parametrize('i', [0, 1])
def test_the_emulated_loop_that_ripples_is_seen_within_20_percent_of_the_truth(plateaus, i):
    found, true = plateaus[True][i]
    size = rms([own.ripple for own in found if np.isfinite(own.ripple)])
    print(f'\ntrue {1e3 * true:.2f}, found {1e3 * size:.2f} mrad/s')
    assert size == pytest.approx(true, rel=0.2)
    if i == 1:
        seen = [own for own in found if own.kind]
        assert len(seen) > 0.7 * len(found)
        assert np.median([own.frequency for own in seen]) == pytest.approx(24.0, abs=4.0)


@pytest.mark.skipif(not FULL, reason='25 s: make validate')
def test_the_shipped_gains_do_not_ripple(plateaus):
    """The elbow moves by a third of what it did, the shoulder by little more than a half."""
    for i, share in ((0, 0.65), (1, 0.45)):
        assert plateaus[False][i][1] < share * plateaus[True][i][1]
    assert not any(own.kind == 'limit cycle' for own in plateaus[False][1][0])
