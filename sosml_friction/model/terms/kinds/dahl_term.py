# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Terms that are an effort of a level F which follows Dahl's state."""

from collections.abc import Mapping
from typing import ClassVar

from sosml_friction.arrays import FloatArray
from sosml_friction.model.dahl import dahl_path, dahl_step
from sosml_friction.model.terms.kinds.effort_term import EffortTerm
from sosml_friction.model.terms.kinds.term import Inner


class DahlTerm(EffortTerm, registered=False):
    """State an effort by z, Dahl's state with ``displacement`` x_s [rad or m]."""

    amplitudes: ClassVar[Mapping[str, str]] = {'level': '{effort}'}
    inner: ClassVar[Mapping[str, str]] = {'displacement': '{length}'}
    refined: ClassVar[tuple[str, ...]] = ('displacement',)
    axis: ClassVar[str] = 'displacement'

    def path_state(self, path: FloatArray, inner: Inner) -> FloatArray:
        """Return z, (N, 1)."""
        return dahl_path(path, float(inner['displacement']))[:, None]

    def next_state(self, state: FloatArray, dq: FloatArray, inner: Inner) -> FloatArray:
        """Return z after a displacement."""
        return dahl_step(state, dq[:, None], inner['displacement'])
