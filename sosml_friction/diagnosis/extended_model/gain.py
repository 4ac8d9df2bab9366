# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What an extended model is worth on data it was not fitted to: inverse and forward."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.regression.chance import BEYOND_CHANCE


@dataclass(frozen=True)
class Gain:
    """
    Hold root mean squares by joint (n,), with the refitted nominal and with the causes.

    ``inverse``: of measured minus predicted effort in the band [Nm or N]; ``relative`` [%] the
    same as a share of the measured effort; ``forward``: of simulated minus measured position over
    ``horizon_s`` from the measured state, driven by the measured effort [rad or m].
    ``forward_error``: standard error of the ratio of the latter two, after over before.
    """

    inverse_before: FloatArray
    inverse_after: FloatArray
    relative_before: FloatArray
    relative_after: FloatArray
    forward_before: FloatArray
    forward_after: FloatArray
    forward_error: FloatArray
    horizon_s: float
    on: str

    @property
    def forward_ratio(self) -> FloatArray:
        """Return the error of position after over before (n,), NaN where none is known before."""
        known = np.isfinite(self.forward_before) & (self.forward_before > 0.0)
        ratio = np.full(self.forward_before.shape, np.nan)
        return np.divide(self.forward_after, self.forward_before, out=ratio, where=known)

    @property
    def forward_by_chance(self) -> BoolArray:
        """Tell where the error of position changes by no more than chance (n,)."""
        change = np.abs(self.forward_ratio - 1.0)
        return np.asarray((change > 0.0) & (change <= BEYOND_CHANCE * self.forward_error))

    def to_dict(self, names: tuple[str, ...], units: tuple[str, ...]) -> dict[str, Any]:
        """Return the entry ``gain`` of diagnosis.json, by joint whose effort is known."""
        return {
            name: {
                'inverse': {
                    'before': self.inverse_before[i],
                    'after': self.inverse_after[i],
                    'unit': units[i],
                    'relative_before_percent': self.relative_before[i],
                    'relative_after_percent': self.relative_after[i],
                },
                'forward': {
                    'before': self.forward_before[i],
                    'after': self.forward_after[i],
                    'ratio': self.forward_ratio[i],
                    'ratio_std_error': self.forward_error[i],
                    'unit': 'rad' if units[i] == 'Nm' else 'm',
                    'horizon_s': self.horizon_s,
                },
                'on': self.on,
            }
            for i, name in enumerate(names)
            if np.isfinite(self.relative_before[i])
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
    # A joint without effort has no error of it.
    size[size == 0.0] = np.nan
    root = [np.sqrt(np.mean(x**2, axis=0)) for x in (before, after)]
    forward = [
        np.sqrt(np.mean(x, axis=0)) if len(x) else np.full(x.shape[1], np.nan)
        for x in (squares_before, squares_after)
    ]
    return Gain(
        root[0], root[1], 100.0 * root[0] / size, 100.0 * root[1] / size, forward[0], forward[1],
        _ratio_error(squares_before, squares_after), horizon_s, on,
    )  # fmt: skip


def _ratio_error(before: FloatArray, after: FloatArray) -> FloatArray:
    """
    Return the standard error (n,) of sqrt(mean after / mean before) over windows (W, n).

    Each window is compared with itself: most of the error of both is the noise of the measured
    effort. To first order the ratio R moves by R / 2 (after / mean after - before / mean before).
    """
    result = np.full(before.shape[1], np.nan)
    for i in range(before.shape[1]):
        b, a = before[:, i], after[:, i]
        if len(b) > 1 and np.isfinite(a).all() and np.isfinite(b).all() and a.any() and b.any():
            moved = a / a.mean() - b / b.mean()
            ratio = np.sqrt(a.mean() / b.mean())
            result[i] = 0.5 * ratio * np.std(moved, ddof=1) / np.sqrt(len(b))
    return result
