# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What two models leave of one joint's effort, beside what it may depend on."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from sosml_friction.arrays import BoolArray, FloatArray
from sosml_friction.compiled import compiled
from sosml_friction.diagnosis.diagnosis import Diagnosis
from sosml_friction.regression.structure import HATS

#: Bins of a curve of residual means: three for each piece of a free curve, which is as much of a
#: shape as the diagnosis can tell.
_BINS = 3 * (HATS - 1)
#: A mean of fewer rows is not given.
_FEWEST_IN_BIN = 5


@dataclass(frozen=True)
class JointResidual:
    """
    Hold the rows of one joint of a diagnosis, (rows,) each.

    ``axes``: time [s], q, v, a, load (rigid-body effort), since (the way since the last reversal
    [rad or m]); ``effort`` as measured; ``before`` and ``after``: what the refitted model leaves
    of it, and what is left with the causes.
    """

    diagnosis: Diagnosis
    i: int
    axes: dict[str, FloatArray]
    effort: FloatArray
    before: FloatArray
    after: FloatArray

    @property
    def name(self) -> str:
        """Return the name of the joint."""
        return self.diagnosis.names[self.i]

    @property
    def unit(self) -> str:
        """Return Nm or N."""
        return self.diagnosis.units[self.i]


def joint_residuals(diagnosis: Diagnosis) -> Iterator[JointResidual]:
    """Yield the rows of each joint; none where the data were too bad to tell."""
    laboratory = diagnosis.laboratory
    before, after = diagnosis.residual_before, diagnosis.residual_after
    if laboratory is None or before is None or after is None:
        return
    parts: dict[str, list[FloatArray]] = {}
    y, _ = laboratory.unwhitened()
    for signals, part in zip(laboratory.signals, laboratory.split(y), strict=True):
        rows = slice(signals.band.first, None, signals.band.factor)
        since = [
            way_since_reversal(np.ascontiguousarray(q), float(least))
            for q, least in zip(signals.q.T, signals.scales.displacement, strict=True)
        ]
        for name, x in (
            ('time', signals.time), ('q', signals.q), ('v', signals.v), ('a', signals.a),
            ('load', signals.rigid), ('since', np.column_stack(since)),
        ):  # fmt: skip
            kept = x[rows][: signals.band.count(len(x))]
            parts.setdefault(name, []).append(kept[-len(part) :])
    joined = {name: np.concatenate(x) for name, x in parts.items()}
    measured = laboratory.measured()
    for i in range(len(diagnosis.names)):
        axes = {name: x if x.ndim == 1 else x[:, i] for name, x in joined.items()}
        yield JointResidual(diagnosis, i, axes, measured[:, i], before[:, i], after[:, i])


@compiled
def way_since_reversal(q: FloatArray, least: float) -> FloatArray:
    """
    Return |q - q_r|, (N,), q_r the extreme of position where it turned around last.

    A way back of less than ``least`` [rad or m] is no reversal, but noise.
    """
    result = np.empty(len(q))
    turn, extreme, way = q[0], q[0], 0
    for k in range(len(q)):
        if way == 0:
            # Not yet under way.
            if abs(q[k] - turn) >= least:
                way = 1 if q[k] > turn else -1
                extreme = q[k]
        elif way * (q[k] - extreme) >= 0.0:
            extreme = q[k]
        elif way * (extreme - q[k]) >= least:
            turn, extreme, way = extreme, q[k], -way
        result[k] = abs(q[k] - turn)
    return result


def is_constant(x: FloatArray) -> bool:
    """Tell whether an axis has no range to speak of."""
    return bool(np.ptp(x) <= 1e-9 * max(float(np.abs(x).max()), 1e-300))


def bins_of(x: FloatArray, over_decades: bool) -> tuple[FloatArray, FloatArray]:
    """
    Return an axis as it is binned, and the edges of its bins.

    Quantiles at least half of an even bin apart: in a narrower one the noise of a plateau is drawn
    as a vertical line. Over decades equal in the logarithm, what is
    smaller than a ten-thousandth of the largest in the first.
    """
    if over_decades:
        x = np.maximum(x, 1e-4 * float(x.max()))
        return x, np.geomspace(float(x.min()), float(x.max()), _BINS + 1)
    least = 0.5 / _BINS * float(np.ptp(x))
    kept = [float(x.min())]
    for edge in np.quantile(x, np.linspace(0.0, 1.0, _BINS + 1)[1:]):
        if edge - kept[-1] >= least:
            kept.append(float(edge))
    # What was left out at the upper end belongs to the last bin.
    kept[-1] = float(x.max())
    return x, np.array(kept)


def means_in_bins(
    x: FloatArray, values: FloatArray, inside: BoolArray, edges: FloatArray
) -> tuple[list[float], list[float]]:
    """Return the means of x and of the values in each bin that has enough of the rows inside."""
    place = np.clip(np.searchsorted(edges, x, side='right') - 1, 0, len(edges) - 2)
    means: tuple[list[float], list[float]] = ([], [])
    for k in range(len(edges) - 1):
        rows = inside & (place == k)
        if rows.sum() >= _FEWEST_IN_BIN:
            for some, mean in zip((x, values), means, strict=True):
                mean.append(float(some[rows].mean()))
    return means
