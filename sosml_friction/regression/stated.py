# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""A term that a model states, with what its numbers are off in proportion to."""

from dataclasses import dataclass

from sosml_friction.arrays import FloatArray
from sosml_friction.model.known_terms import KnownTerm


@dataclass(frozen=True)
class Stated:
    """
    Hold a term that a model states: its amplitudes are nominal parameters, as C and B are.

    ``size`` (k,): what each of them is off in proportion to, in its own unit.
    """

    known: KnownTerm
    size: FloatArray
