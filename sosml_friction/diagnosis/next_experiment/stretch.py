# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Data that are not recorded yet."""

from dataclasses import dataclass

from sosml_friction.model.terms.kinds.term import Term
from sosml_friction.regression.signals import Signals


@dataclass(frozen=True)
class Stretch:
    """
    Hold a motion that is planned, or supposed to be repeated, and what does not act there.

    ``only``: the effects that act, None for all but ``absent``.
    """

    signals: Signals
    absent: frozenset[str] = frozenset()
    only: frozenset[str] | None = None

    @property
    def duration(self) -> float:
        """Return how long it lasts [s]."""
        return float(len(self.signals.q) * self.signals.band.step)

    def acts(self, effect: Term) -> bool:
        """Tell whether an effect acts here."""
        if self.only is not None:
            return effect.identifier in self.only
        return effect.identifier not in self.absent
