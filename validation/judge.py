# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Score an answer: +1 right effect and joint, 0 a set with the truth or no name, -1 wrong.

The first cause of the answer is scored. Further causes that are not true are spurious and counted
separately. Backlash and elasticity are one class: their pair is right. The verdict
``unknown_structure`` names nothing. If nothing is hidden, any name is a false alarm. If the effect
is outside of the library, a single name without rivals is wrong.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from validation.effects import TRANSMISSION
from validation.trial import Truth

#: What the answer to a twin has to hold.
TWIN_SETS: dict[str, frozenset[str]] = {
    'effort_bias': frozenset({'effort_bias', 'asymmetric_friction'}),
    'asymmetric_level': frozenset({'effort_bias', 'asymmetric_friction'}),
    'backlash': frozenset(TRANSMISSION),
    'joint_elasticity': frozenset(TRANSMISSION),
    # The spring of a cable and that of an arm are one effect.
    'spring': frozenset({'spring'}),
}
_INERTIAL = frozenset({'inertia', 'gravity', 'payload'})


@dataclass(frozen=True)
class Judgement:
    """
    Hold a score, what the answer was, and how many of two effects were found.

    ``outcome``: right, set, nothing, unknown, bad_data, wrong joint, wrong name, false alarm,
    several names or single name; ``spurious``: causes that are no truth.
    """

    score: int
    outcome: str
    first: bool = False
    found: int = 0
    spurious: int = 0


def named(document: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the causes that an answer names; none where it says that none explains the data."""
    return list(document['causes']) if document['verdict'] in ('named', 'ambiguous') else []


def match(cause: dict[str, Any], truth: Truth) -> str:
    """Return 'name' or 'set' if a cause, or one of its rivals, is the truth, else ''."""
    effect = 'asymmetric_friction' if truth.effect == 'asymmetric_level' else truth.effect
    right = set(TRANSMISSION) if effect in TRANSMISSION else {effect}
    rivals = set(cause['rivals'])
    if cause['joint'] == truth.joint and cause['effect'] in right:
        return 'name' if rivals <= right else 'set'
    if cause['joint'] == truth.joint and rivals & right:
        return 'set'
    return 'set' if rivals & {f'{name}@{truth.joint}' for name in right} else ''


def judge(kind: str, truths: Sequence[Truth], document: dict[str, Any]) -> Judgement:
    """Return what an answer to a trial of a kind is worth."""
    causes = named(document)
    silent = {
        'nothing_above_floor': 'nothing', 'unknown_structure': 'unknown', 'bad_data': 'bad_data',
    }.get(document['verdict'])  # fmt: skip
    spurious = sum(not any(match(cause, truth) for truth in truths) for cause in causes)
    if kind == 'null':
        if causes:
            return Judgement(-1, 'false alarm', spurious=len(causes))
        return Judgement(int(silent == 'nothing'), silent or 'nothing')
    if kind == 'outside':
        if document['verdict'] == 'named' and len(causes) == 1:
            return Judgement(-1, 'single name', spurious=1)
        if document['verdict'] == 'named':
            return Judgement(0, 'several names', spurious=spurious)
        return Judgement(1, silent or 'set')
    if not causes:
        return Judgement(0, silent or 'nothing')
    first = causes[0]
    if kind == 'twin':
        return _twin(truths[0], causes, spurious)
    if kind == 'double':
        leads = [
            any(match(cause, truth) and _leads(cause, truth) for cause in causes)
            for truth in truths
        ]
        true = any(_leads(first, truth) for truth in truths)
        found = sum(leads)
        score = 1 if found == len(truths) else (0 if true or found else -1)
        outcome = {2: 'both', 1: 'one'}.get(found, 'wrong name')
        return Judgement(score, outcome, true, found, spurious)
    truth = truths[0]
    how = match(first, truth)
    if how:
        return Judgement(
            int(how == 'name'), 'right' if how == 'name' else 'set', True, 1, spurious
        )
    same = first['effect'] == truth.effect
    return Judgement(-1, 'wrong joint' if same else 'wrong name', spurious=spurious)


def _leads(cause: dict[str, Any], truth: Truth) -> bool:
    """Tell whether a cause is the truth by its own name, whatever its rivals."""
    return bool(match({**cause, 'rivals': []}, truth))


def _twin(truth: Truth, causes: list[dict[str, Any]], spurious: int) -> Judgement:
    first = causes[0]
    names = {first['effect'], *first['rivals']}
    if truth.effect == 'common_scale':
        scaled = [cause for cause in causes if cause['effect'] == 'effort_scale']
        if scaled:
            # All joints in one scale, and that their masses in another are the same.
            alike = (cause for cause in scaled if cause['joint'] == truth.joint)
            whole = any(_INERTIAL & set(cause['rivals']) for cause in alike)
            return Judgement(int(whole), 'set' if whole else 'one of them', True, 1, spurious)
        return Judgement(-1, 'wrong name', spurious=spurious)
    if first['joint'] == truth.joint and TWIN_SETS[truth.effect] <= names:
        return Judgement(1, 'set', True, 1, spurious)
    if match(first, truth):
        return Judgement(0, 'one of them', True, 1, spurious)
    return Judgement(-1, 'wrong name', spurious=spurious)
