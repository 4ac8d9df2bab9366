# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The figure of likeness: which causes this motion can tell apart."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from sosml_friction.diagnosis.decision.confusability import Confusability
from sosml_friction.diagnosis.diagnosis import Diagnosis
from sosml_friction.model.terms.kinds.term import ALL_JOINTS
from sosml_friction.report.common.drawing import fix_axes, new_figure

#: More rows than this cannot be read: those that look least alike are left out.
_MOST = 46
#: Shares from here on are written into their cell.
_WRITTEN = 0.3
_MARK = '#D55E00'
_COLOURS = LinearSegmentedColormap.from_list('share', ['#ffffff', '#c6dbef', '#4292c6', '#08306b'])


def ambiguous_pairs(diagnosis: Diagnosis) -> list[tuple[tuple[str, str], tuple[str, str]]]:
    """Return each cause with each of its rivals, as (effect, joint)."""
    pairs = []
    for cause in diagnosis.terms:
        for rival in cause.rivals:
            effect, _, joint = rival.partition('@')
            pairs.append((cause.key, (effect, joint or cause.joint)))
    return pairs


def shown(found: Confusability, kept: set[tuple[str, str]]) -> NDArray[np.int64]:
    """Return the candidates to draw, joint by joint: those of ``kept``, then the most alike."""
    keys = list(zip(found.effects, found.joints, strict=True))
    off = found.share - np.diag(np.diag(found.share))
    alike = np.maximum(off.max(axis=0), off.max(axis=1))
    alike[[k for k, key in enumerate(keys) if key in kept]] = 2.0
    chosen = np.argsort(-alike, kind='stable')[:_MOST]
    joints = list(dict.fromkeys(found.joints))
    joints.sort(key=lambda joint: joint == ALL_JOINTS)
    return np.array(sorted(chosen, key=lambda k: (joints.index(found.joints[k]), k)))


def confusability_map(diagnosis: Diagnosis) -> Figure:
    """
    Return the share of each cause (row) that each other one (column) explains.

    Boxes mark the set that these data leave open; the last column is what the refit takes.
    """
    found = diagnosis.confusability
    assert found is not None
    pairs = ambiguous_pairs(diagnosis)
    named = {cause.key for cause in diagnosis.terms}
    order = shown(found, named | {key for pair in pairs for key in pair})
    keys = [(found.effects[k], found.joints[k]) for k in order]
    m = len(keys)
    share = found.share[np.ix_(order, order)]
    size = 0.185 * m
    figure = new_figure(max(3.1 + size, 7.0), 2.6 + size)
    ax, side = figure.subplots(1, 2, width_ratios=[m, 1.6])
    ax.imshow(100.0 * share, cmap=_COLOURS, vmin=0.0, vmax=100.0, aspect='auto')
    side.imshow(
        100.0 * found.absorbed[order, None], cmap=_COLOURS, vmin=0.0, vmax=100.0, aspect='auto'
    )
    for a in range(m):
        for b in range(m):
            if a != b and share[a, b] >= _WRITTEN:
                _write(ax, b, a, share[a, b])
        _write(side, 0, a, float(found.absorbed[order[a]]))
    labels = [f'{effect.replace("_", " ")}, {joint}' for effect, joint in keys]
    labels = [label.removesuffix(f', {ALL_JOINTS}') for label in labels]
    ax.set_xticks(np.arange(m), labels, rotation=90, fontsize=7)
    ax.set_yticks(np.arange(m), labels, fontsize=7)
    for ticks in (ax.get_xticklabels(), ax.get_yticklabels()):
        for label, key in zip(ticks, keys, strict=True):
            if key in named:
                label.set_fontweight('bold')
                label.set_color(_MARK)
    for one, other in pairs:
        for first, second in ((one, other), (other, one)):
            if first in keys and second in keys:
                corner = (keys.index(second) - 0.5, keys.index(first) - 0.5)
                ax.add_patch(
                    Rectangle(corner, 1.0, 1.0, fill=False, edgecolor=_MARK, linewidth=2.0)
                )
    edges = [k - 0.5 for k in range(1, m) if keys[k][1] != keys[k - 1][1]]
    for edge in edges:
        ax.axhline(edge, color='#7a7a7a', linewidth=0.8)
        ax.axvline(edge, color='#7a7a7a', linewidth=0.8)
    ax.set_ylabel('share of this cause [%] ...', fontsize=9)
    ax.set_xlabel('... that this one explains', fontsize=9)
    side.set_xticks([0], ['taken by\nthe refit'], rotation=90, fontsize=7)
    side.set_yticks([])
    for axes in (ax, side):
        axes.tick_params(length=0)
        for spine in axes.spines.values():
            spine.set_color('#c9c9c9')
    # The longest labels are of 7 points, 0.051 inches a letter.
    room = 0.4 + 0.051 * max(len(label) for label in labels)
    fix_axes(figure, (room, 0.1, room, 0.05), (0.12, 0.0))
    return figure


def _write(axes: Axes, x: int, y: int, value: float) -> None:
    axes.text(
        x, y, f'{100.0 * value:.0f}', ha='center', va='center', fontsize=5.5,
        color='white' if value > 0.55 else '#333333', in_layout=False,
    )  # fmt: skip
