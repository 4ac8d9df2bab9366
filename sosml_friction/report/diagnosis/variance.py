# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The figure of shares: what the causes take of the unexplained variance, and what is noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from scipy.signal import lfilter

from sosml_friction.diagnosis.diagnosis import Diagnosis
from sosml_friction.regression.noise_model import NoiseModel
from sosml_friction.report.common.drawing import FONT, label_axes, new_figure

_CAUSE, _REST, _NOISE, _START = '#0072B2', '#D55E00', '#bdbdbd', '#f2c9ad'
#: Length of an impulse response that is long beside any noise's memory.
_RESPONSE = 4000


@dataclass(frozen=True)
class Step:
    """Hold one bar: from ``low`` to ``high``, in percent of the variance at the start."""

    label: str
    low: float
    high: float
    colour: str


def noise_variance(noise: NoiseModel) -> float:
    """Return the variance of such noise: the energy of its impulse response times sigma^2."""
    impulse = np.zeros(_RESPONSE)
    impulse[0] = noise.sigma
    response = lfilter([1.0], np.concatenate([[1.0], -noise.coefficients]), impulse)
    return float(np.sum(np.asarray(response) ** 2))


def variance_steps(diagnosis: Diagnosis, i: int) -> list[Step]:
    """
    Return the bars of a joint, from the variance the refitted model leaves to what is left.

    On folds left out. Noise is what the whole catalogue and the free curves leave: an estimate
    from below.
    """
    laboratory = diagnosis.laboratory
    assert laboratory is not None
    name = diagnosis.names[i]
    error = [stage['relative_error_percent'][name] ** 2 for stage in diagnosis.stages]
    whole = max(error[0], 1e-300)
    shares = [100.0 * x / whole for x in error]
    steps = [Step('refitted model', 0.0, 100.0, _START)]
    for k, stage in enumerate(diagnosis.stages[1:], 1):
        where = '' if stage['joint'] == name else f' ({stage["joint"]})'
        label = f'{stage["effect"].replace("_", " ")}{where}'
        low, high = sorted((shares[k - 1], shares[k]))
        steps.append(Step(label, low, high, _CAUSE if shares[k] <= shares[k - 1] else _REST))
    tau = np.concatenate([s.band.apply(s.tau[:, i]) for s in laboratory.signals])
    unit = 1e4 / max(float(np.mean(tau**2)), 1e-300)
    noise = min(100.0 * noise_variance(laboratory.noise[i]) * unit / whole, shares[-1])
    steps.append(Step('unexplained', noise, shares[-1], _REST))
    steps.append(Step('noise', 0.0, noise, _NOISE))
    return steps


def variance_waterfall(diagnosis: Diagnosis) -> Figure:
    """Return a cascade of bars for each joint."""
    steps = [variance_steps(diagnosis, i) for i in range(len(diagnosis.names))]
    most = max(len(x) for x in steps)
    figure = new_figure(10.0, 0.9 + (0.3 + 0.3 * most) * len(steps))
    axes = np.atleast_1d(figure.subplots(len(steps), 1, sharex=True))
    for k, (ax, bars) in enumerate(zip(axes, steps, strict=True)):
        place = np.arange(len(bars))[::-1]
        ax.barh(
            place,
            [bar.high - bar.low for bar in bars],
            left=[bar.low for bar in bars],
            color=[bar.colour for bar in bars],
            height=0.7,
        )
        right = max(bar.high for bar in bars)
        for y, bar in zip(place, bars, strict=True):
            ax.text(
                bar.high + 0.01 * right, y, f'{bar.high - bar.low:.1f} %', va='center',
                fontsize=FONT,
            )  # fmt: skip
        ax.set_yticks(place, [bar.label for bar in bars], fontsize=FONT)
        ax.set_title(diagnosis.names[k], fontsize=FONT, loc='left')
        ax.set_xlim(0.0, 1.12 * right)
        last = k == len(steps) - 1
        label_axes(ax, 'share of the variance that the refitted model leaves [%]' * last, '')
        ax.grid(False, axis='y')
    return figure
