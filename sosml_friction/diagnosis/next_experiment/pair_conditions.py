# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Pairs of causes that the joint sensors hardly tell apart, and what else does."""

from typing import NamedTuple

from sosml_friction.model.terms.kinds.term import TERMS


class PairCondition(NamedTuple):
    """
    Hold what tells two causes apart.

    ``condition``: its name in :mod:`.conditions`, '' where it is none of
    them; ``instruction``: what to do, and what is seen then.
    """

    condition: str
    instruction: str


def pair_condition(one: str, other: str) -> PairCondition | None:
    """Return what separates two causes where either term says it, else None."""
    for name, its in ((one, other), (other, one)):
        if name in TERMS.classes and its in TERMS[name].told_apart:
            return PairCondition(*TERMS[name].told_apart[its])
    return None
