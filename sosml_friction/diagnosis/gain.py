# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What an extended model is worth on data it was not fitted to: inverse and forward."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

#: A forward prediction starts afresh from the measured state after so long [s].
HORIZON_S = 0.3


@dataclass(frozen=True)
class Gain:
    """
    Hold root mean squares by joint (n,), with the refitted nominal and with the causes.

    ``inverse``: of measured minus predicted effort in the band [Nm or N]; ``relative`` [%] the
    same as a share of the measured effort; ``forward``: of the position that the model's effort
    error makes over ``horizon_s`` from the measured state [rad or m].
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
    inertia: FloatArray,
    viscous: FloatArray,
    step: float,
    on: str,
) -> Gain:
    """
    Return the gain from effort errors (rows, n) before and after.

    :param measured: effort (rows, n) in the band.
    :param inertia: M_ii (rows, n); viscous: (n,).
    :param step: time between rows [s].
    :param on: what the errors are on, for the report.
    """
    size = np.sqrt(np.mean(measured**2, axis=0))
    root = [np.sqrt(np.mean(x**2, axis=0)) for x in (before, after)]
    forward = [
        np.array(
            [
                _forward(
                    np.ascontiguousarray(x[:, i]),
                    np.ascontiguousarray(inertia[:, i]),
                    float(viscous[i]),
                    step,
                    max(2, round(HORIZON_S / step)),
                )
                for i in range(x.shape[1])
            ]
        )
        for x in (before, after)
    ]
    return Gain(
        root[0], root[1], 100.0 * root[0] / size, 100.0 * root[1] / size, forward[0], forward[1],
        HORIZON_S, on,
    )  # fmt: skip


@njit(cache=True)
def _forward(
    error: FloatArray, inertia: FloatArray, viscous: float, step: float, horizon: int
) -> float:
    """
    Return the root mean square of d, restarted at 0 every ``horizon`` rows.

        M d'' + B d' = -error,

    the first order in the effort error of a forward simulation that is driven by the measured
    effort from the measured state.
    """
    total = 0.0
    d, v = 0.0, 0.0
    for k in range(len(error)):
        if k % horizon == 0:
            d, v = 0.0, 0.0
        v = (v - step * error[k] / inertia[k]) / (1.0 + step * viscous / inertia[k])
        d += step * v
        total += d * d
    return np.sqrt(total / len(error))
