# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Several recordings together: the paper's rule, the joint fit, and in what they disagree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from full_runs import only_full

from sosml_friction.identification.friction_fit import FrictionFit, JointFit
from sosml_friction.identification.law.law_rows import LawRows
from sosml_friction.identification.law.law_stack import joined, row_noise, stack_rows
from sosml_friction.identification.several.bag_roles import BagRole
from sosml_friction.identification.several.consolidation import (
    BY_RULE,
    JOINT,
    MEAN,
    consolidate,
    paper_rule,
    weighted_mean,
)
from sosml_friction.model.parameter import NOT_IDENTIFIABLE, Parameter

TRUTH = {'coulomb': 0.8, 'viscous': 0.35, 'stribeck': 0.5, 'stribeck_velocity': 0.03}
SPEEDS = {
    'ladder': [0.05, 0.1, 0.2, 0.35, 0.5, 0.7],
    'reversals': [0.02, 0.04, 0.08],
    'slow': [0.01, 0.015, 0.02, 0.03, 0.05, 0.08],
}
ROLES = {
    name: BagRole(role, 'stated', '')
    for name, role in zip(SPEEDS, ('T1', 'T2', 'T3'), strict=True)
}
UNITS = {
    'coulomb': 'Nm', 'viscous': 'Nm s/rad', 'stribeck': 'Nm', 'stribeck_velocity': 'rad/s',
    'bias': 'Nm',
}  # fmt: skip


def rows(name, seed, noise=0.01, bias=0.0, coulomb=0.8, repeats=4):
    """Return a level of friction per plateau and direction, with independent noise."""
    rng = np.random.default_rng([seed, list(SPEEDS).index(name)])
    v = np.array([w * way for w in SPEEDS[name] for way in (1, -1)] * repeats)
    fade = TRUTH['stribeck'] * np.exp(-np.abs(v) / TRUTH['stribeck_velocity'])
    y = np.sign(v) * (coulomb + fade) + TRUTH['viscous'] * v + bias
    y += rng.normal(0.0, noise, v.shape)
    return LawRows(v, y, np.arange(len(v)), np.ones(len(v), dtype=bool), v, lambda column: column)


def together(parts, **options):
    """Consolidate bags of rows that have no fits of their own."""
    fits = {
        label: FrictionFit({}, {}, {'j': 'alone'}, {'j': {'o': r}}) for label, r in parts.items()
    }
    roles = {label: ROLES.get(label, BagRole('', 'motion', '')) for label in parts}
    return consolidate('j', 'o', 'Nm', fits, roles, **options)


def all_bags(seed, noise=None, **changes):
    noise = noise or {}
    return {
        name: rows(name, seed, noise.get(name, 0.01), **changes.get(name, {})) for name in SPEEDS
    }


def test_the_joint_fit_knows_what_no_bag_does_and_bags_that_agree_are_said_to():
    """12 seeds: the truth is in at least 8 of the 12 intervals of each parameter, 95 % ones."""
    inside = dict.fromkeys(TRUTH, 0)
    for seed in range(12):
        found = together(all_bags(seed))
        assert (found.preferred, found.agreement.disagreements) == (JOINT, ())
        assert 'agree' in found.reason
        assert found.unavailable == dict.fromkeys(SPEEDS, 'alone')
        for name, truth in TRUTH.items():
            low, high = found.parameters[name].interval
            inside[name] += low <= truth <= high
    assert min(inside.values()) >= 8, inside


def test_bags_in_other_postures_agree_within_what_the_bodies_may_be_off_by():
    """
    A weight that is off by one standard deviation is 0.1 Nm in one bag, and 0.05 Nm in the other.

    To each row alone that is ten times its noise; to the bias it is another in each bag.
    """
    shifts = {'ladder': 0.1, 'slow': 0.05}
    parts = {
        label: replace(rows(label, 0), unsure=np.full((len(rows(label, 0).v), 1), shift))
        for label, shift in shifts.items()
    }
    off = {label: replace(part, y=part.y + shifts[label]) for label, part in parts.items()}
    found = together(off)
    assert found.agreement.disagreements == ()
    low, high = found.parameters['bias'].interval
    assert low < 0.0 < high < 0.3
    known = together({label: replace(part, unsure=None) for label, part in off.items()})
    assert {entry.parameter for entry in known.agreement.disagreements} == {'bias'}


def test_what_refitted_bodies_leave_open_is_in_the_joint_fit_as_in_those_of_bags():
    """Rows at refitted bodies say nothing of it: a bias was 0.036 +- 0.001 Nm of none."""
    parts = all_bags(3, None, slow={'bias': 0.1})
    plain = together(parts)
    wide = together(parts, variance={'bias': 0.05**2, 'coulomb': 0.02**2})
    assert wide.joint_fit.parameters['coulomb'].std_error == pytest.approx(
        np.hypot(plain.joint_fit.parameters['coulomb'].std_error, 0.02)
    )
    for label, bias in wide.agreement.own['bias'].items():
        own = plain.agreement.own['bias'][label]
        assert bias.std_error == pytest.approx(np.hypot(own.std_error, 0.05))
    assert wide.agreement.disagreements == plain.agreement.disagreements
    assert np.ptp(wide.parameters['bias'].interval) > np.ptp(plain.parameters['bias'].interval)


def test_a_bag_counts_by_its_own_noise():
    """Weights are the inverse of each bag's noise, which its own rows tell to a fifth or so."""
    noise = {'ladder': 0.002, 'reversals': 0.05, 'slow': 0.01}
    found = together(all_bags(1, noise, **{}))
    for name, std in noise.items():
        assert found.noise[name] == pytest.approx(std, rel=0.35)
    same = together(all_bags(1, dict.fromkeys(SPEEDS, 0.05)))
    assert found.parameters['viscous'].std_error < 0.2 * same.parameters['viscous'].std_error


@pytest.mark.parametrize('bag', list(SPEEDS))
def test_ten_percent_more_coulomb_in_one_bag_is_told_as_that_and_nothing_else(bag):
    found = together(all_bags(2, None, **{bag: {'coulomb': 0.88}}))
    (only,) = found.agreement.disagreements
    assert (only.parameter, only.bag, only.unit) == ('coulomb', bag, 'Nm')
    assert only.difference == pytest.approx(0.08, abs=4.0 * only.std_error)
    assert only.sigmas > 4.0
    assert f'{bag} differs in coulomb: 0.0' in only.sentence
    assert found.agreement.p_value < 0.01
    assert only.sentence in found.reason


@pytest.mark.parametrize('bag', list(SPEEDS))
def test_coulomb_friction_that_differs_is_given_by_bag_and_never_excluded(bag):
    """The rest of the law is shared; the interval of what differs reaches over all bags."""
    found = together(all_bags(2, None, **{bag: {'coulomb': 0.88}}))
    assert (found.preferred, found.own) == (JOINT, ('coulomb',))
    truth = dict.fromkeys(SPEEDS, 0.8) | {bag: 0.88}
    for label, coulomb in truth.items():
        own = found.agreement.own['coulomb'][label]
        assert own.value == pytest.approx(coulomb, abs=4.0 * own.std_error)
    spread = found.parameters['coulomb']
    assert spread.interval[0] < 0.8 < 0.88 < spread.interval[1]
    # Two levels of three bags 0.08 apart have a standard deviation of 0.046.
    assert 0.03 < spread.std_error < 0.07
    assert 'differs between the bags' in spread.reason
    for name in ('viscous', 'stribeck', 'stribeck_velocity'):
        low, high = found.parameters[name].interval
        assert low < TRUTH[name] < high, name


@pytest.mark.parametrize('bag', list(SPEEDS))
def test_an_offset_in_one_bag_is_told_as_bias_and_the_law_is_what_it_was(bag):
    found = together(all_bags(3, None, **{bag: {'bias': 0.1}}))
    (only,) = found.agreement.disagreements
    assert (only.parameter, only.bag) == ('bias', bag)
    assert found.own_bias
    assert found.preferred == JOINT
    assert 'agree in friction and not in bias' in found.reason
    assert found.agreement.own['bias'][bag].value == pytest.approx(0.1, abs=0.02)
    low, high = found.parameters['bias'].interval
    assert low < 0.0 < 0.1 < high
    plain = together(all_bags(3), own_bias=True)
    for name in TRUTH:
        assert found.parameters[name].value == pytest.approx(
            plain.parameters[name].value, rel=1e-6
        )


def of_knee(seed, stribeck=0.5, stribeck_velocity=0.03, coulomb=0.8):
    """Return the levels of all speeds, the width of the sign to be found, and their own fit."""
    rng = np.random.default_rng([9, seed])
    v = np.array([w * way for w in (*SPEEDS['slow'], *SPEEDS['ladder']) for way in (1, -1)] * 4)
    y = np.sign(v) * (coulomb + stribeck * np.exp(-np.abs(v) / stribeck_velocity))
    y += TRUTH['viscous'] * v + rng.normal(0.0, 0.01, v.shape)
    part = LawRows(v, y, np.arange(len(v)), np.ones(len(v), dtype=bool), v, lambda x: x,
                   find_smoothing=True)  # fmt: skip
    own = JointFit('o', 'segments', 'Nm', part.fit('Nm'), (), np.empty(0))
    return FrictionFit({'j': {'o': own}}, {}, {}, {'j': {'o': part}})


@pytest.mark.parametrize(
    'changes',
    [
        [{'stribeck': S} for S in (0.3, 0.5, 0.7)],
        [{'stribeck_velocity': v_s} for v_s in (0.02, 0.08, 0.02)],
        [{'stribeck': 0.3}, {'stribeck_velocity': 0.06}, {}],
        [{'stribeck': S, 'coulomb': C} for S, C in ((0.3, 0.7), (0.5, 0.8), (0.7, 0.9))],
    ],
)
def test_knees_that_differ_are_told_as_that_and_the_mean_is_one_of_the_bags(changes):
    """One S for all made differences of v_s, C and B, and a value that no mean is."""
    fits = {f'bag{k}': of_knee(k, **change) for k, change in enumerate(changes)}
    none = {label: BagRole('', 'motion', '') for label in fits}
    found = consolidate('j', 'o', 'Nm', fits, none)
    assert found.preferred == MEAN
    assert set(found.agreement.differing) == {name for change in changes for name in change}
    base = {name: TRUTH[name] for name in ('coulomb', 'viscous', 'stribeck', 'stribeck_velocity')}
    for name, own in base.items():
        truths = [change.get(name, own) for change in changes]
        parameter = found.parameters[name]
        low, high = parameter.interval
        assert low < min(truths) <= max(truths) < high, name
        assert parameter.value == pytest.approx(np.mean(truths), abs=0.3 * np.ptp(truths) + 0.02)
        assert bool(parameter.reason) == (len(set(truths)) > 1), name


def test_a_bag_that_knows_of_no_exponent_takes_part():
    """It was asked for a curve of the exponent NaN, and the joint fit ended in a LinAlgError."""
    fits = {f'bag{k}': of_knee(k) for k in range(2)}
    joint = fits['bag1'].joints['j']['o']
    unknown = Parameter(float('nan'), '1', flags=(NOT_IDENTIFIABLE,))
    own = replace(joint.fit, parameters={**joint.fit.parameters, 'exponent': unknown})
    fits['bag1'] = replace(fits['bag1'], joints={'j': {'o': replace(joint, fit=own)}})
    found = consolidate('j', 'o', 'Nm', fits, dict.fromkeys(fits, BagRole('', 'motion', '')))
    assert (found.preferred, found.agreement.disagreements) == (JOINT, ())


@only_full
def test_bags_that_agree_are_seldom_said_to_differ():
    """1 % of false alarms are allowed for: 3 or more of 30 have a chance of less than 1 %."""
    alarms = sum(
        bool(together(all_bags(100 + seed)).agreement.disagreements) for seed in range(30)
    )
    assert alarms <= 2


def test_of_two_bags_the_difference_is_told_of_the_second():
    parts = {name: rows(name, 4) for name in ('ladder', 'slow')}
    parts['slow'] = rows('slow', 4, bias=0.1)
    (only,) = together(parts).agreement.disagreements
    assert (only.parameter, only.bag) == ('bias', 'slow')
    assert only.sentence.startswith('slow differs in bias: 0.099 Nm more than ladder says')


def test_own_biases_are_those_of_a_regression_with_one_for_each_bag():
    parts = [rows(name, 5, bias=0.05 * k) for k, name in enumerate(SPEEDS)]
    weights = [1.0, 0.5, 2.0]
    stack = stack_rows(parts, weights)
    projected = stack.own(('bias',)).rows
    v = projected.v
    shapes = [np.sign(v), v, np.sign(v) * np.exp(-np.abs(v) / 0.03)]
    X = np.column_stack([projected.lag(shape) for shape in [*shapes, np.ones_like(v)]])
    found = np.linalg.lstsq(X, projected.y, rcond=None)[0]
    w = np.repeat(weights, [len(part.y) for part in parts])
    each = [w * (stack.bag == b) for b in range(3)]
    plain = np.column_stack([*(w * shape for shape in shapes), *each])
    expected = np.linalg.lstsq(plain, stack.rows.y, rcond=None)[0]
    np.testing.assert_allclose(found[:3], expected[:3], rtol=1e-9)
    counts = [w_b**2 * len(part.y) for w_b, part in zip(weights, parts, strict=True)]
    assert found[3] == pytest.approx(np.average(expected[3:], weights=counts), rel=1e-9)


def test_rows_that_share_their_noise_are_joined_and_the_others_left():
    """A hundred rows of one noise each are worth a row: the mean of them has its noise."""
    rng = np.random.default_rng(6)
    part = rows('ladder', 6, 0.01, repeats=40)
    assert joined(part, row_noise(part)) is part
    v = np.repeat(part.v, 50)
    shared = np.repeat(rng.normal(0.0, 0.01, len(part.v)), 50)
    y = np.sign(v) * 0.8 + 0.35 * v + shared + rng.normal(0.0, 0.001, len(v))
    groups = np.repeat(np.arange(len(part.v)), 50)
    fine = LawRows(v, y, groups, np.ones(len(v), dtype=bool), v, lambda column: column)
    noise = row_noise(fine)
    assert noise.shared == pytest.approx(50.0, rel=0.3)
    means = joined(fine, noise)
    assert len(means.y) == pytest.approx(len(v) / noise.shared, rel=0.2)
    assert row_noise(means).effective == pytest.approx(0.01, rel=0.3)
    np.testing.assert_allclose(means.lag(v), means.mean_v)


def own_fit(**values):
    """Return a fit whose parameters are (value, standard error), or None: not identifiable."""
    from sosml_friction.identification.law.law_fit import LawFit

    parameters = {
        name: Parameter(np.nan, UNITS[name], interval=(0.1, 2.0), flags=(NOT_IDENTIFIABLE,),
                        reason='too fast')
        if entry is None
        else Parameter(entry[0], UNITS[name], entry[1], (entry[0] - 2.1 * entry[1],
                                                         entry[0] + 2.1 * entry[1]))
        for name, entry in values.items()
    }  # fmt: skip
    law = LawFit('stribeck', parameters, 0.01, 1.0, 20, 20)
    return JointFit('o', 'segments', 'Nm', law, (), np.empty(0))


def test_the_rule_takes_each_parameter_from_its_bags():
    fits = {
        'ladder': own_fit(coulomb=(0.80, 0.01), viscous=(0.35, 0.01), stribeck=(0.4, 0.1),
                          stribeck_velocity=(0.04, 0.01), bias=(0.3, 0.01)),
        'reversals': own_fit(coulomb=(0.5, 0.01), viscous=(3.0, 0.01), stribeck=(0.5, 0.02),
                             stribeck_velocity=(0.03, 0.001), bias=(0.2, 0.01)),
        'slow': own_fit(coulomb=(0.81, 0.02), viscous=None, stribeck=(0.6, 0.1),
                        stribeck_velocity=(0.02, 0.01), bias=(0.1, 0.01)),
    }  # fmt: skip
    rule = paper_rule(fits, ROLES, 'Nm')
    assert rule.sources == {
        'coulomb': ('ladder', 'slow'),
        'viscous': ('ladder',),
        'stribeck': ('reversals',),
        'stribeck_velocity': ('reversals',),
        'bias': ('slow',),
    }
    assert (rule.missing, rule.reason) == ((), '')
    assert rule.parameters['coulomb'].value == pytest.approx(0.802)
    assert rule.parameters['coulomb'].std_error == pytest.approx(1.0 / np.hypot(100.0, 50.0))
    assert rule.parameters['bias'].value == 0.1
    roles = {**ROLES, 'reversals': BagRole('', 'motion', '')}
    without = paper_rule(fits, roles, 'Nm')
    assert without.missing == ('T2',)
    assert NOT_IDENTIFIABLE in without.parameters['stribeck'].flags
    assert without.reason == (
        'no bag is T2 (symmetric_reversals), from which the rule takes stribeck, stribeck '
        'velocity: record it, or say which bag it is with --role'
    )


def test_what_a_bag_of_the_role_cannot_tell_stays_a_range_with_its_reason():
    fits = {'reversals': own_fit(coulomb=(0.8, 0.01), viscous=(0.3, 0.1), stribeck=None,
                                 stribeck_velocity=None, bias=(0.0, 0.01))}  # fmt: skip
    rule = paper_rule(fits, ROLES, 'Nm')
    assert rule.parameters['stribeck'].interval == (0.1, 2.0)
    assert rule.parameters['stribeck'].reason == 'too fast'
    assert np.isnan(rule.parameters['coulomb'].value)


def test_estimates_that_scatter_more_than_their_errors_have_a_mean_that_is_less_sure():
    near = [Parameter(x, 'Nm', 0.01, (x - 0.02, x + 0.02)) for x in (0.79, 0.81)]
    far = [Parameter(x, 'Nm', 0.01, (x - 0.02, x + 0.02)) for x in (0.7, 0.9)]
    assert weighted_mean(near).std_error == pytest.approx(0.01)
    assert weighted_mean(far).std_error == pytest.approx(0.1)
    low, high = weighted_mean(far).interval
    assert (low, high) == pytest.approx((0.6, 1.0))
    assert weighted_mean(near[:1]) is near[0]


def test_without_a_joint_fit_the_rule_stands_alone_and_without_both_there_is_a_sentence():
    one_way = rows('ladder', 7)
    one_way = LawRows(np.abs(one_way.v), one_way.y, one_way.clusters, one_way.keep,
                      np.abs(one_way.v), lambda column: column)  # fmt: skip
    found = together({'ladder': one_way})
    assert found.joint_fit is None
    assert found.preferred == ''
    assert found.parameters == {}
    assert 'one direction only' in found.reason
    assert 'no bag is T2' in found.reason
    fit = own_fit(coulomb=(0.8, 0.01), viscous=(0.35, 0.01), stribeck=None,
                  stribeck_velocity=None, bias=(0.0, 0.01))  # fmt: skip
    recordings = {'ladder': FrictionFit({'j': {'o': fit}}, {}, {}, {'j': {'o': one_way}})}
    by_rule = consolidate('j', 'o', 'Nm', recordings, ROLES)
    assert by_rule.preferred == BY_RULE
    assert by_rule.law == 'coulomb_viscous'
    assert 'No law can be fitted to all bags at once' in by_rule.reason


def test_the_entry_is_plain():
    import json

    from sosml_friction.report.common.output import to_json

    found = together(all_bags(8, None, slow={'bias': 0.1}))
    entry = json.loads(to_json(found.to_dict()), parse_constant=pytest.fail)
    assert entry['preferred'] == 'joint'
    assert entry['disagreements'][0]['bag'] == 'slow'
    assert set(entry['parameters']) == set(UNITS)
