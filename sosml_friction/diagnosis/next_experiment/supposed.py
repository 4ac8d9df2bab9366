# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A cause that is supposed to be there."""

from collections.abc import Sequence
from dataclasses import dataclass

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.term import Inner, Term
from sosml_friction.regression.evidence import CandidateColumns


@dataclass(frozen=True)
class Supposed:
    """
    Hold a cause that is supposed: its columns where it was measured, and how large it is.

    ``points``: inner parameters, those of ``columns``; ``amplitude`` (k,) at the first of them
    with ``x`` (p,) the nominal deviations beside it.
    """

    effect: Term
    joint: int
    points: Sequence[Inner]
    columns: CandidateColumns
    amplitude: FloatArray
    x: FloatArray
