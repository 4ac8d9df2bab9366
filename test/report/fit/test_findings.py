# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is not known is said so, as a range, with the reason and the experiment."""

import dataclasses
import math
import re

import numpy as np
import pytest
from fitted_law import fit_law

from sosml_friction.bags.joint_log import JointLog
from sosml_friction.identification.identifiability import DataReach, reason_for
from sosml_friction.identification.law.law_checks import LawCheck
from sosml_friction.identification.law.law_fit import STRIBECK_AT_SLOWEST
from sosml_friction.identification.law.law_form import LawForm
from sosml_friction.model.parameter import NOT_IDENTIFIABLE, Parameter
from sosml_friction.report.fit.findings import (
    caveats,
    data_remarks,
    joint_sentence,
    law_remarks,
    law_sentence,
    notes,
    open_questions,
    sampling_text,
)
from sosml_friction.report.fit.joint_view import joint_views


@pytest.fixture(scope='module')
def view(analysis):
    return joint_views(analysis)[0]


def unknown(unit, interval=None):
    return Parameter(
        math.nan,
        unit,
        interval=interval,
        flags=(NOT_IDENTIFIABLE,),
        reason='the slowest speed is 9 times the Stribeck velocity',
        experiment='record T3, a slow ladder',
    )


def changed(view, observers=None, law='coulomb_viscous', derived=None, checks=(), **parameters):
    """Return the view with parameters of the fits of some observers replaced."""
    fits = {}
    for observer, fit in view.fits.items():
        fits[observer] = fit
        if observers is None or observer in observers:
            new = dataclasses.replace(
                fit.fit,
                law=law,
                parameters={**fit.fit.parameters, **parameters},
                derived=derived or {},
                checks=tuple(checks),
            )
            fits[observer] = dataclasses.replace(fit, fit=new)
    return dataclasses.replace(view, fits=fits)


@pytest.mark.parametrize(
    ('interval', 'words'),
    [
        ((0.0, 1.23), 'is not identifiable from this motion (0 to 1.23 Nm)'),
        ((0.5, math.inf), 'more near standstill, whose size this motion leaves open (above 0.50'),
        ((0.0, math.inf), 'is not identifiable from this motion, whose speeds begin at '),
        (None, 'is not identifiable from this motion, whose speeds begin at '),
    ],
)
def test_a_stribeck_term_that_is_open_is_a_range_in_the_sentence(view, interval, words):
    sentence = joint_sentence(
        changed(view, stribeck=unknown('Nm', interval), stribeck_velocity=unknown('rad/s'))
    )
    assert words in sentence
    assert not re.search(r'\bnan\b|\binf\b', sentence)


def test_any_parameter_that_is_open_is_a_range_in_the_sentence(view):
    parameters = dict(view.fits['sosml'].fit.parameters)
    for name, interval in (('coulomb', (0.1, 0.9)), ('viscous', None), ('bias', (-1.0, 2.0))):
        parameters[name] = unknown('Nm', interval)
    text = law_sentence('shoulder', parameters, 'stribeck')
    assert 'Coulomb friction that this motion leaves open (0.10 to 0.90 Nm)' in text
    assert 'viscous friction that this motion leaves open and' in text
    assert 'a bias that this motion leaves open (-1.00 to 2.00 Nm)' in text
    assert not re.search(r'\bnan\b|\binf\b', text)


def test_a_reason_and_its_experiment_are_said_once_for_all_they_hold_of(view):
    both = changed(view, stribeck=unknown('Nm', (0.0, 1.0)), stribeck_velocity=unknown('rad/s'))
    reason = 'the slowest speed is 9 times the Stribeck velocity; record T3, a slow ladder.'
    assert open_questions(both) == [f'S, v_s: {reason}']
    one = changed(view, ('first_order',), stribeck=unknown('Nm', (0.0, 1.0)))
    assert open_questions(one) == [f'S (FO): {reason}']
    assert open_questions(view) == []


def test_a_check_that_fails_is_noted_and_one_that_passes_is_not(view):
    failed = LawCheck('dissipation', False, 'The bias is larger than Coulomb friction.')
    passed = LawCheck('odd_even', True, 'Friction is the same in both directions.')
    told = notes([changed(view, law='stribeck', checks=(failed, passed))])
    assert [note for note in told if 'larger than Coulomb' in note] == [
        'shoulder (SOSML): The bias is larger than Coulomb friction.'
    ]
    assert not any('same in both directions' in note for note in told)


@pytest.mark.parametrize(('left', 'said'), [(49.0, False), (60.6, True)])
def test_a_law_that_leaves_more_than_half_is_told_with_what_is_next(view, left, said):
    fit = dataclasses.replace(changed(view).fits['sosml'].fit, relative_error=left)
    told = [remark for remark in law_remarks(fit) if 'sosml diagnose' in remark]
    assert bool(told) == said
    assert not said or 'leaves 61 % of the effort' in told[0]


def test_what_the_data_tell_instead_is_said_with_the_speed(view):
    derived = {STRIBECK_AT_SLOWEST: Parameter(0.049, 'Nm', math.nan, (0.047, 0.051))}
    fit = changed(view, derived=derived).fits['sosml'].fit
    (remark,) = law_remarks(dataclasses.replace(fit, slowest=0.0125))
    assert remark.endswith('0.0470 to 0.0510 Nm (w = 0.01250 rad/s).')
    open_ = {STRIBECK_AT_SLOWEST: unknown('Nm', (0.0, 0.3))}
    (remark,) = law_remarks(changed(view, derived=open_).fits['sosml'].fit)
    assert ': 0 to 0.300 Nm (w = ' in remark


def test_what_is_wrong_with_the_recording_and_a_joint_left_out_are_said(analysis):
    shoulder = analysis.model.joints['shoulder']
    model = dataclasses.replace(
        analysis.model,
        joints={**analysis.model.joints, 'shoulder': dataclasses.replace(shoulder, friction=None)},
    )
    (remark,) = data_remarks(dataclasses.replace(analysis, model=model))
    assert remark.startswith('shoulder: the model has no friction for it, because ')
    assert data_remarks(analysis) == []


def test_the_terminal_hears_of_failed_checks_directions_and_what_to_record(view):
    check = LawCheck('dissipation', False, 'The bias is larger than Coulomb friction.')
    passed = LawCheck('odd_even', True, 'Friction is the same in both directions.')
    forwards = Parameter(1.5, 'Nm s/rad', 0.1, (1.3, 1.7))
    shown = changed(
        view,
        derived={'viscous_positive': forwards},
        checks=(check, passed),
        stribeck=unknown('Nm', (0.0, 2.0)),
    )
    text = '\n'.join(caveats([shown]))
    assert check.sentence in text
    assert passed.sentence not in text
    assert 'Viscous friction forwards, B + its asymmetry: 1.50 ± 0.20 Nm s/rad.' in text
    assert 'record T3, a slow ladder' in text


def test_no_stribeck_term_is_claimed_where_no_data_reach():
    """Extra friction that fades below the slowest speed is not told, in headline or reason."""
    v = np.array([1.0, -1.0])[:, None] * np.geomspace(0.5, 8.0, 40)
    v = v.T.ravel()
    extra = 0.4 * np.sign(v) * np.exp(-np.abs(v) / 0.12)
    y = np.sign(v) + 0.1 * v + extra + np.random.default_rng(5).normal(0.0, 1e-3, len(v))
    fit = fit_law(v, y, np.arange(len(v)) // 4, 'Nm', form=LawForm(alpha=1.0))
    assert fit.parameters['stribeck'].interval == (0.0, math.inf)
    text = law_sentence('shoulder', fit.parameters, fit.law, fit.slowest)
    assert 'above' not in text
    assert 'is not identifiable from this motion, whose speeds begin at 0.5' in text
    (told,) = law_remarks(fit)
    assert re.search(r'at the slowest speed w of the data: 0\.0\d+ to 0\.\d+ Nm', told)
    reach = DataReach('Nm', 0.5, 10.0, 1.0, {'stribeck_velocity': 0.05})
    assert 'begin at 0.5 rad/s' in reason_for('stribeck', reach, (0.448, math.inf))


def test_stamps_of_a_robots_cycle_are_no_missing_samples():
    steps = np.random.default_rng(1).choice([0.010, 0.012], 3000, p=[2 / 3, 1 / 3])
    t_ns = np.rint(np.cumsum(steps) * 1e9).astype(np.int64)
    q = np.zeros((3000, 1))
    assert 'lost' not in sampling_text(JointLog(('a',), t_ns, q, q, q))
    kept = np.random.default_rng(2).random(3000) > 0.05
    few = q[kept]
    text = sampling_text(JointLog(('a',), t_ns[kept], few, few, few))
    assert 'more were lost' in text
    assert 'computer' not in text
