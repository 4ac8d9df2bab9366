# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""``sosml plan``: the ladder it proposes, and what cannot be reached."""

import pytest
from slider_bags import checked


def test_plan_prints_speeds_that_the_ladder_takes_and_what_they_give(sosml):
    """The command it prints runs, and lasts as long as it says."""
    wanted = ('--std-error', 'coulomb=0.003', '--std-error=stribeck=0.01')
    code, out, err = sosml('plan', *wanted, '--budget', '60', '--json')
    assert (code, err) == (0, '')
    document = checked(out, 'plan')
    assert document['reached']
    assert document['std_errors']['coulomb'] <= 0.003
    assert document['std_errors']['stribeck'] <= 0.01
    assert document['duration_s'] <= 60.0
    code, out, _ = sosml('plan', *wanted, '--budget', '60')
    assert code == 0
    command = out.splitlines()[-1].split()
    assert command[:2] == ['sosml', 'trajectory']
    code, out, _ = sosml(*command[1:], '--json')
    assert code == 0
    again = checked(out, 'trajectory')
    assert again['options']['speeds'] == document['speeds']
    assert again['duration_s'] == pytest.approx(document['duration_s'])


def test_plan_says_when_a_wanted_error_cannot_be_reached_and_what_can(sosml):
    impossible = ('plan', '--std-error', 'stribeck=0.0005', '--budget', '60')
    code, out, err = sosml(*impossible, '--json')
    assert (code, err) == (1, '')
    document = checked(out, 'plan')
    assert document['missed'] == ['stribeck']
    assert document['needed_s'] > 60.0
    code, out, _ = sosml(*impossible)
    assert code == 1
    assert 'Not all can be reached within 60 s: the best is 0.00' in out


@pytest.mark.parametrize(
    ('arguments', 'words'),
    [
        ([], 'no standard error is wanted'),
        (['--std-error', 'inertia=1'], 'write NAME=NUMBER with coulomb, '),
        (['--std-error', 'coulomb'], 'write NAME=NUMBER'),
        (['--std-error', 'coulomb=-1'], 'give a positive number'),
        (['--std-error', 'coulomb=1', '--budget', '5'], '5 s are too short'),
        (['--std-error', 'coulomb=1', '--budget', 'nan'], 'the budget is nan s'),
        (['--std-error', 'coulomb=1', '--noise', '0'], 'noise is 0.0'),
        (['--std-error', 'coulomb=1', '--plateau', '0.3'], 'a plateau of 0.3 s is too short'),
        (['--std-error', 'coulomb=1', '--slowest', '1'], 'the slowest speed is 1.0'),
        (['--std-error', 'coulomb=1', '--assume', 'stribeck=0'], 'the assumed stribeck is 0.0'),
    ],
)
def test_a_plan_that_cannot_be_is_refused(refused, arguments, words):
    assert words in refused('plan', *arguments)
