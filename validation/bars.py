# Copyright 2026 the sosml_friction authors
# SPDX-License-Identifier: Apache-2.0
"""The bars of the campaign, each with its counts."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from statistics import median
from typing import Any

from scipy.stats import beta, norm

from validation.effects import TYPICAL

Row = dict[str, Any]
WRONG = ('wrong name', 'wrong joint')


@dataclass(frozen=True)
class Bar:
    """
    Hold one demand: ``value`` of ``n`` trials has to be at least, or at most, ``limit``.

    ``text``: counts and spread, for a person.
    """

    name: str
    demand: str
    n: int
    value: float
    limit: float
    at_least: bool
    text: str

    @property
    def met(self) -> bool:
        """Tell whether it is met; without a trial it is not."""
        if self.n == 0:
            return False
        return self.value >= self.limit if self.at_least else self.value <= self.limit


def interval(k: int, n: int) -> tuple[float, float]:
    """Return the 95 % confidence interval (Clopper and Pearson) of a share of k in n."""
    if n == 0:
        return 0.0, 1.0
    low = float(beta.ppf(0.025, k, n - k + 1)) if k else 0.0
    high = float(beta.ppf(0.975, k + 1, n - k)) if k < n else 1.0
    return low, high


def level(row: Row) -> str | None:
    """Return the bin of a trial's SNR."""
    snr = row.get('snr')
    if snr is None:
        return None
    return 'high' if snr >= 0.6 else ('middle' if snr >= 0.35 else 'low')


def share(
    name: str, demand: str, rows: list[Row], limit: float, at_least: bool,
    hit: Callable[[Row], bool],
) -> Bar:  # fmt: skip
    """Return a bar on the share of trials of which ``hit`` is true."""
    k, n = sum(map(hit, rows)), len(rows)
    low, high = interval(k, n)
    text = f'{k} of {n} ({100 * low:.0f} to {100 * high:.0f} %)'
    others = [row['spec']['name'] for row in rows if hit(row) != at_least]
    if others:
        text += f'; {"not" if at_least else "these"}: {", ".join(others[:12])}'
        text += f' and {len(others) - 12} more' if len(others) > 12 else ''
    return Bar(name, demand, n, k / n if n else 0.0, limit, at_least, text)


def _surely_worse(gains: list[dict[str, Any]]) -> float:
    """Return the largest ratio of the simulated position's errors, less chance (Bonferroni)."""
    ratios = [x for g in gains for x in zip(g['joints'], g['joint_errors'], strict=True)]
    chance = float(norm.isf(0.01 / max(len(ratios), 1)))
    return max((ratio - chance * error for ratio, error in ratios), default=0.0)


def _forward_text(gains: list[dict[str, Any]]) -> str:
    """Return how the error of the simulated position changed, by the trials where it grew."""
    if not gains:
        return 'none'
    grew = sorted((g for g in gains if g['forward'] > 1.0), key=lambda g: -g['forward'])
    text = f'median after / before {median(g["forward"] for g in gains):.2f}; above 1: {len(grew)}'
    ratios = ', '.join(f'{g["forward"]:.3f} ± {g["forward_error"]:.3f}' for g in grew[:6])
    return f'{text} ({ratios})' if grew else text


def cut_of(gain: dict[str, Any]) -> float:
    """Return by how much the excess over the noise was cut, infinite where none of it is left."""
    return float('inf') if gain['cut'] is None else float(gain['cut'])


def said_cut(cut: float) -> str:
    """Return a cut in words."""
    return 'to the noise' if cut == float('inf') else f'{cut:.1f}'


def bars(rows: Iterable[Row]) -> list[Bar]:
    """Return every bar of the issue for the rows of a campaign."""
    rows = list(rows)

    def of(*kinds: str) -> list[Row]:
        return [row for row in rows if row['kind'] in kinds]

    high = [row for row in of('single') if level(row) == 'high']
    middle = [row for row in of('single') if level(row) == 'middle']
    doubles, mutant = of('double'), of('mutant')
    gains = [row['held_out'] for row in high if row.get('held_out')]
    cuts = [cut_of(gain) for gain in gains]
    spurious = [row.get('spurious', 0) for row in doubles]
    costs = [row['cpu_s'] for row in of('single', 'null', 'outside') if 'cpu_s' in row]
    hidden = {row['truths'][0]['effect'] for row in high if row['truths']}
    missing = [e for e in TYPICAL if e not in hidden | {'encoder_eccentricity', 'thermal_drift'}]

    def right(row: Row) -> bool:
        return row['outcome'] == 'right'

    def wrong(row: Row) -> bool:
        return row['outcome'] in WRONG

    return [
        Bar(
            'every effect hidden', 'every effect of the catalogue, SNR >= 0.6', len(high),
            float(len(missing)), 0.0, False, f'missing: {", ".join(missing) or "none"}',
        ),
        share('single right', 'SNR >= 0.6: right >= 92 %', high, 0.92, True, right),
        share('single wrong', 'SNR >= 0.6: wrong <= 3 %', high, 0.03, False, wrong),
        share('small right', 'SNR 0.35 to 0.6: right >= 65 %', middle, 0.65, True, right),
        share('small wrong', 'SNR 0.35 to 0.6: wrong <= 6 %', middle, 0.06, False, wrong),
        share(
            'nulls', 'no effect: named <= 2 %', of('null'), 0.02, False,
            lambda row: row['outcome'] == 'false alarm',
        ),
        share(
            'outside', 'outside the library: a single name <= 8 %', of('outside'), 0.08, False,
            lambda row: row['outcome'] == 'single name',
        ),
        share(
            'twins', 'twins: the set, 100 %', of('twin'), 1.0, True,
            lambda row: row['outcome'] == 'set',
        ),
        share(
            'double first', 'two effects: first name true >= 90 %', doubles, 0.90, True,
            lambda row: bool(row.get('first')),
        ),
        share(
            'double both', 'two effects: both >= 65 %', doubles, 0.65, True,
            lambda row: row.get('found') == 2,
        ),
        Bar(
            'double spurious', 'two effects: spurious <= 0.25 a run', len(doubles),
            sum(spurious) / max(len(spurious), 1), 0.25, False,
            f'{sum(spurious)} in {len(spurious)} runs',
        ),
        Bar(
            'held-out cut', 'right name, SNR >= 0.6: held-out effort error cut >= 3x (median)',
            len(cuts), median(cuts) if cuts else 0.0, 3.0, True,
            f'median {said_cut(median(cuts))}, {sum(c >= 3.0 for c in cuts)} of {len(cuts)} at '
            f'least 3x, least {min(cuts):.2f}' if cuts else 'none',
        ),
        Bar(
            'forward', 'right name: forward re-simulation never worse, p = 0.01 over all joints',
            len(gains), _surely_worse(gains), 1.0, False, _forward_text(gains),
        ),
        Bar(
            'honest gain', 'right name: reported gain <= that of the true model + 5 %', len(gains),
            max((g['gain'] / g['true_gain'] for g in gains), default=0.0), 1.05, False,
            f'largest ratio {max((g["gain"] / g["true_gain"] for g in gains), default=0.0):.3f}',
        ),
        share(
            'thermal', 'thermal_drift, >= 600 s: right >= 80 %', of('thermal'), 0.80, True, right
        ),
        share('faults', 'faults of the data: right >= 92 %', of('fault'), 0.92, True, right),
        share(
            'mutation', 'without an effect, its trial fails', mutant, 1.0, True,
            lambda row: row['outcome'] not in ('right', 'never right', 'failed'),
        ),
        Bar(
            'cost', 'at most 60 s on one core for 140 s of data', len(costs),
            max(costs, default=0.0), 60.0, False,
            f'median {median(costs):.1f}, largest {max(costs):.1f} s with the start of the process'
            if costs else 'none',
        ),
        share(
            'failures', 'no diagnosis fails', rows, 0.0, False,
            lambda row: row['outcome'] == 'failed',
        ),
    ]  # fmt: skip
