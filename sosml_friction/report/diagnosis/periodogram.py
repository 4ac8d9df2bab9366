# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The figure of what repeats with position: the unexplained effort as lines in position."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from sosml_friction.diagnosis.diagnosis import Diagnosis
from sosml_friction.model.terms.cogging import lines
from sosml_friction.model.terms.kinds.term import TERMS
from sosml_friction.regression.kernels import squares
from sosml_friction.report.common.drawing import (
    AFTER,
    BEFORE,
    FONT,
    FloatArray,
    fix_axes,
    label_axes,
    log_axis,
    new_figure,
)

_TURN = 2.0 * np.pi
#: Lines to a range of motion, and in all; so many are made at a time.
_PER_SPAN, _MOST, _AT_ONCE = 4.0, 800, 32
#: At this share of the speed a line still has to be within the band.
_SLOW = 0.04
#: Fewer samples in one direction are no spectrum.
_FEWEST = 200


def position_spectrum(
    q: FloatArray, effort: FloatArray, first: float, step: float, count: int
) -> FloatArray:
    """
    Return the size of the line A cos w q + B sin w q fitted to an effort at each w, (count,).

    By least squares at each frequency by itself, the effort's mean taken off.

    :param q: position (N,) [rad or m]; effort (N,) [Nm or N]; w = first + k step [rad/rad, rad/m].
    """
    e = effort - effort.mean()
    sizes = np.empty(count)
    for begin in range(0, count, _AT_ONCE):
        some = min(_AT_ONCE, count - begin)
        columns = lines(q, first + begin * step, step, some)
        products = (e @ columns.reshape(len(e), 2 * some)).reshape(some, 2)
        energy = squares(columns[:, None])
        energy += 1e-9 * len(q) * np.eye(2)
        amplitude = np.linalg.solve(energy, products[:, :, None])[:, :, 0]
        sizes[begin : begin + some] = np.hypot(amplitude[:, 0], amplitude[:, 1])
    return sizes


def position_periodogram(diagnosis: Diagnosis, i: int, before: FloatArray, after: FloatArray,
                         rows: dict[str, FloatArray]) -> Figure | None:  # fmt: skip
    """
    Return the lines in position of what is unexplained, forwards and backwards.

    What is the same in both directions is a torque of position; friction of position changes its
    sign with the direction, but not its size. None where the joint moves too little.
    """
    laboratory = diagnosis.laboratory
    assert laboratory is not None
    q, v = rows['q'][:, i], rows['v'][:, i]
    span = float(np.ptp(q))
    speed = float(np.quantile(np.abs(v), 0.99))
    ways = ((v > 0.05 * speed, 'forwards'), (v < -0.05 * speed, 'backwards'))
    if span <= 0.0 or speed <= 0.0 or any(way.sum() < _FEWEST for way, _ in ways):
        return None
    turns = diagnosis.units[i] == 'Nm'
    first, step = _TURN / span, _TURN / (_PER_SPAN * span)
    high = _TURN * laboratory.signals[0].band.cutoff / (_SLOW * speed)
    count = int(min(max((high - first) / step, 2.0), _MOST))
    w = first + step * np.arange(count)
    x = w if turns else w / _TURN
    named = [
        cause.parameters[name].value
        for cause in diagnosis.causes
        if cause.joint == diagnosis.names[i]
        and cause.effect in TERMS.classes
        and TERMS[cause.effect].repeats
        for name in cause.parameters
        if name.startswith('frequency')
    ]
    figure = new_figure(10.0, 3.4)
    axes = figure.subplots(1, 2, sharey=True)
    for ax, (way, label) in zip(axes, ways, strict=True):
        place = np.ascontiguousarray(q[way])
        for frequency in named:
            ax.axvline(frequency if turns else frequency / _TURN, color='#c9c9c9', linewidth=3.0)
        for values, colour in ((before, BEFORE), (after, AFTER)):
            size = position_spectrum(place, values[way, i], first, step, count)
            ax.plot(x, size, color=colour, linewidth=0.9)
        ax.set_title(label, fontsize=FONT, loc='left')
        label_axes(
            ax,
            'periods per turn' if turns else 'periods per metre',
            f'size of unexplained line [{diagnosis.units[i]}]' if label[0] == 'f' else '',
        )
        # Over decades: harmonics of a turn are few, teeth and slots are many.
        log_axis(ax)
        ax.set_xlim(float(x[0]), float(x[-1]))
        ax.set_ylim(bottom=0.0)
    handles = [
        Line2D([], [], color=BEFORE, label='refitted model'),
        Line2D([], [], color=AFTER, label='with what was named'),
    ]
    if named:
        handles.append(Line2D([], [], color='#c9c9c9', linewidth=3.0, label='named'))
    fix_axes(figure, (0.85, 0.15, 0.95, 0.35), (0.2, 0.2), handles)
    return figure
