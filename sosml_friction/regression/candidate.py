# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A cause to try, in one joint or in the whole robot."""

from collections.abc import Sequence
from dataclasses import dataclass

from sosml_friction.exceptions import ConfigurationError
from sosml_friction.model.terms.kinds.term import ROBOT, Inner, Term
from sosml_friction.regression.signals import Signals


@dataclass(frozen=True)
class Candidate:
    """Hold one effect in one joint (0 or :data:`ROBOT`: in the whole robot) and its grid."""

    effect: Term
    joint: int
    grid: Sequence[Inner]

    @property
    def key(self) -> tuple[str, int]:
        """Return effect and joint."""
        return self.effect.identifier, self.joint


def make_candidates(
    library: dict[str, Term], signals: Signals, silent: frozenset[int] = frozenset()
) -> tuple[Candidate, ...]:
    """
    Return every effect in every joint that it can act in, but for ``silent`` ones.

    :raises ConfigurationError: if there is none.
    """
    result = []
    n = signals.robot.n
    for effect in library.values():
        for i in (0,) if effect.of_robot else (i for i in range(n) if i not in silent):
            if effect.applies(signals, i) and (grid := effect.grid(signals, i)):
                result.append(Candidate(effect, i, tuple(grid)))
        if effect.everywhere is not None and n > 1:
            alike = effect.everywhere()
            result.append(Candidate(alike, ROBOT, tuple(alike.grid(signals, ROBOT))))
    if not result:
        raise ConfigurationError(
            'no cause is left that could act in these joints: leave out fewer of them'
        )
    return tuple(result)
