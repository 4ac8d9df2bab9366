# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Whether the rest is noise, and whether effort is measured too early or too late."""

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.stats import norm

from sosml_friction.arrays import FloatArray
from sosml_friction.diagnosis.residual.joint_residual import JointResidual
from sosml_friction.regression.chance import CHANCE

#: Longest lag of the autocorrelation [s].
_LONGEST_S = 1.5
#: Shifts of effort that are tried, to each side [s], and how many.
_SHIFT_S, _SHIFTS = 0.02, 41


def whitened_autocorrelation(
    joint: JointResidual,
) -> tuple[FloatArray, tuple[FloatArray, FloatArray], float]:
    """
    Return lags [s], the autocorrelations of the whitened rest before and after, and their bound.

    A rest that is noise is within +- the bound at 99 % of the lags.
    """
    diagnosis, i = joint.diagnosis, joint.i
    laboratory, selection = diagnosis.laboratory, diagnosis.selection
    assert laboratory is not None
    assert selection is not None
    step = laboratory.signals[0].band.output_step
    lags = max(2, round(_LONGEST_S / step))
    before = laboratory.y[:, i] - laboratory.system.Z[:, i] @ selection.before.x
    after = laboratory.y[:, i] - selection.system.Z[:, i] @ selection.after.x
    return (
        np.asarray(step * np.arange(1, lags + 1), dtype=np.float64),
        (autocorrelation(before, lags)[1:], autocorrelation(after, lags)[1:]),
        float(norm.isf(CHANCE / 2.0) / np.sqrt(len(laboratory.y))),
    )


def errors_by_shift(joint: JointResidual) -> tuple[FloatArray, tuple[FloatArray, FloatArray]]:
    """Return shifts of effort [s], and the error at each of them before and after [Nm or N]."""
    laboratory = joint.diagnosis.laboratory
    assert laboratory is not None
    step = laboratory.signals[0].band.output_step
    lengths = [len(part) for part in laboratory.split(joint.before)]
    ends = tuple(int(x) for x in np.cumsum(lengths)[:-1])
    shifts = np.linspace(-_SHIFT_S, _SHIFT_S, _SHIFTS)
    before, after = (
        shifted_error(joint.effort, left, step, shifts, ends)
        for left in (joint.before, joint.after)
    )
    return shifts, (before, after)


def autocorrelation(e: FloatArray, lags: int) -> FloatArray:
    """Return sum e_t e_(t+k) / sum e_t^2 for k = 0 ... lags, (lags + 1,)."""
    size = 2 ** int(np.ceil(np.log2(len(e) + lags + 1)))
    spectrum = np.abs(np.fft.rfft(e, size)) ** 2
    products = np.fft.irfft(spectrum, size)[: lags + 1]
    return np.asarray(products / max(float(products[0]), 1e-300))


def shifted_error(
    measured: FloatArray, left: FloatArray, step: float, shifts: FloatArray, ends: tuple[int, ...]
) -> FloatArray:
    """
    Return the root mean square of measured(t + d) - modelled(t) for each shift d, (shifts,).

    modelled = measured - left; measured is interpolated by cubic splines within each stretch,
    which end at the rows ``ends``.
    """
    total, count = np.zeros(len(shifts)), 0
    for a, b in zip((0, *ends), (*ends, len(measured)), strict=True):
        t = step * np.arange(b - a)
        edge = int(np.ceil(np.abs(shifts).max() / step)) + 1
        if b - a < 4 * edge + 8:
            continue
        spline = CubicSpline(t, measured[a:b])
        modelled = (measured - left)[a:b][edge:-edge]
        for k, d in enumerate(shifts):
            total[k] += float(np.sum((spline(t[edge:-edge] + d) - modelled) ** 2))
        count += len(modelled)
    return np.sqrt(total / max(count, 1))


def lowest(x: FloatArray, y: FloatArray) -> tuple[float, float]:
    """Return where y is least and how much that is: of the parabola through the lowest points."""
    k = int(np.clip(np.argmin(y), 1, len(y) - 2))
    a, b, c = (float(value) for value in y[k - 1 : k + 2])
    bend = a - 2.0 * b + c
    shift = 0.5 * (a - c) / bend if bend > 0.0 else 0.0
    shift = float(np.clip(shift, -1.0, 1.0))
    return float(x[k] + shift * (x[1] - x[0])), b - 0.25 * (a - c) * shift
