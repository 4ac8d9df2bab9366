# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""How much of one limit of one joint a trajectory uses."""

from dataclasses import dataclass


@dataclass(frozen=True)
class LimitUse:
    """
    Hold the instant ``time`` [s] at which ``quantity`` of ``joint`` is closest to its limit.

    ``value`` and ``limit`` are in the joint's units (rad or m, per s, per s^2, Nm or N);
    ``excess`` is positive beyond the limit and negative within it.
    """

    joint: str
    quantity: str
    value: float
    time: float
    limit: float
    excess: float

    def sentence(self) -> str:
        """Return what is beyond the limit, without a full stop."""
        article = 'an' if self.quantity[0] in 'aeiou' else 'a'
        return (
            f'the trajectory takes joint {self.joint} to {article} {self.quantity} of '
            f'{self.value:.3g} at {self.time:.2f} s, {self.excess:.3g} beyond its limit '
            f'of {self.limit:.3g}'
        )
