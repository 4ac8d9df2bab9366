# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What is left along any one axis: not a cause, but the sign that one is missing."""

from collections.abc import Callable, Mapping, Sequence
from typing import ClassVar

import numpy as np

from sosml_friction.arrays import FloatArray
from sosml_friction.model.terms.kinds.recording import Recording
from sosml_friction.model.terms.kinds.term import Inner
from sosml_friction.regression.curves.curve import Curve
from sosml_friction.regression.curves.knots import knots_of, padded_hats
from sosml_friction.regression.signals import Signals

#: Hats of a free curve: it bends within an eighth of an axis, as in the study of 127 recordings
#: that the prior of its size is from.
HATS = 9
#: The axes, as signals (N, n).
_AXES: tuple[Callable[[Recording], FloatArray], ...] = (
    lambda s: s.v,
    lambda s: s.q,
    lambda s: s.a,
    lambda s: s.sure_torque,
)
#: The part of each that is noise of position and no motion, (N, n) or its standard deviation (n,):
#: acceleration has most of it. At a constant speed it is all by which velocity differs, and
#: friction that changes with speed seems to follow it.
_NOISE: tuple[Callable[[Signals], FloatArray | float] | None, ...] = (
    lambda s: s.jitter,
    None,
    lambda s: s.rough,
    lambda s: s.shaken,
)


class Structure(Curve):
    """
    Add any smooth function of velocity, position, acceleration, load, and s times each.

    Hat functions on quantiles of the data, which know no physics: what they predict on data left
    out is structure, whatever its name. Not part of the catalogue.
    """

    identifier: ClassVar[str] = 'structure'
    amplitudes: ClassVar[Mapping[str, str]] = {f'hat_{k}': '{effort}' for k in range(8 * HATS)}

    def __init__(self, stretches: Sequence[Signals]) -> None:
        self._knots = [
            knots_of(stretches, axis, HATS, None if noise is None else spread(stretches, noise))
            for axis, noise in zip(_AXES, _NOISE, strict=True)
        ]

    def columns(self, signals: Recording, joint: int, inner: Inner) -> FloatArray:
        """Return the hats."""
        return signals.in_joint(joint, *self.own_columns(signals, joint, (inner,))[:, 0].T)

    def own_columns(self, signals: Recording, joint: int, grid: Sequence[Inner]) -> FloatArray:
        """Return the hats of the joint alone, (N, 1, k)."""
        factors = 1.0, signals.sign[:, joint]
        parts = [
            padded_hats(axis(signals)[:, joint], knots[joint], HATS, factors)
            for axis, knots in zip(_AXES, self._knots, strict=True)
        ]
        return np.concatenate(parts, axis=1)[:, None]


def spread(
    stretches: Sequence[Signals], signal: Callable[[Signals], FloatArray | float]
) -> FloatArray:
    """Return the root mean square (n,) of a signal (N, n) over all stretches."""
    x = np.concatenate([np.broadcast_to(signal(s), s.q.shape) for s in stretches])
    return np.asarray(np.sqrt(np.mean(x**2, axis=0)))
