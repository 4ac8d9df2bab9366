# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What causes and what is left beside them amount to, and how it is said."""

from dataclasses import replace

import numpy as np
import pytest
from known_robots import slider_model, slider_recording

from sosml_friction.diagnosis.decision.cause import Cause
from sosml_friction.diagnosis.decision.leftover import Leftover
from sosml_friction.diagnosis.decision.remainder import Remainder
from sosml_friction.diagnosis.decision.selection import Selection
from sosml_friction.diagnosis.decision.verdict import verdict_of
from sosml_friction.diagnosis.diagnosis import diagnose
from sosml_friction.diagnosis.extended_model.gain import Gain
from sosml_friction.diagnosis.wording import describe, sentence_of
from sosml_friction.model.dahl import dahl_path
from sosml_friction.model.parameter import Parameter


@pytest.mark.parametrize(
    ('over', 'effect', 'verdict'),
    [
        (True, 'velocity_lag', 'unknown_structure'),
        (False, 'velocity_lag', 'named'),
        (True, 'dropped_samples', 'unknown_structure'),
        (True, 'external_contact', 'unknown_structure'),
        (False, 'external_contact', 'named'),
    ],
)
def test_what_the_data_show_by_themselves_does_not_hide_that_something_is_missing(
    over, effect, verdict
):
    """The diagnosis does not use a late velocity, bridges short holes, leaves contacts out."""
    left = Leftover('time', 0, 500.0 if over else 0.0, 100.0, 1.0, 0.0)
    selection = Selection(None, None, remainder=Remainder((left,), np.array([0.5])))
    parameters = {'lag_s': Parameter(0.01, 's'), 'lag_std_error_s': Parameter(1e-4, 's')}
    cause = Cause(effect, 'elbow', parameters, {})
    assert verdict_of([cause], selection) == verdict
    assert describe(cause) == f'elbow: {effect.replace("_", " ")} (lag 0.01 s)'
    sentence = sentence_of(verdict, [cause], unmoved(), selection, ('elbow',), ('Nm',))
    # A fault leaves no residual; a contact is told beside what is missing.
    told = verdict == 'named' or effect == 'external_contact'
    assert (effect.replace('_', ' ') in sentence) == told
    assert ('The refitted model explains the data' in sentence) != over


def test_contacts_are_told_in_plain_words():
    times = {'start_1': 89.693, 'end_1': 90.081, 'start_2': 100.0, 'end_2': 101.0}
    numbers = {name: Parameter(value, 's') for name, value in times.items()}

    def said(count, **more):
        episodes = {'episodes': Parameter(count, '1'), **numbers, **more}
        return describe(Cause('external_contact', 'elbow', episodes, {}))

    assert said(1.0) == 'elbow: external contact (1 episode: 89.69 to 90.08 s)'
    level = {'level': Parameter(18.24, 'N'), 'share_left_out': Parameter(0.314, '1')}
    assert said(2.0, **level) == (
        'elbow: external contact (2 episodes: 89.69 to 90.08 s, 100.00 to 101.00 s; '
        'level 18.24 N, 31 % left out)'
    )
    assert said(7.0).endswith('101.00 s, ...)')


def test_one_fault_of_several_joints_is_told_once():
    selection = Selection(None, None, remainder=Remainder((), np.zeros(2)))
    late = [
        Cause(
            'velocity_lag', joint, {'lag_s': Parameter(lag, 's'), 'scale': Parameter(1.0, '1')}, {}
        )
        for joint, lag in (('a', 0.0192), ('b', 0.0201))
    ]
    told = sentence_of('named', late, unmoved(), selection, ('a', 'b'), ('Nm', 'Nm'))
    assert told.startswith('Named, of the data: a, b: velocity lag (lag 0.0192 to 0.0201 s). ')


def test_a_set_is_led_by_what_is_shown_and_nothing_unfelt_is_told():
    def size(value, error):
        return Parameter.estimated(value, 'N', error, 1.96)

    def said(cause):
        selection = Selection(None, None, remainder=Remainder((), np.zeros(1)))
        return sentence_of('ambiguous', [cause], unmoved(), selection, ('x',), ('N',))

    numbers = {'stiffness': size(2.2, 2.6), 'offset': size(2.3, 0.97)}
    spring = Cause('spring', 'x', numbers, {}, rivals=('effort_bias',))
    assert ': x: effort bias, or spring (stiffness 2.2 ± 5.1 N' in said(spring)
    seen = replace(spring, parameters={**numbers, 'stiffness': size(20.0, 2.0)})
    assert ': x: spring (stiffness 20.0 ± 3.9 N, offset 2.3 ± 1.9 N), or effort bias.' in said(
        seen
    )
    waves = {'cosine': size(0.1, 0.2), 'sine': size(2.0, 0.2)}
    cogging = Cause('cogging', 'x', waves, {}, rivals=('spring',))
    assert ': x: cogging (' in said(cogging)
    # An axis about which the robot feels no tilt: rounding is no error.
    tilt = {'rotation_x': size(0.0, 1.6e-11), 'rotation_y': size(-0.18, 0.01)}
    assert describe(Cause('gravity_tilt', 'x', tilt, {})).count('rotation') == 1


def unmoved(position_after=1.0):
    """Return a gain of nothing but in the simulated position, known to a tenth."""
    one = np.ones(1)
    after, error = np.full(1, position_after), np.full(1, 0.1)
    return Gain(one, one, one, one, one, after, error, 0.3, 'folds left out')


def told(causes, gain):
    selection = Selection(None, None)
    return sentence_of('named', causes, gain, selection, ('elbow',), ('Nm',))


def cause_of(effect, in_model):
    return Cause(effect, 'elbow', {}, {}, terms=(({}, np.ones(1)),) if in_model else ())


def test_no_gain_is_told_of_a_model_that_no_cause_is_in():
    sentence = told([cause_of('backlash', False)], unmoved())
    assert 'effort error' not in sentence
    assert 'The model is not extended' in sentence
    assert 'The extended model has no' not in sentence


def test_a_cause_that_the_extended_model_lacks_is_said_beside_those_it_has():
    causes = [cause_of('coulomb', True), cause_of('backlash', False)]
    sentence = told([*causes, cause_of('velocity_lag', False)], unmoved())
    assert 'effort error' in sentence
    assert 'The extended model has no backlash (elbow).' in sentence
    assert 'The extended model has no' not in told(causes[:1], unmoved())


def test_a_simulated_position_that_changes_by_chance_is_called_that():
    """Of twice 0.1, the standard error of the ratio, 0.05 is chance and 0.5 is not."""
    causes = [cause_of('coulomb', True)]
    assert '1e+03 -> 950 mrad (chance)' in told(causes, unmoved(0.95))
    assert '1e+03 -> 500 mrad.' in told(causes, unmoved(0.5))


@pytest.mark.parametrize(
    ('interval', 'verdict'),
    [(None, 'named'), ((0.1, 0.4), 'named'), ((-0.1, 0.4), 'unknown_structure')],
)
def test_it_is_said_of_a_stribeck_term_that_it_may_be_nothing(interval, verdict):
    size = Parameter(0.2, 'Nm', 0.05, interval)
    numbers = {'stribeck_velocity': Parameter(0.3, 'rad/s'), 'exponent': Parameter(1.0, '1')}
    cause = Cause('stribeck', 'elbow', {'stribeck': size, **numbers}, {})
    selection = Selection(None, None)
    assert verdict_of([cause], selection) == verdict
    sentence = sentence_of(verdict, [cause], unmoved(), selection, ('elbow',), ('Nm',))
    said = 'elbow: stribeck may be nothing: of 1 candidates one has such a size by chance'
    assert (said in sentence) == (verdict != 'named')


@pytest.mark.parametrize(
    ('effect', 'sizes', 'verdict'),
    [
        ('effort_scale', {'error': (0.04, 0.029)}, 'unknown_structure'),
        ('effort_scale', {'error': (0.04, 0.010)}, 'named'),
        ('cogging', {'cosine': (0.1, 0.2), 'sine': (1.0, 0.2), 'frequency': (7.0, 0.1)}, 'named'),
        ('cogging', {'cosine': (0.1, 0.2), 'sine': (0.1, 0.2)}, 'unknown_structure'),
        ('cogging', {'cosine': (0.1, 0.2), 'cosine_2': (1.0, 0.2)}, 'named'),
        ('coulomb', {'change': (0.01, 0.02)}, 'unknown_structure'),
    ],
)
def test_no_cause_is_named_that_may_be_nothing_as_its_own_intervals_say(effect, sizes, verdict):
    parameters = {
        name: Parameter(value, '1', error, (value - 1.96 * error, value + 1.96 * error))
        for name, (value, error) in sizes.items()
    }
    selection = Selection(None, None, remainder=Remainder((), np.zeros(1)))
    cause = Cause(effect, 'elbow', parameters, {})
    assert verdict_of([cause], selection) == verdict
    rivalled = Cause(effect, 'elbow', parameters, {}, rivals=('inertia',))
    assert verdict_of([rivalled], selection) == 'ambiguous'


@pytest.mark.parametrize(
    ('errors', 'tried', 'verdict'),
    [
        (2.0, 1, 'named'),
        (2.0, 2, 'unknown_structure'),
        (3.2, 40, 'unknown_structure'),
        (3.3, 40, 'named'),
        (3.3, 140, 'unknown_structure'),
        (3.6, 140, 'named'),
    ],
)
def test_the_best_of_many_candidates_has_to_be_further_from_nothing(errors, tried, verdict):
    """Two-sided quantiles of 5 % / K: 1.96 of one candidate, 3.23 of 40, 3.57 of 140."""
    size = Parameter.estimated(0.1 * errors, 'Nm', 0.1, 1.96)
    selection = Selection(None, None, remainder=Remainder((), np.zeros(1)))
    cause = Cause('effort_bias', 'elbow', {'bias': size}, {}, tried=tried)
    assert verdict_of([cause], selection) == verdict


@pytest.mark.parametrize(
    ('errors', 'spread', 'most', 'verdict'),
    [
        # All of the error is a deviation within its tolerance, uniform: it ends at sqrt(3) of it.
        (1.7, 1.0, 3.0**0.5, 'unknown_structure'),
        (1.8, 1.0, 3.0**0.5, 'named'),
        # Half of the variance is noise: 3.23 sqrt(1/2) + sqrt(3/2) = 3.51 is beyond 3.23.
        (3.2, 0.5**0.5, 1.5**0.5, 'unknown_structure'),
        (3.3, 0.5**0.5, 1.5**0.5, 'named'),
        (3.2, 0.0, 0.0, 'unknown_structure'),
    ],
)
def test_a_deviation_within_its_tolerance_moves_a_size_no_further_than_to_its_bound(
    errors, spread, most, verdict
):
    size = Parameter.estimated(0.1 * errors, 'Nm', 0.1, 1.96)
    selection = Selection(None, None, remainder=Remainder((), np.zeros(1)))
    tolerance = {'bias': (spread, most)}
    cause = Cause('effort_bias', 'elbow', {'bias': size}, {}, tried=40, by_tolerance=tolerance)
    assert verdict_of([cause], selection) == verdict


@pytest.mark.parametrize(
    ('left', 'explains', 'noisy'),
    [
        ((4.0, 30.0), ': no cause', ''),
        ((60.0, 30.0), ' of knee: no cause', 'effort, 60 % of that of elbow:'),
        ((60.0, 70.0), '', 'effort, 60 % of that of elbow, 70 % of that of knee:'),
    ],
)
def test_of_effort_that_is_noise_for_the_larger_part_it_is_not_said_to_be_explained(
    left, explains, noisy
):
    names, one = ('elbow', 'knee'), np.ones(2)
    gain = Gain(one, one, one, np.array(left), one, one, 0.1 * one, 0.3, 'folds left out')
    selection = Selection(None, None, remainder=Remainder((), np.array([0.01, 0.02])))
    said = sentence_of('nothing_above_floor', [], gain, selection, names, ('Nm', 'Nm'))
    assert ('These data are too noisy to tell: no cause' in said) != bool(explains)
    assert (f'The refitted model explains the data{explains}' in said) == bool(explains)
    assert ('Noise is the larger part of effort' in said) == bool(noisy)
    assert noisy in said
    for name, share in zip(names, left, strict=True):
        assert (f'{share:.2f} % of effort that is left in {name}' in said) == (share <= 50.0)


def test_a_gear_that_gives_is_told_once():
    """Impacts show a gap that the regression has as a spring which may be a gap."""
    impacts = Cause('backlash', 'x', {}, {}, rivals=('joint_elasticity',))
    spring = Cause('joint_elasticity', 'x', {}, {}, rivals=('backlash',))
    assert spring.stands_for(impacts)
    assert replace(spring, effect='backlash', rivals=()).stands_for(impacts)
    assert not replace(spring, joint='y').stands_for(impacts)
    assert not replace(spring, rivals=()).stands_for(impacts)
    assert not spring.stands_for(replace(impacts, rivals=()))


def test_what_only_an_impossible_cause_explains_is_not_explained():
    """Friction turns around over 40 um; of a fifth over 0.5 mm no curve away from there tells."""

    def found(share):
        def sign(q, v):
            return (1.0 - share) * dahl_path(q, 4e-5) + share * dahl_path(q, 5e-4)

        return diagnose([slider_recording(sign=sign)], slider_model())

    missing = found(0.2)
    assert not missing.selection.remainder.beyond_chance
    assert missing.verdict == 'unknown_structure'
    assert 'It acts in slider beside reversals: only presliding hysteresis' in missing.sentence
    assert found(0.0).verdict == 'nothing_above_floor'


def test_friction_that_turns_around_ahead_of_motion_is_no_unknown_structure():
    """Half of it 80 ms ahead, as of a joint that sticks: a build-up of a negative level fits."""

    def sign(q, v):
        s = dahl_path(q, 4e-5)
        return 0.5 * (s + np.append(s[20:], np.full(20, s[-1])))

    found = diagnose([slider_recording(sign=sign)], slider_model())
    refused = found.selection.rejected
    assert refused.objection == 'the level of friction would be negative'
    assert refused.score.cv_gain > 0.2
    assert found.verdict == 'nothing_above_floor'


def test_a_tone_in_the_place_of_the_next_cause_is_not_explained_by_the_first():
    """A hum beside a delay that was named: the next candidate was no more than the hum."""
    found = diagnose([slider_recording(lambda v: 60.0 * v)], slider_model())
    assert found.verdict == 'named'
    (accepted,) = found.selection.accepted
    more = replace(accepted.score, gain=2.0 * accepted.score.gain)
    hum = replace(accepted, score=more, instead='a tone of 6.3 Hz', failed=('it explains more',))
    beside = replace(found.selection, rejected=hum)
    assert verdict_of(found.causes, beside) == 'unknown_structure'
    # A cogging of four waves beside which a fifth is a ripple of the constant is still named.
    little = replace(hum, score=replace(hum.score, gain=0.1 * hum.score.gain))
    assert verdict_of(found.causes, replace(beside, rejected=little)) == 'named'
