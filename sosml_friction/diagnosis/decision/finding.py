# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A candidate with its evidence."""

from __future__ import annotations

from dataclasses import dataclass, replace

from sosml_friction.diagnosis.decision.cause import joint_name
from sosml_friction.model.terms.kinds.term import Inner, Term
from sosml_friction.regression.evidence import CandidateColumns, Score
from sosml_friction.regression.placed import Placed


@dataclass(frozen=True)
class Finding:
    """
    Hold one candidate with its evidence.

    ``delta_bic``: fall of the cost less the price of its parameters and of its grid; ``floor``:
    what ``score.cv_gain`` has to exceed; ``objection``: why it is physically impossible, or '';
    ``reduced``: the cause that it is where its own part is not seen, or ''. ``rivals``: what
    explains as much; ``failed``: the gates that it did not pass. ``instead``: the tones of time
    or the ripple that explain more, or ''.
    """

    effect: Term
    joint: int
    inner: Inner
    score: Score
    columns: CandidateColumns
    delta_bic: float
    floor: float
    objection: str = ''
    reduced: str = ''
    rivals: tuple[Finding, ...] = ()
    failed: tuple[str, ...] = ()
    instead: str = ''

    @property
    def key(self) -> tuple[str, int]:
        """Return effect and joint, and of a term that the model states that it is one."""
        return self.effect.key, self.joint

    @property
    def rank(self) -> float:
        """
        Return what sorts findings, best first.

        Those that are equal but for rounding, far below VERY_STRONG, keep the order of the
        catalogue.
        """
        return -round(float(self.delta_bic), 3)

    @property
    def placed(self) -> Placed:
        """Return the term where it was found."""
        return Placed(self.effect, self.joint, self.inner, self.columns)

    def reported(self, names: tuple[str, ...]) -> tuple[str, str]:
        """Return effect and joint under which it is reported."""
        return self.effect.identifier, joint_name(self.effect, self.joint, names)

    def judged(self) -> Finding:
        """Return it with the gates that it fails."""
        failed = [self.objection] if self.objection else []
        gain = self.score.cv_gain
        if not gain > self.floor:
            failed.append(
                f'it removes {100 * gain:.1f} % of what is unexplained on data left out, '
                f'within the floor of {100 * self.floor:.1f} %'
            )
        return replace(self, failed=tuple(failed))
