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
        """Return effect and joint, and of a term that the model states that it is one."""
        return self.effect.key, self.joint


def make_candidates(
    library: dict[str, Term], signals: Signals, silent: frozenset[int] = frozenset()
) -> tuple[Candidate, ...]:
    """
    Return every effect in every joint that it can act in, but for ``silent`` ones.

    And each term that the model states, as it states it; one without inner parameters has no
    other form.

    :raises ConfigurationError: if there is none.
    """
    result = []
    n = signals.robot.n
    for effect in library.values():
        kinds = [effect]
        if effect.counterpart is not None and n > 1:
            kinds.append(effect.counterpart())
        whole = 0 if effect.counterpart is None else ROBOT
        for kind in kinds:
            for i in (whole,) if kind.of_robot else (i for i in range(n) if i not in silent):
                if kind.applies(signals, i) and (grid := kind.grid(signals, i)):
                    result.append(Candidate(kind, i, tuple(grid)))
    for known in (each.known for each in signals.stated):
        # Who does not look for a cause of the catalogue does not want it named.
        left_out = known.term.searched and known.term.identifier not in library
        if left_out or (not known.term.of_robot and known.joint in silent):
            continue
        term = known.term.as_stated(known.amplitude, known.names)
        own = Candidate(term, known.joint, (known.inner,))
        name = known.term.identifier, known.joint
        result = [c for c in result if c.effect.inner or (c.effect.identifier, c.joint) != name]
        result.append(own)
    if not result:
        raise ConfigurationError(
            'no cause is left that could act in these joints: leave out fewer of them'
        )
    return tuple(result)
