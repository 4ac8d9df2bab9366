# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What the blind campaign is made of: plant, effects, signal-to-noise, score, plan, bars."""

from __future__ import annotations

import json
from collections import Counter

import numpy as np
import pytest

from sosml_friction.diagnosis.library import make_library, searched_terms
from sosml_friction.model.terms.kinds.term import DATA_CAUSES
from validation import campaign as blind_campaign
from validation import plan as blind_plan
from validation import plant as bp
from validation import snr as blind_snr
from validation import trial as blind_trial
from validation.bars import bars, interval
from validation.effects import FAULTS, OUTSIDE, TWINS, TYPICAL, hide
from validation.gain import held_out, true_residual
from validation.judge import judge
from validation.motion import reference
from validation.plan import make_plan
from validation.process import _check_model
from validation.tables import tables
from validation.trial import SINGLES, Spec, Truth, build

BAND = blind_snr.USUAL_BAND
#: A piece of the rich trajectory [s].
PIECE_S = 24.0


def answer(verdict, *causes):
    return {
        'verdict': verdict,
        'causes': [{'effect': e, 'joint': j, 'rivals': r} for e, j, r in causes],
    }


def score(kind, effect, joint, document):
    truths = [Truth(effect, joint, 1.0)] if effect else []
    return judge(kind, truths, document).score


def test_the_score_rewards_the_truth_and_punishes_a_wrong_name():
    named = answer('named', ('coulomb', 'elbow', []))
    assert score('single', 'coulomb', 'elbow', named) == 1
    assert score('single', 'coulomb', 'shoulder', named) == -1
    assert score('single', 'viscous', 'elbow', named) == -1
    assert score('null', None, '*', named) == -1
    assert score('outside', 'root_friction', 'elbow', named) == -1
    assert score('single', 'coulomb', 'elbow', answer('nothing_above_floor')) == 0
    assert score('null', None, '*', answer('nothing_above_floor')) == 1
    unknown = answer('unknown_structure', ('coulomb', 'elbow', []))
    assert score('single', 'coulomb', 'elbow', unknown) == 0
    assert score('outside', 'root_friction', 'elbow', unknown) == 1
    both = answer('ambiguous', ('asymmetric_friction', 'elbow', ['effort_bias']))
    assert score('single', 'effort_bias', 'elbow', both) == 0
    elsewhere = answer('ambiguous', ('spring', 'elbow', ['gravity@shoulder']))
    assert score('single', 'gravity', 'shoulder', elsewhere) == 0
    gear = answer('ambiguous', ('joint_elasticity', 'elbow', ['backlash']))
    assert score('single', 'backlash', 'elbow', gear) == 1
    assert score('single', 'backlash', 'shoulder', gear) == -1
    wide = answer('ambiguous', ('joint_elasticity', 'elbow', ['backlash', 'inertia']))
    assert score('single', 'backlash', 'elbow', wide) == 0


def test_twins_need_the_set():
    both = answer('ambiguous', ('effort_bias', 'elbow', ['asymmetric_friction']))
    alone = answer('named', ('effort_bias', 'elbow', []))
    for effect in ('effort_bias', 'asymmetric_level'):
        assert score('twin', effect, 'elbow', both) == 1
    assert score('twin', 'effort_bias', 'elbow', alone) == 0
    assert score('twin', 'asymmetric_level', 'elbow', alone) == -1
    assert score('twin', 'spring', 'elbow', answer('named', ('spring', 'elbow', []))) == 1
    scaled = answer('ambiguous', ('effort_scale', '*', ['inertia']))
    assert score('twin', 'common_scale', '*', scaled) == 1
    scaled = answer('ambiguous', ('effort_scale', 'elbow', ['inertia']))
    assert score('twin', 'common_scale', '*', scaled) == 0
    alone = answer('named', ('effort_scale', 'elbow', []), ('effort_scale', 'shoulder', []))
    assert score('twin', 'common_scale', '*', alone) == 0


def test_two_effects_are_counted_one_by_one():
    truths = (Truth('coulomb', 'elbow', 1.0), Truth('backlash', 'shoulder', 1.0))
    causes = [
        ('coulomb', 'elbow', []), ('spring', 'elbow', []),
        ('joint_elasticity', 'shoulder', ['backlash']),
    ]  # fmt: skip
    judged = judge('double', truths, answer('ambiguous', *causes))
    assert (judged.first, judged.found, judged.spurious) == (True, 2, 1)
    judged = judge('double', truths, answer('named', causes[1], causes[0]))
    assert (judged.first, judged.found, judged.spurious) == (False, 1, 1)
    assert judge('double', truths, answer('nothing_above_floor')).found == 0


def test_every_effect_of_the_library_and_every_fault_can_be_hidden():
    assert set(TYPICAL) | set(FAULTS) == set(searched_terms()) | set(DATA_CAUSES)


def test_every_cause_can_be_left_out():
    """For the mutation: without each cause, its trial has to fail."""
    for effect in (*TYPICAL, *FAULTS):
        assert set(make_library((effect,))) == set(searched_terms()) - {effect}


def test_the_exact_plant_obeys_the_closed_form_to_a_tenth_of_the_noise():
    """Two ways to the same equations; the rest is the time step and the tanh of the reference."""
    for soft in (False, True):
        run = bp.simulate(
            bp.Plant(soft=soft), *reference('rich', PIECE_S), np.random.default_rng(0),
            bp.Noise(exact=True),
        )  # fmt: skip
        left = blind_snr.rms(blind_snr.residual(run, BAND))
        noise = blind_snr.noise_rms('rich', PIECE_S, soft, bp.Noise(), BAND)
        assert (left < 0.1 * np.array(noise)).all()


def test_what_a_nominal_within_its_tolerance_takes_up_is_no_effect():
    """Of a mass that is off by twice the tolerance half is left, of one within it nothing."""

    def beyond(**change):
        plant = bp.Plant(**change)
        return blind_snr.beyond_tolerance(plant, 'rich', PIECE_S, bp.Noise(), BAND)

    within = beyond(second=bp.C2 * (1.0 + 0.9 * blind_snr.TOLERANCE))
    twice = bp.Plant(second=bp.C2 * (1.0 + 2.0 * blind_snr.TOLERANCE))
    raw = blind_snr.signal_to_noise(twice, 'rich', PIECE_S, bp.Noise(), BAND).max()
    # The controller makes of another mass a slightly other motion, seen through the friction.
    assert within < 0.02 * raw
    assert 0.0 < beyond(second=twice.second) <= 0.5 * raw
    assert beyond(bias=np.array([0.0, 0.3])) > 10.0 * within


def test_a_twin_is_larger_than_what_the_nominal_takes_up():
    spec = Spec('x', 'twin', 1, 'effort_bias', 1, level='high', motion='multisine', moving=True)
    trial = build(spec)
    seen = blind_snr.beyond_tolerance(trial.exact, 'multisine', None, trial.noise, BAND)
    assert seen >= 0.95 * blind_trial.VISIBLE
    assert trial.snr(BAND) > seen


def test_snr_is_the_size_over_the_noise():
    """A bias is its own root mean square: the mean is not taken off. Slopes are linear in size."""
    noise = blind_snr.noise_rms('rich', PIECE_S, False, bp.Noise(), BAND)
    plant = bp.Plant()
    plant.bias[0] = 0.1
    found = blind_snr.signal_to_noise(plant, 'rich', PIECE_S, bp.Noise(), BAND)
    assert found == pytest.approx([0.1 / noise[0], 0.0], abs=1e-6)
    twice = []
    for scale in (0.5, 1.0):
        plant = bp.Plant()
        hide(plant, 'viscous', 1, scale, np.random.default_rng(0), PIECE_S)
        twice.append(blind_snr.signal_to_noise(plant, 'rich', PIECE_S, bp.Noise(), BAND)[1])
    # The motion changes a little with the friction.
    assert twice[1] == pytest.approx(2.0 * twice[0], rel=0.02)


@pytest.mark.parametrize('effect', [*TYPICAL, *OUTSIDE, *TWINS])
def test_every_effect_leaves_something_in_its_joint(effect):
    """A typical size is above a third of the noise; eccentricity is not, and is not asked for."""
    for i in range(2):
        plant = bp.Plant()
        hide(plant, effect, i, 1.0, np.random.default_rng(1), PIECE_S)
        found = blind_snr.signal_to_noise(plant, 'rich', PIECE_S, bp.Noise(), BAND)
        joint = 0 if effect == 'joint_coupling' else i
        least = 0.01 if effect == 'encoder_eccentricity' else 0.3
        assert found[joint] > least


def test_a_trial_is_made_from_its_spec_alone_and_a_bin_of_snr_is_met():
    spec = Spec('x', 'single', 7, 'stribeck', 1, duration=PIECE_S, holdout=True)
    first, second = build(spec), build(spec)
    for one, other in ((first.log, second.log), (first.holdout, second.holdout)):
        for name in ('q', 'v', 'tau'):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    whole = build(Spec('x', 'single', 7, 'cogging', 1, level='middle'))
    assert 0.35 < whole.snr(BAND) < 0.6


def test_the_cut_on_held_out_data_is_that_of_the_excess_over_the_true_model():
    """A bias of 0.15 Nm of which 0.05 are left: a cut of 3, whatever the noise on top."""
    spec = Spec(
        'x', 'single', 5, 'effort_bias', 0, scale=1.0, duration=PIECE_S, nuisance=(0.0, 0.0),
        holdout=True,
    )  # fmt: skip
    trial = build(spec)
    assert trial.holdout is not None
    other = bp.Run(trial.holdout.time, trial.holdout.q, trial.holdout.v, trial.holdout.tau)
    left = blind_snr.residual(other, BAND)
    sign = np.sign(left[:, 0].mean())
    errors = blind_snr.rms(left), blind_snr.rms(left - [0.1 * sign, 0.0])
    gain = {
        name: {
            'inverse': {'before': float(errors[0][i]), 'after': float(errors[1][i])},
            'forward': {'ratio': 0.5, 'ratio_std_error': 0.1},
        }
        for i, name in enumerate(blind_trial.JOINTS)
    }
    found = held_out(trial, {'band_hz': BAND, 'gain': gain})
    # The mean of the coloured noise over 60 s is 2 mNm, of the 50 that are left.
    assert found['cut'] == pytest.approx(3.0, rel=0.15)
    assert found['forward'] == 0.5
    assert (found['joints'], found['joint_errors']) == ([0.5, 0.5], [0.1, 0.1])
    assert found['gain'] < found['true_gain']


def test_the_true_model_leaves_the_noise_through_the_true_inertia_and_scale():
    """It is noise of effort - scale M(q) e''; the forearm's inertia is in all four of M alike."""

    def left(**hidden):
        spec = Spec('x', 'single', 5, 'effort_bias', 0, scale=0.1, duration=PIECE_S)
        trial = build(spec)
        for name, value in hidden.items():
            setattr(trial.exact, name, value)
        return true_residual(trial, BAND)

    usual = left()
    # The same motion and draws with nothing hidden, as the nominal sees them.
    plant = bp.Plant()
    run = bp.simulate(
        plant, *reference(*blind_trial.HOLDOUT), np.random.default_rng([5, 4]), bp.Noise()
    )
    assert usual == pytest.approx(blind_snr.residual(run, BAND), abs=1e-9)
    weightless = {'armature': np.zeros(2)}
    effort = left(
        inertia=(0.0, 0.0), first=0.0, second=0.0, mass_2=0.0, joint={**plant.joint, **weightless}
    )
    position = usual - effort
    assert blind_snr.rms(position).min() > 1e-3
    scaled = left(scale=np.array([2.0, 1.0]))
    assert scaled - usual == pytest.approx(position * [1.0, 0.0], abs=1e-12)
    heavy, heavier = (left(inertia=(bp.I1, k * bp.I2)) - usual for k in (2.0, 3.0))
    assert heavy[:, 0] == pytest.approx(heavy[:, 1], abs=1e-12)
    assert heavier == pytest.approx(2.0 * heavy, abs=1e-12)
    # Of the elbow's own M, m22 = I2 + rotor: nothing else is in its part of e2''.
    rotors = left(joint={**plant.joint, 'armature': 2.0 * bp.ARMATURE}) - usual
    mixed = position[:, 1] - heavy[:, 1] - rotors[:, 1]
    elbow = rotors[:, 1] / bp.ARMATURE[1]
    shoulder = rotors[:, 0] / bp.ARMATURE[0]
    assert heavy[:, 0] == pytest.approx(bp.I2 * (shoulder + elbow), abs=1e-12)
    # What is left of m12 is L1 m2 c2 cos(elbow), of the shoulder's acceleration alone.
    assert (np.abs(mixed) <= bp.L1 * plant.second * np.abs(shoulder) + 1e-12).all()


def test_an_answer_whose_model_does_not_fit_it_fails_its_trial(tmp_path):
    named = {'causes': [{'in_model': True}], 'tolerated': []}
    with pytest.raises(RuntimeError, match='without'):
        _check_model(tmp_path, named)
    blind_trial.nominal_model().write(tmp_path)
    _check_model(tmp_path, named)
    with pytest.raises(RuntimeError, match='without'):
        _check_model(tmp_path, {'causes': [{'in_model': False}], 'tolerated': []})
    _check_model(tmp_path, {'causes': [], 'tolerated': [{'in_model': True}]})
    file = tmp_path / 'model.yaml'
    file.write_text(file.read_text().replace('term: coulomb', 'term: nothing', 1))
    with pytest.raises(RuntimeError, match='of no use'):
        _check_model(tmp_path, named)


def test_a_simulation_is_worse_only_beyond_what_chance_makes_of_so_many():
    """Of 100 ratios one is above 1 + 3.7 standard errors in 1 of 100 campaigns."""

    def met(ratio, error, others=99):
        gains = [
            {'cut': 9.0, 'gain': 2.0, 'true_gain': 2.0, 'forward': x, 'forward_error': e,
             'joints': [x], 'joint_errors': [e]}
            for x, e in [(ratio, error), *[(0.5, 0.01)] * others]
        ]  # fmt: skip
        rows = [row('single', 'right', k, snr=1.0, held_out=g) for k, g in enumerate(gains)]
        return next(bar.met for bar in bars(rows) if bar.name == 'forward')

    assert met(1.03, 0.01)
    assert not met(1.04, 0.01)
    # One alone may be 2.3 standard errors off.
    assert not met(1.03, 0.01, others=0)
    assert not met(np.inf, 0.0)


def test_shuffled_blocks_hold_the_same_residual_elsewhere():
    options = {'effect': 'viscous', 'joint': 0, 'scale': 1.5, 'duration': PIECE_S + 1.0}
    plain = build(Spec('x', 'null', 3, **options))
    shuffled = build(Spec('x', 'null', 3, **options, shuffled=True))
    assert shuffled.truths == ()
    change = np.abs(shuffled.log.tau - plain.log.tau).max(axis=0)
    assert change[0] > 0.1
    whole = round(4.0 / bp.PERIOD) * (len(plain.log.t_ns) // round(4.0 / bp.PERIOD))
    # Moving blocks changes no sum; what is taken off is one constant, here and in the last piece.
    moved = shuffled.log.tau - plain.log.tau
    np.testing.assert_allclose(
        moved[:whole].mean(axis=0), moved[whole:].mean(axis=0), rtol=1e-9, atol=1e-12
    )


def test_faults_of_the_data_are_as_large_as_they_say():
    for seed in range(1, 5):
        trial = build(Spec('x', 'fault', seed, 'dropped_samples', duration=PIECE_S))
        count = round(PIECE_S / bp.PERIOD)
        repeated = (np.diff(trial.log.tau, axis=0) == 0.0).all(axis=1) & (
            np.diff(trial.log.q, axis=0) == 0.0
        ).all(axis=1)
        share = 1.0 - len(trial.log) / count + repeated.mean()
        # Binomial of 12 000 samples, and a few repeats by chance.
        assert share == pytest.approx(trial.size, abs=6e-3)
    trial = build(Spec('x', 'fault', 1, 'velocity_lag', joint=0, duration=PIECE_S))
    slope = np.gradient(trial.log.q, bp.PERIOD, axis=0)
    lags = [
        np.argmax([np.dot(trial.log.v[k:, i], slope[: len(slope) - k, i]) for k in range(12)])
        for i in range(2)
    ]
    assert lags[0] * bp.PERIOD == pytest.approx(trial.size, abs=bp.PERIOD)
    assert lags[1] == 0


def test_a_small_snr_is_not_asked_of_an_effect_that_is_never_so_small():
    assert blind_trial.reaches('cogging', 1, 'middle')
    assert not blind_trial.reaches('load_dependent_friction', 0, 'middle')


def test_the_plan_has_what_the_issue_asks_for(monkeypatch):
    # Which effects can be small takes many simulations, and is another test's.
    monkeypatch.setattr(
        blind_plan, 'reaches', lambda effect, joint, level: level == 'high' or effect > 'p'
    )
    plan = make_plan(1, 60)
    kinds = Counter(spec.kind for spec in plan)
    assert kinds['null'] >= 40
    assert kinds['double'] >= 30
    assert kinds['outside'] >= 20
    singles = Counter(spec.effect for spec in plan if spec.kind == 'single')
    assert set(singles) == set(SINGLES)
    assert min(singles.values()) >= 3
    high = [spec for spec in plan if spec.kind == 'single' and spec.level == 'high']
    assert len(high) >= 60
    assert len({spec.name for spec in plan}) == len(plan)
    assert len({(spec.seed, spec.motion) for spec in plan}) == len(plan)
    pairs = [spec for spec in plan if spec.kind == 'excitation']
    assert pairs
    assert all(a.seed == b.seed for a, b in zip(pairs[::2], pairs[1::2], strict=True))
    assert {spec.motion for spec in plan if spec.kind == 'null'} >= {'rich', 'reversals', 'slow'}


def row(kind, outcome, number, **more):
    spec = Spec(f'{kind}-{number}', kind, number, 'coulomb')
    entry = {
        'spec': spec.to_dict(), 'kind': kind, 'outcome': outcome, 'verdict': 'named', 'causes': [],
        'truths': [{'effect': 'coulomb', 'joint': 'elbow', 'size': 1.0}], 'cpu_s': 9.0,
        'score': {'right': 1, 'wrong name': -1}.get(outcome, 0), 'spurious': 0,
    }  # fmt: skip
    return {**entry, **more}


def test_a_bar_is_met_by_enough_trials_only():
    rows = [row('single', 'right', k, snr=1.0) for k in range(93)]
    rows += [row('single', 'wrong name', 100 + k, snr=1.0) for k in range(7)]
    rows += [row('single', 'right', 200 + k, snr=0.5) for k in range(3)]
    found = {bar.name: bar for bar in bars(rows)}
    assert found['single right'].met
    assert found['single right'].n == 100
    assert not found['single wrong'].met
    assert found['small right'].met
    assert not found['twins'].met
    assert not found['every effect hidden'].met
    text = tables(rows, found.values(), 1, 60)
    assert '93 of 100' in text
    assert 'single-100' in text


def test_the_interval_of_a_share_is_that_of_clopper_and_pearson():
    # 0 of n has the upper limit 1 - (alpha / 2)^(1 / n).
    assert interval(0, 40) == pytest.approx((0.0, 1.0 - 0.025 ** (1.0 / 40.0)))
    assert interval(40, 40) == pytest.approx((0.025 ** (1.0 / 40.0), 1.0))


def test_a_campaign_goes_on_where_it_was_stopped(tmp_path):
    spec = Spec('single-1', 'single', 1, 'coulomb')
    (tmp_path / 'trials').mkdir()
    code = blind_campaign.code_hash()
    kept = {**row('single', 'right', 1), 'spec': spec.to_dict(), 'code': code}
    (tmp_path / 'trials/single-1.json').write_text(json.dumps(kept))
    said = []
    rows = blind_campaign.run_all([spec], tmp_path, 1, said.append)
    assert rows['single-1']['outcome'] == 'right'
    assert said == ['1 of 1 trials were run before']


def test_the_trial_to_mutate_is_the_clearest_that_was_right():
    rows = [row('single', 'right', k, snr=snr) for k, snr in enumerate((0.7, 3.0, 1.0))]
    specs, none = blind_campaign.mutants(rows)
    assert [spec.seed for spec in specs] == [1]
    assert specs[0].without == ('coulomb',)
    assert len(none) == len(blind_campaign.MUTANTS) - 1
    assert {entry['outcome'] for entry in none} == {'never right'}


def test_the_nominal_model_is_the_plant_without_its_effects():
    model = blind_trial.nominal_model()
    robot = model.make_robot()
    q = np.array([0.3, 0.7])
    torque = robot.inverse_dynamics(q, np.zeros(2), np.zeros(2))
    hang = bp.GRAVITY * bp.C2 * np.cos(q.sum())
    first = bp.GRAVITY * (bp.C1 + bp.M2 * bp.L1) * np.cos(q[0]) + hang
    assert torque == pytest.approx([first, hang], rel=1e-3)
