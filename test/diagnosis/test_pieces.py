# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The parts of a diagnosis, each against a closed form or an independent implementation."""

from __future__ import annotations

import dataclasses
import json
import re
from pathlib import Path

import numpy as np
import pytest
from known_robots import arm_model, arm_motion, recording, rigid_effort
from scipy.signal import lfilter

from sosml_friction.bags.even_stretches import even_stretches
from sosml_friction.bags.joint_log import JointLog
from sosml_friction.diagnosis.data_checks import check_log, velocity_lag
from sosml_friction.diagnosis.decision.leftover import (
    AT_ONCE,
    AXES,
    BURSTS,
    FRICTION_BY,
    SLOW,
    TONE,
    TORQUE_BY,
)
from sosml_friction.diagnosis.library import make_library, searched_terms
from sosml_friction.exceptions import ConfigurationError
from sosml_friction.identification.clean_samples import CleanSamples
from sosml_friction.model.dahl import dahl_path
from sosml_friction.model.finite_differences import first_derivative, second_derivative
from sosml_friction.model.terms.kinds.fitted import Fitted
from sosml_friction.model.terms.kinds.term import TERMS
from sosml_friction.model.terms.kinds.transmission_term import deflection
from sosml_friction.regression.band import Band
from sosml_friction.regression.contacts import find_contacts, find_impacts
from sosml_friction.regression.curves.axes import BACK_AND_FORTH, POSITION
from sosml_friction.regression.curves.elsewhere import Elsewhere
from sosml_friction.regression.noise_model import ORDER, fit_noise
from sosml_friction.regression.nominal import effort_slope, make_nominal
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare
from sosml_friction.regression.structure import HATS, Structure

#: Those of design.md section 4 that the library holds; the other three are faults of data.
DESIGN = [
    'coulomb',
    'viscous',
    'stribeck',
    'asymmetric_friction',
    'load_dependent_friction',
    'position_dependent_friction',
    'cogging',
    'presliding_hysteresis',
    'hysteresis',
    'thermal_drift',
    'backlash',
    'joint_elasticity',
    'effort_scale',
    'effort_saturation',
    'effort_bias',
    'effort_delay',
    'gravity',
    'gravity_tilt',
    'inertia',
    'payload',
    'joint_coupling',
    'spring',
    'encoder_eccentricity',
]


@pytest.fixture(scope='module')
def arm():
    """Return the model, and the signals of a motion whose effort is the model's own."""
    model = arm_model()
    t = np.arange(0.0, 24.0, 4e-3)
    q, v, a = arm_motion(t)
    tau = rigid_effort(model, q, v, a) + 0.5 * np.sign(v) + 0.2 * v
    tau += np.random.default_rng(0).normal(0.0, 0.01, tau.shape)
    log = recording(('shoulder', 'elbow'), t, q, tau, v)
    return model, log, prepare([log], model, model.make_robot(), DiagnosisSettings(band=15.0))[0]


def test_the_library_holds_the_effects_of_the_design():
    assert sorted(searched_terms()) == sorted(DESIGN)


def test_an_unknown_effect_is_refused_by_name():
    with pytest.raises(ConfigurationError, match='stiction'):
        make_library(('stiction',))


@pytest.mark.parametrize('identifier', DESIGN)
def test_every_effect_has_finite_columns_and_restores_what_it_reports(arm, identifier):
    _, _, signals = arm
    effect = TERMS[identifier]()
    # As if it were four minutes: a drift is not looked for in seconds.
    signals = dataclasses.replace(signals, time=10.0 * signals.time)
    joint = 1
    assert effect.applies(signals, joint)
    inner = effect.grid(signals, joint)[0]
    columns = effect.columns(signals, joint, inner)
    assert columns.shape == (len(signals.q), 2, len(effect.amplitudes))
    assert np.isfinite(columns).all()
    assert np.abs(columns).max() > 0.0
    amplitude = np.arange(1.0, len(effect.amplitudes) + 1.0)
    reported = effect.reported(Fitted(signals, joint, inner, amplitude, 0.1 * amplitude))
    assert all(parameter.unit for parameter in reported.values())
    again, values = effect.restore(reported)
    assert again == dict(inner)
    assert values == pytest.approx(amplitude)
    bounds = effect.inner_bounds(signals, joint)
    for point in effect.grid(signals, joint):
        for name, (low, high) in bounds.items():
            assert low <= point[name] <= high


def test_dahls_state_is_an_exponential_and_keeps_its_value_at_rest():
    q = np.concatenate([np.linspace(0.0, 3.0, 7), np.full(5, 3.0), np.linspace(3.0, 2.0, 40)])
    z = dahl_path(q, 1.0)
    assert z[:7] == pytest.approx(1.0 - np.exp(-q[:7]))
    assert z[7:12] == pytest.approx(z[6])
    assert z[-1] == pytest.approx(-1.0 + (1.0 + z[6]) * np.exp(-1.0))


def test_the_band_passes_slow_and_stops_fast_without_delay():
    band = Band(15.0, 2e-3)
    t = np.arange(0.0, 4.0, band.step)
    kept = t[band.first :: band.factor][: band.count(len(t))]
    slow = band.apply(np.sin(2.0 * np.pi * 3.0 * t))
    # Ripple of the Hamming window: 0.2 %, with a short filter up to twice that.
    assert slow == pytest.approx(np.sin(2.0 * np.pi * 3.0 * kept), abs=5e-3)
    # What is folded back by the decimation is stopped: 53 dB for this window.
    assert np.abs(band.apply(np.sin(2.0 * np.pi * 40.0 * t))).max() < 3e-3


def test_derivatives_are_of_fourth_order():
    errors = []
    for h in (0.02, 0.01):
        t = np.arange(0.0, 3.0, h)
        inner = slice(5, -5)
        one = first_derivative(np.sin(4.0 * t), h) - 4.0 * np.cos(4.0 * t)
        two = second_derivative(np.sin(4.0 * t), h) + 16.0 * np.sin(4.0 * t)
        errors.append((np.abs(one[inner]).max(), np.abs(two[inner]).max()))
    assert np.log2(np.array(errors[0]) / errors[1]) == pytest.approx([4.0, 4.0], abs=0.1)


def test_whitened_noise_is_white_with_variance_one():
    rng = np.random.default_rng(2)
    w = rng.standard_normal(20000)
    x = np.zeros_like(w)
    for k in range(2, len(w)):
        x[k] = 1.2 * x[k - 1] - 0.5 * x[k - 2] + 0.3 * w[k]
    # No low-pass has a stop band here that white noise would have to fill.
    model = fit_noise([x[2:]], 1e-9, added=0.0)
    # Standard error of a coefficient is about sqrt((1 - 0.5^2) / N) = 0.006.
    assert model.coefficients[:2] == pytest.approx([1.2, -0.5], abs=0.03)
    e = model.whiten(x)
    assert len(e) == len(x) - ORDER
    assert float(np.var(e)) == pytest.approx(1.0, abs=0.03)
    assert abs(float(np.corrcoef(e[1:], e[:-1])[0, 1])) < 0.03
    assert float(np.std(model.draw(20000, rng))) == pytest.approx(float(np.std(x)), rel=0.05)


def test_short_pieces_of_noise_make_no_unstable_filter():
    """
    Noise that is seen in 30 pieces of 40 rows, strongly coloured: what it predicts stays white.

    Of 1200 rows a variance is known to 4 %; the six coefficients take a little of it. Products
    counted by lag, in Yule and Walker's equations, are no covariance of short pieces.
    """
    rng = np.random.default_rng(3)
    poles = np.repeat([0.97, 0.9], 2) * np.exp(1j * np.array([0.4, -0.4, 1.6, -1.6]))
    denominator = np.real(np.poly(poles))
    worst = []
    for _ in range(10):
        x = lfilter([1.0], denominator, rng.normal(size=1200 + 400))[400:]
        model = fit_noise(np.split(x, 30), 1e-12, added=0.0)
        assert (np.abs(np.roots(np.append(1.0, -model.coefficients))) < 1.0).all()
        worst.append(float(np.var(model.whiten(x))))
    assert worst == pytest.approx([1.0] * 10, abs=0.25)


def test_noise_of_nothing_is_the_least_that_is_allowed():
    for residuals in ([np.zeros(50)], [np.zeros(3)], []):
        model = fit_noise(residuals, 1e-3)
        assert model.sigma == 1e-3
        assert (model.coefficients == 0.0).all()


def test_what_is_cut_in_motion_does_not_seem_to_stop_at_its_ends():
    """
    Beyond an end it goes on with the same speed: a line stays a line, and has no acceleration.

    An end that was held made a spike of 100 rad/s2, and a delay of effort was lost in it.
    """
    band = Band(12.0, 2e-3)
    line = 0.4 * np.arange(500) * 2e-3
    assert band.smooth(line) == pytest.approx(line, abs=1e-12)
    assert first_derivative(line, 2e-3) == pytest.approx(0.4, abs=1e-9)
    assert second_derivative(line, 2e-3) == pytest.approx(0.0, abs=1e-6)


def test_a_free_curve_is_one_over_all_stretches(arm):
    """Where position is the same, so is the curve, whatever else a stretch holds."""
    _, _, signals = arm
    quarter = (len(signals.q) - 1) // 4
    far, near = np.zeros((2, *signals.q.shape))
    far[: 4 * quarter + 1] = np.linspace(-1.0, 1.0, 4 * quarter + 1)[:, None]
    near[:] = 0.5 * far
    stretches = [dataclasses.replace(signals, q=q) for q in (far, near)]
    # Every second position of the short way is one of the long.
    same = slice(quarter, 3 * quarter + 1), slice(0, 4 * quarter + 1, 2)
    assert far[same[0]] == pytest.approx(near[same[1]], abs=1e-12)
    # Of a structure, the second axis is position; of what is elsewhere, the next joint's.
    for effect, hats in (
        (Elsewhere(stretches), slice(18, 27)),
        (Structure(stretches), slice(18, 27)),
    ):
        one, other = (
            effect.columns(x, 0, {})[rows, 0, hats]
            for x, rows in zip(stretches, same, strict=True)
        )
        assert one.std() > 0.1
        assert one == pytest.approx(other, abs=1e-9)


@pytest.mark.parametrize(('apart', 'asked'), [(3.0, False), (30.0, True)])
def test_of_a_joint_that_moves_in_proportion_nothing_is_asked_by_its_speed(arm, apart, asked):
    """Beside the own speed the noise of its velocity is left: 3 times it is, 30 times is not."""
    _, _, signals = arm
    noise = np.array([0.01, 0.02])
    other = np.random.default_rng(0).standard_normal(len(signals.v))
    v = np.column_stack([signals.v[:, 0], 0.5 * signals.v[:, 0] + apart * noise[1] * other])
    own = dataclasses.replace(signals, v=v, jitter=noise)
    hats = Elsewhere([own]).columns(own, 0, {})[:, 0]
    assert np.abs(hats[:, : 4 * HATS]).sum(axis=0).all()
    assert hats[:, 4 * HATS : 6 * HATS].any() == asked


def test_a_spring_deflects_by_load_over_stiffness_and_a_gap_by_half_of_it():
    load, inertia = np.full(2000, 3.0), np.full(2000, 0.1)
    d, a = deflection(load, inertia, 500.0, 0.0, 1e-3, 4)
    assert d[-1] == pytest.approx(-3.0 / 500.0, rel=1e-6)
    assert a[-1] == pytest.approx(0.0, abs=1e-6)
    gap, _ = deflection(load, inertia, 500.0, 0.01, 1e-3, 4)
    assert gap[-1] == pytest.approx(-3.0 / 500.0 - 0.005, rel=1e-6)


def test_a_sinusoidal_load_deflects_a_spring_by_the_oscillators_gain():
    K, M, w = 400.0, 0.1, 20.0
    t = np.arange(0.0, 20.0, 1e-3)
    d, _ = deflection(np.sin(w * t), np.full(len(t), M), K, 0.0, 1e-3, 10)
    c = 2.0 * 0.05 * np.sqrt(K * M)
    gain = 1.0 / abs(K - M * w**2 + 1j * c * w)
    # 1 %: semi-implicit steps of 0.1 ms.
    assert np.abs(d[-1000:]).max() == pytest.approx(gain, rel=0.01)


def test_the_nominal_of_the_planar_arm_has_its_base_parameters(arm):
    _, _, signals = arm
    nominal = make_nominal(signals, 0.035)
    # Two rotors, two first moments of each body, and the second body's inertia. The other, seen
    # by the first joint alone, is one with its rotor.
    assert len(nominal.rigid) == 7
    assert nominal.names[:3] == ('shoulder coulomb', 'shoulder viscous', 'shoulder bias')
    assert nominal.bound[0] == pytest.approx(0.035 * 0.5)
    # m1 c1 = 0.375 kg m, and the forearm's 1.8 kg at 0.30 m act as one.
    moment = nominal.names.index('shoulder body 1')
    assert nominal.bound[moment] == pytest.approx(0.035 * (0.375 + 1.8 * 0.30), rel=1e-6)


def test_the_nominal_effort_is_that_of_the_model(arm):
    _, log, signals = arm
    inner = slice(200, -200)
    wrong = (log.tau - signals.torque)[inner]
    # Noise of 10 mNm, and reversals that the sign's displacement rounds off.
    assert np.median(np.abs(wrong), axis=0) == pytest.approx([0.0067, 0.0067], rel=0.1)


def test_a_velocity_that_lags_is_found_and_its_lag_measured(arm):
    _, log, signals = arm
    t = log.time
    late = np.column_stack([np.interp(t - 0.008, t, x) for x in log.v.T])
    lagged = JointLog(log.names, log.t_ns, log.q, late, log.tau)
    check = velocity_lag(lagged, signals, 0)
    assert check is not None
    assert check.severity == 'warning'
    assert check.values['lag_s'] == pytest.approx(0.008, abs=2e-4)
    assert velocity_lag(log, signals, 0).severity == 'note'


def test_lost_samples_are_counted_and_many_are_bad(arm):
    _, log, _ = arm
    rng = np.random.default_rng(3)
    for share, severity in ((0.02, 'warning'), (0.4, 'bad')):
        kept = rng.random(len(log)) > share
        kept[:2] = True
        part = JointLog(log.names, log.t_ns[kept], log.q[kept], log.v[kept], log.tau[kept])
        found = next(c for c in check_log(CleanSamples.of(part)) if c.kind == 'dropped_samples')
        assert found.severity == severity
        assert found.values['lost_share'] == pytest.approx(share, abs=0.3 * share)
    assert all(c.kind != 'dropped_samples' for c in check_log(CleanSamples.of(log)))


@pytest.mark.parametrize('push', [1.0, 0.15])
def test_a_push_is_a_contact_and_a_vibration_is_none(push):
    """Of 20 and of 3 times the noise: a mean of 12 samples knows it to a tenth and less."""
    rng = np.random.default_rng(4)
    step = 0.02
    t = np.arange(0.0, 60.0, step)
    e = rng.normal(0.0, 0.05, (len(t), 2))
    e[:, 0] += np.where((t > 20.0) & (t < 20.6), push, 0.0)
    e[:, 1] += np.where((t > 20.0) & (t < 22.0), np.sin(2.0 * np.pi * 9.0 * t), 0.0)
    found = find_contacts(e, t, step)
    assert [contact.joint for contact in found.contacts] == [0]
    assert found.contacts[0].start_s == pytest.approx(20.0, abs=0.3)
    assert found.contacts[0].end_s == pytest.approx(20.6, abs=0.3)


def test_energy_where_the_load_changes_sides_is_an_impact_and_elsewhere_is_none():
    """Ten changes of sign of the load, an impact of 5 times the noise after each, or between."""
    rng = np.random.default_rng(5)
    step = 0.02
    t = np.arange(0.0, 100.0, step)
    load = np.column_stack([np.sin(2.0 * np.pi * 0.05 * t), np.full(len(t), 2.0)])
    for shift, joints in ((0.0, [0]), (5.0, [])):
        e = rng.normal(0.0, 0.05, (len(t), 2))
        hit = np.abs(np.mod(t - shift + 0.05, 10.0) - 0.1) < 0.05
        e[hit, 0] += 0.25 * rng.choice([-1.0, 1.0], int(hit.sum()))
        impacts, spoiled = find_impacts(e, load, step, np.ones(e.shape, dtype=bool))
        assert [x.joint for x in impacts] == joints
        assert spoiled.any() == bool(joints)
        if joints:
            assert impacts[0].changes == 9
            assert impacts[0].share == 1.0
            # 0.3 s around each of 9 changes, and what rings.
            assert 0.027 <= spoiled.mean() <= 0.06


def test_a_first_moment_is_known_better_in_direction_than_in_length(arm):
    """Across the upper arm: 0.3 of the tolerance of its length, the forearm's mass beside it."""
    _, _, signals = arm
    nominal = make_nominal(signals, 0.035)
    across = nominal.names.index('shoulder body 2')
    assert nominal.bound[across] == pytest.approx(0.035 * 0.3 * 0.375, rel=1e-6)


def test_the_slope_of_effort_is_that_of_the_motion_and_not_of_the_encoders_noise(arm):
    """Within 3 % of the exact slope between reversals: 7.5 Hz pass a motion of 0.8 Hz."""
    _, _, signals = arm
    inner = slice(400, -400)
    slope = effort_slope(signals)[inner]
    exact = first_derivative(signals.torque, signals.band.step)[inner]
    calm = (np.abs(signals.sign[inner]) > 0.999).all(axis=1)
    left = np.std(signals.band.apply(slope - exact)[:, 0])
    assert calm.mean() > 0.5
    assert left < 0.3 * np.std(signals.band.apply(exact)[:, 0])


def test_friction_that_turns_around_late_is_the_columns_difference_in_time(arm):
    """s(t - d) - s(t + d) = -2 d s' (1 - (w d)^2 / 6): in steps of 4 ms at 15 Hz 2.4 % less."""
    _, _, signals = arm
    nominal = make_nominal(signals, 0.035)
    k = nominal.names.index('elbow reversal late')
    inner = slice(10, -10)
    column = signals.band.apply(nominal.columns(signals)[:, 1, k])[inner]
    s = signals.sign[:, 1]
    turned = signals.band.apply(np.roll(s, 1) - np.roll(s, -1))[inner]
    assert turned.std() > 0.01
    assert np.std(turned - 2.0 * signals.band.step * column) < 0.025 * np.std(turned)
    # Effort is held over a step: friction of 0.5 Nm may come half of one late, and a little more.
    assert nominal.bound[k] == pytest.approx(0.55 * signals.band.step * 0.5)


def test_unknown_effort_of_one_joint_is_a_hole_and_not_zero():
    """A lost sample is bridged, a second without is left out, a joint without any is none."""
    t = 4e-3 * np.arange(5000)
    q = np.column_stack([np.sin(t), np.cos(t)])
    tau = np.column_stack([5.0 + np.sin(t), 3.0 + 0.0 * t])
    tau[1000, 0] = np.nan
    tau[2000:2250, 0] = np.nan
    t_ns = np.rint(t * 1e9).astype(np.int64)
    stretches = even_stretches(JointLog(('a', 'b'), t_ns, q, np.full_like(q, np.nan), tau))
    assert [len(s) for s in stretches] == [2000, 2750]
    joined = np.concatenate([s.tau for s in stretches])
    known = np.concatenate([tau[:2000], tau[2250:]])
    known[1000, 0] = 0.5 * (known[999, 0] + known[1001, 0])
    assert joined == pytest.approx(known, abs=1e-9)
    tau[:, 1] = np.nan
    assert len(even_stretches(JointLog(('a', 'b'), t_ns, q, 0.0 * q, tau))) == 2
    tau[:] = np.nan
    assert even_stretches(JointLog(('a', 'b'), t_ns, q, 0.0 * q, tau)) == []


def test_every_axis_of_what_is_left_is_in_the_schema():
    schema = Path(__file__).parents[2] / 'docs/schema/diagnosis.schema.json'
    axes = json.loads(schema.read_text())['properties']['structure']['properties']['axes']
    one, two = axes['items']['properties']['axis']['anyOf']
    friction = {f'{FRICTION_BY}{axis}' for axis in (*AXES, BACK_AND_FORTH)}
    assert set(one['enum']) == {TONE, BURSTS, SLOW, *AXES, *friction, f'{TORQUE_BY}{POSITION}'}
    assert re.search(two['pattern'], f'{AXES[0]} and {AXES[1]}{AT_ONCE}')
