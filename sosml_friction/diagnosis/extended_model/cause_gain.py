# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What one cause by itself removes of the effort error on data left out."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.diagnosis.extended_model.uncertain import Uncertain
from sosml_friction.model.parameter import Z_95


@dataclass(frozen=True)
class CauseGain:
    """
    Hold what one cause removes by itself on data left out.

    ``joints``: those that it acts in; ``without`` and ``with_it``: root mean square of the effort
    error there [Nm or N]; ``removed``: the difference. ``recurs``: the share b of what it predicts
    that is there, 1 where it carries over. ``size``: root mean square of its columns fitted to the
    data left out, over that of what it predicts; ``phase`` [degrees]: by how much that is off; NaN
    where the term has none. ``units`` of the joints.
    """

    joints: tuple[str, ...]
    units: tuple[str, ...]
    without: FloatArray
    with_it: FloatArray
    removed: tuple[Uncertain, ...]
    recurs: Uncertain
    size: Uncertain
    phase: float

    @property
    def helps(self) -> bool:
        """Tell whether the error is smaller with the cause."""
        return self.recurs.value > 0.5

    @property
    def shown(self) -> bool:
        """Tell whether it helps by all of the 95 % interval of b."""
        return self.recurs.value - Z_95 * self.recurs.std_error > 0.5

    @property
    def carries_over(self) -> bool:
        """Tell that the data left out do not contradict: it helps, or is off by chance only."""
        return self.helps or not self.recurs.beyond(1.0)

    @property
    def size_recurs(self) -> bool:
        """Tell whether another phase of the same frequency is there, beyond chance."""
        return bool(np.isfinite(self.phase)) and self.size.beyond(0.0)

    def to_dict(self) -> dict[str, Any]:
        """Return the entry ``gain`` of a cause in diagnosis.json."""
        return {
            'joints': {
                name: {
                    'without': self.without[i],
                    'with': self.with_it[i],
                    'removed': self.removed[i].value,
                    'removed_std_error': self.removed[i].std_error,
                    'unit': self.units[i],
                }
                for i, name in enumerate(self.joints)
            },
            'recurs': self.recurs,
            'size': self.size,
            'phase_degrees': self.phase,
            'carries_over': self.carries_over,
        }
