# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""Which causes the motion cannot tell apart."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure as Drawing
from matplotlib.patches import Rectangle

from sosml_friction.diagnosis.diagnosis import Diagnosis
from sosml_friction.diagnosis.residual.lookalikes import ambiguous_pairs, most_alike
from sosml_friction.model.terms.kinds.term import ALL_JOINTS
from sosml_friction.report.common.drawing import GREY, fix_axes, new_figure
from sosml_friction.report.common.figure import METHOD, Figure

#: More rows than this cannot be read: those that look least alike are left out.
MOST = 18
#: Shares from here on are written into their cell.
_WRITTEN = 0.3
#: Of a cell [inches], and of its labels [points]: what is read on paper, too.
_CELL_IN, _FONT = 0.3, 9.5
_MARK = '#D55E00'
_COLOURS = LinearSegmentedColormap.from_list('share', ['#ffffff', '#c6dbef', '#4292c6', '#08306b'])


class ConfusabilityMap(Figure[Diagnosis]):
    """Draw the share of each cause (row) that each other one (column) explains."""

    identifier = 'confusability_map'
    title = 'What this motion can tell apart'
    report = 'diagnosis'
    order = 70
    part = METHOD
    themed = False
    caption = (
        'Share of each cause (row), as large as the noise and after the refit, that each '
        'other one (column) explains. Bold: named; boxes: left open by these data. These look '
        'most alike; diagnosis.json has all'
    )

    def applies(self, view: Diagnosis) -> bool:
        found = view.confusability
        return view.laboratory is not None and found is not None and len(found.effects) > 1

    def draw(self, view: Diagnosis) -> Drawing:
        """Draw the map, and the column of what the refit takes beside it."""
        found = view.confusability
        assert found is not None
        pairs = ambiguous_pairs(view)
        named = {cause.key for cause in view.terms}
        order = most_alike(found, named | {key for pair in pairs for key in pair}, MOST)
        keys = [(found.effects[k], found.joints[k]) for k in order]
        m = len(keys)
        size = _CELL_IN * m
        figure = new_figure(max(4.0 + size, 7.0), 3.4 + size)
        ax, side = figure.subplots(1, 2, width_ratios=[m, 1.6])
        share = found.share[np.ix_(order, order)]
        absorbed = found.absorbed[order, None]
        for axes, values in ((ax, share), (side, absorbed)):
            axes.pcolormesh(
                np.arange(values.shape[1] + 1) - 0.5, np.arange(m + 1) - 0.5, 100.0 * values,
                cmap=_COLOURS, vmin=0.0, vmax=100.0,
            )  # fmt: skip
            axes.set_ylim(m - 0.5, -0.5)
        for a in range(m):
            for b in range(m):
                if a != b and share[a, b] >= _WRITTEN:
                    _write(ax, b, a, share[a, b])
            _write(side, 0, a, float(absorbed[a, 0]))
        labels = [f'{effect.replace("_", " ")}, {joint}' for effect, joint in keys]
        labels = [label.removesuffix(f', {ALL_JOINTS}') for label in labels]
        ax.set_xticks(np.arange(m), labels, rotation=90, fontsize=_FONT)
        ax.set_yticks(np.arange(m), labels, fontsize=_FONT)
        for ticks in (ax.get_xticklabels(), ax.get_yticklabels()):
            for label, key in zip(ticks, keys, strict=True):
                if key in named:
                    label.set_fontweight('bold')
                    label.set_color(_MARK)
        for pair in pairs:
            for row, column in (pair, pair[::-1]):
                if row in keys and column in keys:
                    corner = (keys.index(column) - 0.5, keys.index(row) - 0.5)
                    ax.add_patch(
                        Rectangle(corner, 1.0, 1.0, fill=False, edgecolor=_MARK, linewidth=2.0)
                    )
        for k in range(1, m):
            if keys[k][1] != keys[k - 1][1]:
                ax.axhline(k - 0.5, color=GREY, linewidth=0.8)
                ax.axvline(k - 0.5, color=GREY, linewidth=0.8)
        ax.set_ylabel('share of this cause [%] ...', fontsize=_FONT)
        ax.set_xlabel('... that this one explains', fontsize=_FONT)
        side.set_xticks([0], ['taken by\nthe refit'], rotation=90, fontsize=_FONT)
        side.set_yticks([])
        for axes in (ax, side):
            axes.tick_params(length=0)
            for spine in axes.spines.values():
                spine.set_color('#c9c9c9')
        # 0.0075 inches a letter for each point of its size.
        room = 0.4 + 0.0075 * _FONT * max(len(label) for label in labels)
        fix_axes(figure, (room, 0.1, room, 0.05), (0.12, 0.0))
        return figure


def _write(axes: Axes, x: int, y: int, value: float) -> None:
    axes.text(
        x, y, f'{100.0 * value:.0f}', ha='center', va='center', fontsize=8.5,
        color='white' if value > 0.55 else '#333333', in_layout=False,
    )  # fmt: skip
