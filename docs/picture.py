# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""
Draw the picture of the README from what the demo and a diagnosis of its recording wrote.

``make demo``, ``sosml diagnose demo_output/run/bag --model config/exoskeleton --out why``, then
``python docs/picture.py demo_output why docs/picture.svg``.
"""

import csv
import json
import sys
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sosml_friction.report.common.drawing import AFTER, BEFORE, FONT, GREY, label_axes
from sosml_friction.report.common.labels import fit_label

_JOINT = 'shoulder'


def draw_curve(axes: Axes, fit: Path) -> None:
    """Draw the law of the model of one joint over the levels of its windows."""
    document = json.loads((fit / 'fit.json').read_text(encoding='utf-8'))
    observer = document['model'][_JOINT]
    found = document['joints'][_JOINT][observer]
    c, b, s, v_s, bias = (
        found['parameters'][name]['value']
        for name in ('coulomb', 'viscous', 'stribeck', 'stribeck_velocity', 'bias')
    )
    with (fit / 'segments.csv').open(encoding='utf-8') as stream:
        rows = [x for x in csv.DictReader(stream) if x['joint'] == _JOINT and x['used'] == 'yes']
    keys = ('velocity', f'level_{observer}', f'spread_{observer}')
    v, level, spread = np.array([[float(row[key] or 'nan') for key in keys] for row in rows]).T
    slowest, fastest = np.abs(v).min(), 1.05 * np.abs(v).max()
    for side in (1.0, -1.0):
        for low, high, dashes in ((1e-4, slowest, ':'), (slowest, fastest, '-')):
            x = side * np.geomspace(low, high, 200)
            law = np.sign(x) * (c + s * np.exp(-np.abs(x) / v_s)) + b * x + bias
            axes.plot(x, law, color=AFTER, linestyle=dashes, linewidth=1.8)
    axes.errorbar(v, level, spread, fmt='o', color=BEFORE, markersize=5, elinewidth=0.9)
    axes.set_title(f'Friction found in the {_JOINT}', fontsize=FONT, loc='left')
    told = f'C {c:.2f} Nm, B {b:.2f} Nm s/rad,\nS {s:.2f} Nm over {v_s:.3f} rad/s'
    method = fit_label(observer, found['method'])
    axes.text(0.97, 0.05, f'{method}\n{told}', transform=axes.transAxes, ha='right', fontsize=FONT)
    label_axes(axes, 'velocity [rad/s]', 'friction torque [Nm]')


def draw_gain(axes: Axes, diagnosis: Path) -> None:
    """Draw the effort error of each joint before and after what was named."""
    document = json.loads((diagnosis / 'diagnosis.json').read_text(encoding='utf-8'))
    gain = document['gain']
    for side, key, colour, label in (
        (-0.2, 'relative_before_percent', BEFORE, 'the model as given, refitted'),
        (0.2, 'relative_after_percent', AFTER, 'with the cause that was named'),
    ):
        values = [joint['inverse'][key] for joint in gain.values()]
        place = np.arange(len(values)) + side
        axes.bar(place, values, width=0.36, color=colour, label=label)
        for x, value in zip(place, values, strict=True):
            axes.annotate(f'{value:.2f}', (x, value), xytext=(0, 3), ha='center',
                          textcoords='offset points', fontsize=FONT)  # fmt: skip
    named = {}
    for cause in document['causes']:
        named.setdefault(cause['joint'], []).append(cause['effect'].replace('_', ' '))
    ticks = [f'{joint}\n{", ".join(named.get(joint, [])[:1])}' for joint in gain]
    axes.set_xticks(range(len(gain)), ticks)
    axes.set_title('What the model lacked', fontsize=FONT, loc='left')
    label_axes(axes, '', 'effort error on data left out [%]')
    axes.set_ylim(top=1.45 * axes.get_ylim()[1])
    axes.legend(fontsize=FONT, frameon=False, loc='upper right')


def main(fit: str, diagnosis: str, out: str) -> None:
    """Write the picture."""
    with rc_context({'svg.fonttype': 'none', 'svg.hashsalt': 'sosml_friction',
                     'font.family': 'sans-serif'}):  # fmt: skip
        figure = Figure(figsize=(9.5, 3.7), layout='constrained', facecolor='white')
        left, right = figure.subplots(1, 2, width_ratios=(1.25, 1.0))
        left.axhline(0.0, color=GREY, linewidth=0.6)
        draw_curve(left, Path(fit))
        draw_gain(right, Path(diagnosis))
        figure.savefig(out, metadata={'Date': None})


if __name__ == '__main__':
    main(*sys.argv[1:])
