# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A number of the diagnosis is found, changed wherever it is used, and put back."""

import pytest

from sosml_friction.diagnosis.decision import selector
from sosml_friction.regression import chance, contacts
from sosml_friction.regression.settings import DiagnosisSettings
from validation.sensitivity import PLAN, changed, chosen_numbers, row_of, scaled


def the_number(name):
    """Return the chosen number of a name."""
    return next(number for number in chosen_numbers() if number.label.endswith('.' + name))


def test_numbers_that_were_chosen_are_found_and_settings_and_no_others():
    labels = {number.label for number in chosen_numbers()}
    assert 'diagnosis.decision.selector._REFINED' in labels
    # Its comment has two lines, and it stands with another.
    assert 'regression.inner_search._FINER' in labels
    assert 'regression.settings.floor' in labels
    # By measurement, by definition, and no threshold.
    assert not labels & {'regression.contacts._IMPACT', 'regression.contacts._MINORITY'}
    assert 'regression.settings.moving_only' not in labels


@pytest.mark.parametrize(
    ('value', 'twice'),
    [(0.25, 0.5), (3, 6), ((0.5, 2), (1.0, 4)), (True, None), ('text', None), ((), None)],
)
def test_a_number_is_scaled_and_what_is_none_is_not(value, twice):
    assert scaled(value, 2.0) == twice


def test_a_whole_number_stays_one_and_more_than_none():
    assert scaled(1, 0.5) == 1
    assert scaled(4, 0.5) == 2


def test_a_number_is_changed_where_it_stands_and_put_back():
    number = the_number('_REFINED')
    with changed(number, 0.5):
        assert vars(selector)['_REFINED'] == 0.5 * number.value
    assert vars(selector)['_REFINED'] == number.value


def test_a_number_that_others_import_is_changed_there_too():
    number = the_number('NEGLIGIBLE')
    with changed(number, 2.0):
        assert contacts.NEGLIGIBLE == chance.NEGLIGIBLE == 2.0 * number.value
    assert contacts.NEGLIGIBLE == chance.NEGLIGIBLE == number.value


def test_a_number_is_put_back_even_after_an_error():
    number, seen = the_number('_REFINED'), []

    def fail():
        with changed(number, 2.0):
            seen.append(vars(selector)['_REFINED'])
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert seen == [2.0 * number.value]
    assert vars(selector)['_REFINED'] == number.value


def test_a_setting_is_changed_in_the_settings_that_are_to_be_used():
    number = the_number('floor')
    with changed(number, 2.0) as settings:
        assert settings == DiagnosisSettings(floor=2.0 * number.value)
    with changed(the_number('_REFINED'), 2.0) as settings:
        assert settings == DiagnosisSettings()


def test_answers_that_differ_are_counted_and_those_that_are_good():
    """Silence is good where nothing is hidden, and nowhere else."""
    right = {'single': 'right', 'null': 'nothing', 'guess': 'size', 'outside': 'unknown'}
    base = [[right[kind], 'a verdict', []] for kind, _, _ in PLAN]
    silent = [['nothing', 'nothing_above_floor', []] for _ in PLAN]
    nulls = sum(kind == 'null' for kind, _, _ in PLAN)
    assert row_of('x', base, [base, silent]) == (
        f'| x | 0 ({len(PLAN)} good) | {len(PLAN)} ({nulls} good) |'
    )
