# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What an extended model is worth on data it was not fitted to: inverse and forward."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Gain:
    """
    Hold root mean squares by joint (n,), with the refitted nominal and with the causes.

    ``inverse``: of measured minus predicted effort in the band [Nm or N]; ``relative`` [%] the
    same as a share of the measured effort; ``forward``: of simulated minus measured position over
    ``horizon_s`` from the measured state, driven by the measured effort [rad or m].
    """

    inverse_before: FloatArray
    inverse_after: FloatArray
    relative_before: FloatArray
    relative_after: FloatArray
    forward_before: FloatArray
    forward_after: FloatArray
    horizon_s: float
    on: str

    def to_dict(self, names: tuple[str, ...], units: tuple[str, ...]) -> dict[str, Any]:
        """Return the entry ``gain`` of diagnosis.json, by joint."""
        return {
            name: {
                'inverse': {
                    'before': float(self.inverse_before[i]),
                    'after': float(self.inverse_after[i]),
                    'unit': units[i],
                    'relative_before_percent': float(self.relative_before[i]),
                    'relative_after_percent': float(self.relative_after[i]),
                },
                'forward': {
                    'before': float(self.forward_before[i]),
                    'after': float(self.forward_after[i]),
                    'unit': 'rad' if units[i] == 'Nm' else 'm',
                    'horizon_s': self.horizon_s,
                },
                'on': self.on,
            }
            for i, name in enumerate(names)
        }


def make_gain(
    before: FloatArray,
    after: FloatArray,
    measured: FloatArray,
    squares_before: FloatArray,
    squares_after: FloatArray,
    horizon_s: float,
    on: str,
) -> Gain:
    """
    Return the gain from effort errors (rows, n) and simulated windows (W, n) before and after.

    :param measured: effort (rows, n) in the band.
    :param squares_before: mean square of the position error of each window [rad2 or m2]; without
        windows the forward gain is not known, NaN.
    :param on: what the errors are on, for the report.
    """
    size = np.sqrt(np.mean(measured**2, axis=0))
    root = [np.sqrt(np.mean(x**2, axis=0)) for x in (before, after)]
    forward = [
        np.sqrt(np.mean(x, axis=0)) if len(x) else np.full(x.shape[1], np.nan)
        for x in (squares_before, squares_after)
    ]
    return Gain(
        root[0], root[1], 100.0 * root[0] / size, 100.0 * root[1] / size, forward[0], forward[1],
        horizon_s, on,
    )  # fmt: skip
