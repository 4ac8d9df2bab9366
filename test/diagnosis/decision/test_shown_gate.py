# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Which causes are taken back because they may be nothing beside the others."""

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from sosml_friction.diagnosis.decision import shown_gate as module
from sosml_friction.diagnosis.decision.cause import Cause
from sosml_friction.diagnosis.decision.selection import Selection
from sosml_friction.diagnosis.decision.verdict import not_shown
from sosml_friction.model.parameter import Parameter


@dataclass(frozen=True)
class Accepted:
    """A stand-in for a finding: its effect, its size, and another size beside other effects."""

    effect: str
    size: float
    tolerated: bool = False
    beside: dict[str, float] = field(default_factory=dict, hash=False)
    failed: tuple[str, ...] = ()

    def reported(self, names):
        return self.effect, names[0]


class Settler(SimpleNamespace):
    """A stand-in for a selector that counts how often it settled what is left."""

    times = 0

    def settled(self, selection):
        self.times += 1
        return selection


def causes_of(_, selection):
    """Return causes of standard error 1, each with the size that it has beside the others."""
    there = {finding.effect for finding in selection.accepted}
    return [
        Cause(
            each.effect,
            'elbow',
            {name: Parameter(size, 'Nm', 1.0, (size - 2, size + 2))},
            {},
            tolerated=each.tolerated,
        )
        for each in selection.accepted
        for name, size in [
            (
                'stribeck' if each.effect == 'stribeck' else 'bias',
                next((s for e, s in each.beside.items() if e in there), each.size),
            )
        ]
    ]


@pytest.mark.parametrize(
    ('accepted', 'kept'),
    [
        ([Accepted('stribeck', 1.0)], ['stribeck']),
        ([Accepted('effort_bias', 9.0), Accepted('stribeck', 1.0)], ['effort_bias']),
        ([Accepted('effort_bias', 1.0), Accepted('stribeck', 9.0)], ['stribeck']),
        ([Accepted('effort_bias', 1.0), Accepted('stribeck', 1.0)], ['effort_bias']),
        (
            [Accepted('effort_bias', 9.0, beside={'stribeck': 1.0}), Accepted('stribeck', 1.0)],
            ['effort_bias'],
        ),
        (
            [Accepted('effort_bias', 9.0, tolerated=True), Accepted('stribeck', 1.0)],
            ['effort_bias', 'stribeck'],
        ),
    ],
    ids=['alone', 'the last', 'the first', 'both', 'each stands for the other', 'tolerated'],
)
def test_what_may_be_nothing_beside_others_is_taken_back_the_last_first(
    monkeypatch, accepted, kept
):
    """The last of two that are hidden goes first; one alone stays, as something is there."""
    monkeypatch.setattr(module, 'model_causes', causes_of)
    laboratory = SimpleNamespace(robot=SimpleNamespace(names=('elbow',)))
    selector = Settler(laboratory=laboratory)
    selection = module.shown_gate(selector, Selection(None, None, tuple(accepted)))
    assert [finding.effect for finding in selection.accepted] == kept
    taken = len(accepted) - len(kept)
    assert selector.times == taken
    assert (selection.rejected is not None) == bool(taken)


@pytest.mark.parametrize(
    ('effect', 'interval', 'why'),
    [
        ('cogging', (0.0, np.inf), 'what is left beside it leaves its frequency open'),
        ('cogging', (8.0, 10.0), ''),
        ('cogging', None, ''),
        ('stribeck', (0.0, np.inf), ''),
    ],
)
def test_what_repeats_any_number_of_times_is_no_line(effect, interval, why):
    numbers = {
        'sine': Parameter(0.09, 'Nm', 0.01, (0.07, 0.11)),
        'frequency': Parameter(8.9, 'rad/rad', 0.5, interval),
    }
    assert not_shown(Cause(effect, 'tilt', numbers, {}, rivals=('spring',))) == why
