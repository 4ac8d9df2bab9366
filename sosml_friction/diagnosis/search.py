# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The third step of a diagnosis: the causes that are found in a regression."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from sosml_friction.diagnosis.decision.finding import Finding
from sosml_friction.diagnosis.decision.selection import Selection
from sosml_friction.diagnosis.decision.selector import Selector
from sosml_friction.diagnosis.decision.shown_gate import shown_gate
from sosml_friction.diagnosis.design import Design, Step
from sosml_friction.model.terms.kinds.transmission_term import TransmissionTerm
from sosml_friction.regression.whitened import WhitenedRegression

#: Why a cause is not found again.
CONTRADICTED = 'data left out contradict it'


@dataclass(frozen=True)
class Search:
    """Hold what was found, and the design that it was found in."""

    design: Design
    selection: Selection

    @property
    def laboratory(self) -> WhitenedRegression:
        """Return the regression, with the load of the bodies that were found."""
        return self.selection.laboratory or self.design.laboratory

    @classmethod
    def run(cls, design: Design, step: Step, all_friction: bool = False) -> 'Search':
        """
        Search the causes, in another design where the inertia turns out to be none of the model's.

        A gear that gives moves the nominal body, whose inertia the other causes may have hidden.
        """
        selector = Selector(design.laboratory, step)
        selection = selector.run(all_friction)
        stood_out = [*selection.accepted, selection.rejected]
        if any(own and isinstance(own.effect, TransmissionTerm) for own in stood_out):
            untold = design.untold_inertia([cause.placed for cause in selection.accepted])
            if untold:
                design = design.with_free_inertia(untold, step)
                selector = Selector(design.laboratory, step)
                selection = selector.run(all_friction)
        return cls(design, shown_gate(selector, selection))

    def further(
        self, stay: Sequence[Finding], refused: Iterable[tuple[str, int]], step: Step
    ) -> 'Search':
        """Search on beside the causes that stay, without those that were taken back."""
        selector = Selector(self.design.laboratory, step)
        selection = selector.run(begin=stay, refused=dict.fromkeys(refused, CONTRADICTED))
        selection = replace(shown_gate(selector, selection), ranking=self.selection.ranking)
        return replace(self, selection=selection)
