# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""What each candidate removes on data left out."""

import numpy as np
from matplotlib.figure import Figure as Drawing

from sosml_friction.diagnosis.diagnosis import Diagnosis
from sosml_friction.report.common.drawing import AFTER, FONT, GREY, label_axes, new_figure
from sosml_friction.report.common.figure import Figure

#: Bars of the ranking.
_BARS = 12


class RankingBars(Figure[Diagnosis]):
    """Draw the held-out gain of the first round's best candidates, with standard errors."""

    identifier = 'ranking_bars'
    title = 'What was considered'
    report = 'diagnosis'
    order = 60
    caption = (
        'First round: what each candidate removes on data left out, with standard errors; '
        'dark: named; dotted: floor of the first'
    )

    def applies(self, view: Diagnosis) -> bool:
        return view.laboratory is not None and bool(view.ranking)

    def draw(self, view: Diagnosis) -> Drawing:
        entries = list(view.ranking[:_BARS])[::-1]
        figure = new_figure(10.0, 0.6 + 0.32 * len(entries))
        ax = figure.subplots()
        named = {cause.key for cause in view.terms}
        colours, labels = [], []
        for entry in entries:
            other = '#d9d9d9' if entry['objection'] else '#9ecae1'
            colours.append(AFTER if (entry['effect'], entry['joint']) in named else other)
            label = f'{entry["effect"].replace("_", " ")}, {entry["joint"]}'
            labels.append(label + (' (impossible)' if entry['objection'] else ''))
        place = np.arange(len(entries))
        ax.barh(
            place,
            [100.0 * max(entry['cv_gain'], 0.0) for entry in entries],
            xerr=[100.0 * entry['cv_gain_se'] for entry in entries],
            color=colours,
            ecolor=GREY,
        )
        ax.set_yticks(place, labels, fontsize=FONT)
        floors = [cause.evidence.get('floor') for cause in view.terms]
        known = [floor for floor in floors if floor is not None]
        if known:
            ax.axvline(100.0 * known[0], color='black', linestyle=':', linewidth=1.2)
        label_axes(ax, 'removed of what is unexplained, on data left out [%]', '')
        return figure
