# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
What is recommended separates what it is said to separate, by as much as is said.

The effort of an arm that follows its reference exactly is written down in closed form, with an
effect in it. A first recording gives the prediction; then the recommended one is made too, and
the evidence of both together is what the prediction has to be within a factor of 2 of. Two pairs
here; all of them, and other seeds, with SOSML_FRICTION_SEEDS (how many).
"""

from __future__ import annotations

import dataclasses
import os
from types import SimpleNamespace

import numpy as np
import pytest
from known_robots import arm_model

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.compiled import compiled
from sosml_friction.diagnosis.decision.scorer import Scorer
from sosml_friction.diagnosis.decision.selection import Selection
from sosml_friction.diagnosis.library import make_library
from sosml_friction.diagnosis.next_experiment.conditions import WARM_S, conditions
from sosml_friction.diagnosis.next_experiment.experiment import (
    NEEDED,
    _menu,
    recommend,
    supposed,
    weigh,
)
from sosml_friction.diagnosis.next_experiment.pair_conditions import pair_condition
from sosml_friction.diagnosis.next_experiment.recommendation import Recommendation
from sosml_friction.diagnosis.next_experiment.separation import separation
from sosml_friction.motion.building_blocks import begin_motion
from sosml_friction.motion.trajectory_kinds.multisine import MultisineSettings, add_multisine
from sosml_friction.motion.trajectory_kinds.speed_ladder import speed_ladder
from sosml_friction.regression.evidence import Fit
from sosml_friction.regression.settings import DiagnosisSettings
from sosml_friction.regression.signals import prepare
from sosml_friction.regression.whitened import WhitenedRegression

SEEDS = int(os.environ.get('SOSML_FRICTION_SEEDS') or 0)
STEP = 4e-3
JOINTS = ('shoulder', 'elbow')
NOISE = np.array([0.2, 0.06])
SETTINGS = DiagnosisSettings(band=15.0)
#: Cause, size, rival, joint, recording, what is recorded besides.
PAIRS = (
    ('effort_bias', 0.25, 'asymmetric_friction', 0, 'multisine', 'free_hanging_hold'),
    ('load_dependent_friction', 0.015, 'position_dependent_friction', 0, 'multisine',
     'known_payload'),
    ('stribeck', 0.06, 'presliding_hysteresis', 0, 'multisine', 'slow_ladder'),
    ('load_dependent_friction', 0.012, 'coulomb', 0, 'multisine', 'known_payload'),
    ('coulomb', 0.08, 'stribeck', 0, 'multisine', 'slow_ladder'),
    ('viscous', 0.08, 'thermal_drift', 0, 'long', 'warm_up_repeat'),
    ('gravity', 0.08, 'spring', 0, 'ladder', 'not_worn'),
    ('spring', 0.25, 'gravity', 0, 'multisine', 'not_worn'),
    ('effort_scale', 0.05, 'gravity', 0, 'multisine', 'known_payload'),
    ('inertia', 0.004, 'payload', 1, 'multisine', 'rich'),
)  # fmt: skip
IN_SUITE = 2
#: Coulomb [Nm] and viscous [Nm s/rad] friction.
ARM = {'shoulder': (0.8, 0.35), 'elbow': (0.15, 0.06)}


def motion(name):
    """Return position, velocity and acceleration (N, 2) of a recording."""
    start = dict(zip(JOINTS, (-0.9, 0.9), strict=True))
    if name == 'ladder':
        plan = speed_ladder(start, start, (0.05, 0.1, 0.2, 0.4), plateau_s=1.2, ramp_s=0.3)
    else:
        sines = MultisineSettings(
            amplitude=0.5, peak_speed=1.5, peak_acceleration=8.0, period_s=20.0,
            periods=6 if name == 'long' else 3,
        )  # fmt: skip
        built, _, factor = begin_motion('multisine', start, start, (1.0,))
        plan = add_multisine(built, sines, factor).build()
    return along(plan)


def along(plan):
    t = np.arange(0.0, plan.duration, STEP)
    spline = plan.spline()
    return spline(t), spline(t, 1), spline(t, 2)


@compiled
def slip(q):
    """Return the sign of motion (N, 2) of three springs in parallel that slip in turn."""
    result = np.zeros(q.shape)
    for i in range(q.shape[1]):
        for width in (2e-4, 4e-4, 8e-4):
            z = 0.0
            for k in range(1, len(q)):
                z = min(max(z + q[k, i] - q[k - 1, i], -width), width)
                result[k, i] += z / (3.0 * width)
    return result


def recorded(q, v, a, effect, i, size, rng, *, begin=0.0, payload=None, worn=True):
    """Return the recording of an exact motion with an effect of this size in joint i."""
    robot = arm_model(**ARM).make_robot()
    pi = robot.inertial_parameters()
    if effect == 'gravity':
        pi[i, 1] += size
    if payload is not None:
        pi[-1] += payload
    armature = np.array(robot.armature)
    if effect == 'inertia':
        armature[i] += size
    regressor = np.array([robot.torque_regressor(*x) for x in zip(q, v, a, strict=True)])
    load = regressor @ pi.ravel() + armature * a
    coulomb = np.tile([0.8, 0.15], (len(q), 1))
    viscous = np.tile([0.35, 0.06], (len(q), 1))
    sign, t = slip(q), begin + STEP * np.arange(len(q))
    if effect == 'coulomb':
        coulomb[:, i] += size
    elif effect == 'viscous':
        viscous[:, i] += size
    elif effect == 'stribeck':
        coulomb[:, i] += size * np.exp(-np.abs(v[:, i]) / 0.15)
    elif effect == 'load_dependent_friction':
        coulomb[:, i] += size * np.abs(load[:, i])
    elif effect == 'thermal_drift':
        viscous[:, i] *= 1.0 - size * (1.0 - np.exp(-t / 60.0))
    tau = load + coulomb * sign + viscous * v
    if effect == 'spring' and worn:
        tau[:, i] += size * (q[:, i] + 0.4)
    if effect == 'effort_scale':
        tau[:, i] *= 1.0 + size
    if effect == 'effort_bias':
        tau[:, i] += size
    t_ns = np.rint((t - begin) * 1e9).astype(np.int64)
    tau = tau + NOISE * rng.standard_normal(tau.shape)
    # At rest an encoder stays on one count.
    noise = 1e-5 * rng.standard_normal(q.shape) * bool(v.any())
    measured = np.round((q + noise) / 1e-5) * 1e-5
    return JointLog(JOINTS, t_ns, measured, np.full_like(q, np.nan), tau)


def found(laboratory, *keys):
    """Return the refined findings of effects in joints."""
    scorer = Scorer(laboratory)
    fit = Fit.make(laboratory.system, laboratory.y)
    ranked = scorer.ranked(fit, laboratory.columns)
    return [
        scorer.refine(
            fit,
            next(f for f in ranked if f.effect.identifier == name
                 and (f.joint == i or f.effect.of_robot)),
        )
        for name, i in keys
    ]  # fmt: skip


def of_gravity_everywhere(monkeypatch):
    """Take the same components of first moments in all stretches: the arm moves in a plane."""
    from sosml_friction.model.terms import gravity

    monkeypatch.setattr(gravity, 'first_moments', lambda *_: [0, 2], raising=True)


def margins(case, seed):
    """Return predicted and realised margin of a pair with the first, and with both recordings."""
    effect, size, rival, i, name, besides = case
    rng = np.random.default_rng([seed, 20261122])
    model = arm_model(**ARM)
    robot = model.make_robot()
    q, v, a = motion(name)
    log = recorded(q, v, a, effect, i, size, rng)
    signals = prepare([log], model, robot, SETTINGS)
    # Without the widest grid: it takes no part here, and most of the time.
    library = make_library(('cogging',))
    laboratory = WhitenedRegression.make(signals, library, SETTINGS)
    one, other = found(laboratory, (effect, i), (rival, i))
    cause, against = supposed(laboratory, one), supposed(laboratory, other)
    here = separation(laboratory, cause, against, ())[1]
    options = {o.name: o for o in weigh(laboratory, cause, against)}
    again = {}
    begin, drop = 0.0, frozenset()
    if besides == 'known_payload':
        stretch = conditions(tuple(signals))['known_payload'].stretches[0]
        added = stretch.signals.rigid - signals[0].rigid
        # The point mass that makes this torque along the motion.
        body = robot.inertial_parameters()[-1]
        r = 1.5 * body[1:4] / body[0]
        tensor = float(r @ r) * np.eye(3) - np.outer(r, r)
        unit = np.concatenate([[1.0], r, tensor[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]])
        torque = signals[0].regressor[:, :, -10:] @ unit
        mass = float(np.sum(torque * added) / np.sum(torque**2))
        assert added == pytest.approx(mass * torque, abs=1e-9)
        again['payload'] = mass * unit
    elif besides == 'warm_up_repeat':
        begin = WARM_S
    elif besides == 'not_worn':
        again['worn'] = False
        drop = frozenset({'spring'})
    elif besides == 'free_hanging_hold':
        q = np.tile([[-np.pi / 2.0, 0.0]], (5000, 1))
        v, a = np.zeros_like(q), np.zeros_like(q)
    else:
        q, v, a = along(_menu(signals[0])[besides]())
    second = recorded(q, v, a, effect, i, size, rng, begin=begin, **again)
    more = prepare([second], model, robot, SETTINGS, signals[0].scales)
    more = [dataclasses.replace(s, time=s.time + begin, cache={}) for s in more]
    if 'payload' in again:
        more = [
            dataclasses.replace(s, rigid=s.rigid + s.regressor[:, :, -10:] @ again['payload'])
            for s in more
        ]
    if drop:
        acts = library['spring'].columns
        off = {id(s.q) for s in more}
        library['spring'].columns = lambda s, j, x: acts(s, j, x) * (id(s.q) not in off)
    both = WhitenedRegression.make([*signals, *more], library, SETTINGS)
    after = found(both, (effect, i), (rival, i))
    return (
        (here, 0.5 * (one.score.gain - other.score.gain)),
        (options[besides].margin, 0.5 * (after[0].score.gain - after[1].score.gain)),
    )


def test_a_recommendation_says_the_pair_the_margin_and_what_to_do():
    said = Recommendation(
        ('effort_bias', 'asymmetric_friction'), 'elbow', 0.97, 1.3, NEEDED, None, 20.0, 0.34, 48.0,
        pair_condition('effort_bias', 'asymmetric_friction').instruction,
    )  # fmt: skip
    assert said.sentence == (
        'effort bias and asymmetric friction (elbow) are 97.0 % the same in these data (margin '
        '1.3, needed 10), and no trajectory separates them: hold the joint where gravity asks '
        'nothing of it, free of load and at rest, motors off: a bias of effort stays, friction '
        'that differs between the directions does not (20 s; predicted 34.0 % the same with both '
        'recordings, margin 48)'
    )
    run = dataclasses.replace(said, trajectory='slow_ladder', condition='')
    assert run.sentence.endswith(
        'needed 10): run slow_ladder (20 s; predicted 34.0 % the same with both recordings, '
        'margin 48)'
    )
    nothing = dataclasses.replace(said, condition='', predicted_margin=np.nan)
    assert 'change the load or the posture' in nothing.sentence


def test_impacts_that_a_gap_or_a_spring_make_are_told_apart_at_the_link():
    """They are named without a finding of the selection; nothing is recommended without them."""
    robot = SimpleNamespace(names=('shoulder', 'elbow'))
    selection = Selection(None, None)
    for impacts in ((), (SimpleNamespace(joint=1),)):
        laboratory = SimpleNamespace(robot=robot, contacts=SimpleNamespace(impacts=impacts))
        said = recommend(laboratory, selection, ())
        if not impacts:
            assert said is None
    assert said.pair == ('backlash', 'joint_elasticity')
    assert said.joint == 'elbow'
    assert 'lock the motor' in said.sentence


def test_a_joint_whose_effort_is_not_known_takes_no_part_in_what_is_predicted():
    """Its noise is not known: whatever stands for it changes no margin."""
    rng = np.random.default_rng(20261129)
    q, v, a = motion('multisine')
    for x, still in ((q, q[0, 1]), (v, 0.0), (a, 0.0)):
        x[:, 1] = still
    log = recorded(q, v, a, 'effort_bias', 0, 0.25, rng)
    effort = log.tau.copy()
    effort[:, 1] = np.nan
    model = arm_model(**ARM)
    log = dataclasses.replace(log, tau=effort)
    signals = prepare([log], model, model.make_robot(), SETTINGS)
    laboratory = WhitenedRegression.make(signals, make_library(('cogging',)), SETTINGS)
    assert laboratory.nominal.silent == {1}
    one, other = found(laboratory, ('effort_bias', 0), ('asymmetric_friction', 0))
    cause, against = supposed(laboratory, one), supposed(laboratory, other)
    first, second = laboratory.noise
    whitening = dataclasses.replace(
        laboratory.whitening,
        noise=(first, dataclasses.replace(second, sigma=second.sigma / 1000.0)),
    )
    quieter = dataclasses.replace(laboratory, whitening=whitening)
    said, same = (
        {o.name: o.margin for o in weigh(each, cause, against)} for each in (laboratory, quieter)
    )
    assert 0.0 < max(said.values()) < 1e6
    assert same == said


@pytest.mark.parametrize('case', PAIRS[:IN_SUITE], ids=lambda case: f'{case[0]}-{case[2]}')
def test_the_predicted_margin_is_within_a_factor_of_two_of_the_realised_one(case, monkeypatch):
    of_gravity_everywhere(monkeypatch)
    predicted, realised = margins(case, 0)[1]
    assert 0.5 < predicted / realised < 2.0


@pytest.mark.skipif(not SEEDS, reason='set SOSML_FRICTION_SEEDS')
def test_ten_pairs_are_predicted_within_a_factor_of_two(monkeypatch):
    of_gravity_everywhere(monkeypatch)
    within = 0
    for case in PAIRS:
        for seed in range(SEEDS):
            (here, first), (predicted, realised) = margins(case, seed)
            print(
                f'{case[0]} / {case[2]} ({JOINTS[case[3]]}), {case[4]} + {case[5]}: margin '
                f'{here:.1f} predicted, {first:.1f} realised; with both {predicted:.1f}, '
                f'{realised:.1f}'
            )
            within += 0.5 < predicted / max(realised, 1e-9) < 2.0
    assert within >= 0.9 * len(PAIRS) * SEEDS
