# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The reliability run: a short one has no failure, and what would be a failure is seen as one."""

import numpy as np
import pytest

from sosml_friction.bags.recorder import BagRecorder
from sosml_friction.exceptions import BagError
from validation import damaged_bags, random_frames, reliability
from validation.damaged_bags import BAG_DAMAGES, DamagedBags
from validation.kill_points import KillPoints
from validation.malformed_files import FILES, MalformedFiles
from validation.random_frames import RandomFrames
from validation.reliability import DRIVES, Tally, cases_of, outcome_of, table
from validation.silent import SilentError


@pytest.mark.parametrize('kind', [*BAG_DAMAGES, *FILES])
def test_nothing_is_lost_without_a_word_and_nothing_ends_in_a_traceback(kind, tmp_path):
    cases = (DamagedBags if kind in BAG_DAMAGES else MalformedFiles)(kind, tmp_path / 'here')
    count = 8 if kind in ('bombs', 'NPZ') else 40
    for case in range(count):
        outcome, said = outcome_of(cases, np.random.default_rng((7, case)))
        assert outcome in ('whole', 'told', 'refused'), f'case {case}: {said}'


@pytest.mark.parametrize('kind', DRIVES)
def test_a_drive_among_random_frames_and_a_killed_recording_keep_their_promises(kind, tmp_path):
    cases = cases_of(kind, tmp_path)
    outcomes = [outcome_of(cases, np.random.default_rng((7, k))) for k in range(2)]
    if kind == 'kill points':
        outcomes += [outcome_of(cases, np.random.default_rng((8, k))) for k in range(10)]
    assert {outcome for outcome, _ in outcomes} <= {'whole', 'told', 'refused'}, outcomes
    assert 'told' in {outcome for outcome, _ in outcomes}


def test_a_command_beyond_the_limit_is_seen(monkeypatch):
    monkeypatch.setattr(random_frames, '_ROUNDED', -6.0)
    outcome, said = outcome_of(RandomFrames(), np.random.default_rng(7))
    assert outcome == 'silent'
    assert 'A were commanded while enabled' in said


def test_a_recording_that_loses_what_was_flushed_is_seen(tmp_path, monkeypatch):
    monkeypatch.setattr(BagRecorder, 'flush', lambda _: None)
    outcomes = (
        outcome_of(KillPoints(tmp_path), np.random.default_rng((9, case)))[0] for case in range(30)
    )
    # A kill before anything was flushed shows nothing; on a busy machine many are.
    assert 'silent' in outcomes


def test_every_kind_of_damage_is_seen(tmp_path):
    """A reader that believed every file would be caught, by all but what leaves all messages."""
    for kind in BAG_DAMAGES:
        cases = DamagedBags(kind, tmp_path / 'here')
        outcomes = {outcome_of(cases, np.random.default_rng((7, case)))[0] for case in range(8)}
        assert outcomes & {'told', 'refused'}, kind


def test_a_reader_that_says_nothing_is_caught(tmp_path, monkeypatch):
    cases = DamagedBags('chunks dropped', tmp_path / 'here')
    read = damaged_bags.read
    monkeypatch.setattr(damaged_bags, 'read', lambda path: (read(path)[0], ''))
    outcomes = [outcome_of(cases, np.random.default_rng((7, k)))[0] for k in range(10)]
    assert 'silent' in outcomes


@pytest.mark.parametrize(
    ('error', 'outcome'),
    [
        (BagError('what, where'), 'refused'),
        (SilentError('less'), 'silent'),
        (KeyError('x'), 'traceback'),
        (RecursionError(), 'traceback'),
        (BagError(''), 'traceback'),
    ],
)
def test_what_came_of_a_case_is_told_by_what_it_raises(error, outcome):
    def case(_):
        raise error

    assert outcome_of(case, np.random.default_rng(0))[0] == outcome


def test_a_case_that_hangs_is_counted_and_the_rest_goes_on():
    class Pipe:
        answers = iter([(0, 'told', '', 100.0), None])

        def poll(self, _):
            return True

        def recv(self):
            return next(self.answers)

    tally = Tally()
    assert reliability._collect(tally, Pipe(), 0, 5, 1.0) == 2
    assert (tally.cases, tally.outcomes['told'], tally.failures) == (2, 1, 1)
    assert '| x | 2 | 0 | 1 | 0 | 0 | 0 | 1 | 100 MB |' in table({'x': tally})
