# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Terms with a place in a regression, and where their sizes are among its parameters."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol, TypeVar

from sosml_friction.model.terms.kinds.term import Inner, Term
from sosml_friction.regression.evidence import CandidateColumns
from sosml_friction.regression.whitened import WhitenedRegression


class _HasColumns(Protocol):
    @property
    def columns(self) -> CandidateColumns: ...


_T = TypeVar('_T', bound=_HasColumns)


@dataclass(frozen=True)
class Placed:
    """Hold a term in a joint (0 or ``ROBOT``: in the whole robot) with its inner parameters."""

    term: Term
    joint: int
    inner: Inner
    columns: CandidateColumns

    def with_inner(self, laboratory: WhitenedRegression, inner: Inner) -> Placed:
        """Return the term with other inner parameters."""
        return replace(self, inner=inner, columns=laboratory.single(self.term, self.joint, inner))


def with_amplitudes(placed: Sequence[_T], first: int) -> Iterator[tuple[_T, slice]]:
    """Yield each term with where its amplitudes are among the parameters, from ``first`` on."""
    for each in placed:
        last = first + each.columns.C.shape[3]
        yield each, slice(first, last)
        first = last
